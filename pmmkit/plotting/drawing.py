"""Marks of axes as shapes: their places in points, and how a legend and a scale show them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import singledispatch
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array, stretches
from pmmkit.plotting.axes import Key
from pmmkit.plotting.extent import Ticks, ticks
from pmmkit.plotting.letters import width_of
from pmmkit.plotting.marks import (
    INK,
    OPEN,
    Area,
    Arrow,
    BarSeries,
    Line,
    Mark,
    Mosaic,
    Polygons,
    Rule,
    Segments,
    Strip,
    Words,
)
from pmmkit.plotting.scene import (
    Box,
    Dots,
    Fill,
    Letters,
    PlacedAxes,
    Shape,
    Stroke,
    block,
    lettered,
    turned_block,
)

_HEAD: Final = 5.0
"""Length of the head of an arrow [pt]."""
_STEPS: Final = 64
"""Colours of a smooth scale."""


def drawn_marks(marks: Iterable[Mark], frame: PlacedAxes) -> Iterator[Shape]:
    """The shapes of marks on axes."""
    for mark in marks:
        yield from _drawn(mark, frame)


@singledispatch
def _drawn(mark: Mark, frame: PlacedAxes) -> Iterator[Shape]:  # noqa: ARG001
    """The shapes of a mark."""
    raise TypeError(f"{type(mark).__name__} is no mark.")


def _at(frame: PlacedAxes, x: Array, y: Array) -> Array:
    return np.stack([frame.across(x), frame.upright(y)], axis=-1)


@_drawn.register
def _line(mark: Line, frame: PlacedAxes) -> Iterator[Shape]:
    points, clip = _at(frame, mark.x, mark.y), frame.box if mark.clipped else None
    yield from _intervals(mark, frame, points)
    if mark.dash and len(points) > 1:
        yield Stroke(
            points=points, colour=mark.colour, width=mark.width, dash=mark.dash, alpha=mark.alpha,
            clip=clip,
        )  # fmt: skip
    if mark.marker:
        yield _dots(mark, points[:: mark.every], _in_sight(points[:: mark.every], frame, mark))


def _in_sight(points: Array, frame: PlacedAxes, mark: Line) -> NDArray[np.bool_]:
    """Which points lie on the axes: a mark is shown as a whole or not at all."""
    if not mark.clipped:
        return np.asarray(np.isfinite(points).all(axis=1))
    box = frame.box
    low, high = np.array(box[:2]) - 0.5, np.array(box[2:]) + 0.5
    with np.errstate(invalid="ignore"):
        return np.asarray(((points >= low) & (points <= high)).all(axis=1))


def _dots(mark: Line, points: Array, seen: NDArray[np.bool_]) -> Dots:
    face = mark.face or mark.colour
    return Dots(
        points=points[seen],
        marker=mark.marker,
        size=mark.size * (0.5 if mark.marker == "." else 1.0),
        face="" if face == "none" or mark.marker in OPEN else face,
        edge=mark.edge or mark.colour,
        edge_width=mark.edge_width,
        alpha=mark.alpha,
    )


def _intervals(mark: Line, frame: PlacedAxes, points: Array) -> Iterator[Shape]:
    """Bars of intervals, with their ends."""
    pieces: list[Array] = []
    gap = np.full((len(points), 1, 2), np.nan)
    for error, side in ((mark.x_error, 0), (mark.y_error, 1)):
        if error is None or not len(points):
            continue
        own = mark.x if side == 0 else mark.y
        with np.errstate(invalid="ignore"):
            ends = [own - error[0], own + error[1]]
        places = [_at(frame, end, mark.y) if side == 0 else _at(frame, mark.x, end) for end in ends]
        pieces.append(np.concatenate([np.stack(places, axis=1), gap], axis=1).reshape(-1, 2))
        if mark.cap:
            shift = np.array([0.0, mark.cap] if side == 0 else [mark.cap, 0.0])
            pieces += [
                np.concatenate([np.stack([end - shift, end + shift], axis=1), gap], axis=1).reshape(
                    -1, 2
                )
                for end in places
            ]
    if pieces:
        yield Stroke(
            points=np.concatenate(pieces)[:-1],
            colour=mark.colour,
            width=mark.error_width,
            alpha=mark.alpha,
            clip=frame.box,
        )


@_drawn.register
def _segments(mark: Segments, frame: PlacedAxes) -> Iterator[Shape]:
    begin, end = _at(frame, mark.x0, mark.y0), _at(frame, mark.x1, mark.y1)
    points = np.stack([begin, end, np.full(begin.shape, np.nan)], axis=1).reshape(-1, 2)
    if len(points):
        yield Stroke(
            points=points[:-1], colour=mark.colour, width=mark.width, dash=mark.dash, clip=frame.box
        )


@_drawn.register
def _rule(mark: Rule, frame: PlacedAxes) -> Iterator[Shape]:
    box = frame.box
    if mark.upright:
        x = float(frame.across(np.array(mark.at)))
        points = np.array([(x, box.top), (x, box.bottom)])
    else:
        y = float(frame.upright(np.array(mark.at)))
        points = np.array([(box.left, y), (box.right, y)])
    yield Stroke(points=points, colour=mark.colour, width=mark.width, dash=mark.dash, clip=box)


@_drawn.register
def _strip(mark: Strip, frame: PlacedAxes) -> Iterator[Shape]:
    box, ends = frame.box, np.array([mark.low, mark.high])
    if mark.upright:
        left, right = sorted(frame.across(ends).tolist())
        ring = _rectangle(left, box.top, right, box.bottom)
    else:
        top, bottom = sorted(frame.upright(ends).tolist())
        ring = _rectangle(box.left, top, box.right, bottom)
    yield Fill(rings=(ring,), colour=mark.colour, alpha=mark.alpha, clip=box)


def _rectangle(left: float, top: float, right: float, bottom: float) -> Array:
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])


@_drawn.register
def _area(mark: Area, frame: PlacedAxes) -> Iterator[Shape]:
    low, high = _at(frame, mark.x, mark.low), _at(frame, mark.x, mark.high)
    known = np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
    rings = tuple(
        np.concatenate([low[begin:end], high[begin:end][::-1]])
        for begin, end in zip(*stretches(np.asarray(known)), strict=True)
    )
    if rings:
        yield Fill(rings=rings, colour=mark.colour, alpha=mark.alpha, clip=frame.box)


@_drawn.register
def _polygons(mark: Polygons, frame: PlacedAxes) -> Iterator[Shape]:
    places = _at(frame, mark.corners[..., 0], mark.corners[..., 1])
    x, y = places[..., 0], places[..., 1]
    turns = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    # all one way: two that turn against each other leave a hole where both are
    places = np.where((turns < 0.0)[:, None, None], places[:, ::-1], places)
    yield Fill(
        rings=tuple(ring for ring in places if np.isfinite(ring).all()),
        colour=mark.colour,
        alpha=mark.alpha,
        outline=mark.colour if mark.outline else "",
        outline_width=mark.outline,
        clip=frame.box,
    )


@_drawn.register
def _bars(mark: BarSeries, frame: PlacedAxes) -> Iterator[Shape]:
    left, right, bottom, top = mark.corners()
    x, y = (
        [frame.across(own) for own in (left, right)],
        [frame.upright(own) for own in (bottom, top)],
    )
    rings = np.stack(
        [np.stack([x[i], y[j]], axis=-1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1
    )
    for colour in dict.fromkeys(mark.colours):
        own = tuple(
            ring
            for ring, hue in zip(rings, mark.colours, strict=True)
            if hue == colour and np.isfinite(ring).all()
        )
        if own:
            yield Fill(rings=own, colour=colour, alpha=mark.alpha, hatch=mark.hatch, clip=frame.box)


@_drawn.register
def _mosaic(mark: Mosaic, frame: PlacedAxes) -> Iterator[Shape]:
    rows, columns = np.nonzero(np.isfinite(mark.values))
    shades = mark.shades.of(mark.values[rows, columns])
    x, y = mark.x + columns.astype(float), mark.y + rows.astype(float)
    left, right = frame.across(x), frame.across(x + 1.0)
    one, other = frame.upright(y), frame.upright(y + 1.0)
    by_colour: dict[str, list[Array]] = {}
    for colour, *corners in zip(
        shades, left.tolist(), one.tolist(), right.tolist(), other.tolist(), strict=True
    ):
        by_colour.setdefault(colour, []).append(_rectangle(*corners))
    for colour, rings in by_colour.items():
        yield Fill(
            rings=tuple(rings),
            colour=colour,
            outline="#ffffff" if mark.gap else colour,
            outline_width=mark.gap or 0.3,  # of its own colour: no hair lines between cells
            clip=frame.box,
        )


@_drawn.register
def _words(mark: Words, frame: PlacedAxes) -> Iterator[Shape]:
    x, y = _place(frame, (mark.x, mark.y), fraction=mark.fraction)
    x, y = x + mark.dx, y - mark.dy
    if mark.turned:
        lines = turned_block(mark.text, 0.0, y, mark.size, mark.colour)
        wide = max(own.box.right for own in lines) - min(own.box.left for own in lines)
        left = {"left": x, "center": x - wide / 2, "right": x - wide}[mark.across]
        shift = {"center": 0.0, "bottom": -0.5, "baseline": -0.5, "top": 0.5}[mark.upright]
        down = shift * max(own.box.height for own in lines)
        lines = [replace(own, x=own.x + left, y=own.y + down) for own in lines]
    else:
        lines = block(mark.text, x, y, mark.size, mark.colour, mark.across, mark.upright)
    if mark.box and lines:
        boxes = [own.box for own in lines]
        ground = _rectangle(
            min(own.left for own in boxes) - 1.0,
            min(own.top for own in boxes),
            max(own.right for own in boxes) + 1.0,
            max(own.bottom for own in boxes),
        )
        yield Fill(rings=(ground,), colour="#ffffff", alpha=mark.box)
    yield from lines


def words_boxes(frame: PlacedAxes) -> list[Box]:
    """What the words on axes fill."""
    marks = (mark for mark in frame.axes.marks if isinstance(mark, Words) and mark.text)
    shapes = (shape for mark in marks for shape in _words(mark, frame))
    return [shape.box for shape in shapes if isinstance(shape, Letters)]


def _place(frame: PlacedAxes, place: tuple[float, float], *, fraction: bool) -> tuple[float, float]:
    if fraction:
        box = frame.box
        return box.left + place[0] * box.width, box.bottom - place[1] * box.height
    return float(frame.across(np.array(place[0]))), float(frame.upright(np.array(place[1])))


@_drawn.register
def _arrow(mark: Arrow, frame: PlacedAxes) -> Iterator[Shape]:
    ends = np.array([_place(frame, own, fraction=mark.fraction) for own in (mark.start, mark.end)])
    yield Stroke(points=ends, colour=mark.colour, width=mark.width)
    for start, end in (ends, ends[::-1])[: 2 if mark.both else 1]:
        length = float(np.hypot(*(end - start)))
        if length == 0.0:
            continue
        along = (end - start) / length * min(_HEAD, length / 2)
        aside = 0.4 * np.array([-along[1], along[0]])
        head = np.array([end - along + aside, end, end - along - aside])
        yield Stroke(points=head, colour=mark.colour, width=mark.width)


# How a legend shows a mark, and a scale its colours.


def handle(mark: Mark, box: Box) -> Iterator[Shape]:
    """A mark of a legend in a box."""
    middle = (box.top + box.bottom) / 2
    across = np.array([(box.left, middle), (box.right, middle)])
    match mark:
        case Line():
            centre = np.array([((box.left + box.right) / 2, middle)])
            if mark.y_error is not None or mark.x_error is not None:
                up = np.array([centre[0] - (0.0, 4.5), centre[0] + (0.0, 4.5)])
                yield Stroke(points=up, colour=mark.colour, width=mark.error_width)
            if mark.dash:
                yield Stroke(
                    points=across, colour=mark.colour, width=mark.width, dash=mark.dash,
                    alpha=mark.alpha,
                )  # fmt: skip
            if mark.marker:
                yield _dots(mark, centre, np.array([True]))
        case Segments() | Rule():
            yield Stroke(points=across, colour=mark.colour, width=mark.width, dash=mark.dash)
        case BarSeries():
            yield Fill(
                rings=(_rectangle(*box),), colour=mark.colours[0] if len(mark.colours) else INK,
                alpha=mark.alpha, hatch=mark.hatch,
            )  # fmt: skip
        case Strip() | Area() | Polygons():
            yield Fill(rings=(_rectangle(*box),), colour=mark.colour, alpha=mark.alpha)


def colour_key(key: Key, box: Box) -> Iterator[Shape]:
    """A scale of colours in a box, with its numbers and its title at the right."""
    shades = key.shades
    if shades.smooth:
        low, high = shades.levels[0], shades.levels[-1]
        steps = np.linspace(low, high, _STEPS + 1)
        colours = shades.of((steps[:-1] + steps[1:]) / 2)
        marked = ticks((low, high), 6, Ticks(), "linear", 1.0)
        shares = [
            ((x - low) / (high - low), text)
            for x, text in zip(marked.at, marked.labels, strict=True)
        ]
    else:
        colours, count = list(shades.colours), len(shades.colours)
        shares = [(i / count, f"{level:g}") for i, level in enumerate(shades.levels[:-1])]
    edges = np.linspace(box.bottom, box.top, len(colours) + 1).tolist()
    for colour, one, other in zip(colours, edges[:-1], edges[1:], strict=True):
        ring = _rectangle(box.left, other, box.right, one)
        yield Fill(rings=(ring,), colour=colour, outline=colour, outline_width=0.3)
    if key.beyond:
        for colour, edge, out in ((colours[0], box.bottom, 10.0), (colours[-1], box.top, -10.0)):
            tip = np.array(
                [(box.left, edge), (box.right, edge), ((box.left + box.right) / 2, edge + out)]
            )
            yield Fill(rings=(tip,), colour=colour)
    wide = 0.0
    for share, text in shares:
        y = box.bottom - share * box.height
        yield Stroke(
            points=np.array([(box.right, y), (box.right + 3.0, y)]), colour="#444444", width=0.8
        )
        yield lettered(text, (box.right + 5.5, y + 3.2), 9.0, "#444444")
        wide = max(wide, width_of(text, 9.0))
    yield from turned_block(key.title, box.right + 8.0 + wide, (box.top + box.bottom) / 2, 9.5)
