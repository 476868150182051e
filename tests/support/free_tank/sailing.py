"""Sailing manoeuvres: fixed steps of Runge and Kutta over all runs of a campaign at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .flow import Body, Motion
from .hidden import Hidden

ROWS = ("x", "y", "psi", "u", "v", "r", "phi", "p", "late")
PSI = ROWS.index("psi")


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

    @property
    def coefficients(self) -> dict[str, dict[str, float]]: ...

    def revolutions(self, U: np.ndarray) -> np.ndarray: ...

    def accelerations(
        self, now: Motion, delta: np.ndarray, n: np.ndarray, blows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]: ...


@dataclass(frozen=True, kw_only=True)
class Order:
    """A manoeuvre from steady running: rudder and heading of reversal [rad], none in a turn;
    speed [m/s], length [s], true wind [m/s] and where it comes from [rad], significant height [m]
    of the waves and where they come from."""

    rudder: float
    speed: float
    seconds: float
    switch: float | None = None
    wind_speed: float = 0.0
    wind_from: float = 0.0
    sea_height: float = 0.0
    sea_from: float = 0.0


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
        return Motion(*(own[name] for name in ("u", "v", "r", "psi", "phi", "p", "late", "x", "y")))


def sail(ship: Ship, orders: Sequence[Order], step: float) -> list[Sailed]:
    """Sail manoeuvres side by side; the first order is given at t = 0.

    The gear moves at its rate to the last order, and carries the blade along where its play ends.
    Where a zigzag is reversed inside a step, the step is taken again in two parts, up to the
    instant of the heading and on from there.
    """
    speed = np.array([order.speed for order in orders])
    switch = np.array([np.inf if order.switch is None else order.switch for order in orders])
    want = np.array([order.rudder for order in orders])
    blows = np.array(
        [[order.wind_speed, order.wind_from, order.sea_height, order.sea_from] for order in orders]
    ).T
    n, delta, blade = ship.revolutions(speed), np.zeros(len(orders)), np.zeros(len(orders))
    state = np.zeros((len(ROWS), len(orders)))
    state[ROWS.index("u")] = speed
    states, rudders = [state], [delta]
    count = round(max(order.seconds for order in orders) / step)
    for _ in range(count):
        after, moved, carried = _stepped(ship, state, delta, blade, want, n, blows, step)
        side = np.sign(want)
        before, heading = side * state[PSI], side * after[PSI]
        crossed = heading >= switch
        if crossed.any():
            gain = np.where(crossed, heading - before, 1.0)
            late = np.where(crossed, (heading - switch) / gain, 0.0) * step
            after, moved, carried = _stepped(ship, state, delta, blade, want, n, blows, step - late)
            want = np.where(crossed, -want, want)
            after, moved, carried = _stepped(ship, after, moved, carried, want, n, blows, late)
        state, delta, blade = after, moved, carried
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


def _stepped(
    ship: Ship,
    state: np.ndarray,
    delta: np.ndarray,
    blade: np.ndarray,
    want: np.ndarray,
    n: np.ndarray,
    blows: np.ndarray,
    step: np.ndarray | float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """State, rudder stock and blade after a step [s]; steps may be one for all runs or one each."""
    play = ship.hidden.play
    half, whole = (
        delta + np.clip(want - delta, -ship.rate * s, ship.rate * s) for s in (0.5 * step, step)
    )
    there, carried = (np.clip(blade, stock - play, stock + play) for stock in (half, whole))
    a = _change(ship, state, blade, n, blows)
    b = _change(ship, state + 0.5 * step * a, there, n, blows)
    c = _change(ship, state + 0.5 * step * b, there, n, blows)
    d = _change(ship, state + step * c, carried, n, blows)
    return state + step / 6.0 * (a + 2.0 * b + 2.0 * c + d), whole, carried


def _change(
    ship: Ship, state: np.ndarray, delta: np.ndarray, n: np.ndarray, blows: np.ndarray
) -> np.ndarray:
    x, y, psi, u, v, r, phi, p, late = state
    hidden = ship.hidden
    now = Motion(u, v, r, psi, phi, p, late, x, y)
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
