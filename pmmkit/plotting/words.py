"""A figure in words: what its panels show over what, and between which values."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby
from operator import attrgetter
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting.letters import SUPERSCRIPTS, runs_of
from pmmkit.plotting.marks import BarSeries, Line, Mosaic, Rule

if TYPE_CHECKING:
    from pmmkit.plotting.axes import Axes, AxesGrid
    from pmmkit.plotting.extent import Side

_PANELS: Final = 6
"""Panels that are told one by one."""
_SERIES: Final = 4
"""Series of a panel that are told one by one."""


def in_words(figure: AxesGrid) -> str:
    """Panels, what they plot over what, which series there are and between which values they lie.

    Examples
    --------
    >>> from pmmkit.plotting.axes import Axes, AxesGrid
    >>> axis = Axes()
    >>> line = axis.plot([0.0, 2.0], [1.0, 3.5], color="#000000", label="measured")
    >>> axis.set_title("yaw rate r [deg/s]")
    >>> axis.set_xlabel("time [s]")
    >>> print(in_words(AxesGrid(axes=[axis])))
    Yaw rate r [deg/s] over time [s], 0 to 2: measured 1 to 3.5.
    """
    panels = [text for axis in figure.shown if (text := _panel(axis, figure))]
    more = len(panels) - _PANELS
    told = [f"{text[0].upper()}{text[1:]}." for text in panels[:_PANELS]]
    counted = f"{len(panels)} panels. " if len(panels) > 1 else ""
    return counted + " ".join([*told, *([f"And {more} more of the kind."] if more > 0 else [])])


def _panel(axis: Axes, figure: AxesGrid) -> str:
    name = _name(axis, figure)
    below = (axis.xlabel, *(own.xlabel for own in axis.xshared), figure.xlabel)
    over = plain(next((label.text for label in below if label.text), ""))
    if maps := [mark for mark in axis.marks if isinstance(mark, Mosaic)]:
        return "; ".join(text for text in (name, *_map(axis, maps[0])) if text)
    if bars := [_bars(axis, x) for x in axis.marks if isinstance(x, BarSeries) and _seen(x)]:
        return f"{name or over}: {'; '.join(bars)}"
    series = list(_series(axis))
    if not series:
        return ""
    rows = [text for text in _written(axis, "y").values() if text]
    told = [f"{label} {_span(x if rows else y)}".strip() for label, x, y in series[:_SERIES]]
    more = len(series) - _SERIES
    rest = [f"{more} more series"] if more > 0 else []
    if rows:
        listed = f"{len(rows)} rows, {rows[0]} to {rows[-1]}"
        return f"{', '.join(filter(None, (name, over, listed)))}: {'; '.join([*told, *rest])}"
    ends = _span(np.concatenate([x for _, x, _ in series]))
    abscissa = f" over {over}, {ends}" if over else ""
    return f"{name}{abscissa}: {'; '.join([*told, *rest])}"


def _seen(bars: BarSeries) -> bool:
    """Whether some bar has a length."""
    return bool(np.any(np.nan_to_num(bars.length, posinf=0.0, neginf=0.0)))


def _written(axis: Axes, side: Side) -> dict[float, str]:
    """What is written at the ticks of a side by their places, where that is stated."""
    for own in (axis, *(axis.xshared if side == "x" else axis.yshared)):
        ticks = own.xticks if side == "x" else own.yticks
        if ticks.at and ticks.labels:
            return dict(zip(ticks.at, map(plain, ticks.labels), strict=True))
    return {}


def _name(axis: Axes, figure: AxesGrid) -> str:
    """Title and ordinate of a panel, else those at the head of its column and of its row."""
    above = [x for x in figure.axes if x.columns == axis.columns and x.rows[0] == 0]
    beside = [x for x in figure.axes if x.rows == axis.rows and x.columns[0] == 0]
    title = next((x.title.text for x in (axis, *above) if x.title.text), "")
    ylabel = next((x.ylabel.text for x in (axis, *beside) if x.ylabel.text), "")
    return plain(", ".join(dict.fromkeys(filter(None, (title, ylabel)))))


def _series(axis: Axes) -> Iterator[tuple[str, Array, Array]]:
    """Series with a name, else all; points of one name are one series, and level lines are some."""
    groups: dict[str, list[Line | Rule]] = {}
    for mark in axis.marks:
        if isinstance(mark, Line | Rule) and (
            len(mark.x) if isinstance(mark, Line) else not mark.upright
        ):
            groups.setdefault(plain(mark.label), []).append(mark)
    for label, own in groups.items():
        x = np.concatenate([mark.x if isinstance(mark, Line) else [] for mark in own])
        y = np.concatenate([mark.y if isinstance(mark, Line) else [mark.at] for mark in own])
        if np.isfinite(y).any() and (label or len(groups) == 1):
            yield label, x, y


def _bars(axis: Axes, bars: BarSeries) -> str:
    """A set of bars, with the longest by the name of its place."""
    longest = int(np.nanargmax(np.abs(bars.length)))
    middle = float(bars.place[longest])
    names = _written(axis, "y" if bars.sideways else "x")
    place = names[min(names, key=lambda at: abs(at - middle))] if names else f"at {_number(middle)}"
    most = f"up to {_number(float(bars.length[longest]))}"
    return " ".join(filter(None, (plain(bars.label), most, place)))


def _map(axis: Axes, cells: Mosaic) -> Iterator[str]:
    values, (height, width) = cells.values, cells.values.shape
    yield f"a map of {height} rows and {width} columns"
    if not np.isfinite(values).any():
        return
    if height == width and np.allclose(np.diagonal(values), 1.0):
        values = np.where(np.eye(width, dtype=bool), np.nan, values)
    row, column = np.unravel_index(int(np.nanargmax(np.abs(values))), values.shape)
    names = (
        _written(axis, "y").get(cells.y + 0.5 + row),
        _written(axis, "x").get(cells.x + 0.5 + column),
    )
    at = " and ".join(filter(None, names))
    yield f"values {_span(values)}, the largest {_number(float(values[row, column]))} at {at}"


def _span(values: Array) -> str:
    there = values[np.isfinite(values)]
    if not len(there):
        return "without values"
    low, high = _number(float(there.min())), _number(float(there.max()))
    return low if low == high else f"{low} to {high}"


def _number(value: float) -> str:
    return f"{value:.3g}".replace("-", "−") if value else "0"


def plain(text: str) -> str:
    """Mathematical text as it is read aloud.

    Examples
    --------
    >>> plain(r"$10^3\\,$$Y'_{\\dot{v}}$"), plain("drift with\\nrudder")
    ('10³ Y′_v-dot', 'drift with rudder')
    """
    told = ""
    for rise, runs in groupby(runs_of(text), key=attrgetter("rise")):
        own = "".join(run.text for run in runs)
        told += own.translate(SUPERSCRIPTS) if rise > 0.0 else f"_{own}" if rise < 0.0 else own
    return " ".join(re.sub("(.)\u0307", r"\1-dot", told).split())
