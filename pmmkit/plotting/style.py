"""How figures look: one palette, one grid, units on every axis, nothing global."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.files import atomic_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WIDTH: Final = 9.0
"""Width of a figure [inch]: a report column at 100 dots per inch."""

ORDERED: Final = ("#0b2a6b", "#00a78d", "#f8a439", "#902f58", "#966852")
"""Colours for ordered sets (Froude numbers): told apart by hue and by lightness, whatever the
reader's colour vision, and on paper without colour."""
MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
DASHES: Final = ("-", "--", "-.", ":")
HATCHES: Final = ("", "///", "...", "\\\\\\")
FEW: Final = 12
"""Orders of a manoeuvre up to which a line is drawn at each."""
INK: Final = "#222222"
REFERENCE: Final = "#777777"
LIMIT: Final = "#b3261e"

_STYLE: Final[Any] = {
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.titleweight": "normal",
    "axes.titlelocation": "left",
    "axes.labelsize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#888888",
    "axes.labelcolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": False,
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.useoffset": False,
    "text.color": INK,
    "xtick.color": "#444444",
    "ytick.color": "#444444",
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.8,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "lines.linewidth": 1.6,
    "lines.markersize": 5,
    "figure.facecolor": "white",
    "savefig.dpi": 150,
    "svg.fonttype": "path",
    "svg.hashsalt": "pmmkit",
}


_LATIN: Final = "DejaVu Sans"
_EASTERN: Final = (
    "Noto Sans CJK JP",
    "Noto Sans CJK SC",
    "Yu Gothic",
    "MS Gothic",
    "Microsoft YaHei",
    "SimHei",
    "Malgun Gothic",
    "Hiragino Sans",
    "Apple SD Gothic Neo",
    "PingFang SC",
    "WenQuanYi Zen Hei",
)
"""Families that hold Japanese, Chinese or Korean names of runs, where one is installed."""
_OF_THE_SESSION: Final = frozenset(
    {
        "animation.ffmpeg_path",
        "backend",
        "backend_fallback",
        "date.epoch",
        "interactive",
        "timezone",
        "toolbar",
    }
)
"""Settings of matplotlib that say where figures are shown and programs lie, not how they look."""


@contextmanager
def styled() -> Iterator[None]:
    """The style while a figure is drawn, whatever the user's matplotlibrc says; nothing stays."""
    import matplotlib as mpl

    here, plain = mpl.rcParams, mpl.rcParamsDefault
    own = {name: plain[name] for name in plain if name not in _OF_THE_SESSION}
    changed = {name: x for name, x in own.items() if here[name] != x}
    with mpl.rc_context(changed | _STYLE | {"font.family": _families()}), warnings.catch_warnings():
        # a name in a script without a font is drawn as boxes; tables have it in letters
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


@cache
def _families() -> list[str]:
    """The family of all figures, and those that have the letters which it lacks."""
    from matplotlib.font_manager import fontManager

    there = {font.name for font in fontManager.ttflist}
    return [_LATIN, *(name for name in _EASTERN if name in there)]


def canvas(height: float, width: float = WIDTH) -> Figure:
    """An empty figure of a `height` and `width` [inch] that lays itself out, without pyplot."""
    from pmmkit.plotting.shown import Shown

    return Shown(figsize=(width, height), layout="constrained")


def in_powers(axes: Iterable[Axes]) -> None:
    """Write the common power of ten of the ordinates of `axes` as a power."""
    from pmmkit.plotting.shown import Powers

    for axis in axes:
        axis.yaxis.set_major_formatter(Powers())


def colour(number: int) -> str:
    """Colour of a set by its `number`."""
    return ORDERED[number % len(ORDERED)]


def marker(number: int) -> str:
    """Marker of a set by its `number`, so that colour is never the only difference."""
    return MARKERS[number % len(MARKERS)]


