"""Captive and free-running tests: the record of one, the programme of many."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import Figure, colour, widened

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
    figure = Figure(height=1.35 * rows + 0.8)
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
    for axis, (name, values) in zip(axes, channels.items(), strict=False):
        unit = units[name]
        factor = 180.0 / math.pi if unit in _DEGREES else 1.0
        axis.plot(t[some], factor * values[some], color=colour(0), lw=1.1)
        widened(axis)
        axis.set_title(f"{name} [{_DEGREES.get(unit, unit) or '-'}]")
    for axis in axes[len(channels) :]:
        axis.remove()
    for axis in axes[max(len(channels) - columns, 0) : len(channels)]:
        axis.label_below("time t [s]")
    figure.suptitle(title)
    return figure


def programme(tests: Sequence[str], froude: Sequence[float]) -> Figure:
    """Which tests were made at which Froude numbers, with how many runs."""
    kinds = list(dict.fromkeys(tests))
    counts: dict[tuple[str, float], int] = {}
    for test, number in zip(tests, froude, strict=True):
        place = test, round(number, 3)
        counts[place] = counts.get(place, 0) + 1
    figure = Figure(height=0.5 * len(kinds) + 1.2)
    axis = figure.subplots()
    for (test, number), count in counts.items():
        level = kinds.index(test)
        axis.plot(
            number,
            level,
            ls="",
            marker="o",
            ms=np.sqrt(40 + 25 * count),
            markeredgewidth=0.0,
            color=colour(0),
            alpha=0.25,
        )
        axis.text(number, level, str(count), ha="center", va="center", fontsize=9)
    axis.set_yticks(range(len(kinds)), kinds)
    axis.set_ylim(len(kinds) - 0.4, -0.6)
    axis.margins(x=0.12)
    axis.set_xlabel("Froude number [-]; in the marks the number of runs")
    return figure
