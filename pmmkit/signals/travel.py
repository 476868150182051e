"""The part of a record in which carriage and oscillator are at their size: without their ramps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array, stretches
from pmmkit.signals.noise import FEWEST, as_record, white_noise
from pmmkit.signals.periodic import TURN
from pmmkit.signals.steady import calmest_part

BLOCKS: Final = 256
"""Means of the speed that are judged, at most: they average the noise of a speed log."""
SLOW: Final = 0.8
"""Share of the later speed below which a record begins, or ends, on a ramp."""
BAND: Final = 0.01
"""Share of the speed by which it may leave what it has in the middle of the run."""
NOISES: Final = 2.0
"""Standard deviations of a mean beside that: the largest of the middle are not the largest."""
MARGIN: Final = 0.1
"""Part of a ramp left out beside it: a ramp ends softly, and mass times little is much."""
A_CYCLE: Final = 32
"""Means over a cycle that are held against those a cycle later."""
NEIGHBOURS: Final = 4
"""So many of these together are held against the calmest part: one alone is too noisy."""
SIGMAS: Final = 5.0
"""Root mean squares of the calmest part that are not reached by chance."""
NEGLIGIBLE: Final = 3e-3
"""Share of a channel below which a change is none: computations have no noise."""
LEAST: Final = 1.5
"""Cycles that must repeat at least: less may be a chance likeness of a ramp and a stop."""
PULL: Final = 0.5
"""Share of the run's pull that the surge force must lack where the carriage is slower."""
LARGEST: Final = 0.5
"""Largest share of the record that can be the ramp and what stands before it."""
LEVEL: Final = 0.005
"""Share of its size within which a swing has it: over one cycle a soft ramp of a cycle is as close
while it overlaps by a fifth, of which `SOFT` is then left out."""
OVERSHOT: Final = 0.02
"""Share beyond which a swing that comes up is still on its way."""
SMALLER: Final = 0.95
"""Share of its later size below which a swing begins, or ends, on a ramp."""
SOFT: Final = 4
"""Of `A_CYCLE` parts of a cycle left out beside a ramp of the swing: it ends softly."""
LEVELS: Final = 64
"""Sizes of which the one is taken that a swing keeps longest."""


@dataclass(frozen=True)
class Travel:
    """The samples [start, stop) at which carriage and oscillator are at their size.

    Attributes
    ----------
    start, stop : int
        First sample kept, and the one after the last.
    reason : str
        What was left out, for a person; empty where they are so throughout.
    """

    start: int
    stop: int
    reason: str = ""

    def within(self, other: Travel) -> Travel:
        """The samples that both keep; this one where they have none in common."""
        start, stop = max(self.start, other.start), min(self.stop, other.stop)
        if stop - start < FEWEST or not other.reason:
            return self
        told = filter(None, (self.reason, other.reason))
        return Travel(start, stop, " and ".join(told))


