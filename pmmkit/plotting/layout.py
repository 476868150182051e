"""Where everything of a figure stands: axes beside each other, with room for what is about them."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting.axes import Axes, AxesGrid, Title
from pmmkit.plotting.drawing import colour_key, drawn_marks, handle, words_boxes
from pmmkit.plotting.extent import Marked, ticks
from pmmkit.plotting.letters import ASCENT, DESCENT, LINE, MIDDLE, width_of
from pmmkit.plotting.marks import INK, Mark
from pmmkit.plotting.scene import (
    Box,
    Letters,
    PlacedAxes,
    Scene,
    Shape,
    Stroke,
    block,
    lettered,
    turned_block,
)

_PAD: Final = 4.0
"""Room about everything [pt]."""
_TICK: Final = 3.5
"""Length of a tick, and from it to its number [pt]."""
_BESIDE: Final = 8.0
"""Room between two axes [pt]."""
_ABOVE: Final = 5.0
"""From the axes to their title [pt]."""
_LEAST: Final = 6.5
"""Size of letters below which a text that is too long is cut [pt]."""
_PARTS: Final = re.compile(r"\\\$|\$[^$]*\$|.")
"""Letters of a text, and its formulas as a whole."""
_ROUNDS: Final = 3
"""Ticks need room, and room tells how many ticks there are."""
_GRID, _FRAME, _NUMBER = "#e3e3e3", "#888888", "#444444"
_GRID_ORDER, _FRAME_ORDER = 0.5, 2.5
_ENTRY: Final = 9.0
"""Size of letters of the legend [pt]; other lengths of it are multiples."""
_HANDLE, _AFTER_HANDLE, _BETWEEN, _ROW = 2.2, 0.7, 1.8, 1.45
_KEY: Final = 12.0
"""Width of a scale of colours [pt]."""


def laid_out(figure: AxesGrid) -> Scene:
    """Everything that a figure shows, at its place.

    Examples
    --------
    >>> axes = Axes()
    >>> line = axes.plot([0, 1], [0, 1], color="#000000")
    >>> scene = laid_out(AxesGrid(height=2.0, axes=[axes]))
    >>> scene.width, scene.height, [own.text for own in scene.letters][:3]
    (648.0, 144.0, ['0.0', '0.2', '0.4'])
    """
    width, height = 72.0 * figure.width, 72.0 * figure.height
    legend = _Legend.of(figure, width)
    inner = _inner(figure, width, height, legend.height)
    placed = _placed(figure, inner)
    frames = tuple(frame for frame, _ in placed)
    shapes: list[Shape] = []
    for frame, needs in placed:
        shapes += _axes(frame, needs, frames, width)
    shapes += _about(figure, inner, width, height, legend.height)
    if figure.key:
        shapes += colour_key(figure.key, _key_box(inner))
    place = legend.box(width, height)
    shapes += legend.shapes(place)
    return Scene(
        width=width,
        height=height,
        shapes=tuple(shapes),
        frames=frames,
        legend=place if legend.entries else None,
    )


def _lines(title: Title) -> float:
    """Height of the lines of a title [pt]."""
    return LINE * title.size * (title.text.count("\n") + 1) if title.text else 0.0


def _inner(figure: AxesGrid, width: float, height: float, legend: float) -> Box:
    """What titles of all axes, legend and scale of colours leave."""
    left = _PAD + (_lines(figure.ylabel) + _PAD if figure.ylabel.text else 0.0)
    top = _PAD + (_lines(figure.title) + _PAD if figure.title.text else 0.0)
    below = (_lines(figure.xlabel) + _PAD if figure.xlabel.text else 0.0) + legend
    key = 62.0 if figure.key else 0.0
    return Box(left, top, width - _PAD - key, height - _PAD - below)


def _key_box(inner: Box) -> Box:
    """Two thirds of the height, at the right."""
    off = inner.height / 6
    left = inner.right + 1.2 * _BESIDE
    return Box(left, inner.top + off, left + _KEY, inner.bottom - off)


# Axes in their grid.


@dataclass(frozen=True, kw_only=True)
class _Needs:
    """Room that axes need for what is about them [pt]."""

    left: float = 0.0
    right: float = 0.0
    top: float = 0.0
    bottom: float = 0.0


def _placed(figure: AxesGrid, inner: Box) -> list[tuple[PlacedAxes, _Needs]]:
    """Axes at their places: those of a column begin and end alike, and those of a row."""
    widths, heights = np.array(figure.widths, float), np.array(figure.heights, float)
    shown, frames = figure.shown, list[PlacedAxes]()
    needs = [_Needs()] * len(shown)
    for _ in range(_ROUNDS):
        columns = _ends(
            widths, inner.left, inner.width,
            [(axes.columns, own.left, own.right) for axes, own in zip(shown, needs, strict=True)],
        )  # fmt: skip
        rows = _ends(
            heights, inner.top, inner.height,
            [(axes.rows, own.top, own.bottom) for axes, own in zip(shown, needs, strict=True)],
        )  # fmt: skip
        frames = [
            _framed(
                axes,
                Box(
                    columns[0][axes.columns[0]],
                    rows[0][axes.rows[0]],
                    columns[1][axes.columns[1]],
                    rows[1][axes.rows[1]],
                ),
            )
            for axes in shown
        ]
        needs = [*map(_needs, frames)]
    return list(zip(frames, needs, strict=True))


def _ends(
    shares: Array,
    begin: float,
    length: float,
    needs: Sequence[tuple[tuple[int, int], float, float]],
) -> tuple[Array, Array]:
    """Where each column (or row) begins and ends, by what stands before and behind its axes."""
    before, behind = np.zeros(len(shares)), np.zeros(len(shares))
    for (first, last), low, high in needs:
        before[first] = max(before[first], low)
        behind[last] = max(behind[last], high)
    free = length - before.sum() - behind.sum() - _BESIDE * (len(shares) - 1)
    own = np.maximum(free, 10.0 * len(shares)) * shares / shares.sum()
    ends = begin + np.cumsum(before + own) + np.cumsum([0.0, *behind[:-1] + _BESIDE])
    return ends - own, ends


def _framed(axes: Axes, box: Box) -> PlacedAxes:
    """Axes in a box, with their ticks."""
    x, y = axes.limits("x"), axes.limits("y")
    if axes.equal == "box":
        box = _of_one_scale(box, abs(x[1] - x[0]), abs(y[1] - y[0]))
    elif axes.equal:
        x, y = _widened(box, x, y)
    upwards = max(int(box.height // (1.7 * axes.yticks.size)), 1)
    yticks = ticks(y, upwards, axes.yticks, axes.yscale, axes.linear_to)
    return PlacedAxes(axes=axes, box=box, x=x, y=y, xticks=_across(axes, box, x), yticks=yticks)


def _across(axes: Axes, box: Box, x: tuple[float, float]) -> Marked:
    """Ticks of the abscissa: as many as have room for their numbers."""
    own = axes.xticks
    room = max(int(box.width // (3.0 * own.size)), 1)
    while True:
        found = ticks(x, room, own, axes.xscale, axes.linear_to)
        wide = max((width_of(text, own.size) for text in found.labels), default=0.0)
        if room == 1 or own.at is not None or len(found.at) < 2:
            return found
        step = box.width * (found.at[1] - found.at[0]) / abs(x[1] - x[0])
        if wide + 0.8 * own.size <= step:
            return found
        room -= 1


def _of_one_scale(box: Box, wide: float, high: float) -> Box:
    """The largest part of a box, in its middle, of which both sides have one scale."""
    scale = min(box.width / wide, box.height / high)
    x, y = (box.width - scale * wide) / 2, (box.height - scale * high) / 2
    return Box(box.left + x, box.top + y, box.right - x, box.bottom - y)


def _widened(
    box: Box, x: tuple[float, float], y: tuple[float, float]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Ends so far apart that both sides have one scale."""
    scale = max(abs(x[1] - x[0]) / box.width, abs(y[1] - y[0]) / box.height)

    def about(ends: tuple[float, float], length: float) -> tuple[float, float]:
        middle, half = sum(ends) / 2, scale * length / 2
        return (
            (middle - half, middle + half) if ends[1] >= ends[0] else (middle + half, middle - half)
        )

    return about(x, box.width), about(y, box.height)


