"""What a structure's module has of its own, as the functions below the equations see it.

`pmmkit.equations.code_generation` writes them into the module; what stands here is for
those who read the functions, and for the checker of types.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.equations.layouts import Control, LaneMove, LaneSlot, State, StepField

Floats = list[float] | NDArray[np.float64]
NS = 6
OWN = 6
LANES = 8
TIMES = len(LaneSlot) * NS * LANES
MOVES = TIMES + LANES
WIDE = MOVES + len(Control) * len(LaneMove) * LANES
N_AT = -1
REVOLUTIONS = 1
FREE: tuple[int, ...] = (State.u, State.v, State.r)
BALANCE: tuple[int, ...] = (State.u, State.v, State.r)
STRIDE: Final = len(StepField) + 5 * NS
TWICE: Final = 2.0 * math.pi


def rates(
    y: Floats, delta: float, revolutions: float, bucket: float, k: Floats, out: Floats
) -> None:
    """Stands for the equations of a structure: fills `out` with the rates of the states."""
    raise NotImplementedError


def complete(k: Floats) -> int:
    """Stands for that of `pmmkit.equations.equilibrium`, which takes arrays when
    compiled."""
    raise NotImplementedError


def rates_of_lanes(s: list[float]) -> None:
    """Stands for the same equations in lanes: from the states in slot `z` to slot `rate`."""
    raise NotImplementedError


def exponential(x: float) -> float:
    """Stands for the exponential function of lanes."""
    raise NotImplementedError


def part(values: list[float], first: int, size: int) -> list[float]:
    """A view of some of the numbers, of an array."""
    return values[first : first + size]


def vector(size: int) -> list[float]:
    """Room for floats."""
    return [0.0] * size
