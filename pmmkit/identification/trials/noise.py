"""Noise of satellite positions: a part that changes from fix to fix and a part that drifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class PositionNoise:
    """Noise of one coordinate of the fixes.

    `fast`: standard deviation of what differs from fix to fix, rounding included [m]. `slow`:
    standard deviation of what drifts [m]. `time`: correlation time of the drift: it is
    exp(-Δt/time) [s]. `origin`: where the numbers come from.
    """

    fast: float
    slow: float = 0.0
    time: float = 1.0
    origin: str = ""

    def of_difference(self, apart: float, leverage: float = 1.0) -> float:
        """Variance of the way between two places so many seconds apart [m²].

        Examples
        --------
        >>> PositionNoise(fast=1.0, slow=2.0, time=10.0).of_difference(1000.0, leverage=2.0)
        10.0
        """
        drift = 2.0 * self.slow**2 * (1.0 - np.exp(-abs(apart) / self.time))
        return float(drift + self.fast**2 * leverage)

    def covariance(self, t: Array) -> Array:
        """Covariance of fixes at some times [m²]."""
        apart = np.abs(t[:, None] - t)
        matrix: Array = self.slow**2 * np.exp(-apart / self.time) + self.fast**2 * np.eye(len(t))
        return matrix


def straight_line(
    t: Array, values: Array, noise: PositionNoise, most: int = 200
) -> tuple[float, float]:
    """Slope of a coordinate over time and its standard uncertainty under correlated noise.

    t, values [s].

    Examples
    --------
    >>> t = np.arange(20.0)
    >>> slope, std = straight_line(t, 3.0 * t, PositionNoise(fast=1.0))
    >>> round(slope, 9), round(std, 4)
    (3.0, 0.0388)
    """
    at = np.unique(np.linspace(0, len(t) - 1, min(len(t), most)).astype(int))
    centred = t - t.mean()
    slope = float(centred @ values) / float(centred @ centred)
    some = t[at] - t[at].mean()
    weight = some / float(some @ some)
    thinned = PositionNoise(
        fast=noise.fast * np.sqrt(len(at) / len(t)), slow=noise.slow, time=noise.time
    )
    return slope, float(np.sqrt(weight @ thinned.covariance(t[at]) @ weight))
