"""Start values of the states of windows, from what is measured there and no model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns.over_ground import in_ship_axes
from pmmkit.identification.record import FreeRecord
from pmmkit.numerics import Array


def first_states(
    record: FreeRecord,
    begins: NDArray[np.int64],
    states: Sequence[str],
    default: Array,
    length: float,
) -> Array:
    """States (w, s) at the first instants of windows: straight lines through what is measured.

    Parameters
    ----------
    record : FreeRecord
        Measurements.
    begins : array (w + 1,) of int
        First instants of the windows, and the number of instants.
    states : sequence of str
        Names of the states.
    default : array (s,)
        For what no measurement tells.
    length : float
        Of the lines [s]; three instants at least.
    """
    found = np.zeros((len(begins) - 1, len(states)))
    for w, at in enumerate(begins[:-1].tolist()):
        stop = int(np.searchsorted(record.t, record.t[at] + length))
        rows = slice(at, max(stop, min(at + 3, len(record))))
        lines = {
            name: line
            for name, x in record.measured.items()
            if (line := _line(record.t[rows] - record.t[at], x[rows])) is not None
        }
        found[w] = _start(lines, states, default, record.current)
    return found


def _line(t: Array, values: Array) -> Array | None:
    """Slope and start of a straight line; None where nothing is measured."""
    there = np.isfinite(values)
    if there.sum() >= 2:
        return np.polyfit(t[there], values[there], 1)
    return np.array([0.0, values[there][0]]) if there.any() else None


def _start(
    lines: Mapping[str, Array], states: Sequence[str], default: Array, current: tuple[float, float]
) -> Array:
    """States from slopes and starts of the channels; velocities are through the water."""
    found = default.copy()
    place = {name: i for i, name in enumerate(states)}
    for name, i in place.items():
        if name in lines:
            found[i] = lines[name][1]
    if "psi" in lines and "r" not in lines:
        found[place["r"]] = lines["psi"][0]
    if {"x", "y", "psi"} <= set(lines) and "u" not in lines:
        north, east = lines["x"][0] - current[0], lines["y"][0] - current[1]
        found[place["u"]], found[place["v"]] = in_ship_axes(north, east, lines["psi"][1])
    return found
