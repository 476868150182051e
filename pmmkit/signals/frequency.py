"""The frequency of an oscillating record, from the record itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.signals.fourier import design_matrix
from pmmkit.signals.noise import as_record, mean_noise
from pmmkit.signals.periodic import TURN

ORDER: Final = 3
A_CYCLE: Final = 64
"""Samples a cycle that the record is condensed to."""
LEAST_A_CYCLE: Final = 2 * ORDER + 2
"""Samples a cycle from which its harmonics are columns of their own, a quarter above it too."""
RANGE: Final = 0.25
"""How far from the nominal frequency is looked, as a fraction of it."""
STEPS: Final = 30
"""Gauss-Newton steps at most."""
NEAR: Final = 1e-3
"""Length of the last step, over the standard uncertainty that white noise would leave."""
SIGNIFICANT: Final = 25.0
"""Variance ratio below which a record is held not to oscillate at the frequency."""


def estimate_frequency(t: ArrayLike, y: ArrayLike, omega: float) -> tuple[float, float]:
    """Angular frequency of the record near the nominal one, and its standard uncertainty.

    Parameters
    ----------
    t : (n,) array
        Time, increasing; steps may differ [s].
    y : (c, n) array
        Channels that share one frequency; each counts by how well it is explained. Leave out
        transient parts.
    omega : float
        Nominal angular frequency [rad/s].

    Returns
    -------
    omega, std : float
        [rad/s]. The record disagrees with the nominal frequency where they differ by several
        std. A record that does not oscillate within a quarter of the nominal frequency, or has
        fewer than eight samples a cycle, gives the nominal frequency with an infinite std.

    Raises
    ------
    DataError
        If the frequency is not positive, if the record covers less than a cycle and a half, or
        if it is damaged.

    Notes
    -----
    Least squares of a Fourier series of order 3 in time and frequency. The middle four cycles
    are searched on a grid, the part is then doubled until it is the whole record, with
    Gauss-Newton steps at each length, so that the estimate cannot jump to a side lobe. The
    variance is that of the sum of the products of residual and sensitivity, taken as an
    autocorrelated record of their own; noise common to several channels is counted in full.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 60.0, 0.05)
    >>> y = 3.0 * np.cos(0.512 * t) + 0.4 * np.sin(3 * 0.512 * t)
    >>> found, std = estimate_frequency(t, y, 0.5)
    >>> round(found, 9), std < 1e-9
    (0.512, True)
    """
    time, values = as_record(t, y, least=4 * ORDER + 4)
    if not (math.isfinite(omega) and omega > 0.0):
        raise DataError(f"The nominal frequency is {omega} rad/s: it must be positive.")
    covered = (time[-1] - time[0]) * omega / TURN
    if covered < 1.5:
        raise DataError(
            f"The record covers {covered:.2f} nominal cycles: its frequency cannot be told from "
            "less than one and a half."
        )
    if omega * float(np.median(np.diff(time))) > TURN / LEAST_A_CYCLE:
        return float(omega), math.inf
    time, values = _condensed(time, values, covered)
    values = values - values.mean(axis=-1, keepdims=True)
    spread = np.sqrt(np.mean(values**2, axis=-1, keepdims=True))
    changes = spread[:, 0] > 0.0
    values = values[changes] / spread[changes]
    if not values.size:
        return float(omega), math.inf
    time = time - 0.5 * (time[0] + time[-1])
    length = min(4.0, covered)
    found = _searched(*_middle(time, values, length * TURN / omega), omega)
    while length < covered:
        length = min(2.0 * length, covered)
        found = _refined(*_middle(time, values, length * TURN / omega), found).omega
    last = _refined(time, values, found)
    found, std, ratio = last.omega, last.std, last.ratio
    if ratio < SIGNIFICANT or abs(found - omega) > 1.2 * RANGE * omega:
        return float(omega), math.inf
    return found, std


def _condensed(time: Array, values: Array, covered: float) -> tuple[Array, Array]:
    """Means of as many neighbouring samples as leave about 64 a cycle."""
    size = max(1, int(time.size / (A_CYCLE * covered)))
    m = time.size // size
    keep = slice(0, m * size)
    parts = values[:, keep].reshape(values.shape[0], m, size)
    return time[keep].reshape(m, size).mean(axis=-1), parts.mean(axis=-1)


def _middle(time: Array, values: Array, length: float) -> tuple[Array, Array]:
    near = np.abs(time) <= 0.5 * length * (1.0 + 1e-9)
    return time[near], values[:, near]


def _searched(time: Array, values: Array, omega: float) -> float:
    """The best frequency of a grid, refined."""
    covered = (time[-1] - time[0]) * omega / TURN
    points = 2 * math.ceil(RANGE * covered / 0.1) + 1
    tried = omega * np.linspace(1.0 - RANGE, 1.0 + RANGE, points)
    rows = design_matrix(np.outer(tried, time).ravel(), ORDER).T
    rows = rows.reshape(-1, points, time.size).swapaxes(0, 1)
    turned = np.swapaxes(rows, 1, 2)
    seen = values @ turned
    gram = rows @ turned
    explained = np.sum(seen * np.swapaxes(np.linalg.solve(gram, np.swapaxes(seen, 1, 2)), 1, 2), -1)
    rest = np.sum(values**2, axis=-1) - explained
    left = np.sum(np.log(np.maximum(rest, 1e-12 * time.size)), axis=-1)
    return _refined(time, values, float(tried[int(np.argmin(left))])).omega


@dataclass(frozen=True, kw_only=True, eq=False)
class _Refined:
    """Where Gauss-Newton steps in frequency end.

    `score`: products of residual and sensitivity, whose sum vanishes there. `information`:
    minus the derivative of that sum. `ratio`: what is explained over what is not, per degree of
    freedom.
    """

    omega: float
    score: Array
    information: float
    ratio: float

    @property
    def std(self) -> float:
        """Standard uncertainty of the frequency; the score is an autocorrelated record."""
        if self.information <= 0.0:
            return math.inf
        noise, _ = mean_noise(self.score[None, :])
        found = math.sqrt(float(noise[0])) * self.score.size / self.information
        return max(found, 1e-15 * self.omega)


def _refined(time: Array, values: Array, omega: float) -> _Refined:
    """Gauss-Newton steps in frequency."""
    n = np.arange(1, ORDER + 1)
    limit = 0.3 * TURN / (time[-1] - time[0])
    square = np.mean(values**2, axis=-1)
    ratio = 0.0
    for _ in range(STEPS):
        rows = design_matrix(omega * time, ORDER).T
        inverse = np.linalg.inv(rows @ rows.T)
        fitted = values @ rows.T @ inverse
        rest = values - fitted @ rows
        turned = np.zeros_like(fitted)
        turned[:, 1::2] = n * fitted[:, 2::2]
        turned[:, 2::2] = -n * fitted[:, 1::2]
        slope = time * (turned @ rows)
        slope = slope - slope @ rows.T @ inverse @ rows
        variance = np.mean(rest**2, axis=-1, keepdims=True) + 1e-24
        score = np.sum(slope * rest / variance, axis=0)
        information = float(np.sum(slope**2 / variance))
        if information <= 0.0:
            break
        step = float(np.clip(score.sum() / information, -limit, limit))
        omega += step
        explained = np.max(square / variance[:, 0] - 1.0)
        ratio = float(explained) * (time.size - 2 * ORDER - 1) / (2 * ORDER)
        if abs(step) < 1e-14 * omega + NEAR / math.sqrt(information):
            break
    return _Refined(omega=omega, score=score, information=information, ratio=ratio)
