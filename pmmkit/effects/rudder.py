"""Rudder behind propeller and hull: inflow, normal force, what the hull adds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

from pmmkit.effects.effect import Effect, Parameter

_SN = ("inflow", "son-nomoto")
_MMG = ("inflow", "mmg")
RUDDER_MMG: Final = Effect(
    name="rudder_mmg",
    family="rudder",
    kind="force",
    summary="Rudder force from the flow at the rudder, with the force it raises on the hull.",
    parameters=(
        Parameter(name="area", text="rudder area", unit="m2", low=1e-9),
        Parameter(name="lift_slope", text="gradient fα of the normal force coefficient", low=0.0),
        Parameter(name="epsilon", text="wake at the rudder over wake at the propeller", low=0.0),
        Parameter(name="kappa", text="share of the slipstream's acceleration at the rudder"),
        Parameter(name="eta", text="propeller diameter over rudder height", form=_MMG),
        Parameter(name="gamma_positive", text="flow straightening, inflow from port", form=_MMG),
        Parameter(
            name="gamma_negative", text="flow straightening, inflow from starboard", form=_MMG
        ),
        Parameter(
            name="lR", text="effective lever of the yaw rate at the rudder over L", form=_MMG
        ),
        Parameter(name="gamma", text="flow straightening of v'", form=_SN),
        Parameter(name="cRr", text="cross flow per r'", form=_SN),
        Parameter(name="cRrrr", text="cross flow per r'³", default=0.0, form=_SN),
        Parameter(name="cRrrv", text="cross flow per r'² v'", default=0.0, form=_SN),
        Parameter(name="tR", text="steering resistance deduction"),
        Parameter(name="aH", text="hull force over rudder force"),
        Parameter(name="xH", text="point of the hull force forward of midship over L"),
        Parameter(name="xR", text="rudder forward of midship over L", default=-0.5),
        Parameter(name="zR", text="rudder force below the origin over L", default=0.0),
        Parameter(name="rate_deg_s", text="rate of the steering gear", unit="deg/s", low=1e-6),
        Parameter(name="max_deg", text="largest rudder angle", unit="deg", default=90.0, low=0.0),
    ),
    options={"inflow": ("son-nomoto", "mmg")},
    needs=("delta", "n"),
    source="Son and Nomoto 1981; Yasukawa and Yoshimura 2015",
)
EFFECTS: Final = (RUDDER_MMG,)
INFLOWS: Final = RUDDER_MMG.options["inflow"]


class Rudder(NamedTuple):
    """Values of a rudder, SI; `inflow` counts the forms of `INFLOWS`."""

    area: float
    lift_slope: float
    epsilon: float
    kappa: float
    eta: float
    gamma_positive: float
    gamma_negative: float
    lR: float
    gamma: float
    cRr: float
    cRrrr: float
    cRrrv: float
    tR: float
    aH: float
    xH: float
    xR: float
    zR: float
    inflow: int


def resolve(values: Mapping[str, float], options: Mapping[str, str]) -> Rudder:
    """The rudder from values with their defaults; those of other inflow forms are zero."""
    inflow = INFLOWS.index(options["inflow"])
    given = {name: values.get(name, 0.0) for name in Rudder._fields if name != "inflow"}
    return Rudder(**given, inflow=inflow)


def flow(
    u: float, v: float, r: float, L: float, propeller_flow: float, loading: float, c: Rudder
) -> tuple[float, float]:
    """Water speed along and across the ship at the rudder [m/s].

    Parameters
    ----------
    u, v, r : float
        Surge, sway velocity [m/s], yaw rate [rad/s] at midship.
    L : float
        Ship length [m].
    propeller_flow : float
        Speed of the water into the propeller disc [m/s].
    loading : float
        Thrust over ρ D² [m²/s²]; KT/J² is this over the square of `propeller_flow`.
    c : Rudder
        Values.

    Notes
    -----
    Son and Nomoto (1981): ε uP sqrt(1 + 8 κ KT/(π J²)) and γ v' + cRr r' + cRrrr r'³ +
    cRrrv r'² v'. Yasukawa and Yoshimura (2015): ε uP sqrt(η [1 + κ (sqrt(1 + 8 KT/(π J²)) - 1)]²
    + 1 - η) and -γR (β - lR r'), γR by the sign of the inflow angle.
    """
    U = max(math.sqrt(u * u + v * v), 1e-9)
    yaw = r * L / U
    jet = 8.0 * loading / math.pi
    square = propeller_flow * propeller_flow
    if c.inflow == 0:
        along = c.epsilon * math.sqrt(max(square + c.kappa * jet, 0.0))
        sway = v / U
        across = c.gamma * sway + yaw * (c.cRr + yaw * (c.cRrrr * yaw + c.cRrrv * sway))
        return along, across * U
    behind = math.sqrt(max(square + jet, 0.0))
    mixed = propeller_flow + c.kappa * (behind - propeller_flow)
    along = c.epsilon * math.sqrt(max(c.eta * mixed * mixed + (1.0 - c.eta) * square, 0.0))
    angle = math.atan2(-v, u) - c.lR * yaw
    straightening = c.gamma_positive if angle > 0.0 else c.gamma_negative
    return along, -straightening * angle * U


def normal_force(along: float, across: float, delta: float, rho: float, c: Rudder) -> float:
    """Normal force of the rudder [N], negative when the rudder turns the ship to starboard.

    -½ρ A fα V² sin(δ + atan(across/along)).

    Examples
    --------
    >>> zeros = dict.fromkeys(Rudder._fields, 0.0)
    >>> c = Rudder(**{**zeros, "area": 2.0, "lift_slope": 2.5, "inflow": 0})
    >>> round(normal_force(3.0, 0.0, math.pi / 6, 1000.0, c))
    -11250
    """
    angle = delta + math.atan2(across, along)
    return -0.5 * rho * c.area * c.lift_slope * (along * along + across * across) * math.sin(angle)


def forces(normal: float, delta: float, L: float, c: Rudder) -> tuple[float, float, float, float]:
    """X, Y [N] and N, K [N m] on the ship by the rudder's normal force, hull's share included."""
    side = normal * math.cos(delta)
    return (
        (1.0 - c.tR) * normal * math.sin(delta),
        (1.0 + c.aH) * side,
        (c.xR + c.aH * c.xH) * L * side,
        -(1.0 + c.aH) * c.zR * L * side,
    )
