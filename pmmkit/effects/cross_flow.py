"""Cross-flow drag: each section is dragged by the flow across it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import fabs, interpolate, maximum, where

STRIPS: Final = 40
"""Strips over the length where the coefficient changes along it."""


def strip(middle: float, growth: float, half: float) -> tuple[float, float]:
    """Integral of w times its size over a strip, and of that times the distance from its middle.

    middle [m/s]; growth [m/s]; half [m].

    Examples
    --------
    >>> strip(2.0, 0.0, 5.0), strip(0.0, 2.0, 5.0)
    ((40.0, 0.0), (0.0, 50.0))
    """
    flow, gain = fabs(middle), fabs(growth)
    square = middle * middle
    above = maximum(gain, 1e-12)
    one_way = gain <= flow
    whole = where(
        one_way,
        half * where(middle < 0.0, -1.0, 1.0) * (2.0 * square + 2.0 / 3.0 * gain * gain),
        half * middle * (2.0 * gain + 2.0 / 3.0 * square / above),
    )
    about = where(
        one_way,
        half * half * growth * 4.0 / 3.0 * flow,
        half
        * half
        * growth
        * (0.5 * gain + square / above * (1.0 - square / (6.0 * above * above))),
    )
    return whole, about


def ends(middle: float, growth: float, half: float) -> tuple[float, float]:
    """`strip` with a weight (x/half)², x the distance from the middle.

    Examples
    --------
    >>> ends(2.0, 0.0, 3.0), ends(0.0, 2.0, 3.0)
    ((8.0, 0.0), (0.0, 12.0))
    """
    flow, gain = fabs(middle), fabs(growth)
    square = middle * middle
    share = square / maximum(gain * gain, 1e-24)
    one_way = gain <= flow
    whole = where(
        one_way,
        half * where(middle < 0.0, -1.0, 1.0) * (2.0 / 3.0 * square + 0.4 * gain * gain),
        half * middle * (gain + square / maximum(gain, 1e-12) * share / 15.0),
    )
    about = where(
        one_way,
        half * half * growth * 0.8 * flow,
        half
        * half
        * where(growth < 0.0, -1.0, 1.0)
        * (0.5 * square + gain * gain / 3.0 - square * share * share / 30.0),
    )
    return whole, about


def force(
    v: float,
    r: float,
    L: float,
    d: float,
    rho: float,
    form: int,
    shape: int,
    CD: float,
    CrY: float,
    CrN: float,
    growth: float,
    station: Sequence[float],
    CD_station: Sequence[float],
) -> tuple[float, float]:
    """Y [N] and N [N m] of the flow across the hull.

    -½ ρ d ∫ CD(x) |v + CrY r x| (v + CrY r x) dx over the length, and the same with CrN times x;
    in closed form where CD is constant or grows to the ends as 1 + growth (2x/L)², else the sum of
    40 strips of constant CD each. The form ``without-sway`` leaves out the part L |v| v of the
    force, which then stands in the hull.

    Examples
    --------
    >>> force(1.0, 0.0, 100.0, 5.0, 1000.0, 0, 0, 1.0, 1.0, 1.0, 0.0, (0.0,), (0.0,))
    (-250000.0, -0.0)
    """
    half = 0.5 * L
    if shape != 1:
        side, _ = strip(v, CrY * r * half, half)
        _, turn = strip(v, CrN * r * half, half)
        if shape == 2:
            more, _ = ends(v, CrY * r * half, half)
            side = side + growth * more
            _, more = ends(v, CrN * r * half, half)
            turn = turn + growth * more
    else:
        side, turn = 0.0 * v, 0.0 * v
        short = half / STRIPS
        for i in range(STRIPS):
            place = (i + 0.5) / STRIPS - 0.5
            here = interpolate(place, station, CD_station)
            x = place * L
            whole, _ = strip(v + CrY * r * x, CrY * r * short, short)
            side = side + here * whole
            whole, about = strip(v + CrN * r * x, CrN * r * short, short)
            turn = turn + here * (x * whole + about)
    if form == 1:
        side = side - L * fabs(v) * v
    return -0.5 * rho * d * CD * side, -0.5 * rho * d * CD * turn


_TABLE: Final = ("shape", "table")
CROSSFLOW_DRAG: Final = Effect(
    name="crossflow_drag",
    in_words="Cross-flow drag",
    family="cross_flow",
    kind="force",
    summary="Drag of the flow across each section, summed over the length.",
    parameters=(
        Parameter(
            name="CD",
            text="drag coefficient of a section on its draught",
            low=0.0,
            typical=0.55,
            uncertain=True,
        ),
        Parameter(name="CrY", text="factor of the yaw rate in the force", default=1.0),
        Parameter(name="CrN", text="factor of the yaw rate in the moment", default=1.0),
        Parameter(
            name="growth",
            text="growth of CD to the ends",
            form=("shape", "ends"),
            low=-1.0,
            grid=(0.0, 0.8, 2.0),
        ),
        Parameter(
            name="station",
            text="stations over L from midship, ascending, -0.5 to 0.5",
            form=_TABLE,
            table=True,
        ),
        Parameter(
            name="CD_station",
            text="factor of CD at each station",
            form=_TABLE,
            table=True,
            low=0.0,
            over=("station",),
        ),
    ),
    options={"form": ("full", "without-sway"), "shape": ("constant", "table", "ends")},
    force=force,
    grows_with={"CD": "Yvvv"},
    outputs=("Y", "N"),
    sources=("hooft_1994", "faltinsen_1990", "sea_trial_identification"),
    remark="the form without sway: the last, equations of the hull at low speed",
    check="yaw with drift at large r/v, so that the flow changes side inside the hull",
)
EFFECTS: Final = (CROSSFLOW_DRAG,)

_HOERNER: Final = (
    (0.0109, 0.177, 0.353, 0.452, 0.473, 0.493, 0.4933, 0.558, 0.646, 0.834, 0.988, 1.308, 1.639,
     1.860, 2.313, 2.600, 3.009, 3.451, 3.738, 4.003),
    (1.966, 1.966, 1.898, 1.787, 1.584, 1.279, 1.211, 1.084, 0.999, 0.880, 0.828, 0.760, 0.691,
     0.657, 0.631, 0.596, 0.587, 0.586, 0.560, 0.559),
)  # fmt: skip


def hoerner_cd(B: float, d: float) -> float:
    """Drag coefficient of a section across the flow by Hoerner's curve over B/(2 d).

    B, d [m].

    Notes
    -----
    Points of the curve as Leite, Aranha, Umeda and de Conti (1998) give it, in the reading of the
    MSS toolbox (Fossen and Perez 2004).

    Examples
    --------
    >>> round(hoerner_cd(25.4, 8.5), 3)
    0.721
    """
    return interpolate(0.5 * B / d, *_HOERNER)
