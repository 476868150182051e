"""The rest at the head of a record, before the carriage moves: gauges show their zero there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array
from pmmkit.signals.noise import steady_mean
from pmmkit.signals.record import as_record

LEAST_S: Final = 1.0
"""Shortest rest [s]: less tells the zero of a gauge too badly."""
LEAST_SAMPLES: Final = 20
LARGEST: Final = 0.4
"""Largest part of the record that can be its head."""
STEP: Final = 8
"""Samples of which one mean is judged: fewer mistake noise for a start, more blur the start."""
SIGMAS: Final = 5.0
"""Standard errors of such a mean by which a start stands out."""
SHARE: Final = 0.02
"""Share of a channel's range below which a change is no start."""
NEAR: Final = 0.5
"""Share of the run's pull that the surge gauge may show at rest; more is a run at another speed."""
PEAK: Final = 0.9
"""Share of a channel's largest force above which a slow swing stands still at its peak."""
MARGIN: Final = 0.1
"""Part of the rest left out before the start: a carriage starts softly."""


@dataclass(frozen=True)
class Rest:
    """The first samples of a record, in which nothing moves.

    `stop`: the sample after the last. `value, std (c,)`: means of the channels and their
    standard uncertainty.
    """

    stop: int
    duration: float
    value: Array
    std: Array


def head_rest(t: ArrayLike, y: ArrayLike, surge: int = 0) -> Rest | None:
    """The rest at the head of a record, or None where it begins on the way.

    Parameters
    ----------
    t : (n,) array
        Time, increasing [s].
    y : (c, n) array
        Forces, those that a run changes.
    surge : int
        Which of them is the surge force: it pulls as soon as the carriage moves.

    Returns
    -------
    Rest or None

    Raises
    ------
    DataError
        If the record is too short or not finite, or if time does not increase.

    Notes
    -----
    All channels stand still from the first sample on for at least a second; then the surge force
    goes to where it stays for the rest of the record, at least twice as far as it stood from zero.

    Examples
    --------
    >>> t = np.arange(0.0, 30.0, 0.02)
    >>> noise = np.random.default_rng(1).normal(size=(2, t.size))
    >>> started = np.clip((t - 3.0) / 2.0, 0.0, 1.0)
    >>> record = np.stack([-1.2 - 20.0 * started, 40.0 * started]) + 0.2 * noise
    >>> found = head_rest(t, record)
    >>> round(found.duration, 1), bool(abs(found.value[0] + 1.2) < 3 * found.std[0])
    (2.7, True)
    >>> head_rest(t[250:], record[:, 250:]) is None
    True
    """
    time, values = as_record(t, y, least=3 * LEAST_SAMPLES)
    n = time.size
    first = max(STEP, int(np.searchsorted(time, time[0] + LEAST_S / 2)))
    if first >= LARGEST * n:
        return None
    level = values[:, :first].mean(axis=1)
    noise = values[:, :first].std(axis=1)
    head = values[:, : int(LARGEST * n) + STEP]
    sums = np.insert(np.cumsum(head, axis=1), 0, 0.0, axis=1)
    away = np.abs((sums[:, STEP:] - sums[:, :-STEP]) / STEP - level[:, None])
    chance = SIGMAS * noise * np.sqrt(1.0 / STEP + 1.0 / first)
    widest = np.maximum(chance, SHARE * np.ptp(values, axis=1))
    soon = int(np.searchsorted(time, time[0] + (1.0 - MARGIN) * LEAST_S))
    if np.any(away[:, :soon] > widest[:, None]):
        return None
    low, high = np.percentile(values, [5.0, 95.0], axis=1)
    limit = np.maximum(chance, SHARE * (high - low))
    moved = np.any(away > limit[:, None], axis=0)
    if not moved.any():
        return None
    start = int(np.argmax(moved))
    stop = int(np.searchsorted(time, time[0] + (1.0 - MARGIN) * (time[start] - time[0])))
    duration = float(time[stop] - time[0])
    swings = high - low > 2.0 * SIGMAS * noise
    peak = swings & (np.abs(level) > PEAK * np.abs(values).max(axis=1))
    pull = float(np.median(values[surge, n // 2 :])) - level[surge]
    if (
        duration < (1.0 - MARGIN) * LEAST_S
        or stop < LEAST_SAMPLES
        or start > LARGEST * n
        or abs(pull) <= limit[surge]
        or abs(level[surge]) > NEAR * abs(pull)
        or peak.any()
    ):
        return None
    found = steady_mean(time[:stop], values[:, :stop])
    return Rest(stop, duration, found.value, found.std)
