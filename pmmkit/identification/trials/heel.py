"""Heel of a turning circle: the largest, and that of the steady turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.identification.local_fits import local
from pmmkit.numerics import Array

SMOOTH: Final = 0.05
"""Half of the window in which heel is smoothed, in ship lengths over the speed."""
SETTLED: Final = math.pi
"""Change of heading from which a turn counts as steady."""
LEAST: Final = math.pi / 2.0
"""Change of heading over which the steady heel is averaged at least."""
LISTED: Final = math.radians(0.5)
"""Heel of the approach that is said."""


@dataclass(frozen=True, kw_only=True)
class Heel:
    """Heel of a turning circle [rad].

    `upright`: mean of the approach, positive to starboard, from which the others count: a list,
    or the zero of the instrument. `largest, largest_std`: either way; its uncertainty is that
    of the noise, waves are part of it. `steady, steady_std`: outwards; NaN where the turn is
    too short.
    """

    upright: float
    largest: float
    largest_std: float
    steady: float
    steady_std: float

    @property
    def words(self) -> str:
        """The heel of the approach, if it is worth a word."""
        if abs(self.upright) < LISTED:
            return ""
        side = "starboard" if self.upright > 0.0 else "port"
        return (
            f"The ship heels by {math.degrees(abs(self.upright)):.1f}° to {side} in the approach; "
            "heel counts from there."
        )


def heel_of_turn(
    t: Array, phi: Array, psi: Array, *, order: float, until: float, side: float, pace: float
) -> Heel | None:
    """Heel of a turning circle; None where too little of it was recorded.

    t, phi, psi [s]; order, until [s]; pace [s].

    Notes
    -----
    The largest heel is that of parabolas through the samples about each; the steady one a mean from
    half a turn on, with the scatter of means over a ship length and half of what it still changes
    by. Without an approach heel counts from zero.
    """
    known = np.isfinite(phi)
    t, phi, psi = t[known], phi[known], psi[known]
    before, turning = t < order, (t >= order) & (t <= until)
    if np.count_nonzero(turning) < 10:
        return None
    upright = float(phi[before].mean()) if np.count_nonzero(before) >= 5 else 0.0
    heel, own = phi[turning] - upright, t[turning]
    found = local(own, heel, own, SMOOTH * pace)
    most = int(np.argmax(np.abs(found.value)))
    # Third differences hold the noise alone: 20 is the sum of their squared weights.
    noise = math.sqrt(float(np.mean(np.diff(heel, 3) ** 2)) / 20.0)
    turned = side * (psi[turning] - np.interp(order, t, psi))
    late = turned >= SETTLED
    steady, std = math.nan, math.nan
    if late.any() and turned[late].max() - turned[late].min() >= LEAST:
        steady = -side * float(heel[late].mean())
        block = ((own[late] - own[late][0]) / pace).astype(int)
        means = np.bincount(block, heel[late]) / np.maximum(np.bincount(block), 1)
        means = means[np.bincount(block) > 0]
        if len(means) > 1:
            # What the heel still changes by is no noise, and does not go down with the blocks.
            half = len(means) // 2
            change = float(means[half:].mean() - means[:half].mean())
            std = math.hypot(float(means.std(ddof=1)) / math.sqrt(len(means)), 0.5 * change)
    return Heel(
        upright=upright,
        largest=abs(float(found.value[most])),
        largest_std=noise * math.sqrt(found.leverage[most]),
        steady=steady,
        steady_std=std,
    )
