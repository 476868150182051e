"""Axes as plain data: their marks, titles and ticks, and a sheet on which they stand.

Whoever draws says what stands where; nothing of it knows a program that draws. Methods have the
names and words of matplotlib's axes, which everybody knows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array
from pmmkit.plotting.extent import Scale, Side, Ticks, extent
from pmmkit.plotting.marks import (
    INK,
    Across,
    Area,
    Arrow,
    BarSeries,
    Line,
    Mark,
    Mosaic,
    Polygons,
    Rule,
    Segments,
    Shades,
    Strip,
    Upright,
    Words,
)

WIDTH: Final = 9.0
"""Width of a figure [inch]: a report column at 100 dots per inch."""
MARGIN: Final = 0.05
"""Room about the marks, as a share of what they fill."""
SIZES: Final = {"xx-small": 5.8, "x-small": 6.9, "small": 8.3}
"""Sizes of letters by name [pt]."""


@dataclass(kw_only=True, eq=False)
class Title:
    """A text at the side of axes or of a figure, and how it stands there."""

    text: str = ""
    size: float = 10.0
    level: bool = False
    bold: bool = False


@dataclass(kw_only=True, eq=False)
class Key:
    """What the colours of a mosaic mean: a scale beside some axes.

    beyond: whether colours go on beyond the ends.
    """

    shades: Shades
    title: str
    beyond: bool = False


@dataclass(kw_only=True, eq=False)
class Axes:
    """Axes with their marks: what `Figure.subplots` gives.

    Parameters
    ----------
    rows, columns : (int, int)
        First and last place in the grid of the figure.
    marks : list of Mark
        What was drawn, in its order.
    title, title_right, xlabel, ylabel : Title
        What stands about it.
    xticks, yticks : Ticks
        Where numbers stand, as far as it is stated.
    xscale, yscale : {"linear", "log", "symlog"}
        How values stand along the sides.
    linear_to : float
        Where a symlog side begins to be logarithmic.
    stated : dict
        Ends of the sides that were stated: x0, x1, y0, y1.
    room : dict
        Room about the marks by side, as a share of what they fill.
    lines : dict
        Whether lines stand at the ticks of x and of y.
    framed : bool
        Whether sides and ticks are drawn.
    equal : {"", "datalim", "box"}
        Whether both sides have one scale, and what gives way for it.
    xshared, yshared : list of Axes
        Others with the same ends.
    removed : bool
        Whether its place stays empty.

    Examples
    --------
    >>> axis = Axes()
    >>> line = axis.plot([0.0, 2.0], [0.0, 1.0], color="#000000")
    >>> axis.set_ylabel("force Y [N]")
    >>> axis.limits("x")
    (-0.1, 2.1)
    """

    rows: tuple[int, int] = (0, 0)
    columns: tuple[int, int] = (0, 0)
    marks: list[Mark] = field(default_factory=list)
    title: Title = field(default_factory=Title)
    title_right: Title = field(default_factory=Title)
    xlabel: Title = field(default_factory=Title)
    ylabel: Title = field(default_factory=Title)
    xticks: Ticks = field(default_factory=Ticks)
    yticks: Ticks = field(default_factory=Ticks)
    xscale: Scale = "linear"
    yscale: Scale = "linear"
    linear_to: float = 1.0
    stated: dict[str, float] = field(default_factory=dict)
    room: dict[str, float] = field(default_factory=dict)
    lines: dict[str, bool] = field(default_factory=lambda: {"x": True, "y": True})
    framed: bool = True
    equal: Literal["", "datalim", "box"] = ""
    xshared: list[Axes] = field(default_factory=list, repr=False)
    yshared: list[Axes] = field(default_factory=list, repr=False)
    removed: bool = False

    # What is drawn.

    def plot(self, x: ArrayLike, y: ArrayLike, **look: Any) -> Line:
        """A line through points, or points alone (``ls=""`` with a ``marker``)."""
        line = _line(x, y, look)
        self.marks.append(line)
        return line

    def errorbar(
        self,
        x: ArrayLike,
        y: ArrayLike,
        yerr: ArrayLike | None = None,
        xerr: ArrayLike | None = None,
        *,
        elinewidth: float | None = None,
        capsize: float = 0.0,
        **look: Any,
    ) -> Line:
        """Points with intervals: half of each (n,), or what is below and above (2, n)."""
        points = _line(x, y, look)
        errors: dict[str, Any] = {
            f"{side}_error": np.broadcast_to(np.asarray(half, float), (2, len(points.x)))
            for side, half in (("x", xerr), ("y", yerr))
            if half is not None
        }
        thick = points.width if elinewidth is None else elinewidth
        line = replace(points, **errors, cap=capsize, error_width=thick)
        self.marks.append(line)
        return line

    def hlines(self, y: ArrayLike, xmin: ArrayLike, xmax: ArrayLike, **look: Any) -> None:
        """Level pieces of lines."""
        self._segments(xmin, y, xmax, y, look)

    def vlines(self, x: ArrayLike, ymin: ArrayLike, ymax: ArrayLike, **look: Any) -> None:
        """Upright pieces of lines."""
        self._segments(x, ymin, x, ymax, look)

    def axhline(self, y: float, **look: Any) -> None:
        """A level line from end to end."""
        self.marks.append(Rule(at=float(y), upright=False, **_looks(Rule, look)))

    def axvline(self, x: float, **look: Any) -> None:
        """An upright line from end to end."""
        self.marks.append(Rule(at=float(x), upright=True, **_looks(Rule, look)))

    def axhspan(self, low: float, high: float, **look: Any) -> None:
        """A level band from end to end."""
        own = _looks(Strip, look)
        self.marks.append(Strip(low=float(low), high=float(high), upright=False, **own))

    def axvspan(self, low: float, high: float, **look: Any) -> None:
        """An upright band from end to end."""
        own = _looks(Strip, look)
        self.marks.append(Strip(low=float(low), high=float(high), upright=True, **own))

    def fill_between(self, x: ArrayLike, low: ArrayLike, high: ArrayLike, **look: Any) -> None:
        """What lies between two curves."""
        x, low, high = np.broadcast_arrays(_array(x), _array(low), _array(high))
        self.marks.append(Area(x=x, low=low, high=high, **_looks(Area, look)))

    def polygons(self, corners: ArrayLike, *, outline: float = 0.0, **look: Any) -> None:
        """Filled polygons (n, corners, 2), or a single one (corners, 2)."""
        own = np.asarray(corners, float)
        shapes = own if own.ndim == 3 else own[None]
        self.marks.append(Polygons(corners=shapes, outline=outline, **_looks(Polygons, look)))

    def bar(
        self,
        x: ArrayLike,
        height: ArrayLike,
        width: float = 0.8,
        yerr: ArrayLike | None = None,
        *,
        color: str | Sequence[str],
        **look: Any,
    ) -> None:
        """Upright bars from zero; ``yerr`` puts an interval on each."""
        self._bars(x, 0.0, height, width, color, look, sideways=False)
        if yerr is not None:
            self.errorbar(x, height, yerr, ls="", color=INK, elinewidth=0.9, capsize=2)

    def barh(
        self,
        y: ArrayLike,
        width: ArrayLike,
        left: ArrayLike = 0.0,
        height: float = 0.8,
        *,
        color: str | Sequence[str],
        **look: Any,
    ) -> None:
        """Level bars from ``left`` on."""
        self._bars(y, left, width, height, color, look, sideways=True)

    def hist(self, values: ArrayLike, bins: Any = "auto", *, color: str, **look: Any) -> None:
        """How many values lie in each of some classes."""
        counts, edges = np.histogram(_array(values), bins)
        middle, thick = (edges[:-1] + edges[1:]) / 2, float(edges[1] - edges[0])
        self._bars(middle, 0.0, counts, thick, color, look, sideways=False)

    def stairs(
        self, values: ArrayLike, edges: ArrayLike, *, fill: bool = False, **look: Any
    ) -> None:
        """A step for each of some classes."""
        x = np.repeat(_array(edges), 2)
        y = np.concatenate([[0.0], np.repeat(_array(values), 2), [0.0]])
        if fill:
            self.fill_between(x, np.zeros(len(x)), y, **look)
        else:
            self.plot(x, y, **look)

    def mosaic(
        self, values: ArrayLike, shades: Shades, *, x: float = 0.0, y: float = 0.0, gap: float = 0.0
    ) -> Mosaic:
        """Coloured cells of a matrix, the first at (x, y)."""
        cells = Mosaic(values=np.asarray(values, float), shades=shades, x=x, y=y, gap=gap)
        self.marks.append(cells)
        return cells

    def text(
        self,
        x: float,
        y: float,
        text: str,
        *,
        xytext: tuple[float, float] = (0.0, 0.0),
        ha: Across = "left",
        va: Upright = "baseline",
        fontsize: float | str = 10.0,
        color: str = INK,
        rotation: float = 0.0,
        box: float = 0.0,
        fraction: bool = False,
        zorder: float = 3.0,
    ) -> Words:
        """Words at a place, shifted by `xytext` [pt]; ``fraction``: a share of the axes."""
        words = Words(
            x=float(x), y=float(y), text=str(text), colour=color, dx=xytext[0], dy=xytext[1],
            across=ha, upright=va, size=_size(fontsize), turned=bool(rotation), box=box,
            fraction=fraction, order=zorder,
        )  # fmt: skip
        self.marks.append(words)
        return words

    def arrow(
        self,
        start: tuple[float, float],
        end: tuple[float, float],
        *,
        color: str,
        both: bool = False,
        lw: float = 1.0,
        fraction: bool = False,
    ) -> None:
        """An arrow; ``both``: with two heads."""
        self.marks.append(
            Arrow(start=start, end=end, colour=color, both=both, width=lw, fraction=fraction)
        )

    # What stands about it.

    def set_title(
        self, text: str, *, loc: Literal["left", "right"] = "left", fontsize: float | str = 10.0
    ) -> None:
        """The title, at the left or the right end."""
        own = Title(text=str(text), size=_size(fontsize))
        if loc == "left":
            self.title = own
        else:
            self.title_right = own

    def set_xlabel(self, text: str) -> None:
        """The name of the abscissa, with its unit."""
        self.xlabel = Title(text=str(text))

    def set_ylabel(
        self, text: str, *, level: bool = False, fontsize: float | str = 10.0, bold: bool = False
    ) -> None:
        """The name of the ordinate; ``level`` where it is not to be turned."""
        self.ylabel = Title(text=str(text), size=_size(fontsize), level=level, bold=bold)

    def set_xticks(
        self,
        at: ArrayLike,
        labels: Sequence[str] | None = None,
        *,
        rotation: float = 0.0,
        fontsize: float | str = 9.0,
    ) -> None:
        """Where ticks stand below, and what is written there, on all axes of one abscissa."""
        for own in (self, *self.xshared):
            own.xticks = _stated(own.xticks, at, labels, rotation, fontsize)

    def set_yticks(
        self, at: ArrayLike, labels: Sequence[str] | None = None, *, fontsize: float | str = 9.0
    ) -> None:
        """Where ticks stand at the left, and what is written there, on all axes of one ordinate."""
        for own in (self, *self.yshared):
            own.yticks = _stated(own.yticks, at, labels, 0.0, fontsize)

    def set_xlim(
        self, left: float | tuple[float, float] | None = None, right: float | None = None
    ) -> None:
        """Ends of the abscissa, one of them or both."""
        self._limited("x", left, right)

    def set_ylim(
        self, bottom: float | tuple[float, float] | None = None, top: float | None = None
    ) -> None:
        """Ends of the ordinate, one of them or both; the first is that below."""
        self._limited("y", bottom, top)

    def set_xscale(self, scale: Scale, *, linthresh: float = 1.0) -> None:
        """Equal ratios for equal lengths; ``symlog``: beyond ± `linthresh`."""
        self.xscale, self.linear_to = scale, linthresh

    def set_aspect_equal(self, adjustable: Literal["datalim", "box"] = "datalim") -> None:
        """One scale for both sides: what is shown is widened, or the axes are made smaller."""
        self.equal = adjustable

    def invert_yaxis(self) -> None:
        """Let the ordinate grow downwards."""
        low, high = self.limits("y")
        self.set_ylim(max(low, high), min(low, high))

    def margins(self, x: float | None = None, y: float | None = None) -> None:
        """Room about the marks, as a share of what they fill."""
        self.room |= {side: own for side, own in (("x", x), ("y", y)) if own is not None}

    def ticks_at_most(self, count: int = 0, *, side: Side, whole: bool = False) -> None:
        """At most so many intervals on a side; ``whole``: at whole numbers alone."""
        own = self.xticks if side == "x" else self.yticks
        own.most, own.whole = count, whole

    def without_grid(self, side: Side | None = None) -> None:
        """No lines at the ticks of a side, or of both."""
        self.lines |= dict.fromkeys((side,) if side else ("x", "y"), False)

    def without_frame(self) -> None:
        """Neither frame nor ticks: words alone stand beside the marks."""
        self.framed = self.xticks.marked = self.yticks.marked = False
        self.without_grid()

    def label_below(self, text: str) -> None:
        """Numbers and a name below, though other axes of the same abscissa stand further down."""
        self.xticks.shown = True
        self.set_xlabel(text)

    def remove(self) -> None:
        """Leave its place in the grid empty."""
        self.removed = True

    def has_data(self) -> bool:
        """Whether anything was drawn."""
        return bool(self.marks)

    # What is known of it.

    @property
    def points(self) -> list[Line]:
        """Lines and points, in their order."""
        return [mark for mark in self.marks if isinstance(mark, Line)]

    @property
    def words(self) -> list[Words]:
        """Words among the marks."""
        return [mark for mark in self.marks if isinstance(mark, Words)]

    def limits(self, side: Side) -> tuple[float, float]:
        """Ends of a side: those that were stated, else what holds the marks of all axes that share
        it, with some room."""
        own = [self, *(self.xshared if side == "x" else self.yshared)]
        first, last = self.stated.get(f"{side}0"), self.stated.get(f"{side}1")
        if first is not None and last is not None:
            return first, last
        scale = self.xscale if side == "x" else self.yscale
        room = max((axes.room.get(side, MARGIN) for axes in own), default=MARGIN)
        marks = [mark for axes in own if not axes.removed for mark in axes.marks]
        low, high = extent(marks, side, scale, room, self.linear_to)
        return low if first is None else first, high if last is None else last

    def _limited(
        self, side: Side, first: float | tuple[float, float] | None, last: float | None
    ) -> None:
        if isinstance(first, tuple):
            first, last = first
        ends = {f"{side}0": first, f"{side}1": last}
        for own in (self, *(self.xshared if side == "x" else self.yshared)):
            own.stated |= {key: float(value) for key, value in ends.items() if value is not None}

    def _segments(
        self, x0: ArrayLike, y0: ArrayLike, x1: ArrayLike, y1: ArrayLike, look: Mapping[str, Any]
    ) -> None:
        begin_x, begin_y, end_x, end_y = np.broadcast_arrays(*map(_array, (x0, y0, x1, y1)))
        self.marks.append(
            Segments(x0=begin_x, y0=begin_y, x1=end_x, y1=end_y, **_looks(Segments, look))
        )

    def _bars(
        self,
        place: ArrayLike,
        base: ArrayLike,
        length: ArrayLike,
        thickness: float,
        color: str | Sequence[str],
        look: Mapping[str, Any],
        *,
        sideways: bool,
    ) -> None:
        place, base, length = np.broadcast_arrays(_array(place), _array(base), _array(length))
        self.marks.append(
            BarSeries(
                place=place,
                base=base,
                length=length,
                thickness=float(thickness),
                sideways=sideways,
                colours=[color] * len(place) if isinstance(color, str) else list(color),
                **_looks(BarSeries, look),
            )
        )


@dataclass(kw_only=True, eq=False)
class AxesGrid:
    """Axes in a grid, and what stands about them: what `Figure` has, described there."""

    width: float = WIDTH
    height: float = 3.0
    axes: list[Axes] = field(default_factory=list)
    widths: tuple[float, ...] = (1.0,)
    heights: tuple[float, ...] = (1.0,)
    title: Title = field(default_factory=Title)
    xlabel: Title = field(default_factory=Title)
    ylabel: Title = field(default_factory=Title)
    key: Key | None = None
    legend: tuple[Axes, ...] = ()
    legend_columns: int = 4

    @property
    def shown(self) -> list[Axes]:
        """Axes that were not removed."""
        return [own for own in self.axes if not own.removed]


def _array(values: ArrayLike) -> Array:
    return np.atleast_1d(np.asarray(values, float))


def _size(size: float | str) -> float:
    return SIZES[size] if isinstance(size, str) else float(size)


def _stated(
    ticks: Ticks, at: ArrayLike, labels: Sequence[str] | None, rotation: float, size: float | str
) -> Ticks:
    return Ticks(
        at=tuple(_array(at).tolist()),
        labels=None if labels is None else tuple(map(str, labels)),
        turned=bool(rotation),
        size=_size(size),
        marked=ticks.marked,
        shown=ticks.shown,
    )


_LOOKS: Final = {
    "color": "colour",
    "lw": "width",
    "ls": "dash",
    "marker": "marker",
    "ms": "size",
    "markerfacecolor": "face",
    "markeredgecolor": "edge",
    "markeredgewidth": "edge_width",
    "markevery": "every",
    "hatch": "hatch",
    "alpha": "alpha",
    "label": "label",
    "zorder": "order",
    "clip_on": "clipped",
}


def _line(x: ArrayLike, y: ArrayLike, look: Mapping[str, Any]) -> Line:
    x, y = np.broadcast_arrays(_array(x), _array(y))
    return Line(x=x, y=y, **_looks(Line, look))


def _looks(kind: type[Mark], look: Mapping[str, Any]) -> dict[str, Any]:
    """How a mark of a kind looks, by its fields; words that say nothing of it are refused."""
    known = {field.name for field in fields(kind)}
    if unknown := [word for word in look if _LOOKS.get(word) not in known]:
        raise TypeError(f"{kind.__name__} has no {', '.join(unknown)}.")
    return {_LOOKS[word]: value for word, value in look.items() if value is not None}
