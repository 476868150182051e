"""A variable of a MATLAB file, of whatever version."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class MatlabVariable:
    """A variable, or a field of a struct.

    `name`: its name, fields behind dots. `read`: gives real numbers in rows and columns.
    `texts`: the texts of a cell array of texts. `other`: what it is, if neither numbers nor
    texts. `opaque`: whether it is of a class that MATLAB keeps in a form of its own (tables,
    times).
    """

    name: str
    shape: tuple[int, int]
    read: Callable[[], Array] = lambda: np.empty((0, 0))
    texts: tuple[str, ...] | None = None
    other: str | None = None
    opaque: bool = False

    @classmethod
    def of(cls, name: str, values: NDArray[Any]) -> MatlabVariable:
        """A matrix of numbers in the bytes of the file."""
        rows, columns = values.shape
        return cls(
            name=name, shape=(rows, columns), read=lambda: np.asarray(values, dtype=np.float64)
        )
