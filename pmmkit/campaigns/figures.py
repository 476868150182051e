"""Captive and free-running tests: the record of one, the programme of many."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

from pmmkit.numerics import Array
from pmmkit.plotting import canvas, colour, styled, widened

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_POINTS: Final = 4000
"""Samples that are drawn of one channel; more would only make the file large."""
_ALONE: Final = 4
"""Channels up to which one column does."""
_DEGREES: Final = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s²"}


def record(title: str, t: Array, channels: Mapping[str, Array], units: Mapping[str, str]) -> Figure:
    """The channels of a record over time, a panel each; angles in degrees.

    t [s].
    """
    columns = 1 if len(channels) <= _ALONE else 2
    rows = math.ceil(len(channels) / columns)
    some = slice(None, None, max(1, len(t) // _POINTS))
    with styled():
        figure = canvas(1.35 * rows + 0.8)
        axes = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
        for axis, (name, values) in zip(axes, channels.items(), strict=False):
            unit = units[name]
            factor = 180.0 / math.pi if unit in _DEGREES else 1.0
            axis.plot(t[some], factor * values[some], color=colour(0), lw=1.1)
            widened(axis)
            axis.set_title(f"{name} [{_DEGREES.get(unit, unit) or '-'}]")
        for axis in axes[len(channels) :]:
            axis.set_visible(False)
        for axis in axes[max(len(channels) - columns, 0) : len(channels)]:
            axis.set_xlabel("time t [s]")
            axis.tick_params(labelbottom=True)
        figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    return figure


def programme(tests: Sequence[str], froude: Sequence[float]) -> Figure:
    """Which tests were made at which Froude numbers, with how many runs."""
    kinds = list(dict.fromkeys(tests))
    counts: dict[tuple[str, float], int] = {}
    for test, number in zip(tests, froude, strict=True):
        place = test, round(number, 3)
        counts[place] = counts.get(place, 0) + 1
    with styled():
        figure = canvas(0.5 * len(kinds) + 1.2)
        axis = figure.subplots()
        for (test, number), count in counts.items():
            level = kinds.index(test)
            axis.scatter(number, level, s=40 + 25 * count, color=colour(0), alpha=0.25, lw=0)
            axis.annotate(str(count), (number, level), ha="center", va="center", fontsize=9)
        axis.set_yticks(range(len(kinds)), kinds)
        axis.set_ylim(len(kinds) - 0.4, -0.6)
        axis.margins(x=0.12)
        axis.set_xlabel("Froude number [-]; in the marks the number of runs")
    return figure
