"""Noise of autocorrelated records: what the mean of a steady record is worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array
from pmmkit.signals import autoregression as ar
from pmmkit.signals.record import as_record, cell_means, time_weights

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
