"""Numbers of a turning circle: advance, transfer, diameters, the steady turn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pmmkit import kernel
from pmmkit.simulation.integrate import Solution

Array = NDArray[np.float64]
_ITERATIONS = 40
_SETTLED = 1e-11
_NEAR = 0.02
"""How far, in parts of the approach speed, the end of a track may be from its steady turn."""


@dataclass(frozen=True, kw_only=True)
class SteadyTurn:
    """A turn in which nothing changes any more, SI and radians."""

    u: float
    v: float
    r: float
    phi: float


def steady_turn(
    c: kernel.Constants, guess: Array, delta: float, n: float, speed: float
) -> SteadyTurn | None:
    """The turn with no accelerations next to a guess, by Newton's method.

    Parameters
    ----------
    c : kernel.Constants
        The model at its approach speed.
    guess : array
        States in the order of `kernel.STATES`, e.g. the end of a simulation.
    delta, n : float
        Rudder angle [rad], revolutions per second.
    speed : float
        Approach speed, for the size of the steps [m/s].

    Returns
    -------
    SteadyTurn or None
        None if there is none near the guess (the motion still changes, or swings).
    """
    rolls = c.roll is not None
    size = np.array([speed, speed, speed / c.L, 1.0])
    unit = np.array([speed**2 / c.L, speed**2 / c.L, (speed / c.L) ** 2, (speed / c.L) ** 2])
    start = np.array([guess[3], guess[4], guess[5], guess[7] if rolls else 0.0]) / size
    free = 4 if rolls else 3

    def residual(z: Array) -> Array:
        u, v, r, phi = (z * size).tolist()
        rates: Array = np.array(kernel.accelerations(u, v, r, 0.0, phi, delta, n, c)) / unit
        return rates[:free]

    z = start.copy()
    for _ in range(_ITERATIONS):
        value = residual(z)
        if np.max(np.abs(value)) < _SETTLED:
            break
        steps = np.eye(4)[:free] * 1e-6
        slope = np.stack([(residual(z + h) - residual(z - h)) / 2e-6 for h in steps], axis=1)
        try:
            change = np.linalg.solve(slope, value)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.isfinite(change)) or np.max(np.abs(change)) > 1.0:
            return None
        z[:free] -= change
        if np.max(np.abs(change)) < _SETTLED:
            break
    else:
        return None
    if np.max(np.abs((z - start)[:3])) > _NEAR:
        return None
    u, v, r, phi = (z * size).tolist()
    return SteadyTurn(u=u, v=v, r=r, phi=phi)


def turning_metrics(
    solution: Solution, steady: SteadyTurn | None, *, rudder: float, speed: float, L: float
) -> Mapping[str, float]:
    """Metrics of a turning circle, positive for both sides.

    Parameters
    ----------
    solution : Solution
        States in the order of `kernel.STATES`, rudder order at t = 0 in the origin.
    steady : SteadyTurn or None
        The turn at its end.
    rudder : float
        Ordered angle [rad].
    speed : float
        Approach speed [m/s].
    L : float
        Ship length [m].

    Returns
    -------
    mapping
        ``advance`` and ``transfer`` at 90° change of heading, ``tactical_diameter`` at 180°,
        ``steady_diameter`` [m], each with ``_L`` in ship lengths; ``time_90``, ``time_180`` [s];
        ``steady_drift_deg``, ``speed_ratio`` (steady over approach speed),
        ``steady_yaw_rate_deg_s``; with roll ``heel_steady_deg`` (outward positive) and
        ``heel_max_deg`` (to either side). NaN where the track does not reach that far.
    """
    side = math.copysign(1.0, rudder)
    found: dict[str, float] = {}
    quarter = solution.crossing(2, side * math.pi / 2)
    half = solution.crossing(2, side * math.pi) if quarter == quarter else math.nan
    at_quarter, at_half = _position(solution, quarter), _position(solution, half)
    lengths = {
        "advance": at_quarter[0],
        "transfer": side * at_quarter[1],
        "tactical_diameter": side * at_half[1],
        "steady_diameter": math.nan,
    }
    rates = dict.fromkeys(("steady_drift_deg", "speed_ratio", "steady_yaw_rate_deg_s"), math.nan)
    if steady is not None:
        upright = math.cos(steady.phi)
        travel = math.hypot(steady.u, steady.v * upright)
        turn = side * steady.r * upright
        lengths["steady_diameter"] = 2 * travel / turn if turn > 0 else math.inf
        rates = {
            "steady_drift_deg": side * math.degrees(math.atan2(-steady.v, steady.u)),
            "speed_ratio": math.hypot(steady.u, steady.v) / speed,
            "steady_yaw_rate_deg_s": math.degrees(turn),
        }
    for name, value in lengths.items():
        found |= {name: value, f"{name}_L": value / L}
    found |= {"time_90": quarter, "time_180": half, **rates}
    states = solution(np.linspace(0.0, solution.end, 4001))
    if len(states) > 6:
        found["heel_max_deg"] = math.degrees(float(np.max(np.abs(states[7]))))
        found["heel_steady_deg"] = (
            -side * math.degrees(steady.phi) if steady is not None else math.nan
        )
    return MappingProxyType(found)


def _position(solution: Solution, t: float) -> tuple[float, float]:
    if t != t:
        return math.nan, math.nan
    state = solution(t)
    return float(state[0]), float(state[1])
