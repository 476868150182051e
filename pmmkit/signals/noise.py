"""Noise of autocorrelated records: what the mean of a steady record is worth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmmkit.base import DataError, Problem
from pmmkit.numerics import Array
from pmmkit.signals import autoregression as ar

# Records as arrays: checked, weighted by time, condensed to equal stretches.


FEWEST: Final = 16
"""Samples of a record from which a mean and its uncertainty are taken."""


def as_record(
    t: ArrayLike, y: ArrayLike, *, name: str = "t", least: int = 4
) -> tuple[Array, Array]:
    """Abscissa (n,) and channels (c, n) of a record as float arrays, checked."""
    time = np.asarray(t, dtype=float)
    values = np.atleast_2d(np.asarray(y, dtype=float))
    if time.ndim != 1 or values.ndim != 2 or values.shape[-1] != time.size:
        raise DataError(
            f"{name} has shape {time.shape} and the channels {values.shape}: "
            "one value of each channel per sample is needed."
        )
    if time.size < least:
        raise DataError(f"The record has {time.size} samples; at least {least} are needed.")
    problems: list[Problem] = []
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        problems.append(
            Problem(
                message=f"{bad.size} values are not finite numbers.",
                column=name,
                row=int(bad[0]) + 1,
                remedy="Remove these samples.",
            )
        )
    else:
        back = np.flatnonzero(np.diff(time) <= 0)
        if back.size:
            problems.append(
                Problem(
                    message=f"it does not increase at {back.size} samples.",
                    column=name,
                    row=int(back[0]) + 2,
                    remedy="Sort the samples and remove doubles.",
                )
            )
    for channel in np.flatnonzero(~np.isfinite(values).all(axis=-1)):
        bad = np.flatnonzero(~np.isfinite(values[channel]))
        problems.append(
            Problem(
                message=f"{bad.size} values are not finite numbers.",
                column=f"channel {channel + 1}",
                row=int(bad[0]) + 1,
                remedy="Remove these samples or the channel.",
            )
        )
    if problems:
        raise DataError(problems, title="The record cannot be used")
    return time, values


def is_uniform(t: Array) -> bool:
    """Whether the steps are equal to a hundredth (time stamps may be rounded)."""
    step = np.diff(t)
    return bool(step.max() - step.min() <= 0.01 * step.mean())


def time_weights(t: Array) -> Array:
    """Stretch of time that each sample stands for, (n,); equal for equal steps.

    Parameters
    ----------
    t : (n,) array
        Increasing times [s].
    """
    if is_uniform(t):
        return np.full(t.size, (t[-1] - t[0]) / (t.size - 1))
    step = np.diff(t)
    return 0.5 * (np.append(step, step[-1]) + np.insert(step, 0, step[0]))


def cell_means(t: Array, y: Array, cells: int) -> Array:
    """Means over at most `cells` equal stretches of time, (c, m).

    On equal steps each cell holds the same whole number of samples, and up to that many samples
    at the start are left out; on unequal steps a sample counts as the value over its stretch.
    """
    n = t.size
    if is_uniform(t):
        size = -(-n // cells)
        m = n // size
        return np.asarray(y[:, n - m * size :].reshape(y.shape[0], m, size).mean(axis=-1))
    weight = time_weights(t)
    edge = np.insert(np.cumsum(weight), 0, 0.0)
    total = np.insert(np.cumsum(y * weight, axis=-1), 0, 0.0, axis=-1)
    m = min(n, cells)
    grid = np.linspace(0.0, edge[-1], m + 1)
    at = np.array([np.interp(grid, edge, row) for row in total]).reshape(y.shape[0], m + 1)
    return np.asarray(np.diff(at, axis=-1) / (edge[-1] / m))


CELLS: Final = 256
MAX_ORDER: Final = 16
PENALTY: Final = 3.0
"""Cost of one more coefficient; Akaike's is 2, Schwarz's ln(256) = 5.5."""
OVERSAMPLED: Final = 0.85
"""Neighbours correlated more than this are averaged in pairs."""


@dataclass(frozen=True)
class Mean:
    """Means of the channels of one steady record, with their covariance.

    `covariance (c, c)`: covariance of the means; honours correlation in time and between
    channels. `dof (c,)`: degrees of freedom of each variance, for Student's t. `effective
    (c,)`: number of independent samples whose mean would be as uncertain.
    """

    value: Array
    covariance: Array
    dof: Array
    effective: Array

    @property
    def std(self) -> Array:
        """Standard uncertainty of each mean, (c,)."""
        return np.asarray(np.sqrt(np.diagonal(self.covariance)))


def steady_mean(t: ArrayLike, y: ArrayLike) -> Mean:
    """Time-weighted mean of a record that is already steady, and its uncertainty.

    Parameters
    ----------
    t : (n,) array
        Time, increasing; steps may differ [s].
    y : (c, n) array
        Channels.

    Returns
    -------
    Mean

    Raises
    ------
    DataError
        If the record is too short or not finite, or if time does not increase.

    Notes
    -----
    The record is condensed to at most 256 means over equal stretches of time, an autoregression
    is fitted to them by Burg's method with its order chosen by a penalised likelihood, and the
    variance of the mean of so many values of that process is taken. Degrees of freedom follow
    from the variance of the logarithm of the spectrum at frequency zero. Correlation between
    channels is that of the lowest cosine coefficients (Lazarus, Lewis, Stock and Watson 2018).

    Examples
    --------
    >>> import numpy as np
    >>> t = np.linspace(0.0, 60.0, 1201)
    >>> noise = np.random.default_rng(1).normal(size=(1, t.size))
    >>> mean = steady_mean(t, 5.0 + 0.1 * noise)
    >>> round(float(mean.value[0]), 1), round(float(mean.std[0]) * t.size**0.5, 1)
    (5.0, 0.1)
    """
    time, values = as_record(t, y)
    weight = time_weights(time)
    weight = weight / weight.sum()
    value = values @ weight
    spread = ((values - value[:, None]) ** 2) @ weight
    cells = cell_means(time, values, CELLS)
    variance, dof = mean_noise(cells)
    rounding = (4.0 * np.finfo(float).eps * np.max(np.abs(values), axis=-1)) ** 2
    std = np.sqrt(np.maximum(variance, rounding))
    covariance = _correlation(cells, dof) * std[:, None] * std
    effective = np.full(value.size, float(time.size))
    np.divide(spread, variance, out=effective, where=variance > rounding)
    return Mean(value, covariance, dof, effective)


def mean_noise(x: Array) -> tuple[Array, Array]:
    """Variance of the mean of each record x (c, m) and its degrees of freedom.

    Neighbours that are nearly equal are averaged in pairs first, record by record, until they
    are not: a process sampled much faster than it changes has no useful autoregression. A record
    that varies by rounding alone has no noise.
    """
    rest = x - x.mean(axis=-1, keepdims=True)
    variance = np.zeros(x.shape[0])
    dof = np.full(x.shape[0], x.shape[-1] - 1.0)
    rounding = (4.0 * np.finfo(float).eps * np.abs(x).max(axis=-1)) ** 2
    todo = np.arange(x.shape[0])
    while todo.size:
        varies = np.mean(rest**2, axis=-1) > rounding[todo]
        todo, rest = todo[varies], rest[varies]
        half = rest.shape[-1] // 2
        neighbours = np.einsum("cm,cm->c", rest[:, 1:], rest[:, :-1])
        own = np.einsum("cm,cm->c", rest, rest)
        ready = (neighbours <= OVERSAMPLED * own) | (half < 24)
        _, _, gamma, dof[todo[ready]] = autoregressive_noise(rest[ready], MAX_ORDER)
        variance[todo[ready]] = mean_variance(gamma)
        todo = todo[~ready]
        rest = rest[~ready, rest.shape[-1] - 2 * half :].reshape(todo.size, half, 2).mean(axis=-1)
        rest = rest - rest.mean(axis=-1, keepdims=True)
    return variance, dof


def autoregressive_noise(x: Array, max_order: int) -> tuple[Array, Array, Array, Array]:
    """Autoregressions of records x (c, m) with mean zero; none may be constant.

    Parameters
    ----------
    x : (c, m) array
        The records.
    max_order : int
        Highest order that is tried.

    Returns
    -------
    filters : (c, order + 1) array
        The filters 1, a1, a2, … that whiten each record.
    innovation : (c,) array
        Variances of the whitened records.
    gamma : (c, m) array
        Autocovariances at lags 0, 1, …
    dof : (c,) array
        Degrees of freedom of the spectrum at frequency zero.
    """
    c, m = x.shape
    order = max(1, min(max_order, m // 5))
    reflection, power = ar.burg(x, order)
    p = np.arange(order + 1)
    score = m * np.log(np.maximum(power, 1e-30 * power[:, :1] + 1e-300)) + PENALTY * p * m / (
        m - 2.0 * p
    )
    best = 1 + np.argmin(score[:, 1:], axis=-1)
    kept = np.arange(1, order + 1) <= best[:, None]
    reflection = np.where(kept, ar.without_bias(reflection, m), 0.0)
    innovation = power[np.arange(c), best] * m / (m - best - 1.0)
    filters = ar.coefficients(reflection)
    gamma = ar.autocovariances(filters[-1], innovation, m)
    # 1' Γ⁻¹ 1 from the filters of all lower orders, times the innovation variance
    below = np.cumprod((1.0 - reflection**2)[:, ::-1], axis=-1)[:, ::-1]
    information = np.sum(np.where(kept, filters[:-1].sum(axis=-1).T ** 2 * below, 0.0), axis=-1)
    gain = filters[-1].sum(axis=-1)
    log_variance = 2.0 / m + 4.0 * information / gain**2 / m
    return filters[-1], innovation, gamma, np.clip(2.0 / log_variance, 1.0, m - 1.0)


def mean_variance(gamma: Array) -> Array:
    """Variance of the mean of as many values as there are autocovariances, (c,)."""
    m = gamma.shape[-1]
    taper = 1.0 - np.arange(m) / m
    return np.asarray((2.0 * gamma @ taper - gamma[:, 0]) / m)


def _correlation(x: Array, dof: Array) -> Array:
    """Correlation of the slow parts of the channels, (c, c)."""
    from scipy.fft import dct

    m = x.shape[-1]
    waves = int(np.clip(dof.min(), 4, m - 1))
    slow = dct(x, axis=-1)[:, 1 : waves + 1]
    size = np.sqrt(np.sum(slow**2, axis=-1, keepdims=True))
    unit = np.divide(slow, size, out=np.zeros_like(slow), where=size > 0)
    correlation = unit @ unit.T
    np.fill_diagonal(correlation, 1.0)
    return np.asarray(correlation)


def white_noise(values: Array) -> float:
    """Standard deviation of white noise on a smooth record, from its third differences.

    Parameters
    ----------
    values : array (n,)
        Equally spaced samples; NaN where there is none.

    Returns
    -------
    float
        NaN of fewer than ten third differences.

    Notes
    -----
    1.4826 times the median of their distances from their median, over the root of 20: the sum of
    the squares of 1, 3, 3 and 1.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(size=4000)
    >>> abs(white_noise(np.arange(4000.0) ** 2 * 1e-3 + noise) - 1) < 0.05
    True
    """
    third = np.diff(values, 3)
    third = third[np.isfinite(third)]
    if len(third) < 10:
        return float("nan")
    return float(1.4826 * np.median(np.abs(third - np.median(third))) / np.sqrt(20.0))


# The rest at the head of a record, before the carriage moves: gauges show their zero there.


LEAST_S: Final = 1.0
"""Shortest rest [s]: less tells the zero of a gauge too badly."""
LEAST_SAMPLES: Final = 20
STOOD_S: Final = 0.5
"""The same where the carriage's recorded speed says that it stands."""
STANDING: Final = ("U_carriage", "y", "psi")
"""Recorded motions that stand still at rest: without the first it is not known."""
STILL: Final = 5e-3
"""Share of its range below which a recorded speed stands still."""
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


def head_rest(
    t: ArrayLike, y: ArrayLike, surge: int = 0, *, motion: Mapping[str, ArrayLike] | None = None
) -> Rest | None:
    """The rest at the head of a record, or None where it begins on the way.

    Parameters
    ----------
    t : (n,) array
        Time, increasing [s].
    y : (c, n) array
        Forces, those that a run changes.
    surge : int
        Which of them is the surge force: it pulls as soon as the carriage moves.
    motion : mapping of str to (n,) array, optional
        What was recorded beside them; of these `STANDING` count.

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
    Where the speed of the carriage is recorded half a second is enough: it and all else that is
    recorded must stand still.

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
    head = _still(time, values, np.full(len(values), SHARE), (LEAST_S, LEAST_SAMPLES))
    if head is None or not _pulled(values, head, surge):
        seen = motion or {}
        rows = [np.asarray(seen[name], float) for name in STANDING if name in seen]
        if STANDING[0] not in seen or not all(np.isfinite(row).all() for row in rows):
            return None
        share = np.array([SHARE] * len(values) + [STILL] * len(rows))
        head = _still(time, np.vstack([values, *rows]), share, (STOOD_S, FEWEST))
        if head is None or abs(head.level[len(values)]) > SHARE * np.abs(rows[0]).max():
            return None
    found = steady_mean(time[: head.stop], values[:, : head.stop])
    return Rest(head.stop, float(time[head.stop] - time[0]), found.value, found.std)


@dataclass(frozen=True)
class _Head:
    """The samples before `stop`, at which nothing moves.

    `level (c,)`: where the channels stand. `limit (c,)`: by how much a start must move them.
    `swings (c,)`: whether they move clearly later on.
    """

    stop: int
    level: Array
    limit: Array
    swings: NDArray[np.bool_]


def _still(time: Array, values: Array, share: Array, least: tuple[float, int]) -> _Head | None:
    """The head of a record until one of its channels starts; `least` seconds and samples."""
    least_s, samples = least
    n = time.size
    first = max(STEP, int(np.searchsorted(time, time[0] + least_s / 2)))
    if first >= LARGEST * n:
        return None
    level = values[:, :first].mean(axis=1)
    noise = values[:, :first].std(axis=1)
    head = values[:, : int(LARGEST * n) + STEP]
    sums = np.insert(np.cumsum(head, axis=1), 0, 0.0, axis=1)
    away = np.abs((sums[:, STEP:] - sums[:, :-STEP]) / STEP - level[:, None])
    rounding = 1e-9 * np.abs(values).max(axis=1)
    chance = SIGMAS * noise * np.sqrt(1.0 / STEP + 1.0 / first) + rounding
    widest = np.maximum(chance, share * np.ptp(values, axis=1))
    soon = int(np.searchsorted(time, time[0] + (1.0 - MARGIN) * least_s))
    if np.any(away[:, :soon] > widest[:, None]):
        return None
    low, high = np.percentile(values, [5.0, 95.0], axis=1)
    limit = np.maximum(chance, share * (high - low))
    moved = np.any(away > limit[:, None], axis=0)
    if not moved.any():
        return None
    start = int(np.argmax(moved))
    stop = int(np.searchsorted(time, time[0] + (1.0 - MARGIN) * (time[start] - time[0])))
    duration = float(time[stop] - time[0])
    if duration < (1.0 - MARGIN) * least_s or stop < samples or start > LARGEST * n:
        return None
    return _Head(stop, level, limit, high - low > 2.0 * SIGMAS * noise)


def _pulled(values: Array, head: _Head, surge: int) -> bool:
    """Whether the run then pulls much more than the gauges show, and none of them is at a peak."""
    pull = float(np.median(values[surge, values.shape[1] // 2 :])) - head.level[surge]
    peak = head.swings & (np.abs(head.level) > PEAK * np.abs(values).max(axis=1))
    far = abs(pull) > head.limit[surge] and abs(head.level[surge]) <= NEAR * abs(pull)
    return bool(far and not peak.any())
