"""The path along which a solver tows its mesh: a run of a programme, begun from rest.

The hull goes along the path of the test; only the clock of the path starts slowly. So the path has
its form from the first metre, the velocities grow together, and once the run-up is over the motion
is that of the test to the last digit. Where the test has a heading at its start (a drift angle),
the hull is turned to it during the run-up: at t = 0 the mesh lies as it was built, because a solver
takes any other first row for a jump within one time step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.campaigns import TEST_KINDS, Settings, TestKind
from pmmkit.conventions import Ship
from pmmkit.numerics import Array

RUN_UP: Final = 2.0
"""Ship lengths' time L/U of the run-up: the hull is at speed one length further, and its largest
acceleration on the way is 0.94 U²/L, of the size that oscillations with ωL/U of 1 to 5 have."""
ROWS: Final = 400
"""Rows a cycle: what lies between them is off by 1/12 (2π/400)² = 2e-5 of an amplitude at most
where a reader goes in straight lines."""
STEADY_ROWS: Final = 50
"""Rows in the time of a ship length, of a run without a cycle."""
SPARE: Final = 0.1
"""Share of a cycle, or of a ship length's time, that is computed beyond the record: whole cycles
are counted from the first sample behind the run-up, which may lie a time step late."""
_HULL: Final = frozenset({"x", "y", "psi"})


@dataclass(frozen=True, kw_only=True, eq=False)
class TowedPath:
    """Where the hull is, in tank axes: x along the tank, y to starboard, heading to starboard.

    `t` [s], `x, y` [m], `psi` [rad], `xdot, ydot` [m/s], `r` [rad/s]: arrays (n,). `run_up`: time
    after which the motion is that of the test [s]. `end`: time to which a solver computes [s]; the
    rows go a little beyond. `lead`: phase that the displacement has at t = 0 as if it had been
    swung from there on without a run-up [rad].
    """

    t: Array
    x: Array
    y: Array
    psi: Array
    xdot: Array
    ydot: Array
    r: Array
    run_up: float
    end: float
    lead: float


def is_towed(test: str) -> bool:
    """Whether moving the whole mesh in its plane makes a test: not where the rudder swings."""
    return {swing.displacement for swing in TEST_KINDS[test].swings} <= _HULL


def towed_path(test: str, settings: Settings, record: float, ship: Ship) -> TowedPath:
    """The path of a captive test of some length.

    record [s].
    """
    kind = TEST_KINDS[test]
    length_time = ship.L / settings.speed
    cycle = settings.period if kind.swings_hull and settings.period else None
    run_up = round(RUN_UP * length_time, 4)
    end = run_up + record + SPARE * (cycle or length_time)
    end = math.ceil(1000 * end) / 1000
    step = cycle / ROWS if cycle else length_time / STEADY_ROWS
    t = step * np.arange(math.ceil(end / step) + 3, dtype=np.float64)
    q = np.clip(t / run_up, 0.0, 1.0)
    share = q**3 * (10 - 15 * q + 6 * q**2)
    clock = run_up * q**4 * (2.5 - 3 * q + q**2) + np.maximum(t - run_up, 0.0)
    theta = (settings.omega or 0.0) * clock + settings.phase
    course = _course(kind, settings, theta, clock)
    turned = course["psi"][0]
    return TowedPath(
        t=t,
        x=course["x"] - course["x"][0],
        y=course["y"] - course["y"][0],
        psi=course["psi"] - turned * (1 - share),
        xdot=course["xdot"] * share,
        ydot=course["ydot"] * share,
        r=course["r"] * share + turned * 30 * (q * (1 - q)) ** 2 / run_up,
        run_up=run_up,
        end=end,
        lead=settings.phase - (settings.omega or 0.0) * run_up / 2,
    )


def _course(kind: TestKind, settings: Settings, theta: Array, clock: Array) -> dict[str, Array]:
    """Place, heading and velocities of a test over its own clock [s]."""
    from scipy.integrate import cumulative_simpson

    def along(rate: Array) -> Array:
        found: Array = cumulative_simpson(rate, x=clock, initial=0.0)
        return found

    if kind.motion.tank is not None:
        tank = kind.in_tank(settings, theta)
        xdot, ydot, psi, r = tank.xdot, tank.ydot, tank.psi, tank.r
    else:
        ship = kind.nominal(settings, theta)
        u, v, r = (np.zeros_like(theta) + ship.get(name, 0.0) for name in ("u", "v", "r"))
        psi = settings.drift + along(r)
        xdot = u * np.cos(psi) - v * np.sin(psi)
        ydot = u * np.sin(psi) + v * np.cos(psi)
    place = kind.place(settings, theta)
    if place is None:
        x, y = along(xdot), along(ydot)
    else:
        x, y = settings.speed * clock + place[0], place[1]
    return {"x": x, "y": y, "psi": psi, "xdot": xdot, "ydot": ydot, "r": r}
