"""Marks and dimension lines that several drawings of paths share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from pmmkit.numerics import Array
from pmmkit.plotting import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Place = tuple[float, float]
_LINE: Final = {"arrowstyle": "<->", "color": style.REFERENCE, "shrinkA": 0, "shrinkB": 0}


def open_mark(axis: Axes, x: float | Array, y: float | Array, label: str, **more: Any) -> None:
    """An open mark, or several of one label.

    Parameters
    ----------
    axis : Axes
        Where.
    x, y : float or array
        The places.
    label : str
        In the legend.
    **more
        Other settings of the line, such as ``marker`` and ``zorder``.
    """
    usual: dict[str, Any] = {"marker": "o", "color": style.colour(0), "zorder": 4}
    axis.plot(x, y, ls="", ms=5, markerfacecolor="white", label=label, **(usual | more))


def dimension(axis: Axes, start: Place, end: Place, text: str, *, upright: bool) -> None:
    """A dimension line with its text beside it.

    Parameters
    ----------
    axis : Axes
        Where.
    start, end : (float, float)
        Its ends.
    text : str
        What it measures.
    upright : bool
        Whether it goes up, and the text with it.
    """
    axis.annotate("", end, start, arrowprops=_LINE)
    axis.annotate(
        text,
        ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2),
        xytext=(-5, 0) if upright else (0, 3),
        textcoords="offset points",
        rotation=90 if upright else 0,
        ha="right" if upright else "center",
        va="center" if upright else "bottom",
        fontsize=9,
        color=style.REFERENCE,
    )


def guide(axis: Axes, start: Place, end: Place) -> None:
    """A thin dotted line from what is measured to its dimension line."""
    axis.plot([start[0], end[0]], [start[1], end[1]], color="#bbbbbb", lw=0.8, ls=":")
