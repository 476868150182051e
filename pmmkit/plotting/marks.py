"""What stands on the axes of a figure, as plain data: lines, areas, bars, cells, words, arrows.

Places are in the units of the axes, sizes in points. Every writer draws these and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from pmmkit.numerics import Array

Across = Literal["left", "center", "right"]
Upright = Literal["top", "center", "bottom", "baseline"]
INK: Final = "#222222"
"""Of letters and of what is drawn without a colour of its own."""
OPEN: Final = frozenset("x+|")
"""Marks that are strokes alone."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stroked:
    """How a line looks. dash: -, --, -., : or nothing. label: empty where no legend has it."""

    colour: str
    width: float = 1.6
    dash: str = "-"
    label: str = ""
    order: float = 2.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Filled:
    """How an area looks."""

    colour: str
    alpha: float = 1.0
    label: str = ""
    order: float = 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Line(Stroked):
    """A line through points, points alone, or points with intervals.

    x, y (n,): NaN breaks the line. marker: as matplotlib calls it; every: one mark each so many
    points. face, edge: of marks, `colour` where empty. x_error,
    y_error (2, n): down and up. cap: half width of their ends.
    """

    x: Array
    y: Array
    marker: str = ""
    size: float = 5.0
    face: str = ""
    edge: str = ""
    edge_width: float = 1.0
    every: int = 1
    alpha: float = 1.0
    clipped: bool = True
    x_error: Array | None = None
    y_error: Array | None = None
    cap: float = 0.0
    error_width: float = 1.6


@dataclass(frozen=True, kw_only=True, eq=False)
class Segments(Stroked):
    """Straight pieces, each from (x0, y0) to (x1, y1), all (n,)."""

    x0: Array
    y0: Array
    x1: Array
    y1: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Rule(Stroked):
    """A line from end to end of the axes; upright: at an abscissa."""

    at: float
    upright: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Strip(Filled):
    """A band from end to end of the axes; upright: between two abscissae."""

    low: float
    high: float
    upright: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Area(Filled):
    """What lies between two curves over one abscissa, all (n,); NaN breaks it."""

    x: Array
    low: Array
    high: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Polygons(Filled):
    """Filled polygons (n, corners, 2)."""

    corners: Array
    outline: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class BarSeries:
    """Bars, upright or sideways: where each stands, where it begins and how long it is, all (n,).

    colours (n,). thickness: in the units of the axis on which they stand.
    """

    place: Array
    base: Array
    length: Array
    thickness: float
    sideways: bool
    colours: Sequence[str]
    hatch: str = ""
    alpha: float = 1.0
    label: str = ""
    order: float = 1.0

    def corners(self) -> tuple[Array, Array, Array, Array]:
        """Left, right, bottom and top of each."""
        low, high = self.place - self.thickness / 2, self.place + self.thickness / 2
        begin, end = self.base, self.base + self.length
        return (begin, end, low, high) if self.sideways else (low, high, begin, end)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shades:
    """Which colour a value has.

    Parameters
    ----------
    levels : tuple of float
        Ends of the steps; the first and the last end of a smooth scale.
    colours : tuple of str
        One for each step; along a smooth scale at equal distances.
    smooth : bool
        Whether there are colours between them.

    Examples
    --------
    >>> Shades(levels=(0.0, 1.0, 2.0), colours=("#000000", "#ffffff")).of(np.array([0.5, 1.5]))
    ['#000000', '#ffffff']
    """

    levels: tuple[float, ...]
    colours: tuple[str, ...]
    smooth: bool = False

    def of(self, values: Array) -> list[str]:
        """Colours of values (n,), none of which is NaN."""
        if not self.smooth:
            last = len(self.colours) - 1
            places = np.clip(np.searchsorted(self.levels, values, side="right") - 1, 0, last)
            return [self.colours[place] for place in places.tolist()]
        rgb = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in self.colours])
        share = (values - self.levels[0]) / (self.levels[-1] - self.levels[0])
        along = np.linspace(0.0, 1.0, len(self.colours))
        mixed = np.stack([np.interp(share, along, part) for part in rgb.T], axis=1)
        return [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in np.rint(mixed).astype(int).tolist()]


RED_BLUE: Final = (
    *("#053061", "#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7"),
    *("#fddbc7", "#f4a582", "#d6604d", "#b2182b", "#67001f"),
)
"""From negative to positive values: RdBu of ColorBrewer 2.0 (colorbrewer2.org), reversed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Mosaic:
    """A matrix (m, n) of coloured cells of size 1, from (x, y) on; NaN is left empty.

    gap: white line between two cells.
    """

    values: Array
    shades: Shades
    x: float = 0.0
    y: float = 0.0
    gap: float = 0.0
    order: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Words:
    """A text at a place, shifted by (dx, dy), upwards positive.

    fraction: whether the place is a share of the axes. box: opacity of a white ground.
    """

    x: float
    y: float
    text: str
    colour: str
    dx: float = 0.0
    dy: float = 0.0
    across: Across = "left"
    upright: Upright = "baseline"
    size: float = 10.0
    turned: bool = False
    box: float = 0.0
    fraction: bool = False
    order: float = 3.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Arrow:
    """An arrow from a place to another; both: with a head at either end."""

    start: tuple[float, float]
    end: tuple[float, float]
    colour: str
    both: bool = False
    width: float = 1.0
    fraction: bool = False
    order: float = 3.0


Mark = Line | Segments | Rule | Strip | Area | Polygons | BarSeries | Mosaic | Words | Arrow
