"""What is around a trial: the wind, and the noise of the fixes where no circle shows it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from pmmkit.campaigns.over_ground import true_wind, velocity
from pmmkit.signals.noise import white_noise
from pmmkit.trials.circle import Circle
from pmmkit.trials.noise import PositionNoise
from pmmkit.trials.record import Record
from pmmkit.trials.table import Wind

SLOW_TIME: Final = 100.0
"""Correlation time of a stated uncertainty of the fixes [s]."""


def noise_of(
    record: Record, circles: Sequence[Circle], stated: float | None, notes: list[str]
) -> PositionNoise:
    """Noise of the fixes of a run that is no fitted circle: as stated, or that of the circles.

    Parameters
    ----------
    record : Record
        Of the run.
    circles : sequence of Circle
        Fitted turning circles of the same trial.
    stated : float or None
        Standard uncertainty of a fix [m].
    notes : list of str
        Gets what the uncertainty then lacks.
    """
    fast = math.sqrt(0.5 * (white_noise(record.x) ** 2 + white_noise(record.y) ** 2))
    if stated is not None:
        slow = math.sqrt(max(stated**2 - fast**2, 0.0))
        return PositionNoise(fast=min(fast, stated), slow=slow, time=SLOW_TIME, origin="as stated")
    if circles:
        known = [item.noise for item in circles]
        return PositionNoise(
            fast=max(fast, math.sqrt(float(np.mean([item.fast**2 for item in known])))),
            slow=math.sqrt(float(np.mean([item.slow**2 for item in known]))),
            time=float(np.mean([item.time for item in known])),
            origin="what the fitted circles leave",
        )
    notes.append(
        "The uncertainty holds the noise from fix to fix, not a drift of the fixes: state "
        "position_std under [trial] for that."
    )
    return PositionNoise(fast=fast, origin="what changes from fix to fix")


def mean_wind(record: Record, half: float) -> Wind | None:
    """Mean true wind from the relative one, the heading and the velocity over ground.

    Parameters
    ----------
    record : Record
        With wind_speed and wind_direction; None without.
    half : float
        Half of the window in which places are smoothed [s].
    """
    felt = [record.others.get(name) for name in ("wind_speed", "wind_direction")]
    if felt[0] is None or felt[1] is None:
        return None
    north, east = velocity(record.t, record.x, record.y, record.t, half)
    speed, direction = true_wind(record.psi, felt[0], felt[1], north, east)
    mean = np.nanmean(speed * np.exp(1j * direction))
    return Wind(
        speed=float(np.abs(mean)),
        direction_deg=math.degrees(np.angle(mean)) % 360.0,
        spread=float(np.nanstd(speed)),
    )