def _needs(frame: PlacedAxes) -> _Needs:
    axes, box = frame.axes, frame.box
    out = _TICK + (_TICK if axes.xticks.marked else 0.0)
    below, left = 0.0, 0.0
    if axes.xticks.shown and frame.xticks.labels:
        below = out + _label_height(frame)
    if axes.xlabel.text:
        below += _PAD + _lines(axes.xlabel)
    if frame.xticks.power and axes.xticks.shown:
        below += 0.0 if axes.xlabel.text else LINE * axes.xticks.size
    if axes.yticks.shown and frame.yticks.labels:
        left = out + max(_widest(text, axes.yticks.size) for text in frame.yticks.labels)
    if axes.ylabel.text:
        own = axes.ylabel
        left += _PAD + (_widest(own.text, own.size) if own.level else _lines(own))
    top, right = 0.0, 0.0
    if axes.title.text or axes.title_right.text:
        top = _ABOVE + max(_lines(axes.title), _lines(axes.title_right))
    if frame.yticks.power and axes.yticks.shown:
        top = max(top, _ABOVE + LINE * axes.yticks.size)
        left = max(left, _TICK + width_of(frame.yticks.power, axes.yticks.size))
    if axes.xticks.shown and not axes.xticks.turned and frame.xticks.labels:
        at = frame.across(np.array(frame.xticks.at)).tolist()
        half = [_widest(text, axes.xticks.size) / 2 for text in frame.xticks.labels]
        right = max(0.0, max(x + w for x, w in zip(at, half, strict=True)) - box.right)
        left = max(left, box.left - min(x - w for x, w in zip(at, half, strict=True)))
    for words in words_boxes(frame):
        left, right = max(left, box.left - words.left), max(right, words.right - box.right)
        top, below = max(top, box.top - words.top), max(below, words.bottom - box.bottom)
    return _Needs(left=left, right=right, top=top, bottom=below)


