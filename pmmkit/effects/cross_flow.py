"""Cross-flow drag: each section is dragged by the flow across it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.primitives import fabs, interpolate, where

STRIPS: Final = 40
"""Strips over the length where the coefficient changes along it."""


def strip_force(w: float, k: float, a: float, b: float) -> float:
    """Integral of \\|w + k x\\|(w + k x) over x from a to b, exactly."""
    first, last = w + k * a, w + k * b
    side = where(first + last >= 0.0, 1.0, -1.0)
    same = side * (
        w * w * (b - a) + w * k * (b * b - a * a) + k * k * (b * b * b - a * a * a) / 3.0
    )
    slope = where(fabs(k) < 1e-12, 1e-12, k)
    turned = (fabs(last * last * last) - fabs(first * first * first)) / (3.0 * slope)
    return where(first * last >= 0.0, same, turned)


def strip_moment(w: float, k: float, a: float, b: float) -> float:
    """Integral of \\|w + k x\\|(w + k x) x over x from a to b, exactly."""
    first, last = w + k * a, w + k * b
    side = where(first + last >= 0.0, 1.0, -1.0)
    same = side * (
        w * w * (b * b - a * a) / 2.0
        + 2.0 * w * k * (b * b * b - a * a * a) / 3.0
        + k * k * (b * b * b * b - a * a * a * a) / 4.0
    )
    slope = where(fabs(k) < 1e-12, 1e-12, k)
    fourth = (fabs(last) * last * last * last - fabs(first) * first * first * first) / 4.0
    third = (fabs(last * last * last) - fabs(first * first * first)) / 3.0
    turned = (fourth - w * third) / (slope * slope)
    return where(first * last >= 0.0, same, turned)


def force(
    v: float, r: float, L: float, d: float, rho: float, form: int, shape: int, CD: float,
    CrY: float, CrN: float, station: Sequence[float], CD_station: Sequence[float],
) -> tuple[float, float]:  # fmt: skip
    """Y [N] and N [N m] of the flow across the hull.

    -½ ρ d ∫ CD(x) |v + Cr r x| (v + Cr r x) (1, x) dx over the length.

    Examples
    --------
    >>> force(1.0, 0.0, 100.0, 5.0, 1000.0, 0, 0, 1.0, 1.0, 1.0, (0.0,), (0.0,))
    (-250000.0, -0.0)
    """
    half = 0.5 * L
    if shape == 0:
        side = CD * strip_force(v, CrY * r, -half, half)
        turn = CD * strip_moment(v, CrN * r, -half, half)
    else:
        side, turn = 0.0 * v, 0.0 * v
        for i in range(40):
            a, b = -half + L * i / 40, -half + L * (i + 1) / 40
            here = CD * interpolate((i + 0.5) / 40 - 0.5, station, CD_station)
            side += here * strip_force(v, CrY * r, a, b)
            turn += here * strip_moment(v, CrN * r, a, b)
    if form == 1:
        side -= CD * L * fabs(v) * v
    return -0.5 * rho * d * side, -0.5 * rho * d * turn


_TABLE: Final = ("shape", "table")
CROSSFLOW_DRAG: Final = Effect(
    name="crossflow_drag",
    family="cross_flow",
    kind="force",
    summary="Drag of the flow across each section, summed over the length.",
    parameters=(
        Parameter(name="CD", text="drag coefficient of a section on its draught", low=0.0),
        Parameter(name="CrY", text="factor of the yaw rate in the force", default=1.0),
        Parameter(name="CrN", text="factor of the yaw rate in the moment", default=1.0),
        Parameter(
            name="station", text="stations over L from midship, ascending, -0.5 to 0.5",
            form=_TABLE, table=True,
        ),
        Parameter(
            name="CD_station", text="factor of CD at each station", form=_TABLE, table=True,
            low=0.0,
        ),
    ),
    options={"form": ("full", "without_sway"), "shape": ("constant", "table")},
    force=force,
    outputs=("Y", "N"),
    source="Hooft 1994; Faltinsen 1990; without_sway (Yv|v| stands in the hull): Kose 1984, as "
    "used for stopping ships at low speed",
)  # fmt: skip
EFFECTS: Final = (CROSSFLOW_DRAG,)

_HOERNER: Final = (
    (0.0109, 0.177, 0.353, 0.452, 0.473, 0.493, 0.4933, 0.558, 0.646, 0.834, 0.988, 1.308, 1.639,
     1.860, 2.313, 2.600, 3.009, 3.451, 3.738, 4.003),
    (1.966, 1.966, 1.898, 1.787, 1.584, 1.279, 1.211, 1.084, 0.999, 0.880, 0.828, 0.760, 0.691,
     0.657, 0.631, 0.596, 0.587, 0.586, 0.560, 0.559),
)  # fmt: skip


def hoerner_drag(B: float, d: float) -> float:
    """Drag coefficient of a section from breadth and draught [m], Hoerner's curve over B/(2d).

    References
    ----------
    Leite, Aranha, Umeda and de Conti, Applied Ocean Research 20 (1998); values as in the public
    MSS toolbox.

    Examples
    --------
    >>> round(hoerner_drag(25.4, 8.5), 3)
    0.721
    """
    return interpolate(0.5 * B / d, *_HOERNER)
