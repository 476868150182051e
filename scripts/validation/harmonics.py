"""Motions and Fourier coefficients of captive tests."""

from __future__ import annotations

import math
from functools import cache
from typing import Final

import numpy as np

from pmmkit.campaigns import Run, Settings
from pmmkit.signals import harmonics
from scripts.validation.published import Published, Values, table

CARRIAGE: Final = 1.047
LENGTH: Final = 5.52
SWAY_HZ: Final = 0.0284
YAW_HZ: Final = 0.0389
"""Speed [m/s], length [m] and frequencies of the tests of SIMMAN 2008 in INSEAN's tank."""


def run(test: str, frequency: float, **settings: float) -> Run:
    """A captive test without forces."""
    given = Settings(speed=CARRIAGE, period=1 / frequency, **settings)
    return Run(id=test, test=test, kind="history", settings=given, loader=lambda: None)


def cycle(frequency: float) -> np.ndarray:
    """Instants of one cycle [s]."""
    return np.arange(720) / 720 / frequency


@cache
def simman() -> Values:
    """Largest motions of test cases 1b-3 (pure sway of 0.5 m) and 1b-4 (pure yaw of 1 m)."""
    sway = run("pure_sway", SWAY_HZ, amplitude=0.5).nominal_motion(cycle(SWAY_HZ))
    heading = math.atan(1.0 * 2 * math.pi * YAW_HZ / CARRIAGE)
    yaw = run("pure_yaw", YAW_HZ, yaw_amplitude=heading).nominal_motion(cycle(YAW_HZ))
    return {
        "sway velocity of 1b-3, v/Uc": float(np.abs(sway.v).max()) / CARRIAGE,
        "heading of 1b-4 [°]": math.degrees(heading),
        "yaw rate of 1b-4, r L/Uc": float(np.abs(yaw.r).max()) * LENGTH / CARRIAGE,
    }


@cache
def products() -> Values:
    """Harmonics of products of a motion v = cos θ."""
    theta = np.arange(7200) * (2 * math.pi / 7200)
    v = np.cos(theta)
    found = harmonics(theta, np.stack([v * np.abs(v), np.abs(v), v**3])).coefficients
    modulus, size, cube = (dict(zip(range(6), [x[0], *x[1::2]], strict=True)) for x in found)
    return {
        "v|v|, C1": modulus[1], "v|v|, C3": modulus[3], "v|v|, C5": modulus[5],
        "|v|, C0": size[0], "|v|, C2": size[2], "|v|, C4": size[4],
        "v³, C1": cube[1], "v³, C3": cube[3],
    }  # fmt: skip


FIGURES: tuple[Published, ...] = (
    *table(
        "KVLCC2 in INSEAN's tank, motions of two tests",
        {
            "sway velocity of 1b-3, v/Uc": 0.0852,
            "heading of 1b-4 [°]": 13.36,
            "yaw rate of 1b-4, r L/Uc": 0.30,
        },
        simman,
        sources=("simman_2008",),
        place="conditions of test cases 1b-3 and 1b-4",
        nature="printed",
        part="program",
        how="nominal motion of a run with the stated amplitude and frequency; the heading without "
        "sway is atan(y₀ω/Uc)",
        within=0.025,
        why="The heading printed is y₀ω/Uc itself, taken as radians.",
    ),
    *table(
        "Harmonics of products",
        {
            "v|v|, C1": 8 / (3 * math.pi), "v|v|, C3": 8 / (15 * math.pi),
            "v|v|, C5": -8 / (105 * math.pi),
            "|v|, C0": 2 / math.pi, "|v|, C2": 4 / (3 * math.pi), "|v|, C4": -4 / (15 * math.pi),
            "v³, C1": 0.75, "v³, C3": 0.25,
        },
        products,
        sources=(),
        place="closed forms of the Fourier series for v = cos θ",
        nature="printed",
        part="program",
        how="`pmmkit.signals.fourier` on 7200 samples",
        within=1e-5,
    ),
)  # fmt: skip
