"""Tests that hold nothing between the harmonics: means, and cycles of a short Fourier series.

A laboratory that hands in one cycle of 24 points, averaged, filtered and fitted, gives records that
do not know their own noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr
from small_campaign import RHO, L, forces, sway, yaw

from pmmkit import Campaign, Run
from pmmkit.campaigns import Settings
from pmmkit.conventions import Ship, Water

SHIP = Ship(
    name="S175 model", L=L, B=0.705556, d=0.236111, mass=454.476, Izz=618.332, volume=0.454861
)
POINTS = 24


def shortened(x: np.ndarray, order: int) -> np.ndarray:
    """A cycle without what is above a harmonic."""
    parts = np.fft.rfft(x)
    parts[order + 1 :] = 0.0
    return np.fft.irfft(parts, len(x))


def campaign(order: int, *, speeds: tuple[float, ...] = (1.0, 2.0)) -> Campaign:
    """Six drift angles as means and six oscillating tests of one cycle at each speed."""
    return Campaign(
        title="exact cycles",
        ship=SHIP,
        water=Water(rho=RHO, g=9.81),
        runs=tuple(run for speed in speeds for run in _runs(speed, order)),
    )


def _runs(speed: float, order: int) -> Iterator[Run]:
    for degrees in (-8, -4, 0, 4, 8, 12):
        beta, still = math.radians(degrees), np.zeros(1)
        u, v = still + speed * math.cos(beta), still - speed * math.sin(beta)
        means = {name: float(x[0]) for name, x in forces(u, v, *[still] * 4).items()}
        yield _run(f"SD{degrees}", "static_drift", speed, xr.Dataset(means), drift=beta)
    period = 12.5 / speed
    t, omega = np.arange(POINTS) * period / POINTS, 2 * math.pi / period
    cycles = [("pure_sway", {"amplitude": a}, sway(speed, a, t, omega)) for a in (0.15, 0.3)] + [
        (
            "yaw_drift" if drift else "pure_yaw",
            {"yaw_amplitude": math.radians(psi), "drift": math.radians(drift)},
            yaw(speed, math.radians(psi), math.radians(drift), t, omega),
        )
        for psi, drift in ((8, 0), (14, 0), (12, 4), (12, 8))
    ]
    for number, (test, settings, motion) in enumerate(cycles):
        shown = {name: ("t", shortened(x, order)) for name, x in forces(**motion).items()}
        data = xr.Dataset(shown, coords={"t": t})
        yield _run(f"{test}{number}", test, speed, data, period=period, **settings)


def _run(name: str, test: str, speed: float, data: xr.Dataset, **settings: float) -> Run:
    return Run(
        id=f"{name}_U{speed:g}",
        test=test,
        kind="history" if "t" in data.coords else "means",
        settings=Settings(speed=speed, **settings),
        loader=lambda: data,
    )
