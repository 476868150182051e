"""The S175 programme: its runs, and histories of them with noise, biases and start-up transients.

Synthetic. The forces follow from the true derivatives of ``datasets/s175/truth.toml`` through the
plain formulas of ``virtual_tank.py``, which share nothing with the package.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scripts.datasets.s175_truth import Truth
from scripts.datasets.virtual_tank import SHIP, WATER, history, motion, water_forces

from pmmkit.campaigns import Campaign, Run
from pmmkit.campaigns import TypeB
from pmmkit.campaigns import Settings

SPEEDS = (1.0, 1.5, 2.0)
DRIFT = (-12.0, -9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0, 12.0)
SWAY = (0.08, 0.16, 0.24)
YAW = (0.2, 0.4, 0.6)
COMBINED = tuple((drift, rate) for drift in (-8.0, 4.0, 8.0) for rate in (0.3, 0.5))
SWAY_FREQUENCY, YAW_FREQUENCY = 1.6, 2.2
CYCLES, RATE, STATIC_LENGTHS = 5, 10.0, 16.0
CHANNEL_SIZE = {"X": 6e-4, "Y": 3.2e-3, "N": 1.3e-3}
NOISE, MEMORY = 0.015, 1.2
UNCERTAINTY = (
    TypeB(name="X_gauge", std=0.04, shared=True),
    TypeB(name="Y_gauge", std=0.15, shared=True),
    TypeB(name="N_gauge", std=0.25, shared=True),
    TypeB(name="Y_gauge", std=0.002, relative=True, shared=True),
    TypeB(name="N_gauge", std=0.002, relative=True, shared=True),
    TypeB(name="drift", std=math.radians(0.03), shared=True),
    TypeB(name="drift", std=math.radians(0.02)),
    TypeB(name="speed", std=0.001),
)
"""Standard uncertainties of gauges and settings; the histories hold one draw of each."""


@dataclass(frozen=True)
class Plan:
    """One run of the programme; amplitudes v and r are non-dimensional."""

    id: str
    test: str
    speed: float
    drift_deg: float = 0.0
    v: float = 0.0
    r: float = 0.0

    @property
    def omega(self) -> float:
        prime = SWAY_FREQUENCY if self.test == "pure_sway" else YAW_FREQUENCY
        return prime * self.speed / SHIP.L

    @property
    def period(self) -> float | None:
        return None if self.test == "static_drift" else round(2 * math.pi / self.omega, 4)

    @property
    def amplitude_m(self) -> float | None:
        """As the mechanism is set: to a tenth of a millimetre."""
        return round(self.v * self.speed / self.frequency, 4) if self.v else None

    @property
    def yaw_amplitude_deg(self) -> float | None:
        """As the mechanism is set: to a hundredth of a degree."""
        rate = self.r * self.speed / SHIP.L
        return round(math.degrees(rate / self.frequency), 2) if self.r else None

    @property
    def yaw_amplitude(self) -> float | None:
        return None if self.yaw_amplitude_deg is None else math.radians(self.yaw_amplitude_deg)

    @property
    def frequency(self) -> float:
        """Angular frequency of the rounded period."""
        assert self.period is not None
        return 2 * math.pi / self.period


def programme() -> Iterator[Plan]:
    """All runs: 24 at each of three speeds."""
    for speed in SPEEDS:
        tag = f"U{speed:.1f}"
        for drift in DRIFT:
            yield Plan(f"SD_{tag}_b{drift:+03.0f}", "static_drift", speed, drift_deg=drift)
        for v in SWAY:
            yield Plan(f"PS_{tag}_v{v:.2f}", "pure_sway", speed, v=v)
        for r in YAW:
            yield Plan(f"PY_{tag}_r{r:.1f}", "pure_yaw", speed, r=r)
        for drift, r in COMBINED:
            yield Plan(f"YD_{tag}_b{drift:+03.0f}_r{r:.1f}", "yaw_drift", speed, drift, r=r)


def noise(rng: np.random.Generator, n: int, rms: float) -> np.ndarray:
    """Stationary AR(1) noise [N] with a memory of `MEMORY` seconds."""
    from scipy.signal import lfilter

    keep = math.exp(-1 / (RATE * MEMORY))
    white = rng.normal(size=n) * rms * math.sqrt(1 - keep**2)
    white[0] = rng.normal() * rms
    return lfilter([1.0], [1.0, -keep], white)


def transient(plan: Plan, t: np.ndarray) -> np.ndarray:
    """Factor on the forces at the start: an impulsive start that rings and dies out."""
    if plan.test == "static_drift":
        tau = SHIP.L / plan.speed
        return 1 + 0.9 * np.exp(-t / tau) * np.cos(2 * math.pi * t / (2.5 * tau))
    return 1 + 0.3 * np.exp(-t / (0.25 * 2 * math.pi / plan.frequency))


def draw_biases(rng: np.random.Generator) -> dict[str, float]:
    """One draw of every shared error, by name, in units of its standard uncertainty."""
    return {f"{b.name}{'%' if b.relative else ''}": rng.normal() for b in UNCERTAINTY if b.shared}


def record(
    plan: Plan, coefficients: Mapping[str, float], rng: np.random.Generator, shared: Mapping
) -> xr.Dataset:
    """History of one run as the balance would give it without inertia: t, X, Y, N."""
    std = {
        f"{b.name}{'%' if b.relative else ''}{'' if b.shared else '#'}": b.std for b in UNCERTAINTY
    }
    drift = (
        math.radians(plan.drift_deg) + shared["drift"] * std["drift"] + rng.normal() * std["drift#"]
    )
    speed = plan.speed + rng.normal() * std["speed#"]
    if plan.test == "static_drift":
        t = np.arange(int(STATIC_LENGTHS * SHIP.L / plan.speed * RATE)) / RATE
        state = motion("static_drift", speed, t, 1.0, drift=drift)
    else:
        omega = plan.frequency
        t = np.arange(int(CYCLES * plan.period * RATE) + 1) / RATE
        state = oscillation(plan, speed, omega * t, omega, drift)
    force = water_forces(coefficients, *state)
    factor = transient(plan, t)
    out = {}
    for channel, values in force.items():
        arm = SHIP.L if channel == "N" else 1.0
        size = CHANNEL_SIZE[channel] * 0.5 * WATER.rho * SHIP.L**2 * 1.5**2 * arm
        gain = 1 + shared.get(f"{channel}_gauge%", 0.0) * std.get(f"{channel}_gauge%", 0.0)
        zero = shared[f"{channel}_gauge"] * std[f"{channel}_gauge"]
        told = values * factor * gain + zero + noise(rng, len(t), NOISE * size)
        # An amplifier tells 24 bits; the file is half as large without those beyond.
        out[channel] = told.astype(np.float32).astype(float)
    return history(t, out)


def oscillation(plan: Plan, speed: float, theta: np.ndarray, omega: float, drift: float):
    """Motion with small errors of drift and speed: the mechanism keeps its amplitudes [m, rad]."""
    if plan.test == "pure_sway":
        lateral = plan.amplitude_m * omega
        y, ydot = np.cos(theta), -omega * np.sin(theta)
        along, across = math.cos(drift), math.sin(drift)
        return (
            speed * along + lateral * y * across, -speed * across + lateral * y * along,
            0 * theta, lateral * ydot * across, lateral * ydot * along, 0 * theta,
        )
    rate = plan.yaw_amplitude * omega * SHIP.L / speed
    return motion("yaw_drift", speed, theta, omega, drift=drift, r=rate)


def campaign(truth: Truth, seed: int, *, biased: bool = True) -> Campaign:
    """The programme as a campaign in memory, one draw of noise and biases."""
    rng = np.random.default_rng([175, seed])
    shared = draw_biases(rng)
    if not biased:
        shared = dict.fromkeys(shared, 0.0)
    made = []
    for plan in programme():
        coefficients = truth.at(SHIP.froude(plan.speed, WATER.g))
        data = record(plan, coefficients, rng, shared)
        made.append(
            Run(
                id=plan.id,
                test=plan.test,
                kind="history",
                settings=Settings(
                    speed=plan.speed,
                    drift=math.radians(plan.drift_deg),
                    period=plan.period,
                    amplitude=plan.amplitude_m,
                    yaw_amplitude=plan.yaw_amplitude,
                ),
                loader=lambda data=data: data,
            )
        )
    return Campaign(
        title="S175 at 1:36, synthetic PMM programme",
        ship=SHIP,
        water=WATER,
        runs=tuple(made),
        free=("heave", "pitch"),
        uncertainty=UNCERTAINTY,
    )
