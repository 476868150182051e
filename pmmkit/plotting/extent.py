"""What the marks of axes fill, and the ticks of a side: round values and how they are written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting.letters import SUPERSCRIPTS
from pmmkit.plotting.marks import (
    Area,
    BarSeries,
    Line,
    Mark,
    Mosaic,
    Polygons,
    Rule,
    Segments,
    Strip,
)

Side = Literal["x", "y"]
Scale = Literal["linear", "log", "symlog"]
_ROUND: Final = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Steps of ticks, times a power of ten."""
_MOST: Final = 9
"""Intervals of a side at most."""
_POWERS: Final = (-3, 5)
"""Powers of ten from which on they are written apart from the numbers."""
_LARGEST: Final = 1e150
"""Size from which on a value is not shown: its square is no number any more."""
_ALONE: Final = 0.055
"""Half of what is shown about a single value that is zero."""


def scaled(values: Array, scale: Scale, linear_to: float = 1.0) -> Array:
    """Values as they stand along a side: themselves, their logarithm, or both in turn.

    Examples
    --------
    >>> scaled(np.array([-100.0, 0.0, 10.0, 100.0]), "symlog", 10.0).tolist()
    [-2.0, 0.0, 1.0, 2.0]
    """
    if scale == "linear":
        return values
    if scale == "log":
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.log10(values)
    size = np.abs(values) / linear_to
    return np.sign(values) * np.where(size > 1.0, 1.0 + np.log10(np.maximum(size, 1.0)), size)


def unscaled(value: float, scale: Scale, linear_to: float = 1.0) -> float:
    """The inverse of `scaled`."""
    if scale == "linear":
        return value
    if scale == "log":
        return float(10.0**value)
    size = abs(value)
    return math.copysign(linear_to * (10.0 ** (size - 1.0) if size > 1.0 else size), value)


def extent(
    marks: Sequence[Mark], side: Side, scale: Scale, room: float, linear_to: float
) -> tuple[float, float]:
    """Ends of a side that hold some marks with `room` about them.

    Bars stand on their base, cells fill their axes: there is no room beyond these.
    """
    values, firm = [], []
    with np.errstate(invalid="ignore"):
        for mark in marks:
            own, ends = _filled(mark, side)
            values += own
            firm += ends
    known = np.concatenate([np.ravel(own) for own in values] or [np.empty(0)])
    known = known[np.abs(known) < _LARGEST]
    if scale == "log":
        known = known[known > 0]
    if not len(known):
        return (0.0, 1.0) if scale != "log" else (1.0, 10.0)
    low, high = float(known.min()), float(known.max())
    a, b = scaled(np.array([low, high]), scale, linear_to).tolist()
    if a == b:
        wide = max(abs(a) * 0.05, _ALONE if a == 0.0 else 0.0) or _ALONE
        return unscaled(a - wide, scale, linear_to), unscaled(b + wide, scale, linear_to)
    more = room * (b - a)
    first = low if low in firm else unscaled(a - more, scale, linear_to)
    last = high if high in firm else unscaled(b + more, scale, linear_to)
    return first, last


def _filled(mark: Mark, side: Side) -> tuple[list[Array], list[float]]:
    """Values of a mark along a side, and those of them beyond which it has no room."""
    flat = side == "x"
    match mark:
        case Line():
            error = mark.x_error if flat else mark.y_error
            own = mark.x if flat else mark.y
            other = mark.y if flat else mark.x
            own = np.where(np.isnan(other), np.nan, own)
            return [own] if error is None else [own, own - error[0], own + error[1]], []
        case Segments():
            return [mark.x0, mark.x1] if flat else [mark.y0, mark.y1], []
        case Rule():
            return [np.array([mark.at])] if flat == mark.upright else [], []
        case Strip():
            return [np.array([mark.low, mark.high])] if flat == mark.upright else [], []
        case Area():
            return [mark.x] if flat else [mark.low, mark.high], []
        case Polygons():
            return [mark.corners[..., 0 if flat else 1]], []
        case BarSeries():
            left, right, bottom, top = mark.corners()
            along = flat == mark.sideways
            base = np.unique(mark.base).tolist() if along else []
            return [left, right] if flat else [bottom, top], base
        case Mosaic():
            begin = mark.x if flat else mark.y
            ends = [begin, begin + mark.values.shape[1 if flat else 0]]
            return [np.array(ends)], ends
    return [], []


@dataclass(kw_only=True, eq=False)
class Ticks:
    """Ticks of one side of the axes, where they are stated, and how they are written.

    at, labels: none where they follow from the limits. most: number of intervals at most; 0 for
    as many as there is room.
    """

    at: tuple[float, ...] | None = None
    labels: tuple[str, ...] | None = None
    turned: bool = False
    size: float = 9.0
    most: int = 0
    whole: bool = False
    marked: bool = True
    shown: bool = True