def at_speed(t: ArrayLike, speed: ArrayLike) -> Travel:
    """Where a carriage is at its speed, from its recorded speed.

    Parameters
    ----------
    t : (n,) array
        Time, increasing [s].
    speed : (n,) array
        Speed along the tank; the sign does not matter, and it may swing [m/s].

    Returns
    -------
    Travel
        The whole record unless it begins or ends at less than 0.8 of the lowest speed of the
        middle of the run; then what lies between the last and the first time that the speed is
        further than 1 % from what the middle of the run shows, with a tenth of the ramp beside it.

    Raises
    ------
    DataError
        If the record is too short or not finite, or if time does not increase.

    Examples
    --------
    >>> t = np.arange(0.0, 60.0, 0.1)
    >>> found = at_speed(t, 1.2 * np.clip((t - 3.0) / 5.0, 0.0, 1.0))
    >>> found.start, found.stop == t.size, found.reason
    (87, True, '0 to 8.7 s (the carriage speeds up)')
    >>> at_speed(t, 1.2 + 0.3 * np.sin(t)).reason
    ''
    """
    time, values = as_record(t, speed, least=FEWEST)
    size = -(-time.size // BLOCKS)
    starts = np.arange(0, time.size, size)
    width = np.diff(starts, append=time.size)
    means = np.add.reduceat(values[0], starts) / width
    means = means * np.sign(np.median(means[np.abs(means) >= 0.5 * np.abs(means).max()]))
    level = float(np.median(means[means >= 0.5 * means.max()]))
    whole = Travel(0, time.size)
    if level <= 0.0:
        return whole
    fast = np.flatnonzero(means >= SLOW * level)
    first, last = int(fast[0]), int(fast[-1]) + 1
    inner = means[first + (last - first) // 4 : last - (last - first) // 4]
    low, high = float(inner.min()), float(inner.max())
    noise = float(np.std(np.diff(inner)) / np.sqrt(2.0)) if inner.size > 1 else 0.0
    band = BAND * level + NOISES * noise
    outside = (means < low - band) | (means > high + band)
    middle = (first + last) // 2
    start, stop = 0, time.size
    moving = np.flatnonzero(means > (1.0 - SLOW) * level)
    if means[0] < SLOW * low and outside[:middle].any():
        end = int(np.flatnonzero(outside[:middle])[-1]) + 1
        start = int(starts[min(end + _margin(end - int(moving[0])), middle)])
    if means[-1] < SLOW * low and outside[middle:].any():
        begin = middle + int(np.flatnonzero(outside[middle:])[0])
        stop = int(starts[max(begin - _margin(int(moving[-1]) + 1 - begin), middle)])
    return _told(time, start, stop) if start < stop else whole


def _margin(ramp: int) -> int:
    return int(np.ceil(MARGIN * ramp))


def at_size(t: ArrayLike, y: ArrayLike, omega: float) -> Travel:
    """Where an oscillator swings at its full size, from the recorded motion.

    Parameters
    ----------
    t : (n,) array
        Time, increasing [s].
    y : (c, n) array
        Motions that swing at one frequency: displacements or velocities.
    omega : float
        Their angular frequency [rad/s].

    Returns
    -------
    Travel
        The whole record unless a motion begins or ends at less than 0.95 of the size that it keeps
        longest; then the cycles in which all of them have theirs, without an eighth of a cycle
        beside each ramp.

    Raises
    ------
    DataError
        If the record is too short or not finite, or if time does not increase.

    Notes
    -----
    The size is that of the first harmonic over one cycle, which slides along the record by 32nds.

    Examples
    --------
    >>> t = np.arange(0.0, 50.0, 0.05)
    >>> y = 0.25 * np.clip((t - 5.0) / 6.0, 0.0, 1.0) * np.sin(2 * np.pi * t / 9.0)
    >>> found = at_size(t, y, 2 * np.pi / 9.0)
    >>> bool(11.0 < t[found.start] < 12.5), found.stop == t.size
    (True, True)
    >>> at_size(t[300:], y[300:], 2 * np.pi / 9.0).reason
    ''
    """
    time, values = as_record(t, y, least=FEWEST)
    whole = Travel(0, time.size)
    phase = omega * (time - time[0])
    count = int(phase[-1] / TURN * A_CYCLE)
    edges = np.searchsorted(phase, TURN / A_CYCLE * np.arange(count + 1) - 1e-9)
    if count < 2 * A_CYCLE or np.diff(edges).min() < 1:
        return whole
    means = np.add.reduceat(values[:, : edges[-1]], edges[:-1], axis=1) / np.diff(edges)
    turned = means * np.exp(-1j * TURN / A_CYCLE * (np.arange(count) + 0.5))
    sums = np.insert(np.cumsum(turned, axis=1), 0, 0.0, axis=1)
    sizes = np.abs(sums[:, A_CYCLE:] - sums[:, :-A_CYCLE]) * 2.0 / A_CYCLE
    first, last = 0, count
    for size, motion in zip(sizes, values, strict=True):
        noise = white_noise(motion) * np.sqrt(2.0 * count / A_CYCLE / time.size)
        begin, end = _kept_longest(size, noise)
        first = max(first, begin + SOFT if begin else 0)
        last = min(last, end + A_CYCLE - 1 - SOFT if end < size.size else count)
    if last - first < A_CYCLE:
        return whole
    stop = int(edges[last]) if last < count else time.size
    said = ("the oscillator comes up", "the oscillator goes down")
    return _told(time, int(edges[first]), stop, said)


def _kept_longest(size: Array, noise: float) -> tuple[int, int]:
    """The places [first, last) at which a swing has the size that it keeps longest."""
    level, kept = 0.0, (0, size.size)
    longest = 0
    for tried in np.linspace(0.5, 1.0, LEVELS)[::-1] * size.max():
        starts, stops = stretches(np.abs(size - tried) <= LEVEL * tried + SIGMAS * noise)
        if starts.size and (stops - starts).max() > longest:
            best = int(np.argmax(stops - starts))
            longest = int(stops[best] - starts[best])
            kept = int(starts[best]), int(stops[best])
            level = float(np.median(size[kept[0] : kept[1]]))
    near = np.abs(size - level) <= LEVEL * level + SIGMAS * noise
    far = np.abs(size - level) > OVERSHOT * level + SIGMAS * noise
    middle = sum(kept) // 2
    first, last = 0, size.size
    if size[0] < SMALLER * level and far[:middle].any():
        after = int(np.flatnonzero(far[:middle])[-1]) + 1
        first = after + int(np.argmax(near[after : middle + 1]))
    if size[-1] < SMALLER * level and far[middle:].any():
        before = middle + int(np.argmax(far[middle:]))
        last = before - int(np.argmax(near[middle:before][::-1]))
    return first, last


def in_step(t: ArrayLike, theta: ArrayLike, y: ArrayLike, surge: int = 0) -> Travel:
    """Where the carriage of an oscillating run is at its speed, from the forces alone.

    Parameters
    ----------
    t : (n,) array
        Time, increasing [s].
    theta : (n,) array
        Phase of the motion, increasing by 2π a cycle [rad].
    y : (c, n) array
        Forces.
    surge : int
        Which of them is the surge force: it tells a ramp.

    Returns
    -------
    Travel
        The whole record unless a ramp is found.

    Raises
    ------
    DataError
        If the record is too short or not finite, or if time or phase do not increase.

    Notes
    -----
    Once the carriage is at its speed, each cycle repeats the one before: the difference of means
    over 32nds of a cycle to those a cycle later is noise. Its calmest part is found as that of a
    static run is, and then followed to both sides until four neighbouring differences together
    leave what they are in it. What is left over is a ramp only if half of the pull or more is
    missing where the record begins (or ends): the start of the oscillator, or of the waves, stays
    for the comparison of whole cycles, and so does a record that begins in the middle of a ramp.

    Examples
    --------
    >>> t = np.arange(0.0, 40.0, 0.05)
    >>> on = np.clip((t - 2.0) / 6.0, 0.0, 1.0)
    >>> theta = 2 * np.pi * t / 9.0
    >>> noise = np.random.default_rng(1).normal(size=(2, t.size))
    >>> forces = np.stack([-20.0 * on**2, 50.0 * on * np.cos(theta)]) + 0.3 * noise
    >>> found = in_step(t, theta, forces)
    >>> bool(7.5 < t[found.start] < 9.0), found.stop == t.size
    (True, True)
    >>> in_step(t[200:], theta[200:], forces[:, 200:]).reason
    ''
    """
    time, values = as_record(t, y, least=FEWEST)
    phase, values = as_record(theta, values, name="theta")
    whole = Travel(0, time.size)
    count = int((phase[-1] - phase[0]) / TURN * A_CYCLE)
    edges = np.searchsorted(phase, phase[0] + TURN / A_CYCLE * np.arange(count + 1) - 1e-9)
    if count < (LEAST + 0.5) * A_CYCLE + NEIGHBOURS or np.diff(edges).min() < 1:
        return whole
    cells = np.add.reduceat(values, edges[:-1], axis=1)[:, :count]
    width = np.diff(edges)
    cells[:, -1] = values[:, edges[-2] : edges[-1]].sum(axis=1)
    cells = cells / width
    change = cells[:, A_CYCLE:] - cells[:, :-A_CYCLE]
    core = calmest_part(np.arange(change.shape[1], dtype=float), change)
    head, tail = _repeating(change, cells, core)
    tail += A_CYCLE
    if tail - head < LEAST * A_CYCLE:
        return whole
    pull = float(np.mean(cells[surge, head:tail]))
    if abs(pull) <= PULL * float(np.sqrt(np.mean(cells[surge, head:tail] ** 2))):
        return whole
    gained = change[surge] / pull
    start, stop = 0, time.size
    if 0 < head <= LARGEST * count and _lacks(gained[:head]):
        start = int(edges[head])
    if count > tail >= (1.0 - LARGEST) * count and _lacks(-gained[tail - A_CYCLE :][::-1]):
        stop = int(edges[tail])
    return _told(time, start, stop)


def _repeating(change: Array, cells: Array, core: tuple[int, int]) -> tuple[int, int]:
    """The cells [first, last) around a calm core whose changes are as small as in the core."""
    sums = np.insert(np.cumsum(change, axis=1), 0, 0.0, axis=1)
    smooth = (sums[:, NEIGHBOURS:] - sums[:, :-NEIGHBOURS]) / NEIGHBOURS
    first, last = core[0], max(core[1] - NEIGHBOURS + 1, core[0] + 1)
    usual = np.sqrt(np.mean(smooth[:, first:last] ** 2, axis=1, keepdims=True))
    size = np.sqrt(np.mean(cells**2, axis=1, keepdims=True))
    away = np.any(np.abs(smooth) > SIGMAS * usual + NEGLIGIBLE * size, axis=0)
    middle = (first + last) // 2
    before, after = np.flatnonzero(away[:middle]), np.flatnonzero(away[middle:])
    return (
        int(before[-1]) + NEIGHBOURS - 1 if before.size else 0,
        middle + int(after[0]) + 1 if after.size else change.shape[1],
    )


def _lacks(gained: Array) -> bool:
    """Whether much of the pull is missing at an end, over up to an eighth of a cycle."""
    return bool(np.median(gained[: A_CYCLE // 8]) > PULL)


def _told(
    time: Array,
    start: int,
    stop: int,
    said: tuple[str, str] = ("the carriage speeds up", "the carriage stops"),
) -> Travel:
    parts = []
    if start > 0:
        parts.append(f"{time[0]:.4g} to {time[start]:.4g} s ({said[0]})")
    if stop < time.size:
        parts.append(f"{time[stop]:.4g} to {time[-1]:.4g} s ({said[1]})")
    return Travel(start, stop, " and ".join(parts))
