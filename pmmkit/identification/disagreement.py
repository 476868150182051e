"""Records whose sensors disagree: positions that are not where heading and velocities lead."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.identification.record import sensors_of
from pmmkit.identification.smoother import Smoothed
from pmmkit.models import Model
from pmmkit.numerics import Array

DISAGREE: Final = 0.02
"""Share of measurements that a smoother leaves out from which its sensors disagree. Of records of a
virtual tank it left out none in wind, with any effect of the ship and with a late clock, and 7 to
40 % in a current, with a log 3 % off, a heading 1° off and an antenna .1 L off."""
LINE: Final = 0.5
"""Length of the lines by which a sensor alone is smoothed, in ship lengths over the speed."""


def disagree(item: Smoothed) -> bool:
    """Whether some sensors of a record say another motion than the others."""
    count = sum(int(np.isfinite(x).sum()) for x in item.record.measured.values())
    return item.gated > DISAGREE * count


def each_by_itself(item: Smoothed, model: Model, sensors: Mapping[str, float]) -> Smoothed:
    """A record that shows in each channel what its own sensor does.

    One motion cannot be that of all sensors: smoothed together some of them are left out, and a
    model that fails there would look right.
    """
    noise = sensors_of([item.record], sensors)
    length = LINE * model.ship.L / item.record.speed
    motion, std, covariance = dict(item.motion), dict(item.motion_std), item.covariance.copy()
    for place, name in enumerate(item.motion_std):
        if name not in item.record.measured:
            continue
        left, share = local_lines(item.t, item.record.measured[name] - motion[name], length)
        motion[name] = motion[name] + left
        own = noise[name] ** 2 * share
        std[name] = np.sqrt(std[name] ** 2 + own)
        covariance[:, place, place] += own
    return replace(
        item,
        motion=MappingProxyType(motion),
        motion_std=MappingProxyType(std),
        covariance=covariance,
    )


def local_lines(t: Array, values: Array, length: float) -> tuple[Array, Array]:
    """Values of straight lines through those nearby, and their variance over that of a value.

    Examples
    --------
    >>> t = np.arange(0.0, 10.0, 0.1)
    >>> lines, share = local_lines(t, 2.0 * t, 1.0)
    >>> bool(np.allclose(lines, 2.0 * t)), round(1.0 / share[50])
    (True, 11)
    """
    there = np.isfinite(values)
    if there.sum() < 2:
        return np.zeros(len(t)), np.zeros(len(t))
    at, x = t[there] - t[0], values[there]
    low = np.searchsorted(at, at - 0.5 * length - 1e-9)
    high = np.searchsorted(at, at + 0.5 * length + 1e-9)
    # A line needs two values, wherever its neighbours are.
    low = np.minimum(low, np.maximum(np.arange(len(at)) - 1, 0))
    high = np.maximum(high, np.minimum(np.arange(len(at)) + 2, len(at)))

    def sums(of: Array) -> Array:
        whole = np.concatenate([[0.0], np.cumsum(of)])
        found: Array = whole[high] - whole[low]
        return found

    count = sums(np.ones(len(at)))
    t_mean, x_mean = sums(at) / count, sums(x) / count
    spread = sums(at**2) / count - t_mean**2
    away = at - t_mean
    slope = (sums(at * x) / count - t_mean * x_mean) / spread
    share = (1.0 + away**2 / spread) / count
    return np.interp(t - t[0], at, x_mean + slope * away), np.interp(t - t[0], at, share)
