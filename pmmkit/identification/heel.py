"""The measured heel as an input: what is left of it and of its rates without the noise."""

from __future__ import annotations

from typing import Final

import numpy as np

from pmmkit.numerics import Array

WIDTHS: Final = (5, 7, 9, 13, 17, 25, 33, 49, 65, 97, 129, 193, 257, 385)
"""Numbers of instants over which cubics are tried."""
ORDER: Final = 3


def measured_roll(t: Array, phi: Array, p: Array | None = None) -> tuple[Array, Array, Array]:
    """Heel and its rates as inputs of a ship that does not roll by itself.

    Parameters
    ----------
    t : array (n,)
        Instants [s], ascending.
    phi : array (n,)
        Measured heel [rad], without gaps.
    p : array (n,), optional
        Measured roll rate [rad/s]; by default the slope of the heel.

    Returns
    -------
    array (n,), array (n,), array (n,)
        Heel [rad], roll rate [rad/s] and the rate of that [rad/s²].

    Notes
    -----
    Cubics through a sliding window (Savitzky and Golay 1964). Its width is that of the least
    generalised cross-validation, mean square of the residuals over (1 - w)² with w the weight of
    an instant in its own value (Craven and Wahba 1979): a slow roll is smoothed over longer times
    than a fast one, and a heel without noise over five instants. Instants that are not equally
    spaced are looked at on a grid of as many that are.

    Examples
    --------
    >>> t = np.linspace(0.0, 100.0, 401)
    >>> truth = 0.1 * np.sin(0.3 * t)
    >>> noise = np.random.default_rng(0).normal(size=401)
    >>> roll, rate, gain = measured_roll(t, truth + 0.002 * noise)
    >>> bool(np.std(roll - truth) < 0.001), bool(np.std(rate - 0.03 * np.cos(0.3 * t)) < 0.001)
    (True, True)
    """
    even = np.linspace(t[0], t[-1], len(t))
    at = even if np.allclose(even, t, rtol=0.0, atol=1e-6 * (even[1] - even[0])) else t
    step = even[1] - even[0]
    smooth, rate, gain = _smoothed(np.interp(even, at, phi), step)
    if p is not None:
        rate, gain, _ = _smoothed(np.interp(even, at, p), step)
    return np.interp(at, even, smooth), np.interp(at, even, rate), np.interp(at, even, gain)


def _smoothed(values: Array, step: float) -> tuple[Array, Array, Array]:
    """Values at equal steps [s] without noise, their slopes, and the slopes of these."""
    from scipy.signal import savgol_coeffs, savgol_filter

    widths = [width for width in WIDTHS if width <= len(values)]
    if not widths:
        slope = np.gradient(values, step)
        return values, slope, np.gradient(slope, step)

    def left(width: int) -> float:
        own = savgol_coeffs(width, ORDER)[width // 2]
        away = values - savgol_filter(values, width, ORDER)
        return float(np.mean(away**2) / (1.0 - own) ** 2)

    best = min(widths, key=left)
    return (
        savgol_filter(values, best, ORDER),
        savgol_filter(values, best, ORDER, deriv=1, delta=step),
        savgol_filter(values, best, ORDER, deriv=2, delta=step),
    )
