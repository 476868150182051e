"""Shaft and engine: what the revolutions do when the load or the order changes."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.primitives import fabs, maximum, minimum, pi, tanh, where


def engine_torque(
    wanted: float,
    n: float,
    side: float,
    limit: int,
    torque_max: float,
    torque_at_rest: float,
    n_rated: float,
    power_max: float,
    astern_share: float,
    reverse_below: float,
) -> float:
    """What a diesel engine gives of the torque that its governor asks for [N m].

    n [1/s].

    Notes
    -----
    An engine gives torque one way only. While the shaft still turns against the way it is set, it
    gives none above the revolutions `reverse_below`, and all that it can below 0.8 of them.

    Examples
    --------
    >>> engine_torque(9e5, 1.5, 1.0, 0, 6e5, 1.0, 2.0, 0.0, 1.0, 0.5)
    600000.0
    >>> engine_torque(-9e5, 1.5, -1.0, 0, 6e5, 1.0, 2.0, 0.0, 1.0, 0.5)
    -0.0
    """
    turning = fabs(n)
    most = torque_max + 0.0 * turning
    if limit == 1:
        falling = torque_at_rest + (1.0 - torque_at_rest) * turning / n_rated
        most = torque_max * minimum(falling, 1.0)
    if limit == 2:
        most = minimum(torque_max, power_max / (2.0 * pi * maximum(turning, 1e-9)))
    allowed = minimum(maximum((reverse_below - turning) / (0.2 * reverse_below), 0.0), 1.0)
    most = most * where(n * side < 0.0, allowed, 1.0) * where(side < 0.0, astern_share, 1.0)
    return side * minimum(maximum(side * wanted, 0.0), most)


def force(
    n: float,
    n_order: float,
    torque: float,
    limit: int,
    inertia: float,
    torque_max: float,
    torque_at_rest: float,
    n_rated: float,
    power_max: float,
    astern_share: float,
    reverse_below: float,
    friction: float,
    n_low: float,
    time_constant: float,
) -> tuple[float]:
    """Rate of the revolutions [1/s²]: 2π I dn/dt = QE - Q - Qf.

    The governor asks for the torque that brings the revolutions to the order within its time
    constant, and the engine gives what it can. Without a limit in the way the revolutions are
    those ordered, without droop. An explicit integration needs steps below about twice the time
    constant.

    Examples
    --------
    >>> force(1.0, 1.1, 5e5, 0, 1e5, 1e6, 1.0, 2.0, 0.0, 1.0, 0.5, 0.0, 0.3, 2.0)
    (0.05...,)
    """
    moment = 2.0 * pi * inertia
    load = torque + friction * tanh(n / n_low)
    wanted = load + moment * (n_order - n) / time_constant
    side = where(n_order < 0.0, -1.0, 1.0)
    given = engine_torque(
        wanted,
        n,
        side,
        limit,
        torque_max,
        torque_at_rest,
        n_rated,
        power_max,
        astern_share,
        reverse_below,
    )
    return ((given - load) / moment,)


def lag(
    n: float,
    n_order: float,
    law: int,
    time_constant: float,
    time_turns: float,
    n_low: float,
    n_step: float,
) -> tuple[float]:
    """Rate of revolutions that follow their order [1/s²], whatever the load.

    dn/dt = (nO - n)/Tm; ``by-turns``: Tm is `time_turns` over the revolutions, at least `n_low`.

    Examples
    --------
    >>> lag(1.0, 2.0, 0, 5.0, 5.65, 0.3, 1e6)
    (0.2,)
    >>> 1 / lag(0.1, 1.1, 1, 5.0, 5.65, 0.3, 1e6)[0]
    18.83...
    """
    gap = minimum(maximum(n_order - n, -n_step), n_step)
    if law == 0:
        return (gap / time_constant,)
    return (gap * maximum(fabs(n), n_low) / time_turns,)


_FALLING: Final = ("limit", "falling")
SHAFT: Final = Effect(
    name="shaft",
    family="shaft",
    kind="state",
    roles=("shaft",),
    summary="Revolutions as a state: an engine with governor, limits of torque and power, and a "
    "reversal that has to wait.",
    parameters=(
        Parameter(
            name="inertia",
            text="rotating inertia of engine, shaft, propeller and its water, at "
            "the speed of the shaft",
            unit="kg m2",
            low=1e-12,
        ),
        Parameter(name="torque_max", text="largest torque at the shaft", unit="N m", low=0.0),
        Parameter(
            name="torque_at_rest",
            text="torque limit at rest over that at n_rated",
            default=0.4,
            low=0.0,
            high=1.0,
            form=_FALLING,
        ),
        Parameter(
            name="n_rated",
            text="revolutions from which the whole torque is there",
            unit="1/s",
            low=1e-6,
            form=_FALLING,
        ),
        Parameter(
            name="power_max",
            text="largest power at the shaft",
            unit="W",
            low=0.0,
            form=("limit", "power"),
        ),
        Parameter(
            name="astern_share",
            text="torque limit astern over that ahead",
            default=1.0,
            low=0.0,
            high=1.0,
        ),
        Parameter(
            name="reverse_below",
            text="revolutions below which the engine can be started against "
            "the way the shaft turns",
            unit="1/s",
            default=1e6,
            low=1e-6,
        ),
        Parameter(name="friction", text="torque of friction", unit="N m", default=0.0, low=0.0),
        Parameter(
            name="n_low",
            text="revolutions below which the friction fades",
            unit="1/s",
            default=0.3,
            low=1e-6,
        ),
        Parameter(name="time_constant", text="of the governor", unit="s", default=5.0, low=1e-3),
    ),
    options={"limit": ("constant", "falling", "power")},
    needs=("n",),
    force=force,
    outputs=("n_rate",),
    states=("n",),
    sources=("sea_trial_identification",),
    remark="equation of the shaft and constant limit of the torque",
)
SHAFT_LAG: Final = Effect(
    name="shaft_lag",
    family="shaft",
    kind="state",
    roles=("shaft",),
    summary="Revolutions as a state that follows its order with a time constant.",
    parameters=(
        Parameter(
            name="time_constant",
            text="of the revolutions",
            unit="s",
            low=1e-3,
            form=("law", "first-order"),
        ),
        Parameter(
            name="time_turns",
            text="time constant times revolutions",
            default=5.65,
            low=1e-6,
            form=("law", "by-turns"),
        ),
        Parameter(
            name="n_low",
            text="revolutions below which the time constant grows no more",
            unit="1/s",
            default=0.3,
            low=1e-6,
            form=("law", "by-turns"),
        ),
        Parameter(
            name="n_step",
            text="largest difference from the order that is acted on: limits the "
            "rate to this over the time constant",
            unit="1/s",
            default=1e6,
            low=1e-9,
        ),
    ),
    options={"law": ("first-order", "by-turns")},
    needs=("n",),
    force=lag,
    outputs=("n_rate",),
    states=("n",),
    sources=("van_berlekom_goddard_1972", "son_nomoto_1981"),
    remark="by turns as the MSS toolbox has it",
)
EFFECTS: Final = (SHAFT, SHAFT_LAG)
