"""Which of the computed speeds and headings is asked for."""

from __future__ import annotations

import numpy as np

from pmmkit.errors import DataError
from pmmkit.numerics import Array


def nearest(values: Array, wanted: float | None, name: str) -> int:
    """Index of a value that was asked, or of the only one; an error lists those there are."""
    if wanted is None and values.size == 1:
        return 0
    if wanted is None:
        raise DataError(f"Say which {name}: {', '.join(f'{x:g}' for x in values)}.")
    place = int(np.argmin(np.abs(values - wanted)))
    if abs(values[place] - wanted) > 1e-3 * max(1.0, abs(wanted)):
        there = ", ".join(f"{x:.4g}" for x in values)
        raise DataError(f"{name} {wanted:g} was not computed; there are {there}.")
    return place
