"""Records as arrays: checked, weighted by time, condensed to equal stretches."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import DataError, Problem
from pmmkit.numerics import Array

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
