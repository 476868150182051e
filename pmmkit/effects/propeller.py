"""Propeller ahead: open-water polynomial, wake that changes in the turn, thrust deduction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

from pmmkit.effects.effect import Effect, Parameter

PROPELLER: Final = Effect(
    name="propeller",
    family="propeller",
    kind="force",
    summary="Thrust of one propeller ahead, from KT over J, with wake and thrust deduction.",
    parameters=(
        Parameter(name="D", text="diameter", unit="m", low=1e-6),
        Parameter(name="t", text="thrust deduction fraction", low=-0.99, high=0.99),
        Parameter(name="kt0", text="KT at J = 0"),
        Parameter(name="kt1", text="coefficient of J in KT"),
        Parameter(name="kt2", text="coefficient of J² in KT", default=0.0),
        Parameter(name="wp", text="wake fraction straight ahead", low=-0.99, high=0.99),
        Parameter(name="xp", text="propeller forward of midship over L", default=-0.5),
        Parameter(
            name="tau", text="growth of the inflow with (v' + xp r')²", form=("wake", "son-nomoto")
        ),
        Parameter(name="cpv", text="inflow per v'", default=0.0, form=("wake", "son-nomoto")),
        Parameter(name="cpr", text="inflow per r'", default=0.0, form=("wake", "son-nomoto")),
        Parameter(name="C1", text="how fast the wake fades with drift", form=("wake", "mmg")),
        Parameter(name="C2_positive", text="inflow at large positive drift", form=("wake", "mmg")),
        Parameter(name="C2_negative", text="inflow at large negative drift", form=("wake", "mmg")),
    ),
    options={"wake": ("constant", "son-nomoto", "mmg")},
    needs=("n",),
    source="Son and Nomoto 1981; Yasukawa and Yoshimura 2015",
)
EFFECTS: Final = (PROPELLER,)
WAKES: Final = PROPELLER.options["wake"]


class Propeller(NamedTuple):
    """Values of a propeller, SI; `wake` counts the forms of `WAKES`."""

    D: float
    t: float
    kt0: float
    kt1: float
    kt2: float
    wp: float
    xp: float
    wake: int
    tau: float
    cpv: float
    cpr: float
    C1: float
    C2_positive: float
    C2_negative: float


def resolve(values: Mapping[str, float], options: Mapping[str, str]) -> Propeller:
    """The propeller from values with their defaults; those of other wake forms are zero."""
    wake = WAKES.index(options["wake"])
    given = {name: values.get(name, 0.0) for name in Propeller._fields if name != "wake"}
    return Propeller(**given, wake=wake)


def inflow(u: float, v: float, r: float, L: float, c: Propeller) -> float:
    """Speed of the water into the propeller disc [m/s].

    Parameters
    ----------
    u, v, r : float
        Surge, sway velocity [m/s], yaw rate [rad/s] at midship.
    L : float
        Ship length [m].
    c : Propeller
        Values.

    Notes
    -----
    Son and Nomoto (1981): u (1 - wp + τ[(v' + xp r')² + cpv v' + cpr r']). Yasukawa and Yoshimura
    (2015): u (1 - wp)(1 + [1 - exp(-C1 |βP|)](C2 - 1)), βP = β - xp r'.

    Examples
    --------
    >>> c = Propeller(D=6.5, t=.2, kt0=.5, kt1=-.4, kt2=0., wp=.2, xp=-.5, wake=0, tau=0.,
    ...               cpv=0., cpr=0., C1=0., C2_positive=0., C2_negative=0.)
    >>> inflow(10.0, -2.0, 0.02, 175.0, c)
    8.0
    """
    if c.wake == 0:
        return u * (1.0 - c.wp)
    U = max(math.sqrt(u * u + v * v), 1e-9)
    yaw = r * L / U
    if c.wake == 1:
        sway = v / U
        cross = sway + c.xp * yaw
        return u * (1.0 - c.wp + c.tau * (cross * cross + c.cpv * sway + c.cpr * yaw))
    angle = math.atan2(-v, u) - c.xp * yaw
    limit = c.C2_positive if angle > 0.0 else c.C2_negative
    grown = 1.0 + (1.0 - math.exp(-c.C1 * abs(angle))) * (limit - 1.0)
    return u * (1.0 - c.wp) * grown


def thrust(inflow_speed: float, n: float, rho: float, c: Propeller) -> float:
    """Thrust ρ n² D⁴ KT(J) [N], written so that it holds at n = 0 too.

    Parameters
    ----------
    inflow_speed : float
        From `inflow` [m/s].
    n : float
        Revolutions per second, ahead.
    rho : float
        Density [kg/m³].
    c : Propeller
        Values.
    """
    turned = n * c.D
    return (
        rho
        * c.D**2
        * (
            c.kt0 * turned * abs(turned)
            + c.kt1 * turned * inflow_speed
            + c.kt2 * inflow_speed * inflow_speed
        )
    )


def revolutions(force: float, inflow_speed: float, rho: float, c: Propeller) -> float:
    """Revolutions per second at which the propeller gives a thrust.

    Parameters
    ----------
    force : float
        Thrust [N].
    inflow_speed : float
        Speed of the water into the disc [m/s].
    rho : float
        Density [kg/m³].
    c : Propeller
        Values.

    Returns
    -------
    float
        The larger root of the quadratic; NaN where no revolutions give that thrust.

    Examples
    --------
    >>> c = Propeller(D=2.0, t=.2, kt0=.5, kt1=-.4, kt2=-.1, wp=.2, xp=-.5, wake=0, tau=0.,
    ...               cpv=0., cpr=0., C1=0., C2_positive=0., C2_negative=0.)
    >>> n = revolutions(1e4, 3.0, 1000.0, c)
    >>> round(thrust(3.0, n, 1000.0, c), 6)
    10000.0
    """
    b = c.kt1 * inflow_speed
    rest = c.kt2 * inflow_speed**2 - force / (rho * c.D**2)
    inside = b * b - 4.0 * c.kt0 * rest
    if inside < 0.0 or c.kt0 <= 0.0:
        return math.nan
    turned = (-b + math.sqrt(inside)) / (2.0 * c.kt0)
    return turned / c.D if turned > 0.0 else math.nan
