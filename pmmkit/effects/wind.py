"""Wind on the ship above the water."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.primitives import atan2, cos, fabs, interpolate, pi, sin, where


def force(
    u: float, v: float, psi: float, L: float, wind_speed: float, wind_direction: float,
    coefficients: int, air: float, frontal: float, lateral: float, length: float, lever: float,
    cx: float, cy: float, cn: float, angle_deg: Sequence[float], CX: Sequence[float],
    CY: Sequence[float], CN: Sequence[float],
) -> tuple[float, float, float, float]:  # fmt: skip
    """X, Y [N], N, K [N m] of the relative wind at midship.

    Half the density times the square of the relative wind times CX AF, CY AL, CN AL L. Its
    direction is where it comes from, from the bow, positive to starboard: wind from starboard
    pushes to port. ``simple``: CX = -cx cos γ, CY = -cy sin γ, CN = -cn sin 2γ.

    Examples
    --------
    >>> X, Y, N, K = force(0.0, 0.0, 0.0, 100.0, 10.0, 1.5707963267948966, 0, 1.225, 100.0, 500.0,
    ...                    1.0, 10.0, 0.6, 0.8, 0.1, (0.0,), (0.0,), (0.0,), (0.0,))
    >>> round(Y), round(K)
    (-24500, -245000)
    """
    bearing = wind_direction - psi
    along = -wind_speed * cos(bearing) - u
    across = -wind_speed * sin(bearing) - v
    pressure = 0.5 * air * (along * along + across * across)
    angle = atan2(-across, -along)
    if coefficients == 0:
        ahead, side, turn = -cx * cos(angle), -cy * sin(angle), -cn * sin(2.0 * angle)
    else:
        degrees = fabs(angle) * 180.0 / pi
        hand = where(angle >= 0.0, 1.0, -1.0)
        ahead = interpolate(degrees, angle_deg, CX)
        side = hand * interpolate(degrees, angle_deg, CY)
        turn = hand * interpolate(degrees, angle_deg, CN)
    Y = pressure * side * lateral
    return pressure * ahead * frontal, Y, pressure * turn * lateral * length * L, Y * lever


_SIMPLE: Final = ("coefficients", "simple")
_TABLE: Final = ("coefficients", "table")
WIND: Final = Effect(
    name="wind",
    family="environment",
    kind="force",
    summary="Forces of the relative wind by coefficients over its angle.",
    parameters=(
        Parameter(name="air", text="density of the air [kg/m³]", default=1.225, low=0.0),
        Parameter(name="frontal", text="frontal area above water", unit="m2", low=0.0),
        Parameter(name="lateral", text="lateral area above water", unit="m2", low=0.0),
        Parameter(name="length", text="length of CN over L", default=1.0, low=0.0),
        Parameter(
            name="lever", text="centre of the lateral area above the origin", unit="m", default=0.0
        ),
        Parameter(name="cx", text="CX in wind from ahead, positive", default=0.7, form=_SIMPLE),
        Parameter(name="cy", text="CY in wind from abeam, positive", default=0.8, form=_SIMPLE),
        Parameter(
            name="cn", text="CN in wind 45° from the bow, positive", default=0.1, form=_SIMPLE
        ),
        Parameter(
            name="angle_deg", text="angles 0 to 180 of the wind from starboard, ascending",
            unit="deg", form=_TABLE, table=True,
        ),
        Parameter(name="CX", text="at each angle, ahead positive", form=_TABLE, table=True),
        Parameter(name="CY", text="at each angle, starboard positive", form=_TABLE, table=True),
        Parameter(name="CN", text="at each angle, bow to starboard positive", form=_TABLE,
                  table=True),
    ),
    options={"coefficients": ("simple", "table")},
    needs=("wind_speed", "wind_direction"),
    force=force,
    outputs=("X", "Y", "N", "K"),
    source="Isherwood 1972 (form of the coefficients); simple: Fossen 2011, section 8.1",
)  # fmt: skip
EFFECTS: Final = (WIND,)
