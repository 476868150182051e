"""Roll: what rights the ship and what damps the motion, besides the hull polynomial."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.primitives import fabs, sin


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
    force=force,
    outputs=("K",),
    source="Son and Nomoto 1981",
)
EFFECTS: Final = (ROLL,)
