"""Shaft and engine: what the revolutions do when the load or the order changes."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.primitives import fabs, maximum, minimum, pi, where


def force(
    n: float, n_order: float, torque: float, inertia: float, torque_max: float, power_max: float,
    astern_share: float, reverse_below: float, friction: float, time_constant: float,
) -> tuple[float]:  # fmt: skip
    """Rate of the revolutions [1/s²].

    2π I dn/dt = QE - Q - friction. The governor asks for the torque that brings the order within
    its time constant, at most that of the engine. Ordered astern, the engine gives none before the
    revolutions ahead have fallen below `reverse_below`, and likewise the other way.
    """
    moment = 2.0 * pi * inertia
    rubbing = friction * n / maximum(fabs(n), 1e-3)
    wanted = torque + rubbing + moment * (n_order - n) / time_constant
    most = minimum(torque_max, power_max / (2.0 * pi * maximum(fabs(n), 1e-3)))
    ahead = where(n < -reverse_below, 0.0, minimum(maximum(wanted, 0.0), most))
    back = where(n > reverse_below, 0.0, maximum(minimum(wanted, 0.0), -astern_share * most))
    given = where(n_order >= 0.0, ahead, back)
    return ((given - torque - rubbing) / moment,)


def lag(n: float, n_order: float, time_constant: float) -> tuple[float]:
    """Rate of the revolutions that follow their order [1/s²].

    Examples
    --------
    >>> lag(1.0, 2.0, 5.0)
    (0.2,)
    """
    return ((n_order - n) / time_constant,)


SHAFT: Final = Effect(
    name="shaft",
    family="shaft",
    kind="state",
    summary="Revolutions as a state: an engine with governor, limit of torque and power, and a "
    "reversal that has to wait.",
    parameters=(
        Parameter(name="inertia", text="rotating inertia, water included", unit="kg m2", low=1e-9),
        Parameter(
            name="torque_max", text="largest torque of the engine", unit="N m", default=1e12,
            low=0.0,
        ),
        Parameter(
            name="power_max", text="largest power of the engine", unit="W", default=1e15, low=0.0
        ),
        Parameter(
            name="astern_share", text="torque astern over that ahead", default=1.0, low=0.0,
            high=1.0,
        ),
        Parameter(
            name="reverse_below", text="revolutions below which the engine can be reversed",
            unit="1/s", default=1e6, low=0.0,
        ),
        Parameter(name="friction", text="torque of friction", unit="N m", default=0.0, low=0.0),
        Parameter(
            name="time_constant", text="of the governor", unit="s", default=5.0, low=1e-3
        ),
    ),
    needs=("n",),
    force=force,
    outputs=("n_rate",),
    states=("n",),
    source="Equation of the shaft; torque limit of a diesel engine as in stopping models (Kose "
    "1984)",
)  # fmt: skip
SHAFT_LAG: Final = Effect(
    name="shaft_lag",
    family="shaft",
    kind="state",
    summary="Revolutions as a state that follows its order with a time constant.",
    parameters=(
        Parameter(name="time_constant", text="of the revolutions", unit="s", low=1e-3),
    ),
    needs=("n",),
    force=lag,
    outputs=("n_rate",),
    states=("n",),
    source="Van Berlekom and Goddard 1972; Son and Nomoto 1981",
)  # fmt: skip
EFFECTS: Final = (SHAFT, SHAFT_LAG)
