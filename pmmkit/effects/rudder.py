"""Rudder behind propeller and hull: inflow, normal force, what the hull adds."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import atan2, cos, fabs, maximum, minimum, pi, sin, sqrt, where
from pmmkit.effects.seen import Move, Vessel


def rudder_flow(
    v: float,
    r: float,
    beta: float,
    L: float,
    U: float,
    propeller_inflow: float,
    loading: float,
    inflow: int,
    epsilon: float,
    kappa: float,
    eta: float,
    gamma_positive: float,
    gamma_negative: float,
    lR: float,
    gamma: float,
    cRr: float,
    cRrrr: float,
    cRrrv: float,
) -> tuple[float, float]:
    """Water speed along and across the ship at the rudder [m/s].

    Parameters
    ----------
    v, r, beta, U : float
        Sway velocity [m/s], yaw rate [rad/s], drift angle [rad] at midship, speed [m/s].
    L : float
        Ship length [m].
    propeller_inflow : float
        Speed of the water into the propeller disc [m/s].
    loading : float
        Thrust over ρ D² [m²/s²]; KT/J² is this over the square of `propeller_inflow`.
    inflow : int
        0 Son and Nomoto, 1 MMG.
    epsilon, kappa, eta, gamma_positive, gamma_negative, lR, gamma, cRr, cRrrr, cRrrv : float
        Parameters of the effect ``rudder_mmg``.

    Notes
    -----
    Son and Nomoto (1981): ε uP sqrt(1 + 8 κ KT/(π J²)) and γ v' + cRr r' + cRrrr r'³ +
    cRrrv r'² v'. Yasukawa and Yoshimura (2015): ε uP sqrt(η [1 + κ (sqrt(1 + 8 KT/(π J²)) - 1)]²
    + 1 - η) and -γR (β - lR r'), γR by the sign of the inflow angle.
    """
    yaw = r * L / U
    jet = 8.0 * loading / pi
    square = propeller_inflow * propeller_inflow
    if inflow == 0:
        along = epsilon * sqrt(maximum(square + kappa * jet, 0.0))
        sway = v / U
        across = gamma * sway + yaw * (cRr + yaw * (cRrrr * yaw + cRrrv * sway))
        return along, across * U
    behind = sqrt(maximum(square + jet, 0.0))
    mixed = propeller_inflow + kappa * (behind - propeller_inflow)
    along = epsilon * sqrt(maximum(eta * mixed * mixed + (1.0 - eta) * square, 0.0))
    angle = beta - lR * yaw
    straightening = where(angle > 0.0, gamma_positive, gamma_negative)
    return along, -straightening * angle * U


def normal_force(
    along: float,
    across: float,
    delta: float,
    rho: float,
    area: float,
    lift_slope: float,
    stall: int,
    stall_deg: float,
    stall_loss: float,
) -> float:
    """Normal force of the rudder [N], negative when the rudder turns the ship to starboard.

    -½ρ A fα V² sin α with α = δ + atan(across/along), written by sums of angles. With `stall` the
    force falls beyond the stall angle by the share that is lost: 1 smoothly over 10°, 2 so much
    more with each 10°, down to what a plate across the flow has.

    Examples
    --------
    >>> from math import radians
    >>> round(normal_force(3.0, 0.0, radians(30), 1000.0, 2.0, 2.5, 0, 0.0, 0.0))
    -11250
    >>> round(normal_force(3.0, 0.0, radians(30), 1000.0, 2.0, 2.5, 2, 20.0, 0.3))
    -7875
    """
    flow = sqrt(along * along + across * across)
    force = -0.5 * rho * area * lift_slope * flow * (along * sin(delta) + across * cos(delta))
    if stall == 0:
        return force
    angle = fabs(delta + atan2(across, along)) * 180.0 / pi
    if stall == 2:
        further = maximum((angle - stall_deg) / 10.0, 0.0)
        # A plate across the flow has a coefficient of about 1.2, a rudder's fα is 2.5 to 3.
        return force * maximum(1.0 - stall_loss * further, 0.4)
    beyond = minimum(maximum((angle - stall_deg) / 10.0, 0.0), 1.0)
    return force * (1.0 - stall_loss * beyond * beyond * (3.0 - 2.0 * beyond))


def force(
    v: float,
    r: float,
    beta: float,
    delta: float,
    L: float,
    U: float,
    rho: float,
    propeller_inflow: float,
    loading: float,
    inflow: int,
    area: float,
    lift_slope: float,
    epsilon: float,
    kappa: float,
    eta: float,
    gamma_positive: float,
    gamma_negative: float,
    lR: float,
    gamma: float,
    cRr: float,
    cRrrr: float,
    cRrrv: float,
    tR: float,
    aH: float,
    xH: float,
    xR: float,
    zR: float,
    stall: int,
    stall_deg: float,
    stall_loss: float,
) -> tuple[float, float, float, float, float]:
    """X, Y [N], N, K [N m] on the ship with the hull's share, and the rudder's normal force [N]."""
    along, across = rudder_flow(
        v,
        r,
        beta,
        L,
        U,
        propeller_inflow,
        loading,
        inflow,
        epsilon,
        kappa,
        eta,
        gamma_positive,
        gamma_negative,
        lR,
        gamma,
        cRr,
        cRrrr,
        cRrrv,
    )
    normal = normal_force(along, across, delta, rho, area, lift_slope, stall, stall_deg, stall_loss)
    side = normal * cos(delta)
    return (
        (1.0 - tR) * normal * sin(delta),
        (1.0 + aH) * side,
        (xR + aH * xH) * L * side,
        -(1.0 + aH) * zR * L * side,
        normal,
    )


_SN: Final = ("inflow", "son-nomoto")
_MMG: Final = ("inflow", "mmg")
_STALL: Final = ("stall", "smooth", "linear")
RUDDER_MMG: Final = Effect(
    name="rudder_mmg",
    in_words="Rudder (MMG)",
    family="rudder",
    kind="force",
    roles=("steering",),
    summary="Rudder force from the flow at the rudder, with the force it raises on the hull.",
    parameters=(
        Parameter(name="area", text="rudder area", unit="m2", low=1e-9),
        Parameter(name="lift_slope", text="gradient fα of the normal force coefficient", low=0.0),
        Parameter(
            name="epsilon",
            text="wake at the rudder over wake at the propeller",
            low=0.0,
            uncertain=True,
        ),
        Parameter(name="kappa", text="share of the slipstream's acceleration at the rudder"),
        Parameter(name="eta", text="propeller diameter over rudder height", form=_MMG),
        Parameter(
            name="gamma_positive",
            text="flow straightening, inflow from port",
            form=_MMG,
            uncertain=True,
        ),
        Parameter(
            name="gamma_negative",
            text="flow straightening, inflow from starboard",
            form=_MMG,
            uncertain=True,
        ),
        Parameter(
            name="lR", text="effective lever of the yaw rate at the rudder over L", form=_MMG
        ),
        Parameter(name="gamma", text="flow straightening of v'", form=_SN, uncertain=True),
        Parameter(name="cRr", text="cross flow per r'", form=_SN, uncertain=True),
        Parameter(name="cRrrr", text="cross flow per r'³", default=0.0, form=_SN),
        Parameter(name="cRrrv", text="cross flow per r'² v'", default=0.0, form=_SN),
        Parameter(name="tR", text="steering resistance deduction"),
        Parameter(name="aH", text="hull force over rudder force", uncertain=True),
        Parameter(name="xH", text="point of the hull force forward of midship over L"),
        Parameter(name="xR", text="rudder forward of midship over L", default=-0.5),
        Parameter(name="zR", text="rudder force below the origin over L", default=0.0),
        Parameter(
            name="stall_deg",
            text="angle of attack at which the rudder begins to stall",
            unit="deg",
            form=_STALL,
            low=1.0,
        ),
        Parameter(
            name="stall_loss",
            text="share of the normal force lost 10 degrees beyond that angle; below 0 gained",
            form=_STALL,
            low=-1.0,
            high=1.0,
        ),
        Parameter(name="rate_deg_s", text="rate of the steering gear", unit="deg/s", low=1e-6),
        Parameter(name="max_deg", text="largest rudder angle", unit="deg", default=90.0, low=0.0),
    ),
    options={"inflow": ("son-nomoto", "mmg"), "stall": ("none", "smooth", "linear")},
    needs=("delta", "n"),
    force=force,
    outputs=("X", "Y", "N", "K", "rudder_force"),
    sources=("son_nomoto_1981", "yasukawa_yoshimura_2015"),
)


_STALLING: Final = {"stall_loss": (0.0, 0.4), "stall_deg": (15.0, 5.0)}
"""Where values of a stall begin and how far they usually are from there: few stall before 15°."""


def stall_of_the_rudder(vessel: Vessel) -> Mapping[str, Move]:
    """The stall of a rudder in the flow behind ship and propeller; none without such a rudder.

    A rudder of which nothing is known begins to stall at 15° and loses nothing.
    """
    part = RUDDER_MMG.name
    if not vessel.holds(part, "area"):
        return {}
    begins = MappingProxyType({f"{part}.{name}": at for name, (at, _) in _STALLING.items()})
    # How the force falls is not known: in proportion is the first term of any law.
    words = {} if vessel.holds(part, "stall_loss") else {"stall": "linear"}
    options = MappingProxyType({part: MappingProxyType(words)})
    return {
        name: Move(
            values=MappingProxyType({f"{part}.{name}": 1.0}),
            typical=usual,
            options=options,
            begins=begins,
        )
        for name, (_, usual) in _STALLING.items()
    }


def _freed(
    name: str, summary: str, sizes: Mapping[str, float], *, check: str, in_words: str = ""
) -> Effect:
    return Effect(
        name=name,
        family="rudder",
        kind="freed",
        frees=RUDDER_MMG.name,
        summary=summary,
        parameters=tuple(
            Parameter(name=own, text=text, typical=size)
            for own, size in sizes.items()
            if (known := RUDDER_MMG.parameter(own)) is not None
            for text in [f"change of the {known.text}"]
        ),
        sources=("yasukawa_yoshimura_2015", "son_nomoto_1981"),
        check=check,
        in_words=in_words,
        not_captive="captive tests are reduced to derivatives, which hold the rudder as it is",
    )


FLOW_STRAIGHTENING: Final = _freed(
    "flow_straightening",
    "How much of the flow across the stern the rudder feels, to port and to starboard.",
    {"gamma_positive": 0.15, "gamma_negative": 0.15, "lR": 0.2, "gamma": 0.1, "cRr": 0.1},
    check="captive drift with rudder at the four corners ±β, ±δ",
)
RUDDER_SLIPSTREAM: Final = _freed(
    "rudder_slipstream",
    "Speed of the flow at the rudder behind the propeller.",
    {"epsilon": 0.15, "kappa": 0.15},
    check="captive rudder at three propeller loads",
)
RUDDER_HULL_INTERACTION: Final = _freed(
    "rudder_hull_interaction",
    "Force that the rudder raises on the hull.",
    {"aH": 0.1, "xH": 0.15, "tR": 0.1},
    check="captive rudder with a rudder gauge",
    in_words="Rudder–hull interaction",
)
EFFECTS: Final = (RUDDER_MMG, FLOW_STRAIGHTENING, RUDDER_SLIPSTREAM, RUDDER_HULL_INTERACTION)
