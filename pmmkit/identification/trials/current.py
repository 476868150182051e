"""A uniform current, and the mean of what several turning circles give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class Current:
    """A uniform current.

    `x, y`: velocity along the axes of the record, north and east where it holds latitudes
    [m/s]. `covariance`: variances of x and of y, and their covariance [m²/s²]. `origin`: where
    it comes from.
    """

    x: float
    y: float
    covariance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    origin: str = ""

    @property
    def speed(self) -> float:
        """Speed [m/s]."""
        return math.hypot(self.x, self.y)

    @property
    def direction_deg(self) -> float:
        """Direction it flows to, from the x axis (north) towards y (east), 0 to 360 [deg]."""
        return math.degrees(math.atan2(self.y, self.x)) % 360.0

    @property
    def std(self) -> tuple[float, float]:
        """Standard uncertainties of x and y [m/s]."""
        return math.sqrt(self.covariance[0]), math.sqrt(self.covariance[1])

    @property
    def speed_std(self) -> float:
        """Standard uncertainty of the speed [m/s]; of a weak current that of its stronger part."""
        if self.speed <= max(self.std):
            return max(self.std)
        return math.sqrt(self.variance_along(math.radians(self.direction_deg)))

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "x": self.x,
            "y": self.y,
            "std_x": self.std[0],
            "std_y": self.std[1],
            "speed": self.speed,
            "direction_deg": self.direction_deg,
            "origin": self.origin,
        }

    def variance_along(self, heading: float) -> float:
        """Variance of the component along a heading [m²/s²]."""
        cos, sin = math.cos(heading), math.sin(heading)
        xx, yy, xy = self.covariance
        return max(cos * cos * xx + sin * sin * yy + 2 * cos * sin * xy, 0.0)


def mean_current(found: Mapping[str, Current]) -> Current | None:
    """Weighted mean of the circles' currents in north and east; their scatter counts too."""
    if not found:
        return None
    values = np.array([(item.x, item.y) for item in found.values()])
    information = [np.linalg.inv(_matrix(item)) for item in found.values()]
    covariance = np.linalg.inv(np.sum(information, axis=0))
    mean = covariance @ np.sum(
        [one @ value for one, value in zip(information, values, strict=True)], axis=0
    )
    if len(found) > 1:
        rest = values - mean
        covariance = covariance + rest.T @ rest / len(found)
    return Current(
        x=float(mean[0]),
        y=float(mean[1]),
        covariance=(float(covariance[0, 0]), float(covariance[1, 1]), float(covariance[0, 1])),
        origin=f"turning circle{'s' if len(found) > 1 else ''} {', '.join(found)}",
    )


def _matrix(current: Current) -> Array:
    xx, yy, xy = current.covariance
    return np.array([[xx + 1e-12, xy], [xy, yy + 1e-12]])
