"""Values of a noisy record at instants by local parabolas; by them velocities and the true wind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmmkit.numerics import Array, unwrapped

FEWEST: Final = 6
WIDER: Final = 1.3
"""By which a window grows until so many samples lie in it."""
ROOM: Final = 1_000_000
"""Samples of windows that are held in memory at a time."""


@dataclass(frozen=True)
class Local:
    """A record at an instant, or at several.

    `value, slope (m,)`: there, and its rate of change. `leverage (m,)`: variance of `value`
    over that of a sample. `gap (m,)`: seconds between the samples on either side.
    """

    value: Any
    slope: Any
    leverage: Any
    gap: Any


def local(t: Array, values: Array, at: ArrayLike, half: float) -> Local:
    """Fit a parabola to the samples within so many seconds of each instant.

    t, values [s]; at (m,); at [s]; half [s].

    Examples
    --------
    >>> t = np.arange(20.0)
    >>> found = local(t, 0.5 * t**2, 10.5, 4.0)
    >>> round(found.value, 6), round(found.slope, 6), found.gap
    (55.125, 10.5, 1.0)
    >>> local(t, 0.5 * t**2, [3.0, 10.5], 4.0).slope.round(6)
    array([ 3. , 10.5])
    """
    instants = np.atleast_1d(np.asarray(at, float))
    first, last, halves = _windows(t, instants, max(half, 1e-9))
    most = max(ROOM // int(np.max(last - first, initial=1)), 1)
    pieces = [
        _parabolas(t, values, instants[own], first[own], last[own], halves[own])
        for own in (slice(i, i + most) for i in range(0, len(instants), most))
    ]
    value, slope, leverage = np.concatenate(pieces, axis=1) if pieces else np.empty((3, 0))
    right = np.clip(np.searchsorted(t, instants), 1, len(t) - 1)
    found = Local(value=value, slope=slope, leverage=leverage, gap=t[right] - t[right - 1])
    if np.ndim(at):
        return found
    return Local(*(float(part[0]) for part in (value, slope, leverage, found.gap)))


def _windows(t: Array, at: Array, half: float) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """First sample of each window, the one after its last, and half of its width [s]."""
    need = min(FEWEST, len(t))
    halves = np.full(len(at), half)
    first, last = np.searchsorted(t, at - halves), np.searchsorted(t, at + halves)
    while len(few := np.flatnonzero(last - first < need)):
        halves[few] *= WIDER
        first[few] = np.searchsorted(t, at[few] - halves[few])
        last[few] = np.searchsorted(t, at[few] + halves[few])
    return first, last, halves


def _parabolas(
    t: Array, values: Array, at: Array, first: NDArray[np.intp], last: NDArray[np.intp], half: Array
) -> Array:
    """Value, slope and leverage (3, m): least squares in times over half of each window."""
    places = first[:, None] + np.arange(int(np.max(last - first, initial=1)))
    inside = places < last[:, None]
    places = np.minimum(places, len(t) - 1)
    near = np.where(inside, (t[places] - at[:, None]) / half[:, None], 0.0)
    powers = (inside, near, near**2) if len(t) > 3 else (inside, near)
    basis = np.stack([np.asarray(part, float) for part in powers], axis=1)
    inverse = np.linalg.inv(np.einsum("mkw,mlw->mkl", basis, basis))
    moments = np.einsum("mkw,mw->mk", basis, values[places])
    fitted = np.einsum("mkl,ml->mk", inverse[:, :2], moments)
    return np.stack([fitted[:, 0], fitted[:, 1] / half, inverse[:, 0, 0]])


def crossing(t: Array, values: Array, level: float, half: float, start: float) -> float | None:
    """First instant after a start at which a smoothed record rises through a level.

    Across a gap that is longer than the windows the record is a straight line.

    start [s].

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
    seen = float(t[above[0]])
    before = max(start, float(t[max(above[0] - 1, 0)]))
    if seen - before > 3 * half:
        # Parabolas through samples far away on either side are wild in the middle.
        at = np.array([before, seen])
    else:
        at = np.linspace(max(start, seen - 3 * half), min(seen + 3 * half, float(t[-1])), 61)
    smooth = local(t, values, at, half).value
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

    t, x, y [s]; start, end [s]; shortest [m].
    """
    count = max(round((end - start) / every), 2)
    at = np.linspace(start, end, count + 1)
    path = np.stack([local(t, part, at, 0.5 * every).value for part in (x, y)])
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


SMOOTHED: Final = 0.15
"""Half of the window of local fits in ship lengths over the approach speed, at least 3 samples."""


def half_window(t: Array, L: float, speed: float) -> float:
    """Half of the window in which places and headings of a record are smoothed [s].

    t [s]; L, speed [m].

    Examples
    --------
    >>> half_window(np.arange(60.0), 320.0, 8.0), half_window(np.arange(60.0), 7.0, 1.2)
    (6.0, 3.0)
    """
    return max(SMOOTHED * L / speed, 3.0 * float(np.median(np.diff(t))))


def velocity(t: Array, x: Array, y: Array, at: ArrayLike, half: float) -> tuple[Any, Any]:
    """Velocity along x and y at an instant or at several, from the positions about it.

    t, x, y [s]; at (m,); at [s]; half [s].

    Examples
    --------
    >>> t = np.arange(0.0, 60.0)
    >>> ahead, aside = velocity(t, 5.0 * t, 0.01 * t**2, [10.0, 30.0], 3.0)
    >>> ahead.round(6).tolist(), aside.round(6).tolist()
    ([5.0, 5.0], [0.2, 0.6])
    """
    window = 2.0 * half
    return local(t, x, at, window).slope, local(t, y, at, window).slope


def true_wind(
    psi: Array, speed: Array, direction: Array, north: Array, east: Array
) -> tuple[Array, Array]:
    """True wind over ground from that which a ship feels.

    speed, direction [m/s]; north, east [m/s].

    Examples
    --------
    A ship at 4 m/s to the east in a calm feels her own way from ahead:

    >>> still, four = np.zeros(1), np.array([4.0])
    >>> true_wind(np.array([np.pi / 2]), four, still, still, four)[0].round(9)
    array([0.])
    >>> blows, comes_from = true_wind(still, np.array([10.0]), still, four, still)
    >>> blows.tolist(), comes_from.tolist()
    ([6.0], [0.0])
    """
    way = direction + psi
    along, across = speed * np.cos(way) - north, speed * np.sin(way) - east
    return np.hypot(along, across), unwrapped(np.arctan2(across, along))