def _widest(text: str, size: float) -> float:
    return max(width_of(line, size) for line in text.split("\n"))


def _label_height(frame: PlacedAxes) -> float:
    own = frame.axes.xticks
    if own.turned:
        return max(width_of(text, own.size) for text in frame.xticks.labels)
    return LINE * own.size * max(text.count("\n") + 1 for text in frame.xticks.labels)


# What stands on axes and about them.


def _axes(
    frame: PlacedAxes, needs: _Needs, frames: Sequence[PlacedAxes], width: float
) -> list[Shape]:
    """Marks by their order, with the grid and the frame between them."""
    marks = sorted(frame.axes.marks, key=attrgetter("order"))
    behind = bisect_left(marks, _GRID_ORDER, key=attrgetter("order"))
    front = bisect_left(marks, _FRAME_ORDER, key=attrgetter("order"))
    return [
        *drawn_marks(marks[:behind], frame),
        *_grid(frame),
        *drawn_marks(marks[behind:front], frame),
        *_frame(frame),
        *drawn_marks(marks[front:], frame),
        *_numbers(frame),
        *_titles(frame, needs, frames, width),
    ]


def _grid(frame: PlacedAxes) -> list[Shape]:
    """Lines at the ticks of either side."""
    box, found = frame.box, []
    if frame.axes.lines["x"]:
        found += [[(x, box.top), (x, box.bottom)] for x in frame.across(_at(frame.xticks))]
    if frame.axes.lines["y"]:
        found += [[(box.left, y), (box.right, y)] for y in frame.upright(_at(frame.yticks))]
    return [_pieces(found, _GRID, 0.8)] if found else []


def _at(own: Marked) -> Array:
    return np.array(own.at, float)


def _pieces(pieces: Sequence[Sequence[tuple[float, float]]], colour: str, width: float) -> Stroke:
    """Single straight lines as one."""
    gap = np.full((1, 2), np.nan)
    points = np.concatenate([part for own in pieces for part in (np.array(own, float), gap)])
    return Stroke(points=points[:-1], colour=colour, width=width)


