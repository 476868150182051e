"""Values of a noisy record at an instant, from a parabola through the samples about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.numerics import Array

FEWEST: Final = 6


@dataclass(frozen=True)
class Local:
    """A record at an instant.

    Parameters
    ----------
    value, slope : float
        There, and its rate of change.
    leverage : float
        Variance of `value` over that of a sample.
    gap : float
        Seconds between the samples on either side.
    """

    value: float
    slope: float
    leverage: float
    gap: float


def local(t: Array, values: Array, at: float, half: float) -> Local:
    """Fit a parabola to the samples within so many seconds of an instant.

    Parameters
    ----------
    t, values : array (n,)
        Increasing times [s] and a record.
    at : float
        The instant [s].
    half : float
        Half of the window [s]; widened until 6 samples lie in it.

    Examples
    --------
    >>> t = np.arange(20.0)
    >>> found = local(t, 0.5 * t**2, 10.5, 4.0)
    >>> round(found.value, 6), round(found.slope, 6), found.gap
    (55.125, 10.5, 1.0)
    """
    half = max(half, 1e-9)
    need = min(FEWEST, len(t))
    first, last = np.searchsorted(t, (at - half, at + half))
    while last - first < need:
        half *= 1.3
        first, last = np.searchsorted(t, (at - half, at + half))
    near = t[first:last] - at
    degree = 2 if last - first > 3 else 1
    basis = np.vander(near / half, degree + 1, increasing=True)
    inverse = np.linalg.solve(basis.T @ basis, basis.T)
    fitted = inverse @ values[first:last]
    right = int(np.clip(np.searchsorted(t, at), 1, len(t) - 1))
    return Local(
        value=float(fitted[0]),
        slope=float(fitted[1] / half),
        leverage=float(inverse[0] @ inverse[0]),
        gap=float(t[right] - t[right - 1]),
    )


def crossing(t: Array, values: Array, level: float, half: float, start: float) -> float | None:
    """First instant after a start at which a smoothed record rises through a level.

    Parameters
    ----------
    t, values, half
        As for `local`.
    level : float
        The level.
    start : float
        Where to begin [s].

    Returns
    -------
    float or None
        None if the record does not get there.

    Examples
    --------
    >>> t = np.arange(0.0, 30.0)
    >>> round(crossing(t, 2.0 * t, 21.0, 3.0, 0.0), 6)
    10.5
    """
    inside = np.flatnonzero(t >= start)
    if not len(inside):
        return None
    above = inside[values[inside] >= level]
    if not len(above):
        return None
    low, high = max(start, float(t[above[0]]) - 3 * half), float(t[above[0]]) + 3 * half
    at = np.linspace(low, min(high, float(t[-1])), 61)
    smooth = np.array([local(t, values, float(one), half).value for one in at])
    over = np.flatnonzero(smooth >= level)
    if not len(over):
        return None
    place = int(over[0])
    if place == 0:
        return float(at[0])
    share = (level - smooth[place - 1]) / (smooth[place] - smooth[place - 1])
    return float(at[place - 1] + share * (at[place] - at[place - 1]))


def way_along(
    t: Array, x: Array, y: Array, start: float, end: float, every: float, shortest: float = 0.0
) -> float:
    """Length of the path between two instants, by places so far apart that noise adds nothing.

    Parameters
    ----------
    t, x, y : array (n,)
        Increasing times [s] and positions [m].
    start, end : float
        The instants [s].
    every : float
        Seconds between the places; each is smoothed over half of that.
    shortest : float
        Least way between two places [m]; of a ship that hardly moves any more, noise would else
        make the way longer.
    """
    count = max(round((end - start) / every), 2)
    at = np.linspace(start, end, count + 1)
    path = np.array(
        [[local(t, part, float(one), 0.5 * every).value for one in at] for part in (x, y)]
    )
    kept = [0]
    for place in range(1, count):
        if float(np.hypot(*(path[:, place] - path[:, kept[-1]]))) >= shortest:
            kept.append(place)
    if len(kept) > 1 and float(np.hypot(*(path[:, count] - path[:, kept[-1]]))) < 0.5 * shortest:
        kept.pop()
    steps = np.diff(path[:, [*kept, count]], axis=1)
    chord = np.hypot(*steps)
    heading = np.unwrap(np.arctan2(steps[1], steps[0]))
    bend = np.gradient(heading) if len(heading) > 1 else np.zeros(1)
    return float(np.sum(chord * (1.0 + bend**2 / 24.0)))