def dash(number: int, *, rounds: bool = False) -> str:
    """Dash of a line by its `number`; with `rounds` another one for each round of the colours."""
    return DASHES[(number // len(ORDERED) if rounds else number) % len(DASHES)]


def hatch(number: int, *, rounds: bool = False) -> str:
    """Hatch of bars by their `number`; with `rounds` another one for each round of the colours."""
    return HATCHES[(number // len(ORDERED) if rounds else number) % len(HATCHES)]


ROUNDING: Final = 1e-12
"""Height of an axis, in whatever unit, below which it shows what arithmetic leaves of zero: a ship
that stops on a straight course turns by 1e-19 degrees."""
FLAT: Final = 0.055
"""What such an axis shows to either side: as matplotlib does of a line that is zero."""


def widened(axis: Axes, share: float = 1e-4) -> None:
    """Widen ordinates that hold next to nothing but one value, so that ticks stay short, and that
    hold the rounding of zero alone.

    Parameters
    ----------
    axis : Axes
        After everything was drawn.
    share : float
        Least height of the axis over the value in its middle.
    """
    low, high = axis.get_ylim()
    middle = (low + high) / 2
    if abs(high - low) < share * abs(middle):
        axis.set_ylim(middle - 0.1 * abs(middle), middle + 0.1 * abs(middle))
    elif abs(high - low) < ROUNDING:
        axis.set_ylim(-FLAT, FLAT)


def legend_below(figure: Figure, axes: Sequence[Axes], columns: int = 4) -> None:
    """One legend for several axes under the figure, where it covers nothing.

    Parameters
    ----------
    figure : Figure
        The figure.
    axes : sequence of Axes
        Whose entries it takes; each label once.
    columns : int
        Entries side by side, fewer where they are too long for the width.
    """
    entries: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if entries:
        figure.legend(
            list(entries.values()),
            list(entries),
            loc="outside lower center",
            ncols=_fitting(figure, list(entries), columns),
        )


def _fitting(figure: Figure, labels: Sequence[str], columns: int) -> int:
    """How many columns of a legend the width of a figure holds."""
    from matplotlib import rcParams
    from matplotlib.cbook import is_math_text
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(size=rcParams["legend.fontsize"])
    size = font.get_size_in_points()
    beside = size * (
        rcParams["legend.handlelength"]
        + rcParams["legend.handletextpad"]
        + rcParams["legend.columnspacing"]
    )
    measure = text_to_path.get_text_width_height_descent
    widths = [measure(x, font, is_math_text(x))[0] for x in labels]
    for count in range(min(columns, len(labels)), 1, -1):
        own = sum(max(column) for column in np.array_split(widths, count))
        if own + count * beside < 72.0 * figure.get_figwidth():
            return count
    return 1


def save(figure: Figure, path: str | Path, *, final: bool = False) -> Path:
    """Write a figure, all or nothing; the ending of the name says how (png, svg, pdf).

    Parameters
    ----------
    figure : Figure
        What to write.
    path : path
        Where.
    final : bool
        As for `svg`.
    """
    target = Path(path)
    if final:
        _settle(figure)
    with atomic_path(target) as part:
        if target.suffix == ".svg":
            from matplotlib.backends.backend_svg import svgProlog

            part.write_text(svgProlog + svg(figure), encoding="utf-8", newline="\n")
        else:
            with styled():
                undated = {"CreationDate": None} if target.suffix == ".pdf" else {}
                figure.savefig(part, metadata=undated)
    return target


def svg(figure: Figure, *, final: bool = False) -> str:
    """A figure as an ``<svg>`` element to stand inside a page.

    Parameters
    ----------
    figure : Figure
        What to draw.
    final : bool
        Whether no axis is given a label afterwards, which takes less time.
    """
    if final:
        _settle(figure)
    buffer = io.StringIO()
    with styled(), _laid_out(figure, buffer) as renderer:
        figure.draw(renderer)
        renderer.finalize()
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def _settle(figure: Figure) -> None:
    """Give labels without words a place: each else measures the ticks of its axis to find one."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if not axis.get_label_text():
                axis.set_label_coords(0.0, 0.0)


@contextmanager
def _laid_out(figure: Figure, file: io.StringIO) -> Iterator[Any]:
    """A renderer of SVG into `file`, the axes of the figure in their places: `savefig` would find
    them by drawing everything, and then draw everything again."""
    from pmmkit.plotting.shown import Measured

    dots, engine, shown_on = figure.dpi, figure.get_layout_engine(), figure.canvas
    try:
        figure.dpi = Measured.fixed_dpi
        renderer = Measured(figure, file, dots=_STYLE["savefig.dpi"]).get_renderer()
        if engine is not None:
            engine.execute(figure)
            figure.set_layout_engine("none")
        yield renderer
    finally:
        figure.dpi = dots
        figure.set_canvas(shown_on)
        figure.set_layout_engine(engine)
