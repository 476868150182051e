"""The figures of `sizes.toml`: programmes, noise, and the size of every effect at "size 1"."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Final

from pmmkit.conventions import Ship, Water

FIGURES: Final[dict[str, Any]] = tomllib.loads(
    (Path(__file__).parent / "sizes.toml").read_text(encoding="utf-8")
)
SIZES: Final[dict[str, dict[str, float]]] = FIGURES["sizes"]
NOISE: Final[dict[str, Any]] = FIGURES["noise"]
STARTUP: Final[dict[str, float]] = FIGURES["startup"]
ROLL: Final[dict[str, float]] = FIGURES["roll"]

SHIP: Final = Ship(
    name="S175 1:36", L=4.861111, B=0.705556, d=0.236111, volume=0.454861, mass=454.476, Izz=618.332
)
WATER: Final = Water(rho=999.1, g=9.81)
CHANNELS: Final = ("X", "Y", "N")
MIDDLE_SPEED: Final = 1.5
REFERENCE_FROUDE: Final = 0.217
PER_CYCLE: Final = 48
CYCLES: Final = 4
STATIC_CYCLES: Final = 3
"""A static record is as long as so many cycles of omega' 2."""


def unit(channel: str, speed: float) -> float:
    """Unit of a channel in the prime system at a speed [N, N m]."""
    force = 0.5 * WATER.rho * SHIP.L**2 * speed**2
    return force * SHIP.L if channel == "N" else force


def scale(channel: str) -> float:
    """Channel scale in newtons at the middle speed, to which the noise refers."""
    return NOISE["scale"][channel] * unit(channel, MIDDLE_SPEED)
