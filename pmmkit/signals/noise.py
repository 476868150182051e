"""Noise of autocorrelated records: what the mean of a steady record is worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.errors import DataError, Problem

Array = NDArray[np.float64]
CELLS: Final = 1024
MAX_ORDER: Final = 24


@dataclass(frozen=True)
class Mean:
    """Means of the channels of one steady record, with their covariance.

    Attributes
    ----------
    value : (c,) array
        Time-weighted means.
    covariance : (c, c) array
        Covariance of the means; the noise may be correlated in time and between channels.
    dof : (c,) array
        Degrees of freedom of each variance, for Student's t.
    effective : (c,) array
        Number of independent samples whose mean would be as uncertain.
    """

    value: Array
    covariance: Array
    dof: Array
    effective: Array

    @property
    def std(self) -> Array:
        """Standard uncertainty of each mean."""
        return np.sqrt(np.diag(self.covariance))


def as_record(t: Array, y: Array, *, name: str = "t", least: int = 4) -> tuple[Array, Array]:
    """The abscissa (n,) and the channels (c, n) as float arrays, checked."""
    time = np.asarray(t, dtype=float)
    values = np.atleast_2d(np.asarray(y, dtype=float))
    problems: list[Problem] = []
    if time.ndim != 1 or values.ndim != 2 or values.shape[-1] != time.size:
        raise DataError(
            f"{name} has shape {time.shape} and the channels {values.shape}: "
            "one value of each channel per sample is needed."
        )
    if time.size < least:
        problems.append(
            Problem(message=f"The record has {time.size} samples; at least {least} are needed.")
        )
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        problems.append(
            Problem(
                message=f"{name} is not a finite number in {bad.size} samples.",
                row=int(bad[0]) + 1,
                column=name,
            )
        )
    else:
        back = np.flatnonzero(np.diff(time) <= 0)
        if back.size:
            problems.append(
                Problem(
                    message=f"{name} does not increase at {back.size} samples.",
                    row=int(back[0]) + 2,
                    column=name,
                )
            )
    for channel, row in enumerate(values):
        bad = np.flatnonzero(~np.isfinite(row))
        if bad.size:
            problems.append(
                Problem(
                    message=f"Channel {channel} is not a finite number in {bad.size} samples.",
                    row=int(bad[0]) + 1,
                )
            )
    if problems:
        raise DataError(problems, title="The record cannot be used")
    return time, values


def time_weights(t: Array) -> Array:
    """The stretch of time each sample stands for, (n,)."""
    step = np.diff(t)
    return 0.5 * (np.concatenate(([step[0]], step)) + np.concatenate((step, [step[-1]])))


def is_uniform(t: Array) -> bool:
    """Whether the steps of t are equal to a thousandth."""
    step = np.diff(t)
    return bool(step.max() - step.min() <= 1e-3 * step.mean())


def cell_means(t: Array, y: Array, cells: int) -> Array:
    """Means of y (c, n) over at most `cells` equal stretches of time, (c, m)."""
    n = t.size
    if is_uniform(t):
        batch = -(-n // cells)
        m = n // batch
        if batch == 1:
            return y
        return y[:, n - m * batch :].reshape(y.shape[0], m, batch).mean(axis=-1)
    weight = time_weights(t)
    edge = np.concatenate(([0.0], np.cumsum(weight)))
    total = np.concatenate((np.zeros((y.shape[0], 1)), np.cumsum(y * weight, axis=-1)), axis=-1)
    m = min(n, cells)
    grid = np.linspace(0.0, edge[-1], m + 1)
    at = np.stack([np.interp(grid, edge, row) for row in total])
    return np.diff(at, axis=-1) / (edge[-1] / m)


def burg(x: Array, order: int) -> tuple[Array, Array]:
    """Autoregressions of all orders up to `order` by Burg's method.

    Parameters
    ----------
    x : (c, n) array
        Records with mean zero.

    Returns
    -------
    coefficients : (order + 1, c, order + 1) array
        Row p holds the filter 1, a1, …, ap of order p, padded with zeros.
    power : (order + 1, c) array
        Variance of the innovations of each order.
    """
    c = x.shape[0]
    filters = np.zeros((order + 1, c, order + 1))
    filters[:, :, 0] = 1.0
    power = np.empty((order + 1, c))
    power[0] = np.mean(x * x, axis=-1)
    forward, backward = x[:, 1:], x[:, :-1]
    current = filters[0].copy()
    for p in range(1, order + 1):
        top = -2.0 * np.einsum("cn,cn->c", forward, backward)
        bottom = np.einsum("cn,cn->c", forward, forward) + np.einsum("cn,cn->c", backward, backward)
        k = np.divide(top, bottom, out=np.zeros(c), where=bottom > 0)
        previous = current.copy()
        current[:, 1 : p + 1] = (
            previous[:, 1 : p + 1] + k[:, None] * previous[:, p - 1 :: -1][:, :p]
        )
        filters[p] = current
        power[p] = power[p - 1] * (1.0 - k * k)
        forward, backward = (
            (forward + k[:, None] * backward)[:, 1:],
            (backward + k[:, None] * forward)[:, :-1],
        )
    return filters, power


def steady_mean(t: Array, y: Array) -> Mean:
    """Time-weighted mean of a steady record and its uncertainty.

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
        If the record is too short, not finite or not increasing in time.
    """
    time, values = as_record(t, y)
    weight = time_weights(time)
    weight = weight / weight.sum()
    value = values @ weight
    cells = cell_means(time, values, CELLS)
    x = cells - cells.mean(axis=-1, keepdims=True)
    c, m = x.shape
    spread = np.einsum("n,cn->c", weight, (values - value[:, None]) ** 2)
    order = min(MAX_ORDER, m // 4)
    filters, power = burg(x, order)
    score = m * np.log(np.maximum(power, 1e-300)) + 2.0 * np.arange(order + 1)[:, None]
    best = np.argmin(score, axis=0)
    pick = np.arange(c)
    gain = filters[best, pick].sum(axis=-1)
    variance = power[best, pick] / gain**2 / m
    dof = np.maximum(1.0, m * power[best, pick] / np.maximum(2 * m * variance, 1e-300))
    scale = np.sqrt(variance)
    covariance = np.diag(scale**2)
    effective = np.divide(spread, variance, out=np.full(c, float(time.size)), where=variance > 0)
    return Mean(value, covariance, np.minimum(dof, m - 1.0), effective)
