"""Wind on the ship above the water."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import atan2, cos, fabs, interpolate, pi, sin, where
from pmmkit.effects.seen import Vessel


def relative_wind(
    u: float, v: float, psi: float, wind_speed: float, wind_direction: float
) -> tuple[float, float]:
    """Square of the wind's speed past midship [m²/s²], and where it comes from [rad].

    u, v [m/s]; wind_speed, wind_direction [m/s].

    Examples
    --------
    >>> relative_wind(3.0, 0.0, 0.0, 2.0, 0.0)
    (25.0, 0.0)
    """
    bearing = wind_direction - psi
    ahead = wind_speed * cos(bearing) + u
    starboard = wind_speed * sin(bearing) + v
    return ahead * ahead + starboard * starboard, atan2(starboard, ahead)


def force(
    u: float,
    v: float,
    psi: float,
    L: float,
    wind_speed: float,
    wind_direction: float,
    coefficients: int,
    rho_air: float,
    AF: float,
    AL: float,
    Loa: float,
    lever: float,
    cx: float,
    cy: float,
    cn: float,
    angle_deg: Sequence[float],
    CX: Sequence[float],
    CY: Sequence[float],
    CN: Sequence[float],
    CK: Sequence[float],
) -> tuple[float, float, float, float]:
    """X, Y [N], N, K [N m] of the wind past midship.

    Notes
    -----
    X = q CX AF, Y = q CY AL, N = q CN AL Loa with q = ½ ρair V² and coefficients over the angle γ
    from which the wind comes, from the bow, positive to starboard. Wind from starboard pushes to
    port: CY < 0. ``simple``: CX = -cx cos γ, CY = -cy sin γ, CN = -cn sin 2γ, which is Fossen's
    form with his angle, positive to port, turned over. Tables reach over 0 to 180°; wind from port
    mirrors them. The roll moment is Y times the lever, or q CK AL AL/Loa with AL/Loa the mean
    height of the lateral area.

    Examples
    --------
    Beam wind of 10 m/s from starboard on 500 m², its centre 10 m above the origin.

    >>> none = (0.0,)
    >>> X, Y, N, K = force(0.0, 0.0, 0.0, 100.0, 10.0, pi / 2, 0, 1.225, 100.0, 500.0, 1.0, 10.0,
    ...                    0.6, 0.8, 0.1, none, none, none, none, none)
    >>> round(Y), round(K)
    (-24500, -245000)
    """
    square, angle = relative_wind(u, v, psi, wind_speed, wind_direction)
    pressure = 0.5 * rho_air * square
    length = Loa * L
    if coefficients == 0:
        Y = -pressure * cy * sin(angle) * AL
        return (
            -pressure * cx * cos(angle) * AF,
            Y,
            -pressure * cn * sin(2.0 * angle) * AL * length,
            Y * lever,
        )
    degrees = fabs(angle) * 180.0 / pi
    side = where(angle < 0.0, -pressure, pressure) * AL
    Y = side * interpolate(degrees, angle_deg, CY)
    K = Y * lever
    if coefficients == 2:
        K = side * interpolate(degrees, angle_deg, CK) * AL / length
    return (
        pressure * interpolate(degrees, angle_deg, CX) * AF,
        Y,
        side * interpolate(degrees, angle_deg, CN) * length,
        K,
    )


def windage(vessel: Vessel) -> Mapping[str, float]:
    """Areas above water as large as those below, where nothing is known of them [m²]."""
    ship = vessel.ship
    return {"AF": ship.B * ship.d, "AL": ship.L * ship.d}


_SIMPLE: Final = ("coefficients", "simple")
_TABLE: Final = ("coefficients", "table", "table-with-roll")
_ANGLES: Final = ("angle_deg",)
WIND: Final = Effect(
    name="wind",
    family="environment",
    kind="force",
    roles=("wind",),
    excites=("wind",),
    not_captive="wind on a towed model is that of the carriage: it goes with U² like the water's",
    estimates=windage,
    check="the same run in a calm",
    summary="Forces of the wind past the ship, by coefficients over its angle.",
    parameters=(
        Parameter(name="rho_air", text="density of the air [kg/m³]", default=1.225, low=0.0),
        Parameter(name="AF", text="frontal area above water", unit="m2", low=0.0),
        Parameter(name="AL", text="lateral area above water", unit="m2", low=0.0),
        Parameter(
            name="Loa", text="length overall over L, for N and CK", default=1.0, low=0.5, high=2.0
        ),
        Parameter(
            name="lever", text="height of the side force above the origin", unit="m", default=0.0
        ),
        Parameter(
            name="cx",
            text="size of CX in wind from ahead, 0.5 to 0.9",
            typical=0.7,
            uncertain=True,
            default=0.7,
            form=_SIMPLE,
        ),
        Parameter(
            name="cy",
            text="size of CY in wind from abeam, 0.7 to 0.95",
            typical=0.8,
            uncertain=True,
            default=0.8,
            form=_SIMPLE,
        ),
        Parameter(
            name="cn",
            text="size of CN in wind 45° off the bow, 0.05 to 0.2",
            typical=0.1,
            uncertain=True,
            default=0.1,
            form=_SIMPLE,
        ),
        Parameter(
            name="angle_deg",
            text="angles 0 to 180 from which the wind comes, from starboard, ascending",
            unit="deg",
            form=_TABLE,
            table=True,
        ),
        Parameter(
            name="CX", text="at each angle, ahead positive", form=_TABLE, table=True, over=_ANGLES
        ),
        Parameter(
            name="CY",
            text="at each angle, to starboard positive",
            form=_TABLE,
            table=True,
            over=_ANGLES,
        ),
        Parameter(
            name="CN",
            text="at each angle, bow to starboard positive",
            form=_TABLE,
            table=True,
            over=_ANGLES,
        ),
        Parameter(
            name="CK",
            text="at each angle, starboard side down positive",
            form=("coefficients", "table-with-roll"),
            table=True,
            over=_ANGLES,
        ),
    ),
    options={"coefficients": ("simple", "table", "table-with-roll")},
    needs=("wind_speed", "wind_direction"),
    force=force,
    outputs=("X", "Y", "N", "K"),
    sources=("isherwood_1972", "blendermann_1994", "fossen_2011"),
    remark="the first two: what the coefficients refer to; the last: the simple form, section "
    "8.1, as public programs quote it",
)
EFFECTS: Final = (WIND,)
