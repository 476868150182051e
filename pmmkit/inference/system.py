"""What a filter asks of a system, as its functions see it.

Whoever compiles `pmmkit.inference.estimators` writes those of a system in their place
(`pmmkit.equations.code_generation`); what stands here is for those who read the filters,
and for the checker of types.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FILTERS: Final = str(Path(__file__).with_name("estimators.py"))
"""The file of the filters, which is written below a system of one's own."""


def transition(system: Any, t: int, points: Array, changes: Array) -> int:
    """Stands for a system: carries the states of points, a row each, from instant t - 1 to t while
    the values are off by `changes`; not 0 where they are lost."""
    raise NotImplementedError


def linearised(system: Any, t: int, z: Array, change: Array, y: Array, A: Array, B: Array) -> int:
    """Stands for a system: fills `y` with the states at instant t that follow those of `z` at t - 1
    while the values are off by `change`, and A, B with their slopes; not 0 where they are lost."""
    raise NotImplementedError


def at_instant(system: Any, t: int, change: Array) -> None:
    """Stands for a system: readies its sensors for an instant."""
    raise NotImplementedError


def sensed(system: Any, kind: int, z: Array, h: Array) -> float:
    """Stands for a system: what a sensor should show, its slopes over states and values in `h`."""
    raise NotImplementedError


def innovation(difference: float, kind: int) -> float:
    """Stands for a system: measured less expected, of an angle the short way round."""
    raise NotImplementedError
