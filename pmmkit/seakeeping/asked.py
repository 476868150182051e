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


def between(computed: Array, heading_deg: float) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Headings [rad] that were computed beside one, with weights; port and starboard are alike."""
    folded = abs((heading_deg + 180.0) % 360.0 - 180.0)
    there = np.abs((np.degrees(computed) + 180.0) % 360.0 - 180.0)
    gap = np.abs(there - folded)
    if gap.min() < 1e-6:
        return (int(gap.argmin()),), (1.0,)
    below, above = np.flatnonzero(there < folded), np.flatnonzero(there > folded)
    if not below.size or not above.size:
        raise DataError(
            f"A short-crested sea needs headings on both sides of {folded:.0f}°: compute them from "
            "0 to 180° in steps of 15° or so."
        )
    low, high = int(below[there[below].argmax()]), int(above[there[above].argmin()])
    if there[high] - there[low] > 31.0:
        raise DataError("A short-crested sea needs headings in steps of 30° or less.")
    part = (folded - there[low]) / (there[high] - there[low])
    return (low, high), (float(1 - part), float(part))
