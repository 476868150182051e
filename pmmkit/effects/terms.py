"""Effects that are derivatives of the hull polynomial: one name for terms of one cause."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from pmmkit.conventions import parse_derivative
from pmmkit.effects.definition import BY_SPEED, Effect, Parameter
from pmmkit.effects.roll import ROLL_PART
from pmmkit.effects.rudder import stall_of_the_rudder
from pmmkit.effects.seen import Move, Vessel


def terms(
    name: str,
    family: str,
    summary: str,
    sizes: Mapping[str, float],
    *,
    sources: tuple[str, ...] = (),
    check: str = "",
    excites: tuple[str, ...] = (),
    **more: Any,
) -> Effect:
    """An effect that is written in derivatives.

    Examples
    --------
    >>> terms("sway_drag", "hull", "Drag.", {"Yv|v|": -0.02}).parameters[0].text
    'multiplies v|v| in Y'
    """
    return Effect(
        name=name,
        family=family,
        kind="terms",
        summary=summary,
        sources=sources,
        check=check,
        excites=excites,
        **more,
        parameters=tuple(
            Parameter(name=label, text=_meaning(label), typical=size)
            for label, size in sizes.items()
        ),
    )


_HEEL: Final = MappingProxyType(
    {
        "Yphi": -4e-4,
        "Nphi": -3e-4,
        "Yvphiphi": 0.003,
        "Nvvphi": -0.019,
        "Yrphiphi": 0.003,
        "Nrrphi": -0.003,
    }
)
"""What static heel and heeled drift show of the forces of heel."""
_HEEL_SAILED: Final = MappingProxyType(
    {
        **_HEEL,
        "Xphiphi": -2e-4,
        "Yvvphi": 0.046,
        "Yrrphi": 0.0093,
        "Nvphiphi": -0.0054,
        "Nrphiphi": 0.0024,
        "Np": 2.1e-4,
    }
)
"""All of them, and the moment of the roll rate: a ship that turns has them at once."""


_HEEL_DRIVEN: Final = MappingProxyType({**_HEEL_SAILED, "Ypdot": 2.2e-4})
"""And the side force of the roll's acceleration, which a ship that rolls has in her masses."""


def heel_of_the_ship(vessel: Vessel) -> Mapping[str, Move]:
    """Every derivative of heel and its rates that sailing shows; in the prime system."""
    rolls = vessel.holds(ROLL_PART, "damping")
    return {
        label: Move(values=MappingProxyType({label: 1.0}), typical=size)
        for label, size in (_HEEL_SAILED if rolls else _HEEL_DRIVEN).items()
    }


def _meaning(label: str) -> str:
    derivative = parse_derivative(label.removesuffix(BY_SPEED))
    product = "1" if derivative.factors == ("0",) else "".join(derivative.factors)
    times = " and (Fn/Fn0)² - 1" if label.endswith(BY_SPEED) else ""
    return f"multiplies {product}{times} in {derivative.channel}"


