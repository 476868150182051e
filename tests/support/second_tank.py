"""A second virtual tank: a full tanker on a raw balance, written apart from package and first tank.

The rig is described by where the model is: positions and headings of midship over time, with a
smooth start, from which velocities and accelerations follow by differences. The force is summed in
the flow's own variables, drift angle and path curvature, and turned into derivatives by hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from pmmkit import Campaign, Run
from pmmkit.campaigns import Settings
from pmmkit.conventions import Ship, Water

SHIP = Ship(
    name="tanker, L 7 m", L=7.0, B=1.27, d=0.46, volume=3.27, mass=3262.0, Izz=10150.0, xG=0.25
)
WATER = Water(rho=997.6, g=9.80665)
MIDDLE = 0.142
"""Froude number to which `CENTRAL` refers."""
CHANNELS = ("X", "Y", "N")
RATE, FINER = 12.5, 8
"""Samples a second of a record; steps of the motion for each."""
START = 4.0
"""Seconds in which an oscillation comes up."""
RECORD = {"X": 0.02, "Y": 0.015, "N": 0.015}
"""Noise of a record over the channel's scale."""

CENTRAL: Mapping[str, float] = {
    "Xuu": -0.00143, "Xvv": -0.0026, "Xvr": 0.0146, "Xrr": 0.0007,
    "Yv": -0.0205, "Yr": 0.0040, "Yvvv": -0.1045, "Yvvr": 0.0246, "Yvrr": -0.0254,
    "Yrrr": 0.0005, "Yvdot": -0.0145, "Yrdot": -0.0006,
    "Nv": -0.0089, "Nr": -0.0032, "Nvvv": -0.0020, "Nvvr": -0.0191, "Nvrr": 0.0036,
    "Nrrr": -0.0008, "Nvdot": -0.0003, "Nrdot": -0.0007, "Xudot": -0.0014,
}  # fmt: skip
"""Near the KVLCC2 of Yasukawa and Yoshimura (2015), in ½ρL²U² (L for N), as a PMM measures them."""
SLOPE = 0.15
"""Each derivative changes by up to this share when the Froude number changes by half."""


def truth(Fn: float) -> dict[str, float]:
    """The derivatives at a Froude number: each has a slope of its own."""
    away = 2.0 * (Fn / MIDDLE - 1.0)
    return {
        name: value * (1.0 + SLOPE * math.sin(3.0 * place) * away)
        for place, (name, value) in enumerate(CENTRAL.items())
    }


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A run: drift and heading amplitude [rad], sway amplitude [m], frequency [rad/s]."""

    id: str
    test: str
    speed: float
    drift: float = 0.0
    sway: float = 0.0
    heading: float = 0.0
    omega: float = 0.0


def plans(programme: str) -> Iterator[Plan]:
    """16 runs at one speed (``small``), or 20 at each of three (``speeds``)."""
    small = programme == "small"
    for Fn in (MIDDLE,) if small else (0.095, MIDDLE, 0.19):
        U = round(Fn * math.sqrt(WATER.g * SHIP.L), 3)
        omega = 2.2 * U / SHIP.L
        for beta in (-10, -4, 4, 7, 10) if small else (-10, -7, -4, -2, 2, 4, 7, 10):
            yield Plan(id=f"{U}d{beta}", test="static_drift", speed=U, drift=math.radians(beta))
        for v in (0.08, 0.14, 0.20):
            yield Plan(id=f"{U}s{v}", test="pure_sway", speed=U, sway=v * U / omega, omega=omega)
        for r in (0.2, 0.35, 0.5, 0.6) if small else (0.2, 0.35, 0.5):
            psi = r * U / SHIP.L / omega
            yield Plan(id=f"{U}y{r}", test="pure_yaw", speed=U, heading=psi, omega=omega)
        pairs = [(4, 0.35), (8, 0.35), (8, 0.5), (-8, 0.35)]
        for beta, r in pairs if small else [*pairs, (4, 0.5), (-8, 0.5)]:
            psi = r * U / SHIP.L / omega
            yield Plan(
                id=f"{U}c{beta}_{r}", test="yaw_drift", speed=U, heading=psi, omega=omega,
                drift=math.radians(beta),
            )  # fmt: skip


def moved(plan: Plan) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times of the samples and the motion of midship there, ship axes, by differences."""
    span = 5.4 * 2.0 * math.pi / plan.omega if plan.omega else 60.0
    t = np.arange(-4 * FINER, int(span * RATE + 4) * FINER) / (RATE * FINER)
    rising = np.clip(t / START, 0.0, 1.0)
    swing = np.sin(plan.omega * t) * rising**3 * (10.0 - 15.0 * rising + 6.0 * rising**2)
    course = plan.heading * swing
    across = plan.sway * swing if plan.test == "pure_sway" else None
    side = plan.speed * np.tan(course) if across is None else np.gradient(across, t, edge_order=2)
    head = course + plan.drift
    u = plan.speed * np.cos(head) + side * np.sin(head)
    v = side * np.cos(head) - plan.speed * np.sin(head)
    motion = {"u": u, "v": v, "r": np.gradient(head, t, edge_order=2)}
    motion |= {f"{name}dot": np.gradient(x, t, edge_order=2) for name, x in motion.items()}
    kept = slice(4 * FINER, -4 * FINER, FINER)
    return t[kept], {name: x[kept] for name, x in motion.items()}


