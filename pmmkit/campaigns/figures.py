"""Captive and free-running tests: the record of one, the programme of many, what a fit leaves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import REFERENCE, canvas, colour, marker, styled, widened

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


def left_by_the_fit(
    channels: Mapping[str, Mapping[str, tuple[Array, Array]]], units: Mapping[str, str]
) -> Figure:
    """What a fit leaves of the measured forces, over what was fitted.

    Parameters
    ----------
    channels : mapping of str to mapping of str to (array (n,), array (n,))
        By channel and title of the kind of test: measured and fitted values.
    units : mapping of str to str
        Of the channels.

    Returns
    -------
    Figure
        A column a channel, a row a kind of test, all of a column to one scale; at zero the fit is
        what was measured. In each panel stands its root mean square.
    """
    kinds = list(dict.fromkeys(kind for groups in channels.values() for kind in groups))
    with styled():
        figure = canvas(1.15 * len(kinds) + 0.7)
        axes = figure.subplots(len(kinds), len(channels), squeeze=False, sharex="col", sharey="col")
        for column, (channel, groups) in zip(axes.T, channels.items(), strict=True):
            unit = units[channel]
            for number, (axis, kind) in enumerate(zip(column, kinds, strict=True)):
                axis.axhline(0.0, color=REFERENCE, lw=0.8)
                if kind not in groups:
                    continue
                measured, fitted = groups[kind]
                left = measured - fitted
                axis.plot(
                    fitted,
                    left,
                    ls="",
                    ms=3.5,
                    alpha=0.7,
                    lw=0,
                    markeredgewidth=0.0,
                    marker=marker(number),
                    color=colour(number),
                    label=kind,
                )
                axis.set_title(
                    f"rms {np.sqrt(np.nanmean(left**2)):.2g} {unit}", loc="right", fontsize=8.5
                )
            column[0].set_title(f"{channel} [{unit}]")
            column[-1].set_xlabel(f"{channel} fitted [{unit}]")
        for axis, kind in zip(axes[:, 0], kinds, strict=True):
            axis.set_ylabel(kind.replace(" ", "\n", 1), rotation=0, ha="right", va="center")
        figure.supylabel("measured less fitted", fontsize=10)
    return figure