EFFECTS: Final = (
    terms(
        "modulus_sway_drag",
        "cross_flow",
        "Drag of sway with the square of its velocity.",
        {"Yv|v|": -0.020, "Nv|v|": 0.004},
        sources=("fedyaevsky_sobolev_1964", "norrbin_1971"),
        check="static drift at 15 to 25°, or pure sway at a third amplitude",
        in_words="Sway drag v|v|",
    ),
    terms(
        "modulus_yaw_drag",
        "cross_flow",
        "Drag of yaw with the square of its rate.",
        {"Yr|r|": 0.0022, "Nr|r|": -0.0017},
        sources=("norrbin_1971",),
        check="pure yaw at r' 0.8, or circular motion",
        in_words="Yaw drag r|r|",
    ),
    terms(
        "cubic_hull_terms",
        "hull",
        "Damping that grows with the cube of sway and of yaw.",
        {"Yvvv": -0.109, "Nvvv": 0.0015, "Yrrr": 0.0018, "Nrrr": -0.0023},
        sources=("abkowitz_1964",),
        check="static drift to 15°, and pure yaw at a third amplitude",
        not_free_running="sway and yaw go together in free running: the modulus terms stand for it",
    ),
    terms(
        "higher_order_hull",
        "hull",
        "Fifth powers of sway and of yaw.",
        {"Yvvvvv": -0.5, "Nvvvvv": 0.05, "Yrrrrr": 0.001, "Nrrrrr": -0.001},
        sources=("toxopeus_2011",),
        check="static drift to 25°, circular motion at r' 1",
        excites=("large motion",),
        not_free_running="sway and yaw go together in free running: the modulus terms stand for it",
        in_words="Higher-order hull terms",
    ),
    terms(
        "yaw_sway_coupling",
        "hull_coupling",
        "Products of sway and yaw in side force and moment.",
        {"Yvvr": 0.0214, "Yvrr": -0.0405, "Nvvr": -0.0424, "Nvrr": 0.00156},
        sources=("son_nomoto_1981",),
        check="yaw with drift at two drift angles of both signs",
        in_words="Yaw–sway coupling",
    ),
    terms(
        "surge_yaw_coupling",
        "surge",
        "Surge force of sway and yaw together.",
        {"Xvr": 0.0039},
        sources=("yasukawa_yoshimura_2015",),
        check="yaw with drift at two drift angles",
        in_words="Surge–yaw coupling",
    ),
    terms(
        "surge_quadratic",
        "surge",
        "Surge force of sway and of yaw alone.",
        {"Xvv": -0.0039, "Xrr": 0.0005},
        sources=("son_nomoto_1981",),
        check="static drift and pure yaw, surge force",
        in_words="Surge of second order",
    ),
    terms(
        "surge_fourth_order",
        "surge",
        "Surge force with the fourth power of sway.",
        {"Xvvvv": 0.05},
        sources=("yasukawa_yoshimura_2015",),
        check="static drift to 20°",
        in_words="Surge of fourth order",
    ),
    terms(
        "asymmetry",
        "asymmetry",
        "A constant side force and moment, with the square of the speed.",
        {"Y0": 1.0e-4, "N0": -4.5e-5},
        sources=("abkowitz_1964",),
        check="a straight run without the propeller",
    ),
    terms(
        "even_hull_terms",
        "asymmetry",
        "Forces that are the same to port and to starboard.",
        {"Yvv": 0.003, "Nvv": 0.0004, "Yrr": 0.001, "Nrr": -0.0003, "Yvr": 0.001, "Nvr": 0.001},
        sources=("abkowitz_1964",),
        check="static drift to both sides",
    ),
    terms(
        "acceleration_cross_terms",
        "inertia",
        "Side force of yaw acceleration, moment of sway acceleration.",
        {"Yrdot": -3.5e-4, "Nvdot": -3.5e-4},
        sources=("clarke_gedling_hine_1983",),
        check="pure sway and pure yaw",
    ),
    terms(
        "heel_coupling",
        "heel",
        "Forces of the heel angle.",
        _HEEL,
        sources=("son_nomoto_1981",),
        check="static heel of 5 and 10° straight ahead",
        excites=("roll",),
        moves=heel_of_the_ship,
    ),
    terms(
        "rudder_stall",
        "rudder",
        "Rudder force that bends over at large angles.",
        {"Yddd": 0.0045, "Nddd": -0.0022},
        sources=("molland_turnock_2007",),
        check="rudder at 25, 30 and 35°",
        excites=("rudder",),
        moves=stall_of_the_rudder,
    ),
    terms(
        "rudder_cross_terms",
        "rudder",
        "Rudder force that changes with drift.",
        {"Yvvd": -0.06, "Yvdd": 0.02, "Nvvd": 0.03, "Nvdd": -0.01},
        sources=("strom_tejsen_1965",),
        check="drift with rudder at both signs of each",
        excites=("rudder",),
    ),
)
