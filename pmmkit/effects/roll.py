"""Roll: what rights the ship and what damps the motion, besides the hull polynomial."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import fabs, sin, sqrt
from pmmkit.effects.seen import Move, Vessel


def force(
    p: float,
    phi: float,
    rho: float,
    g: float,
    volume: float,
    GM: float,
    damping: float,
    damping_quadratic: float,
    restoring: int,
) -> tuple[float]:
    """Roll moment [N m] at a roll rate [rad/s] and a heel [rad].

    Examples
    --------
    >>> force(0.0, 0.1, 1000.0, 10.0, 100.0, 1.0, 0.0, 0.0, 0)
    (-100000.0,)
    """
    heel = phi if restoring == 0 else sin(phi)
    return (-rho * g * volume * GM * heel - (damping + damping_quadratic * fabs(p)) * p,)


ROLL_PART: Final = "roll"
ROLL: Final = Effect(
    name=ROLL_PART,
    family="roll",
    kind="force",
    roles=("roll",),
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
    force=force,
    outputs=("K",),
    sources=("son_nomoto_1981",),
)


def damping_of_the_ship(vessel: Vessel) -> Mapping[str, Move]:
    """Roll damping off by a twentieth of the critical one."""
    ship, water = vessel.ship, vessel.water
    if not (ship.GM and ship.Ixx and vessel.holds(ROLL_PART, "damping")):
        return {}
    critical = 2.0 * sqrt(water.rho * water.g * ship.volume * ship.GM * ship.Ixx)
    return {"damping": Move(values={f"{ROLL_PART}.damping": 1.0}, typical=0.05 * critical)}


ROLL_DAMPING: Final = Effect(
    name="roll_damping",
    family="roll",
    kind="freed",
    frees=ROLL_PART,
    summary="Damping of roll by keels and hull.",
    moves=damping_of_the_ship,
    sources=("ikeda_himeno_tanaka_1978",),
    check="a roll decay test",
    excites=("roll",),
    not_captive="captive tests measure X, Y and N; roll moments are not diagnosed",
)
EFFECTS: Final = (ROLL, ROLL_DAMPING)
