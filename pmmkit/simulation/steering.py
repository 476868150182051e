"""The rudder angle over time, in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

RudderLaw = Literal["ramp", "lag"]


@dataclass(frozen=True, kw_only=True)
class RudderOrder:
    """A rudder order at t = 0, from amidships.

    Parameters
    ----------
    order : float
        Ordered angle [rad], positive turns the ship to starboard.
    rate : float
        Largest rate of the steering gear [rad/s].
    law : {"ramp", "lag"}
        ``ramp``: at the rate until the order is reached. ``lag``: dδ/dt = (order - δ)/lag, at
        most the rate; so at the rate until the error is rate times lag, then exponential.
    lag : float
        Time constant of the lag law [s].
    """

    order: float
    rate: float
    law: RudderLaw = "ramp"
    lag: float = 1.0

    @property
    def corners(self) -> tuple[float, ...]:
        """Instants at which the rate of the rudder jumps or bends [s]."""
        ramped = abs(self.order) - (self.rate * self.lag if self.law == "lag" else 0.0)
        return (ramped / self.rate,) if ramped > 0.0 else ()

    def angle(self, t: float) -> float:
        """Rudder angle at an instant [rad].

        Examples
        --------
        >>> gear = RudderOrder(order=0.6, rate=0.1)
        >>> gear.angle(2.0), gear.angle(9.0)
        (0.2, 0.6)
        """
        size = abs(self.order)
        if self.law == "ramp":
            return math.copysign(min(self.rate * t, size), self.order)
        corner = self.corners[0] if self.corners else 0.0
        if t <= corner:
            return math.copysign(self.rate * t, self.order)
        rest = (size - self.rate * corner) * math.exp(-(t - corner) / self.lag)
        return math.copysign(size - rest, self.order)
