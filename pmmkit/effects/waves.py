"""Mean drift of waves on a ship that manoeuvres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import (
    atan2,
    cos,
    fabs,
    interpolate,
    interpolate_rows,
    pi,
    sin,
    where,
)
from pmmkit.effects.seen import Move, Vessel


def drift(
    U: float,
    psi: float,
    L: float,
    B: float,
    rho: float,
    g: float,
    wave_height: float,
    wave_direction: float,
    coefficients: int,
    Hs: float,
    from_deg: float,
    kx: float,
    ky: float,
    kn: float,
    kx1: float,
    ky1: float,
    kn1: float,
    kx2: float,
    ky2: float,
    kn2: float,
    speeds: Sequence[float],
    angle_deg: Sequence[float],
    DX: Sequence[float],
    DY: Sequence[float],
    DN: Sequence[float],
) -> tuple[float, float, float]:
    """X, Y [N] and N [N m] of a sea past midship.

    Notes
    -----
    X = fx ρgHs² L DX, Y = fy ρgHs² L DY, N = fn ρgHs² L² DN, over the angle γ from which the waves
    come, from the bow, positive to starboard. The factors are fx = kx + kx1 cos γ + kx2 cos 2γ and
    so on, for a table is not right at all angles alike. Waves from starboard push to port: DY < 0.
    Tables reach over 0 to 180°; waves from port mirror them. ``speeds``: a row over the angles for
    each of ``speeds``, between which lie straight lines in U, as in short waves, which meet the
    ship the more often the faster it goes; below the first and beyond the last they are held.
    ``reflected``: waves that are short beside the ship, whose energy a wall sends back,
    DX = -(B/L) cos γ |cos γ|/16, DY = -sin γ |sin γ|/16, and no moment. A sea that a record states,
    ``wave_height`` [m] from ``wave_direction`` [rad], stands for ``Hs`` and ``from_deg``; a height
    below zero states none.

    Examples
    --------
    A sea of 4 m from starboard on 100 m of wall: ρgHs²L/16 to port.

    >>> none = (0.0,)
    >>> X, Y, N = drift(5.0, 0.0, 100.0, 20.0, 1025.0, 9.81, -1.0, 0.0, 0, 4.0, 90.0, 1.0, 1.0,
    ...                 1.0, *[0.0] * 6, *[none] * 5)
    >>> round(Y / 1e3)
    -1006
    """
    stated = wave_height >= 0.0
    bearing = where(stated, wave_direction, from_deg * pi / 180.0) - psi
    height = where(stated, wave_height, Hs)
    across, ahead = sin(bearing), cos(bearing)
    twice = 2.0 * ahead * ahead - 1.0
    fx = kx + kx1 * ahead + kx2 * twice
    fy = ky + ky1 * ahead + ky2 * twice
    fn = kn + kn1 * ahead + kn2 * twice
    size = rho * g * height * height * L
    if coefficients == 0:
        return (
            -fx * size * B / L * ahead * fabs(ahead) / 16.0,
            -fy * size * across * fabs(across) / 16.0,
            0.0,
        )
    angle = atan2(across, ahead)
    degrees = fabs(angle) * 180.0 / pi
    side = where(angle < 0.0, -size, size)
    if coefficients == 2:
        x = interpolate_rows(U, speeds, degrees, angle_deg, DX)
        y = interpolate_rows(U, speeds, degrees, angle_deg, DY)
        n = interpolate_rows(U, speeds, degrees, angle_deg, DN)
    else:
        x = interpolate(degrees, angle_deg, DX)
        y = interpolate(degrees, angle_deg, DY)
        n = interpolate(degrees, angle_deg, DN)
    return fx * size * x, fy * side * y, fn * side * L * n


def some_sea(vessel: Vessel) -> Mapping[str, float]:
    """A significant height of a hundredth of the length, where nothing is known of the sea [m]."""
    return {"Hs": 0.01 * vessel.ship.L}


_OFF: Final = {"kx": 0.2, "ky": 0.2, "kn": 0.47}
"""Usual errors of the factors: two thirds of the ±.3, .3 and .7 by which methods differ, because a
diagnosis takes a coefficient for as large as one and a half times its usual size."""


def together(_: Vessel) -> Mapping[str, Move]:
    """The whole drift by a share of the table, each factor about this share, and its harmonics."""
    whole = Move(values=dict.fromkeys((f"wave_drift.{x}" for x in _OFF), 1.0), typical=1.0)
    return {"share": whole} | {
        f"{axis}{order}": Move(values={f"wave_drift.{name}{order}": 1.0}, typical=size)
        for axis, (name, size) in zip(("surge", "sway", "yaw"), _OFF.items(), strict=True)
        for order in _ORDERS
    }


_ORDERS: Final = {"": "", "1": " times cos γ", "2": " times cos 2γ"}
_FACTORS: Final = tuple(
    Parameter(
        name=f"{name}{order}",
        text=f"factor on the {force}{shape}",
        default=0.0 if order else 1.0,
        typical=_OFF[name],
        expected=0.0 if order else 1.0,
        uncertain=True,
    )
    for order, shape in _ORDERS.items()
    for name, force in (("kx", "surge force"), ("ky", "sway force"), ("kn", "yaw moment"))
)
_TABLE: Final = ("coefficients", "table", "speeds")
_SPEEDS: Final = ("coefficients", "speeds")
_PLACES: Final = ("speeds", "angle_deg")
WAVE_DRIFT: Final = Effect(
    name="wave_drift",
    family="environment",
    kind="force",
    estimates=some_sea,
    not_captive="a tank is calm while a model is towed",
    roles=("waves",),
    needs=("wave_height", "wave_direction"),
    excites=("waves",),
    moves=together,
    check="the same run in a calm",
    summary="Mean force of a sea on the ship, by a table over the angle of the waves.",
    parameters=(
        Parameter(name="Hs", text="significant wave height", unit="m", low=0.0),
        Parameter(
            name="from_deg",
            text="where the waves come from, from the heading of the approach, to starboard",
            unit="deg",
            default=0.0,
        ),
        *_FACTORS,
        Parameter(
            name="angle_deg",
            text="angles 0 to 180 from which the waves come, from starboard, ascending",
            unit="deg",
            form=_TABLE,
            table=True,
        ),
        Parameter(
            name="speeds",
            text="at which the tables stand, ascending: a row over the angles for each",
            unit="m/s",
            low=0.0,
            form=_SPEEDS,
            table=True,
        ),
        Parameter(
            name="DX", text="X over ρgHs²L, ahead positive", form=_TABLE, table=True, over=_PLACES
        ),
        Parameter(
            name="DY",
            text="Y over ρgHs²L, to starboard positive",
            form=_TABLE,
            table=True,
            over=_PLACES,
        ),
        Parameter(
            name="DN",
            text="N over ρgHs²L², bow to starboard positive",
            form=_TABLE,
            table=True,
            over=_PLACES,
        ),
        Parameter(
            name="Tp",
            text="peak period of the waves that the tables are for; 0 where it is not known",
            unit="s",
            low=0.0,
            default=0.0,
            form=_TABLE,
        ),
    ),
    options={"coefficients": ("reflected", "table", "speeds")},
    force=drift,
    outputs=("X", "Y", "N"),
    sources=("faltinsen_1980",),
    remark="reflection of short waves; tables are those of `pmmkit.seakeeping.drift_table`, at one "
    "speed or several, and at one period of the waves",
)
EFFECTS: Final = (WAVE_DRIFT,)
