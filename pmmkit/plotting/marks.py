"""Marks and dimension lines that several drawings of paths share."""

from __future__ import annotations

from collections.abc import Sequence
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


def dimension(
    axis: Axes,
    start: Place,
    end: Place,
    text: str,
    *,
    upright: bool,
    guides: Sequence[tuple[Place, Place]] = (),
) -> None:
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
    guides : sequence of (place, place)
        Thin dotted lines from what is measured to the dimension line.
    """
    for there, here in guides:
        axis.plot([there[0], here[0]], [there[1], here[1]], color="#bbbbbb", lw=0.8, ls=":")
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
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 0.8},
        zorder=6,
    )


def path_axes(axis: Axes) -> None:
    """Axes of a path in ship lengths, ahead upwards, both to one scale."""
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("to starboard, y / L [-]")
    axis.set_ylabel("ahead, x / L [-]")


def beyond(
    axis: Axes, value: Array, places: Array, limit: float, colour: str, *, size: float = 7
) -> None:
    """Values beyond an axis of -limit to limit, as arrows at its ends with their number.

    Parameters
    ----------
    axis : Axes
        Where.
    value, places : array (n,)
        Values, and where they stand across the axis; those inside and NaN are left out.
    limit : float
        End of the axis.
    colour : str
        Of arrows and numbers.
    size : float
        Of the numbers [pt].
    """
    for x, y in zip(value, places, strict=True):
        if not abs(x) > limit:
            continue
        right = bool(x > 0)
        end = limit if right else -limit
        axis.plot(end, y, marker=">" if right else "<", ms=4, color=colour, clip_on=False, zorder=4)
        axis.annotate(
            f"{x:.3g}",
            (end, y),
            xytext=(-6 if right else 6, 0),
            textcoords="offset points",
            ha="right" if right else "left",
            va="center",
            fontsize=size,
            color=colour,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
            zorder=5,
        )
