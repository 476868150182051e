"""A first look at the columns of a file, and at the zeros of the gauges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.intake import ColumnLook, FileGroup, FileLook, Look, seen_values
from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, Figure, colour, marker, widened
from pmmkit.presentation import WIDE, figure_text

# Zeros of the gauges over the day.


_NAMED: Final = 30
"""Runs up to which each is named below the figure."""


def zeros_over_the_day(
    names: Sequence[str],
    value: Mapping[str, Array],
    std: Mapping[str, Array],
    units: Mapping[str, str],
) -> Figure:
    """What each gauge shows at rest, run by run, a panel a gauge."""
    place = np.arange(len(names))
    figure = Figure(height=1.35 * len(value) + 1.0)
    axes = figure.subplots(len(value), 1, squeeze=False, sharex=True)[:, 0]
    for number, (axis, (channel, zeros)) in enumerate(zip(axes, value.items(), strict=True)):
        axis.axhline(float(np.nanmean(zeros)), color=REFERENCE, lw=0.9, ls="--")
        axis.errorbar(
            place,
            zeros,
            yerr=WIDE * std[channel],
            ls="-",
            lw=0.7,
            marker=marker(number),
            ms=4,
            color=colour(number),
        )
        widened(axis)
        axis.set_title(f"{channel} at rest [{units[channel]}]")
    few = len(names) <= _NAMED
    axes[-1].set_xlabel("" if few else "runs in the order of the day")
    if few:
        axes[-1].set_xticks(place, [figure_text(name) for name in names], rotation=90)
    return figure


PANELS: Final = 24
"""Most panels in one figure."""
_POINTS: Final = 1200
"""Stretches into which a long record is thinned."""


def columns_over_time(
    time: Array, columns: Mapping[str, Array], *, time_label: str, title: str
) -> Figure:
    """Small multiples: each column over time, or over the number of its row."""
    drawn = list(columns.items())[:PANELS]
    across = min(3, len(drawn))
    down = -(-len(drawn) // across)
    figure = Figure(height=0.6 + 1.75 * down, width=3.6 * across)
    axes = figure.subplots(down, across, squeeze=False, sharex=True)
    for place, (label, values) in enumerate(drawn):
        axis = axes.flat[place]
        axis.plot(*envelope(time, values), color=colour(0), lw=1.0)
        axis.set_title(figure_text(label))
        widened(axis)
    for axis in axes.flat[len(drawn) :]:
        axis.remove()
    for place in range(max(0, len(drawn) - across), len(drawn)):
        axes.flat[place].label_below(figure_text(time_label))
    title = title if len(title) <= 100 else title[:98] + " …"
    figure.suptitle(figure_text(title), fontsize=11)
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


def first_look(found: Look) -> Figure | None:
    """The columns of the first history that was seen, else of the first file with numbers.

    Parameters
    ----------
    found : Look
        As `look` gives it.
    """
    look = _drawn(found.groups)
    if look is None:
        return None
    try:
        values = seen_values(look).numbers
    except OSError as error:
        raise DataError(f"{look.shown} cannot be read: {error.strerror}.") from error
    clock = look.known.get("t") if look.kind == "history" else None
    count = max(len(numbers) for numbers in values.values())
    time = values[clock.position] if clock else np.arange(1.0, count + 1.0)
    unit = (clock.unit or (clock.suggestion and clock.suggestion.unit) or "s") if clock else ""
    columns = {
        f"{column.clipped} [{_unit(column)}]": values[column.position]
        for column in look.columns
        if column.position in values and column is not clock
    }
    return columns_over_time(
        time,
        columns,
        time_label=f"{clock.clipped} [{unit}]" if clock else "row",
        title=look.shown + (" (beginning, middle and end)" if look.sampled else ""),
    )


def _drawn(groups: Sequence[FileGroup]) -> FileLook | None:
    """The file whose columns are drawn."""
    rank = {"history": 0, "unknown": 1, "table": 2, "open water": 3}
    files = [
        group.first for group in groups if any(column.numbers for column in group.first.columns)
    ]
    return min(files, key=lambda item: rank[item.kind], default=None)


def _unit(column: ColumnLook) -> str:
    stated = column.unit or (column.suggestion.unit if column.suggestion else None)
    return stated or "no unit stated"
