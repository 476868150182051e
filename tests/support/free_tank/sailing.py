"""Sailing manoeuvres: fixed steps of Runge and Kutta over all runs of a campaign at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .flow import Body, Motion
from .hidden import Hidden

ROWS = ("x", "y", "psi", "u", "v", "r", "phi", "p", "late")


class Ship(Protocol):
    """What sails."""

    @property
    def hidden(self) -> Hidden: ...

    @property
    def rolls(self) -> bool: ...

    @property
    def body(self) -> Body: ...

    @property
    def rate(self) -> float: ...

    def revolutions(self, U: np.ndarray) -> np.ndarray: ...

    def accelerations(
        self, now: Motion, delta: np.ndarray, n: np.ndarray, blows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]: ...


@dataclass(frozen=True, kw_only=True)
class Order:
    """A manoeuvre from steady running: rudder and heading of reversal [rad], none in a turn;
    speed [m/s], length [s], true wind [m/s] and where it comes from [rad]."""

    rudder: float
    speed: float
    seconds: float
    switch: float | None = None
    wind_speed: float = 0.0
    wind_from: float = 0.0


@dataclass(frozen=True)
class Sailed:
    """Time [s] of a run, its motion by the names of `ROWS`, rudder as indicated [rad],
    revolutions [1/s]."""

    t: np.ndarray
    motion: dict[str, np.ndarray]
    delta: np.ndarray
    n: float
    order: Order

    def now(self) -> Motion:
        """All instants as one motion."""
        own = self.motion
        return Motion(*(own[name] for name in ("u", "v", "r", "psi", "phi", "p", "late")))


def sail(ship: Ship, orders: Sequence[Order], step: float) -> list[Sailed]:
    """Sail manoeuvres side by side; the first order is given at t = 0.

    The gear moves at its rate to the last order. A zigzag is reversed inside a step: the gear then
    catches up what it should have moved since the heading was reached.
    """
    speed = np.array([order.speed for order in orders])
    switch = np.array([np.inf if order.switch is None else order.switch for order in orders])
    want = np.array([order.rudder for order in orders])
    blows = np.array([[order.wind_speed, order.wind_from] for order in orders]).T
    n, delta = ship.revolutions(speed), np.zeros(len(orders))
    state = np.zeros((len(ROWS), len(orders)))
    state[ROWS.index("u")] = speed
    states, rudders = [state], [delta]
    count = round(max(order.seconds for order in orders) / step)
    for _ in range(count):
        half, whole = (_moved(delta, want, ship.rate * s) for s in (0.5 * step, step))
        after = _runge_kutta(ship, state, (delta, half, whole), n, blows, step)
        side = np.sign(want)
        before, heading = side * state[2], side * after[2]
        crossed = heading >= switch
        late = np.where(crossed, (heading - switch) / np.where(crossed, heading - before, 1.0), 0.0)
        on_time = _moved(delta, want, ship.rate * step * (1.0 - late))
        want = np.where(crossed, -want, want)
        delta = np.where(crossed, _moved(on_time, want, ship.rate * step * late), whole)
        state = after
        states.append(state)
        rudders.append(delta)
    t, found, angles = step * np.arange(count + 1), np.stack(states), np.stack(rudders)
    return [
        Sailed(
            t[: (kept := round(order.seconds / step) + 1)],
            {name: found[:kept, row, i] for row, name in enumerate(ROWS)},
            angles[:kept, i],
            float(n[i]),
            order,
        )
        for i, order in enumerate(orders)
    ]


def _moved(delta: np.ndarray, want: np.ndarray, most: np.ndarray | float) -> np.ndarray:
    return delta + np.clip(want - delta, -most, most)


def _runge_kutta(
    ship: Ship,
    state: np.ndarray,
    rudders: tuple[np.ndarray, np.ndarray, np.ndarray],
    n: np.ndarray,
    blows: np.ndarray,
    step: float,
) -> np.ndarray:
    a = _change(ship, state, rudders[0], n, blows)
    b = _change(ship, state + 0.5 * step * a, rudders[1], n, blows)
    c = _change(ship, state + 0.5 * step * b, rudders[1], n, blows)
    d = _change(ship, state + step * c, rudders[2], n, blows)
    return state + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)


def _change(
    ship: Ship, state: np.ndarray, delta: np.ndarray, n: np.ndarray, blows: np.ndarray
) -> np.ndarray:
    _, _, psi, u, v, r, phi, p, late = state
    hidden = ship.hidden
    now = Motion(u, v, r, psi, phi, p, late)
    surge, sway, yaw, roll = ship.accelerations(now, delta + hidden.rudder_zero, n, blows)
    level, U = v * np.cos(phi), now.speed
    return np.stack(
        [
            u * np.cos(psi) - level * np.sin(psi) + hidden.current[0],
            u * np.sin(psi) + level * np.cos(psi) + hidden.current[1],
            r * np.cos(phi),
            surge,
            sway,
            yaw,
            p,
            roll,
            (v / U - late) * U / (hidden.lag * ship.body.L),
        ]
    )
