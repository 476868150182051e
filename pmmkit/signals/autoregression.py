"""Autoregressions by their reflection coefficients, many records at once.

An autoregression x_t + a1 x_{t-1} + … + ap x_{t-p} = e_t is held by its reflection coefficients
k1 … kp, all within ±1, so that it is always stationary. Lower orders have zeros at the end.
"""

from __future__ import annotations

import numpy as np

from pmmkit.numerics import Array


def burg(x: Array, order: int) -> tuple[Array, Array]:
    """Reflection coefficients by Burg's method, and the innovation variance of every order.

    x (c, n); reflection (c, order); power (c, order + 1).

    Notes
    -----
    Burg, J. P. (1975), Maximum entropy spectral analysis, thesis, Stanford University.
    """
    c = x.shape[0]
    reflection = np.zeros((c, order))
    power = np.empty((c, order + 1))
    power[:, 0] = np.mean(x * x, axis=-1)
    forward, backward = x[:, 1:], x[:, :-1]
    for p in range(order):
        cross = np.vecdot(forward, backward)
        size = 0.5 * (np.vecdot(forward, forward) + np.vecdot(backward, backward))
        k = np.divide(-cross, size, out=np.zeros(c), where=size > 0)
        reflection[:, p] = k
        power[:, p + 1] = power[:, p] * (1.0 - k * k)
        forward, backward = (
            (forward + k[:, None] * backward)[:, 1:],
            (backward + k[:, None] * forward)[:, :-1],
        )
    return reflection, power


def without_bias(reflection: Array, n: int) -> Array:
    """Reflection coefficients corrected for their bias in records of n samples.

    To order 1/n the last coefficient of an autoregression of order p, fitted after the mean was
    removed, is too small: by (1 + 3φ)/n for p = 1 (Marriott and Pope 1954), by (2 + 4φ)/n for
    p = 2, and so on in turn. At most half of the distance to ±1 is added.
    """
    p = np.arange(1, reflection.shape[-1] + 1)
    last = -reflection
    moved = last + (2.0 - p % 2 + (p + 2.0) * last) / n
    limit = 0.5 * (1.0 + np.abs(last))
    return np.asarray(-np.clip(moved, -limit, limit))


def levinson(autocovariance: Array, limit: float) -> tuple[Array, Array]:
    """The autoregressions that have the autocovariances at lags 0 to p, arrays (c, p + 1).

    filters (c, p + 1); unexplained (c,).
    """
    c, size = autocovariance.shape
    variance = autocovariance[:, :1]
    correlation = np.divide(autocovariance, variance, out=np.zeros((c, size)), where=variance > 0)
    filters = np.zeros((c, size))
    filters[:, 0] = 1.0
    unexplained = np.ones((c, 1))
    for p in range(1, size):
        top = np.vecdot(filters[:, :p], correlation[:, p:0:-1])[:, None]
        k = np.minimum(np.maximum(-top / unexplained, -limit), limit)
        filters[:, 1 : p + 1] += k * filters[:, p - 1 :: -1]
        unexplained = unexplained * (1.0 - k * k)
    return filters, unexplained[:, 0]


def coefficients(reflection: Array) -> Array:
    """The filters 1, a1, …, ap of every order up to the highest, (p + 1, c, p + 1)."""
    c, p = reflection.shape
    filters = np.zeros((p + 1, c, p + 1))
    filters[:, :, 0] = 1.0
    for i in range(1, p + 1):
        filters[i] = filters[i - 1]
        filters[i, :, 1 : i + 1] += reflection[:, i - 1, None] * filters[i - 1, :, i - 1 :: -1]
    return filters


def autocovariances(filters: Array, power: Array, lags: int) -> Array:
    """Autocovariances (c, lags) at lags 0, 1, … of autoregressions with innovations `power`."""
    length = transform_length(lags)
    response = np.fft.rfft(filters, length, axis=-1)
    spectrum = power[:, None] / (response.real**2 + response.imag**2)
    return np.fft.irfft(spectrum, length, axis=-1)[:, :lags]


def transform_length(lags: int) -> int:
    """Length of the transform that gives autocovariances at so many lags without aliasing."""
    return 1 << int(4 * lags - 1).bit_length()
