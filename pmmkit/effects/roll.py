"""Roll: what rights the ship and what damps the motion, besides the hull polynomial."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.ship import Ship, Water

ROLL: Final = Effect(
    name="roll",
    family="roll",
    kind="force",
    summary="Righting moment by the metacentric height, and roll damping.",
    parameters=(
        Parameter(name="damping", text="moment per roll rate", unit="N m s", default=0.0, low=0.0),
        Parameter(
            name="damping_quadratic",
            text="moment per square of the roll rate",
            unit="N m s2",
            default=0.0,
            low=0.0,
        ),
    ),
    options={"restoring": ("linear", "sine")},
    needs=("phi", "p"),
    source="Son and Nomoto 1981",
)
EFFECTS: Final = (ROLL,)


class Roll(NamedTuple):
    """Values of the roll part, SI: `stiffness` is ρ g volume GM [N m]."""

    stiffness: float
    damping: float
    damping_quadratic: float
    sine: bool


def resolve(
    values: Mapping[str, float], options: Mapping[str, str], *, ship: Ship, water: Water
) -> Roll:
    """The roll part of a ship; it needs the ship's GM."""
    assert ship.GM is not None
    return Roll(
        stiffness=water.rho * water.g * ship.volume * ship.GM,
        damping=values["damping"],
        damping_quadratic=values["damping_quadratic"],
        sine=options["restoring"] == "sine",
    )


def moment(p: float, phi: float, c: Roll) -> float:
    """Roll moment [N m] at a roll rate [rad/s] and a heel [rad].

    Examples
    --------
    >>> moment(0.0, 0.1, Roll(stiffness=1e6, damping=0., damping_quadratic=0., sine=False))
    -100000.0
    """
    heel = math.sin(phi) if c.sine else phi
    return -c.stiffness * heel - (c.damping + c.damping_quadratic * abs(p)) * p
