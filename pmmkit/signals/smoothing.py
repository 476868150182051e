"""Records that were fitted before they were handed in: nothing is left between their harmonics."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array
from pmmkit.signals.fourier import Harmonics

ROUNDED: Final = 2.0
"""Rms of what harmonics leave, over that of rounding, up to which rounding explains it. Flanders
Hydraulics' cycles of KCS (24 points, written to 1e-4) lie at 0.9 to 1.1."""
STANDS: Final = 5.0
"""Amplitude of a harmonic, over the standard deviation that rounding gives it, from which it was
fitted."""
FINEST: Final = 1e-12
"""Resolution of binary numbers over the largest of them: what is left of sums of harmonics."""
DECIMALS: Final = 12


def resolution(values: ArrayLike) -> Array:
    """The decimal step of which all numbers of each channel are multiples.

    values (c, n).

    Examples
    --------
    >>> resolution([[0.25, 1.5, -0.75], [1 / 3, 0.1, 2.0]])
    array([1.e-02, 2.e-12])
    """
    x = np.asarray(values, float)
    largest = np.max(np.abs(x), axis=1)
    found = FINEST * np.where(largest > 0, largest, 1.0)
    open_ = np.ones(len(x), bool)
    for decimals in range(DECIMALS + 1):
        step = 10.0**-decimals
        steps = x / step
        # A decimal number is stored to the last bit, not exactly.
        near = np.abs(steps - np.rint(steps)) <= 4 * np.finfo(float).eps * np.abs(steps)
        whole = open_ & near.all(axis=1) & (step > found)
        found[whole], open_[whole] = step, False
    return found


def fitted_order(values: ArrayLike, found: Harmonics) -> int | None:
    """The highest harmonic to which a record was fitted before it was written.

    Parameters
    ----------
    values : array (c, n)
        Channels of whole cycles.
    found : Harmonics
        Of these.

    Returns
    -------
    int or None
        None for a record in which something is left between the harmonics, or too few samples to
        tell: it has noise of its own.

    Examples
    --------
    >>> from pmmkit.signals.fourier import harmonics
    >>> theta = 2 * np.pi * np.arange(24) / 24
    >>> cycle = np.round([3 * np.cos(theta) + np.sin(2 * theta)], 4)
    >>> fitted_order(cycle, harmonics(theta, cycle))
    2
    >>> noisy = cycle + 0.01 * np.cos(8 * theta)
    >>> fitted_order(noisy, harmonics(theta, noisy)) is None
    True
    """
    x = np.asarray(values, float)
    n = x.shape[1]
    if n <= 2 * (2 * found.order + 1):
        return None
    rounding = resolution(x) / np.sqrt(12.0)
    if np.any(found.residual > ROUNDED * rounding):
        return None
    pairs = found.coefficients[:, 1:].reshape(len(x), found.order, 2)
    amplitude = np.linalg.norm(pairs, axis=2)
    there = np.any(amplitude > STANDS * (rounding * np.sqrt(2.0 / n))[:, None], axis=0)
    return int(np.max(np.flatnonzero(there), initial=-1)) + 1