@dataclass(frozen=True, kw_only=True)
class Marked:
    """Ticks of a side: where they stand, what is written there, and the power of ten of all."""

    at: tuple[float, ...]
    labels: tuple[str, ...]
    power: str = ""


def ticks(
    limits: tuple[float, float], room: int, stated: Ticks, scale: Scale, linear_to: float
) -> Marked:
    """Ticks between the ends of a side that has room for so many intervals.

    Examples
    --------
    >>> ticks((0.0, 1.05), 5, Ticks(), "linear", 1.0).labels
    ('0.00', '0.25', '0.50', '0.75', '1.00')
    >>> ticks((-2.1e-5, 3e-5), 5, Ticks(), "linear", 1.0)
    Marked(at=(-2e-05, 0.0, 2e-05), labels=('−2', '0', '2'), power='×10⁻⁵')
    """
    low, high = min(limits), max(limits)
    slack = 1e-9 * (high - low)
    if stated.at is not None:
        kept = [x for x in stated.at if low - slack <= x <= high + slack]
        if stated.labels is None:
            return _written(kept, _step_of(kept))
        labels = [
            label
            for x, label in zip(stated.at, stated.labels, strict=True)
            if low - slack <= x <= high + slack
        ]
        return Marked(at=tuple(kept), labels=tuple(labels))
    if scale != "linear":
        at = _decades(low, high, scale, linear_to)
        return Marked(at=tuple(at), labels=tuple(_plain(f"{x:g}") for x in at))
    if not high > low or not math.isfinite(high - low):
        return Marked(at=(), labels=())
    count = max(1, min(room, stated.most or _MOST, _MOST))
    step = _round_step((high - low) / count)
    if stated.whole:
        step = max(1.0, round(step))
    first, last = _places(low - slack, high + slack, step)
    while last <= first and not stated.whole:  # one number alone tells no scale
        step = _round_step(0.45 * step)
        first, last = _places(low - slack, high + slack, step)
    return _written([number * step for number in range(first, last + 1)], step)


def _places(low: float, high: float, step: float) -> tuple[int, int]:
    """First and last multiple of a step between two ends."""
    return math.ceil(low / step), math.floor(high / step)


def _round_step(least: float) -> float:
    """The least round step that is no smaller."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(own * power for own in _ROUND if own * power >= least * (1.0 - 1e-9))


def _step_of(at: Sequence[float]) -> float:
    gaps = [b - a for a, b in pairwise(at) if b > a]
    return min(gaps, default=max(map(abs, at), default=1.0) or 1.0)


def _decades(low: float, high: float, scale: Scale, linear_to: float) -> list[float]:
    """Powers of ten of a logarithmic side; between them 2 and 5 where they are few."""
    if scale == "symlog":
        top = math.floor(math.log10(max(abs(low), abs(high), linear_to)))
        first = math.ceil(math.log10(linear_to))
        powers = [10.0**p for p in range(first, top + 1)]
        return [x for x in [*(-p for p in powers[::-1]), 0.0, *powers] if low <= x <= high]
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    for factors in ((1.0,), (1.0, 3.0), (1.0, 2.0, 5.0)):
        at = [f * 10.0**p for p in range(first, last + 1) for f in factors]
        at = [x for x in at if low * (1 - 1e-9) <= x <= high * (1 + 1e-9)]
        if len(at) > 2:
            break
    return at


def _written(at: Sequence[float], step: float) -> Marked:
    """Numbers with as many digits as tell two of them apart, large and small ones by a power."""
    largest = max(map(abs, at), default=0.0)
    power = math.floor(math.log10(largest)) if largest > 0 else 0
    power = power if power <= _POWERS[0] or power >= _POWERS[1] else 0
    unit = 10.0**power
    digits = _digits(step / unit)
    labels = tuple(_plain(f"{x / unit:.{digits}f}") for x in at)
    told = f"×10{str(power).translate(SUPERSCRIPTS)}" if power else ""
    return Marked(at=tuple(at), labels=labels, power=told)


def _digits(step: float) -> int:
    """Digits behind the point that a step has."""
    for digits in range(12):
        if abs(step * 10**digits - round(step * 10**digits)) < 1e-6 * step * 10**digits:
            return digits
    return 3


def _plain(number: str) -> str:
    """A number with a minus sign, and zero without one."""
    if set(number) <= set("-0."):
        number = number.lstrip("-")
    return number.replace("-", "−")
