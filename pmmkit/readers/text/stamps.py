"""Time stamps of text files, such as ``2024-05-01T10:00:00.5Z`` or ``10:00:00``, as seconds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.numerics import Array

if TYPE_CHECKING:
    import pandas as pd

_DATE: Final = (
    r"(?:(?P<y>\d{4})[-/.](?P<m>\d{1,2})[-/.](?P<d>\d{1,2})"
    r"|(?P<one>\d{1,2})[-/.](?P<two>\d{1,2})[-/.](?P<year>\d{4}))"
)
_TIME: Final = (
    r"(?P<hour>\d{1,2}):(?P<minute>\d{2}):(?P<second>\d{2}(?:[.,]\d+)?)"
    r"\s*(?P<half>[AaPp][Mm])?(?:Z|[ ]?UTC|[+-]\d{2}:?\d{2})?"
)
_STAMP: Final = re.compile(rf"\s*\"?(?:{_DATE}[T ]\s*)?{_TIME}\"?\s*")
_DAY: Final = re.compile(rf"\s*\"?{_DATE}\"?\s*")
DAY: Final = 86400.0
_START: Final = date(2000, 1, 1).toordinal()
"""Seconds since then keep a tenth of a microsecond."""


def is_stamp(cell: str) -> bool:
    """Whether a cell says an instant, with or without its date.

    Examples
    --------
    >>> [is_stamp(x) for x in ("2024-05-01T10:00:00Z", "10:00:00.25", "01.05.2024", "1:10")]
    [True, True, False, False]
    """
    return _STAMP.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Whether a cell says a day."""
    return _DAY.fullmatch(cell) is not None


def seconds_of(cells: pd.Series[str]) -> Array:
    """Seconds of time stamps since 2000, or since midnight where they have no date; NaN where
    a cell is none.

    Where no year stands first, days stand before months unless a month would be beyond 12. A zone
    is the same in all rows of a record and is left out.
    """
    found = cells.str.extract(f"^{_STAMP.pattern}$")
    numbers = {
        name: found[name].str.replace(",", ".").astype(float).to_numpy()
        for name in ("hour", "minute", "second")
    }
    half = found["half"].str.lower()
    hour = numbers["hour"] % 12 + 12 * (half == "pm") if half.notna().any() else numbers["hour"]
    clock = 3600.0 * np.asarray(hour) + 60.0 * numbers["minute"] + numbers["second"]
    dates = found[["y", "m", "d", "one", "two", "year"]].fillna("")
    codes, days = dates.groupby(list(dates.columns), sort=False).ngroup(), dates.drop_duplicates()
    counted = np.array([_day(tuple(row)) for row in days.itertuples(index=False)])
    return clock + DAY * counted[codes.to_numpy()]


def _day(parts: Sequence[str]) -> float:
    """Days since 2000-01-01 of a date in parts; 0 without a date, NaN for one that is none."""
    year, month, day, one, two, last = parts
    if last:
        year, month, day = (last, two, one) if int(two) <= 12 else (last, one, two)
    if not year:
        return 0.0
    try:
        return float(date(int(year), int(month), int(day)).toordinal() - _START)
    except ValueError:
        return float("nan")


def elapsed(seconds: Array) -> Array:
    """Seconds since the first row; a clock without a date goes on over midnight.

    Examples
    --------
    >>> elapsed(np.array([86399.0, 0.0, 1.0]))
    array([0., 1., 2.])
    """
    late = np.diff(seconds, prepend=seconds[:1]) < -DAY / 2
    return seconds + DAY * np.cumsum(late) - (seconds[0] if len(seconds) else 0.0)
