"""Numbers for the screen: short, and no more samples than it can show."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

DIGITS: Final = 5
"""Significant digits: a pixel is a thousandth of a plot."""
FEW: Final = 32
"""Numbers that are shortened one by one."""
EXACT: Final = 22
"""Powers of ten below this one are whole numbers of a double."""
BUCKETS: Final = 400
"""Pieces of a record of which the least and the largest sample are shown."""


def short(values: Any) -> Any:
    """Numbers with `DIGITS` significant digits, as plain lists; NaN becomes None.

    Examples
    --------
    >>> short(np.array([1.23456789, np.nan, 0.0]))
    [1.2346, None, 0.0]
    >>> short(12345678.0)
    12346000.0
    """
    given = np.asarray(values, float)
    if given.size < FEW:
        every = [_short(x) for x in given.ravel().tolist()]
        return _shaped(every, given.shape)
    flat = given.ravel()
    with np.errstate(all="ignore"):
        places = DIGITS - 1 - np.floor(np.log10(np.abs(flat)))
        # Whole numbers and powers of ten are exact: the quotient is the nearest to the decimal.
        rounded = np.rint(flat * 10.0**places) / 10.0**places
    easy = np.isfinite(rounded) & (places >= 0.0) & (places < EXACT)
    pairs = zip(flat.tolist(), rounded.tolist(), easy.tolist(), strict=True)
    return _shaped([near if fine else _short(x) for x, near, fine in pairs], given.shape)


def _short(x: float) -> float | None:
    return float(f"{x:.{DIGITS}g}") if math.isfinite(x) else None


def _shaped(values: list[Any], shape: tuple[int, ...]) -> Any:
    if not shape:
        return values[0]
    if len(shape) == 1:
        return values
    step = len(values) // shape[0] if shape[0] else 0
    return [_shaped(values[i * step : (i + 1) * step], shape[1:]) for i in range(shape[0])]


def thinned(columns: Mapping[str, Array], buckets: int = BUCKETS) -> NDArray[np.intp]:
    """Places of the samples that are shown: of each piece the extremes of every column.

    Examples
    --------
    >>> x = np.zeros(100_000); x[54_321] = 7.0
    >>> 54_321 in thinned({"X": x}), len(thinned({"X": x})) <= 2 * BUCKETS + 2
    (True, True)
    """
    length = len(next(iter(columns.values()))) if columns else 0
    if length <= 2 * buckets:
        return np.arange(length)
    size = -(-length // buckets)
    begin = np.arange(0, length, size)
    found = [np.array([0, length - 1])]
    for values in columns.values():
        # The last piece is filled up with its last sample.
        whole = np.pad(np.nan_to_num(values), (0, size * len(begin) - length), mode="edge")
        pieces = whole.reshape(len(begin), size)
        found += [begin + pieces.argmin(axis=1), begin + pieces.argmax(axis=1)]
    return np.unique(np.minimum(np.concatenate(found), length - 1))