def _frame(frame: PlacedAxes) -> list[Shape]:
    """The two sides that have numbers, and their ticks."""
    axes, box = frame.axes, frame.box
    if not axes.framed:
        return []
    sides = _pieces(
        [[(box.left, box.top), (box.left, box.bottom), (box.right, box.bottom)]], _FRAME, 0.8
    )
    small = [[(x, box.bottom), (x, box.bottom + _TICK)] for x in frame.across(_at(frame.xticks))]
    small += [[(box.left - _TICK, y), (box.left, y)] for y in frame.upright(_at(frame.yticks))]
    return [sides, *([_pieces(small, _NUMBER, 0.8)] if small else [])]


def _numbers(frame: PlacedAxes) -> list[Letters]:
    """What is written at the ticks, and the powers of ten."""
    axes, box, found = frame.axes, frame.box, []
    out = _TICK + (_TICK if axes.xticks.marked else 0.0)
    if axes.xticks.shown:
        size = axes.xticks.size
        for x, text in zip(
            frame.across(_at(frame.xticks)).tolist(), frame.xticks.labels, strict=True
        ):
            if axes.xticks.turned:
                place = x + MIDDLE * size, box.bottom + out
                found.append(lettered(text, place, size, _NUMBER, "right", turned=True))
            else:
                top = box.bottom + out
                found += block(text, x, top, size, _NUMBER, "center", "top")
        if frame.xticks.power:
            down = _label_height(frame) + (_PAD if axes.xlabel.text else 0.0)
            place = box.right, box.bottom + out + down + ASCENT * size
            found.append(lettered(frame.xticks.power, place, size, _NUMBER, "right"))
    if axes.yticks.shown:
        size = axes.yticks.size
        for y, text in zip(
            frame.upright(_at(frame.yticks)).tolist(), frame.yticks.labels, strict=True
        ):
            found += block(text, box.left - out, y, size, _NUMBER, "right", "center")
        if frame.yticks.power:
            place = box.left - _TICK, box.top - _ABOVE - DESCENT * size
            found.append(lettered(frame.yticks.power, place, size, _NUMBER, "right"))
    return found


def _titles(
    frame: PlacedAxes, needs: _Needs, frames: Sequence[PlacedAxes], width: float
) -> list[Letters]:
    """Titles and names of the sides, made smaller where they are longer than their room."""
    axes, box, found = frame.axes, frame.box, []
    beside = [_begins(own) for own in frames if own.box.left > box.right - 1.0]
    room = min([*beside, width]) - _PAD - box.left
    base = box.top - _ABOVE
    if axes.title.text:
        taken = (
            _widest(axes.title_right.text, axes.title_right.size) if axes.title_right.text else 0
        )
        own = fitted(axes.title, room - (taken + 2 * _PAD if taken else 0.0))
        found += block(own.text, box.left, base, own.size, INK, "left", "bottom")
    if axes.title_right.text:
        own = fitted(axes.title_right, box.width)
        found += block(own.text, box.right, base, own.size, INK, "right", "bottom")
    if axes.xlabel.text:
        low = box.bottom + needs.bottom - _lines(axes.xlabel)
        before = [own.box.right for own in frames if own.box.right < box.left + 1.0]
        middle = (box.left + box.right) / 2
        half = min(room + box.left - middle, middle - max([*before, 0.0]) - _PAD)
        own = fitted(axes.xlabel, 2 * half)
        found += block(own.text, middle, low, own.size, INK, "center", "top")
    if axes.ylabel.text:
        own, middle = axes.ylabel, (box.top + box.bottom) / 2
        edge = box.left - needs.left
        if own.level:
            right = edge + _widest(own.text, own.size)
            found += block(own.text, right, middle, own.size, INK, "right", "center", bold=own.bold)
        else:
            own = fitted(own, box.height + needs.top + needs.bottom + _BESIDE)
            found += turned_block(own.text, edge, middle, own.size)
    return found


def _begins(frame: PlacedAxes) -> float:
    """Where what stands above axes begins."""
    own = frame.yticks.power
    return frame.box.left - (_TICK + width_of(own, frame.axes.yticks.size) if own else 0.0)


