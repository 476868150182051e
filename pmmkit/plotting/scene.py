"""What a figure shows, laid out: strokes, fills, dots and letters at their places in points.

The origin is the upper left corner, y goes down. Writers draw these in their order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting.axes import Axes
from pmmkit.plotting.extent import Marked, Side, scaled
from pmmkit.plotting.letters import ASCENT, DESCENT, LINE, MIDDLE, width_of
from pmmkit.plotting.marks import INK, Across, Upright


class Box(NamedTuple):
    """A rectangle [pt]."""

    left: float
    top: float
    right: float
    bottom: float

    @property
    def width(self) -> float:
        """From left to right."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """From top to bottom."""
        return self.bottom - self.top


@dataclass(frozen=True, kw_only=True, eq=False)
class Stroke:
    """A line through points (n, 2), broken at NaN. clip: what alone of it is seen."""

    points: Array
    colour: str
    width: float
    dash: str = "-"
    alpha: float = 1.0
    clip: Box | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Fill:
    """Polygons, each (n, 2), of one colour."""

    rings: tuple[Array, ...]
    colour: str
    alpha: float = 1.0
    outline: str = ""
    outline_width: float = 0.0
    hatch: str = ""
    clip: Box | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Dots:
    """Marks at points (n, 2)."""

    points: Array
    marker: str
    size: float
    face: str
    edge: str
    edge_width: float
    alpha: float = 1.0
    clip: Box | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Letters:
    """A line of text: where its base line begins, is in the middle, or ends."""

    text: str
    x: float
    y: float
    size: float
    colour: str
    across: Across = "left"
    turned: bool = False
    bold: bool = False

    @property
    def box(self) -> Box:
        """The rectangle that it fills."""
        wide = width_of(self.text, self.size) * (1.08 if self.bold else 1.0)
        before = {"left": 0.0, "center": wide / 2, "right": wide}[self.across]
        up, down = ASCENT * self.size, DESCENT * self.size
        if self.turned:
            bottom = self.y + before
            return Box(self.x - up, bottom - wide, self.x + down, bottom)
        left = self.x - before
        return Box(left, self.y - up, left + wide, self.y + down)


Shape = Stroke | Fill | Dots | Letters


def clip_of(shape: Shape) -> Box | None:
    """The rectangle in which alone a shape is seen."""
    return None if isinstance(shape, Letters) else shape.clip


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedAxes:
    """Axes at their place, with the ends of their sides."""

    axes: Axes
    box: Box
    x: tuple[float, float]
    y: tuple[float, float]
    xticks: Marked
    yticks: Marked

    def across(self, values: Array) -> Array:
        """Where abscissae stand [pt]."""
        return self._along(values, "x")

    def upright(self, values: Array) -> Array:
        """Where ordinates stand [pt]."""
        return self._along(values, "y")

    def _along(self, values: Array, side: Side) -> Array:
        axes, box = self.axes, self.box
        scale = axes.xscale if side == "x" else axes.yscale
        ends = np.array(self.x if side == "x" else self.y)
        first, last = scaled(ends, scale, axes.linear_to)
        share = (scaled(np.asarray(values, float), scale, axes.linear_to) - first) / (last - first)
        begin, end = (box.left, box.right) if side == "x" else (box.bottom, box.top)
        return np.asarray(np.clip(begin + share * (end - begin), -1e4, 1e4), np.float64)


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A figure laid out, of a width and height [pt]; shapes in the order of drawing."""

    width: float
    height: float
    shapes: tuple[Shape, ...]
    frames: tuple[PlacedAxes, ...]
    legend: Box | None

    @property
    def letters(self) -> tuple[Letters, ...]:
        """All texts."""
        return tuple(shape for shape in self.shapes if isinstance(shape, Letters))


def block(
    text: str,
    x: float,
    y: float,
    size: float,
    colour: str,
    across: Across = "left",
    upright: Upright = "baseline",
    *,
    bold: bool = False,
) -> list[Letters]:
    """Lines of a text, below, above or about a place."""
    lines, step = text.split("\n"), LINE * size
    more = step * (len(lines) - 1)
    first = {
        "top": y + ASCENT * size,
        "center": y - more / 2 + MIDDLE * size,
        "bottom": y - more - DESCENT * size,
        "baseline": y - more,
    }[upright]
    return [
        lettered(line, (x, first + step * number), size, colour, across, bold=bold)
        for number, line in enumerate(lines)
        if line
    ]


def turned_block(
    text: str, left: float, middle: float, size: float, colour: str = INK
) -> list[Letters]:
    """Lines of a text that goes upwards, the first at the left."""
    return [
        lettered(
            line, (left + size * (ASCENT + LINE * n), middle), size, colour, "center", turned=True
        )
        for n, line in enumerate(text.split("\n"))
    ]


def lettered(
    text: str,
    place: tuple[float, float],
    size: float,
    colour: str,
    across: Across = "left",
    *,
    turned: bool = False,
    bold: bool = False,
) -> Letters:
    """A line of text at a place."""
    return Letters(
        text=text, x=place[0], y=place[1], size=size, colour=colour, across=across,
        turned=turned, bold=bold,
    )  # fmt: skip