def water(m: Mapping[str, np.ndarray], values: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Force of the water [N, N m]: sums over powers of sin β and of the path's curvature."""
    U = np.hypot(m["u"], m["v"])
    flow = {"u": m["u"] / U, "v": m["v"] / U, "r": m["r"] * SHIP.L / U}
    flow |= {"a": m["udot"] * SHIP.L / U**2, "b": m["vdot"] * SHIP.L / U**2}
    flow |= {"c": m["rdot"] * SHIP.L**2 / U**2}
    spelt = {"udot": "a", "vdot": "b", "rdot": "c"}
    total = {name: np.zeros_like(U) for name in CHANNELS}
    for name, value in values.items():
        letters = spelt.get(name[1:], name[1:])
        total[name[0]] = total[name[0]] + value * np.prod([flow[x] for x in letters], axis=0)
    head = 0.5 * WATER.rho * (U * SHIP.L) ** 2
    return {name: x * head * (SHIP.L if name == "N" else 1.0) for name, x in total.items()}


def on_the_balance(
    force: Mapping[str, np.ndarray], m: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """What the gauges show: the water's force less the model's momentum, changing in space."""
    sway = m["vdot"] + m["u"] * m["r"] + SHIP.xG * m["rdot"]
    surge = m["udot"] - m["v"] * m["r"] - SHIP.xG * m["r"] ** 2
    turn = SHIP.Izz * m["rdot"] + SHIP.mass * SHIP.xG * (m["vdot"] + m["u"] * m["r"])
    return {
        "X": force["X"] - SHIP.mass * surge,
        "Y": force["Y"] - SHIP.mass * sway,
        "N": force["N"] - turn,
    }


def scale(channel: str, speed: float) -> float:
    """Usual size of a channel at a speed [N, N m]."""
    share = {"X": 0.0015, "Y": 0.0045, "N": 0.0018}[channel]
    return share * 0.5 * WATER.rho * (speed * SHIP.L) ** 2 * (SHIP.L if channel == "N" else 1.0)


def campaign(
    programme: str,
    seed: int,
    gain: float,
    offset: float,
    law: Callable[[np.random.Generator], float],
    *,
    bad: int | None = None,
    bad_gain: float = 0.03,
) -> Campaign:
    """A campaign with errors of run and gauge: shares of the reading and of the channel's scale.

    The number `bad` is that of a run whose side force is too large by `bad_gain`.
    """
    made = []
    for number, plan in enumerate(plans(programme)):
        rng = np.random.default_rng([seed, number, 7])
        t, motion = moved(plan)
        values = truth(plan.speed / math.sqrt(WATER.g * SHIP.L))
        shown = on_the_balance(water(motion, values), motion)
        record = {}
        for name in CHANNELS:
            factor = 1.0 + gain * law(rng) + (bad_gain if number == bad and name == "Y" else 0.0)
            size = scale(name, plan.speed)
            rough = np.convolve(rng.standard_normal(len(t) + 4), np.full(5, 5**-0.5), "valid")
            noise = RECORD[name] * (0.8 * rough + 0.6 * rng.standard_normal(len(t)))
            record[name] = ("t", factor * shown[name] + size * (offset * law(rng) + noise))
        data = xr.Dataset(record, coords={"t": t})
        made.append(
            Run(
                id=plan.id,
                test=plan.test,
                kind="history",
                settings=Settings(
                    speed=plan.speed,
                    drift=plan.drift,
                    amplitude=plan.sway or None,
                    yaw_amplitude=plan.heading or None,
                    period=2.0 * math.pi / plan.omega if plan.omega else None,
                ),
                loader=lambda data=data: data,
                forces="balance",
            )
        )
    return Campaign(
        title=f"second tank, {programme}",
        ship=SHIP,
        water=WATER,
        runs=tuple(made),
        forces="balance",
    )
