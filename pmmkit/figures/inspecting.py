"""A first look at the columns of a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting.style import INK, canvas, colour, in_powers, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PANELS: Final = 24
"""Most panels in one figure."""
_POINTS: Final = 1200
"""Stretches into which a long record is thinned."""


def columns_over_time(
    time: Array, columns: Mapping[str, Array], *, time_label: str, title: str
) -> Figure:
    """Small multiples: each column over time, or over the number of its row.

    Parameters
    ----------
    time : array (n,)
        Abscissa.
    columns : mapping of str to array (n,)
        Columns by the label of their ordinate, unit included; the first 24 are drawn.
    time_label : str
        Label of the abscissa, unit included.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        Long records are thinned to the least and the largest value of each stretch, so that spikes
        stay.
    """
    drawn = list(columns.items())[:PANELS]
    across = min(3, len(drawn))
    down = -(-len(drawn) // across)
    with styled():
        figure = canvas(0.6 + 1.75 * down, 3.6 * across)
        axes = figure.subplots(down, across, squeeze=False, sharex=True)
        for place, (label, values) in enumerate(drawn):
            axis = axes.flat[place]
            axis.plot(*envelope(time, values), color=colour(0), linewidth=1.0)
            axis.set_title(label)
            low, high = np.nanmin(values, initial=np.inf), np.nanmax(values, initial=-np.inf)
            if low == high:
                axis.set_ylim(low - max(abs(low), 1.0) * 0.1, low + max(abs(low), 1.0) * 0.1)
        in_powers(axes.flat[: len(drawn)])
        for axis in axes.flat[len(drawn) :]:
            axis.set_visible(False)
        for place in range(max(0, len(drawn) - across), len(drawn)):
            axes.flat[place].tick_params(labelbottom=True)
            axes.flat[place].set_xlabel(time_label)
        figure.suptitle(_cut(title, 100), x=0.01, ha="left", fontsize=11, color=INK)
    return figure


def envelope(time: Sequence[float] | Array, values: Array) -> tuple[Array, Array]:
    """A record thinned to the least and the largest value of each of 1200 stretches.

    Examples
    --------
    >>> spike = np.zeros(100_000)
    >>> spike[77_777] = 5.0
    >>> t, y = envelope(np.arange(100_000.0), spike)
    >>> len(t) < 3000, float(y.max())
    (True, 5.0)
    """
    t, y = np.asarray(time, float), np.asarray(values, float)
    size = len(y) // _POINTS
    if size < 3:
        return t, y
    whole = len(y) // size * size
    starts = np.arange(0, whole, size)
    parts = y[:whole].reshape(-1, size)
    lowest = np.where(np.isnan(parts), np.inf, parts).argmin(axis=1)
    highest = np.where(np.isnan(parts), -np.inf, parts).argmax(axis=1)
    kept = np.unique(np.concatenate([starts + lowest, starts + highest, np.arange(whole, len(y))]))
    return t[kept], y[kept]


def _cut(text: str, length: int) -> str:
    return text if len(text) <= length else text[: length - 2] + " …"
