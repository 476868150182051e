"""What surrounds a ship, as its equations take it: written in what Python and C share."""

from __future__ import annotations

import math


def flow(speed: float, direction: float) -> tuple[float, float]:
    """Velocity of a current north and east by its size and the direction it flows to.

    speed, direction [m/s].

    Examples
    --------
    >>> flow(2.0, 0.0)
    (2.0, 0.0)
    """
    return speed * math.cos(direction), speed * math.sin(direction)


def wind_over_current(
    speed: float, direction: float, north: float, east: float
) -> tuple[float, float]:
    """The wind as drifting water feels it: its speed [m/s] and where it comes from [rad].

    speed, direction [m/s]; north, east [m/s].

    Examples
    --------
    >>> wind_over_current(5.0, 0.0, 1.0, 0.0)[0]
    6.0
    """
    x = -speed * math.cos(direction) - north
    y = -speed * math.sin(direction) - east
    return math.hypot(x, y), math.atan2(-y, -x)
