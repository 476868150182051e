"""Identified parameters beside what was known before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from pmmkit.conventions import Convention
from pmmkit.errors import DataError, UnknownNameError
from pmmkit.numerics import Array
from pmmkit.plotting import style
from pmmkit.plotting.marks import beyond
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FARTHEST: Final = 6.0
"""Distance from the prior, in its standard deviations, up to which values are drawn."""


class Result(Protocol):
    """What is drawn of the parameters that a method found."""

    @property
    def method(self) -> str:
        """Its name."""

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters."""

    @property
    def unseen(self) -> tuple[str, ...]:
        """Those that the records do not determine."""

    def scaled(self) -> tuple[Array, Array]:
        """Value less prior mean and half of the 95 % interval, over the prior's deviation."""


def parameters(found: Sequence[Result], convention: Convention) -> Figure:
    """Intervals of 95 % before and after, per parameter and method.

    Parameters
    ----------
    found : sequence of Result
        Of one method or several, from the same prior.
    convention : Convention
        Of the derivatives, for their symbols.

    Returns
    -------
    Figure
        Each parameter less its prior mean, over the standard deviation of the prior; values beyond
        the axis are arrows with their number. Open markers: not determined by the records.

    Raises
    ------
    DataError
        If nothing is given.
    """
    if not found:
        raise DataError("There is no result to draw.")
    names = list(dict.fromkeys(name for item in found for name in item.names))
    ends = np.concatenate([np.abs(x) + y for item in found for x, y in (item.scaled(),)])
    limit = min(max([2.4, *ends[np.isfinite(ends)].tolist()]) * 1.05, _FARTHEST)
    with style.styled():
        figure = style.canvas(0.9 + (0.16 + 0.13 * len(found)) * len(names), 7.2)
        axis = figure.subplots()
        places = np.arange(len(names), dtype=float)
        axis.barh(
            places,
            2 * WIDE,
            left=-WIDE,
            height=0.82,
            color="#e6e6e6",
            label="prior, 95 %",
            zorder=0,
        )
        axis.axvline(0.0, color=style.REFERENCE, lw=1.0, ls="--", zorder=1)
        for number, item in enumerate(found):
            shift = 0.66 * ((number + 0.5) / len(found) - 0.5)
            at = np.array([places[names.index(name)] for name in item.names]) + shift
            _intervals(axis, item, at, number, limit)
        axis.set_yticks(places, [parameter_symbol(name, convention) for name in names])
        axis.set_ylim(len(names) - 0.4, -0.6)
        axis.set_xlim(-limit, limit)
        axis.grid(visible=False, axis="y")
        axis.set_xlabel("(value - prior mean) / standard deviation of the prior [-]")
        style.legend_below(figure, [axis], columns=3)
    return figure


def _intervals(axis: Axes, item: Result, at: np.ndarray, number: int, limit: float) -> None:
    colour = style.colour(number)
    value, half = item.scaled()
    low, high = value - half, value + half
    axis.hlines(at, low.clip(-limit, limit), high.clip(-limit, limit), color=colour, lw=1.6)
    inside = np.abs(value) <= limit
    seen = np.array([name not in item.unseen for name in item.names])
    for kept, face in ((inside & seen, colour), (inside & ~seen, "white")):
        axis.plot(
            value[kept],
            at[kept],
            ls="",
            marker=style.marker(number),
            color=colour,
            ms=4.5,
            markerfacecolor=face,
            label=f"{item.method}, 95 %" if face == colour else None,
            zorder=3,
        )
    beyond(axis, value, at, limit, colour, size=8)


def parameter_symbol(name: str, convention: Convention) -> str:
    """A derivative in mathematical text, other parameters as they are called.

    Parameters
    ----------
    name : str
        Name of the parameter.
    convention : Convention
        Of the derivatives.
    """
    try:
        return style.symbol(name, convention)
    except UnknownNameError:
        return name