def fitted(title: Title, room: float) -> Title:
    """A title in letters so small that it has room, cut where that is not enough."""
    wide = _widest(title.text, title.size)
    if wide <= room:
        return title
    size = max(title.size * room / wide, _LEAST)
    lines = [_cut(line, size, room) for line in title.text.split("\n")]
    return replace(title, text="\n".join(lines), size=size)


def _cut(line: str, size: float, room: float) -> str:
    if width_of(line, size) <= room + 1e-6:
        return line
    parts = _PARTS.findall(line)
    while len(parts) > 1 and width_of(f"{''.join(parts)} …", size) > room:
        parts.pop()
    return f"{''.join(parts).rstrip()} …"


def _about(figure: AxesGrid, inner: Box, width: float, height: float, legend: float) -> list[Shape]:
    """Titles of all axes together."""
    found: list[Shape] = []
    if figure.title.text:
        own = fitted(figure.title, width - 2 * _PAD)
        found += block(own.text, _PAD + 2.0, _PAD, own.size, INK, "left", "top")
    if figure.ylabel.text:
        own = fitted(figure.ylabel, inner.height)
        found += turned_block(own.text, _PAD, (inner.top + inner.bottom) / 2, own.size)
    if figure.xlabel.text:
        own, below = fitted(figure.xlabel, width - 2 * _PAD), height - legend - _PAD
        found += block(own.text, width / 2, below, own.size, INK, "center", "bottom")
    return found


# The legend.


@dataclass(frozen=True, kw_only=True, eq=False)
class _Legend:
    """Entries of a legend in columns."""

    entries: tuple[tuple[str, Mark], ...]
    columns: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, figure: AxesGrid, width: float) -> _Legend:
        """Each label once, in so many columns as have room."""
        found: dict[str, Mark] = {}
        for axes in figure.legend:
            for mark in axes.marks:
                label = getattr(mark, "label", "")
                if label:
                    found.setdefault(label, mark)
        entries = tuple(found.items())
        for count in range(min(figure.legend_columns, len(entries)), 0, -1):
            columns = tuple(
                tuple(own.tolist()) for own in np.array_split(np.arange(len(entries)), count)
            )
            if count == 1 or _total(entries, columns) < width - 2 * _PAD:
                return cls(entries=entries, columns=columns)
        return cls(entries=(), columns=())

    @property
    def height(self) -> float:
        """With the room above it."""
        if not self.entries:
            return 0.0
        return _ROW * _ENTRY * max(map(len, self.columns)) + 2 * _PAD

    def box(self, width: float, height: float) -> Box:
        """In the middle, at the lower edge."""
        wide = min(_total(self.entries, self.columns), width - 2 * _PAD)
        left = (width - wide) / 2
        return Box(left, height - self.height + _PAD, left + wide, height - _PAD / 2)

    def shapes(self, box: Box) -> list[Shape]:
        """Handles and labels."""
        found: list[Shape] = []
        left = box.left
        room = box.width - (_HANDLE + _AFTER_HANDLE) * _ENTRY
        for column in self.columns:
            for row, number in enumerate(column):
                label, mark = self.entries[number]
                middle = box.top + _ROW * _ENTRY * (row + 0.5)
                right = left + _HANDLE * _ENTRY
                found += handle(mark, Box(left, middle - 3.2, right, middle + 3.2))
                own = fitted(Title(text=label, size=_ENTRY), room)
                start = right + _AFTER_HANDLE * _ENTRY
                found += block(own.text, start, middle, own.size, INK, "left", "center")
            left += _column(self.entries, column) + _BETWEEN * _ENTRY
        return found


def _column(entries: Sequence[tuple[str, Mark]], column: Sequence[int]) -> float:
    wide = max((_widest(entries[number][0], _ENTRY) for number in column), default=0.0)
    return wide + (_HANDLE + _AFTER_HANDLE) * _ENTRY


def _total(entries: Sequence[tuple[str, Mark]], columns: Sequence[Sequence[int]]) -> float:
    gaps = _BETWEEN * _ENTRY * (len(columns) - 1)
    return sum(_column(entries, column) for column in columns) + gaps
