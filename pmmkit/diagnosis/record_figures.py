"""Free-running records left out, as they were measured and as they were sailed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.plotting import INK, REFERENCE, Axes, Figure, colour, dash
from pmmkit.presentation import WIDE, figure_text

Array = NDArray[np.float64]
DEGREES: Final = 180.0 / math.pi


@dataclass(frozen=True, kw_only=True, eq=False)
class Sailed:
    """A record that was left out, as it was measured and as it was sailed.

    `begins (w,)`: first instants of the windows. `measured`: measured channels [m, rad, m/s,
    rad/s]. `simulated`: what a model shows of them through the windows, by its name in words.
    `std`: how far that may be off, as standard deviations.
    """

    name: str
    t: Array
    begins: NDArray[np.int64]
    measured: Mapping[str, Array]
    simulated: Mapping[str, Mapping[str, Array]]
    std: Mapping[str, Mapping[str, Array]]


def before_and_after(records: Sequence[Sailed]) -> Figure:
    """Tracks, headings and yaw rates of records, measured and as models sail them, and how far the
    headings are off.
    """
    if not records:
        raise DataError("There is no record to draw.")
    track = all("x" in item.measured and "y" in item.measured for item in records)
    turning = all("r" in item.measured for item in records)
    figure = Figure(height=2.6 * (2 + track + turning))
    axes = figure.subplots(2 + track + turning, len(records), squeeze=False)
    for column, item in enumerate(records):
        own = list(axes[:, column])
        own[0].set_title(figure_text(item.name))
        if track:
            _track(own.pop(0), item)
        _over_time(own[0], item, "psi")
        _off(own[1], item)
        if turning:
            _over_time(own[2], item, "r")
        axes[-1, column].set_xlabel("time [s]")
        if column == 0:
            words = ["heading [deg]", "heading, simulated\nless measured [deg]"]
            words += ["yaw rate [deg/s]"] if turning else []
            for axis, word in zip(own, words, strict=True):
                axis.set_ylabel(word)
    figure.legend_below([axes[0, 0]])
    return figure


def _track(axis: Axes, item: Sailed) -> None:
    """Seen from above, ahead to the right, so that starboard is below."""
    x, y = item.measured["x"], item.measured["y"]
    axis.plot(x, y, label="measured", **_MEASURED)
    at = _whole(item)
    for number, (label, shown) in enumerate(item.simulated.items()):
        axis.plot(_cut(shown["x"], at), _cut(shown["y"], at), label=label, **_look(number))
    axis.plot(x[item.begins], y[item.begins], ls="", marker="|", color=INK, label="a window begins")
    axis.set_aspect_equal()
    axis.invert_yaxis()
    axis.set_xlabel("x, ahead [m]")
    axis.set_ylabel("y, to starboard [m]")


def _over_time(axis: Axes, item: Sailed, channel: str) -> None:
    axis.plot(item.t, DEGREES * item.measured[channel], **_MEASURED)
    at = _whole(item)
    for number, (name, shown) in enumerate(item.simulated.items()):
        values = DEGREES * shown[channel]
        axis.plot(_cut(item.t, at), _cut(values, at), **_look(number))
        _band(axis, item, number, values, item.std[name][channel])


def _off(axis: Axes, item: Sailed) -> None:
    at = _whole(item)
    axis.axhline(0.0, color=REFERENCE, lw=0.8)
    for number, (name, shown) in enumerate(item.simulated.items()):
        off = DEGREES * (shown["psi"] - item.measured["psi"])
        axis.plot(_cut(item.t, at), _cut(off, at), **_look(number))
        _band(axis, item, number, np.zeros(len(item.t)), item.std[name]["psi"])


def _band(axis: Axes, item: Sailed, number: int, middle: Array, std: Array) -> None:
    """The 95 % interval about some values in degrees."""
    at, half = _whole(item), WIDE * DEGREES * std
    axis.fill_between(
        _cut(item.t, at),
        _cut(middle - half, at),
        _cut(middle + half, at),
        color=colour(2 - number),
        alpha=0.18,
    )


_MEASURED: Final[dict[str, Any]] = {"color": REFERENCE, "lw": 2.5, "alpha": 0.6}


def _look(number: int) -> dict[str, Any]:
    return {"color": colour(2 - number), "ls": dash(number), "lw": 1.1}


def _whole(item: Sailed) -> NDArray[np.int64]:
    """Where lines break: before each window but the first."""
    return item.begins[1:]


def _cut(values: Array, at: NDArray[np.int64]) -> Array:
    return np.insert(values, at, np.nan)
