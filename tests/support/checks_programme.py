"""A small captive programme with a known hull, made by hand for the tests of the checks.

The hull is the S175 container ship at 1:36 with round numbers near those of Son and Nomoto (1982),
in the prime system with the carriage speed. Faults are put in by the tests.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import xarray as xr

from pmmkit import Campaign, Run
from pmmkit.campaigns import Settings
from pmmkit.conventions import Ship, Water

SHIP = Ship(
    name="S175 model",
    L=4.861111,
    B=0.705556,
    d=0.236111,
    volume=0.454861,
    mass=454.476,
    Izz=618.332,
)
WATER = Water(rho=999.1, g=9.81, tank_width=10.0, tank_depth=5.0)
HULL = {
    "mx": 0.00024,
    "my": 0.00705,
    "Jz": 0.00042,
    "Ya": -0.00035,
    "X0": -0.0009,
    "Xvv": -0.0039,
    "Xvr": 0.0039,
    "Xrr": 0.0002,
    "Yv": -0.0116,
    "Yvvv": -0.109,
    "Yr": 0.0022,
    "Yvrr": -0.0405,
    "Nv": -0.00385,
    "Nr": -0.00222,
    "Nvvr": -0.0424,
    "Nrrr": -0.0023,
}

Change = Callable[[Run, xr.Dataset], xr.Dataset]


def forces(run: Run, state, inside: bool = False, hull=HULL) -> dict[str, np.ndarray]:
    """X [N], Y [N], N [N m] on the hull; with the model's inertia where ``inside``."""
    U, L = run.settings.speed, SHIP.L
    v, r = state.v / U, state.r * L / U
    udot, vdot, rdot = state.udot * L / U**2, state.vdot * L / U**2, state.rdot * L**2 / U**2
    u = state.u / U
    h = hull
    X = h["X0"] * u**2 + h["Xvv"] * v**2 + h["Xvr"] * v * r + h["Xrr"] * r**2 - h["mx"] * udot
    Y = (
        h["Yv"] * v
        + h["Yvvv"] * v**3
        + h["Yr"] * r * u
        + h["Yvrr"] * v * r**2
        - h["my"] * vdot
        + h["Ya"] * rdot
    )
    N = (
        h["Nv"] * v
        + h["Nr"] * r * u
        + h["Nvvr"] * v**2 * r
        + h["Nrrr"] * r**3
        + h["Ya"] * vdot
        - h["Jz"] * rdot
    )
    unit = 0.5 * WATER.rho * L**2 * U**2
    X, Y, N = X * unit, Y * unit, N * unit * L
    if inside:
        X = X - SHIP.mass * (state.udot - state.r * state.v)
        Y = Y - SHIP.mass * (state.vdot + state.r * state.u)
        N = N - SHIP.Izz * state.rdot
    return {"X": X, "Y": Y, "N": N}


def run_of(
    name: str,
    test: str,
    *,
    change: Change | None = None,
    inside: bool = False,
    noise: float = 0.01,
    motion: bool = False,
    cycles: float = 5.2,
    step: float = 0.1,
    hull=HULL,
    forces_are: str = "hydrodynamic",
    **settings,
) -> Run:
    """A history; white noise of a share of 2 % drift's force on every channel."""
    settings = {"speed": 1.5, **settings}
    bare = Run(id=name, test=test, kind="history", settings=Settings(**settings), loader=dict)

    def load() -> xr.Dataset:
        run = bare
        span = cycles * run.settings.period if run.settings.period else 60.0
        t = np.arange(0, span, step)
        state = run.nominal_motion(t)
        generator = np.random.default_rng(abs(hash_of(name)))
        channels = forces(run, state, inside, hull)
        size = 0.5 * WATER.rho * SHIP.L**2 * run.settings.speed**2 * 0.0023
        values = {
            key: ("t", part + noise * size * generator.standard_normal(len(t)))
            for key, part in channels.items()
        }
        if motion:
            names = ("u", "v", "r", "udot", "vdot", "rdot")
            values |= {key: ("t", np.array(getattr(state, key))) for key in names}
        data = xr.Dataset(values, coords={"t": t})
        return change(run, data) if change else data

    return bare.with_(loader=load, forces=forces_are)


def hash_of(name: str) -> int:
    """A number for a name that is the same in every process."""
    return int.from_bytes(name.encode()[:12].ljust(12, b"."), "big")


def programme(speeds=(1.0, 1.5, 2.0), **common) -> tuple[Run, ...]:
    """Static drift, pure sway, pure yaw and yaw with drift at some speeds."""
    runs = []
    for U in speeds:
        more = {"speed": U, "propeller_rps": 0.0, **common}
        for angle in (-12, -8, -4, 0, 2, 4, 8, 12):
            name = f"SD_{U}_{angle}"
            runs.append(run_of(name, "static_drift", drift=math.radians(angle), **more))
        for amplitude in (0.1, 0.2, 0.3, 0.4):
            name = f"PS_{U}_{amplitude}"
            runs.append(run_of(name, "pure_sway", period=12.5, amplitude=amplitude, **more))
        for angle in (4, 8, 12, 15):
            name = f"PY_{U}_{angle}"
            runs.append(
                run_of(name, "pure_yaw", period=13.2, yaw_amplitude=math.radians(angle), **more)
            )
        for angle in (4, 8):
            runs.append(
                run_of(
                    f"YD_{U}_{angle}",
                    "yaw_drift",
                    period=13.2,
                    drift=math.radians(angle),
                    yaw_amplitude=math.radians(8),
                    **more,
                )
            )
    return tuple(runs)


def campaign_of(runs, **changes) -> Campaign:
    """A campaign of the model."""
    return Campaign(title="test", **{"ship": SHIP, "water": WATER, "runs": tuple(runs), **changes})
