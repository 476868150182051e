"""The path of a trial in axes of its approach, with and without the current."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import DataError
from pmmkit.campaigns import Attitude
from pmmkit.identification.local_fits import half_window, local, velocity
from pmmkit.identification.trials.current import Current
from pmmkit.identification.trials.orders import Order
from pmmkit.identification.trials.record import GAP, Record
from pmmkit.numerics import Array
from pmmkit.signals import white_noise

# Noise of satellite positions: a part that changes from fix to fix and a part that drifts.


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


MOST: Final = 200
"""Fixes of which the covariance is taken."""


def straight_line(t: Array, values: Array, noise: PositionNoise) -> tuple[float, float]:
    """Slope of a coordinate over time and its standard uncertainty under correlated noise.

    t, values [s].

    Examples
    --------
    >>> t = np.arange(20.0)
    >>> slope, std = straight_line(t, 3.0 * t, PositionNoise(fast=1.0))
    >>> round(slope, 9), round(std, 4)
    (3.0, 0.0388)
    """
    at = np.unique(np.linspace(0, len(t) - 1, min(len(t), MOST)).astype(int))
    centred = t - t.mean()
    slope = float(centred @ values) / float(centred @ centred)
    some = t[at] - t[at].mean()
    weight = some / float(some @ some)
    thinned = PositionNoise(
        fast=noise.fast * np.sqrt(len(at) / len(t)), slow=noise.slow, time=noise.time
    )
    return slope, float(np.sqrt(weight @ thinned.covariance(t[at]) @ weight))


APPROACH: Final = 2.0
"""Ship lengths of the approach that its heading and speed are taken from."""
MINUTE: Final = 60.0
"""Least seconds of it for a ship of 100 m or more; for a model its own seconds by Froude's law."""
UNSTEADY: Final = 0.1
"""Share by which the speed of the second half of an approach may differ from that of the first."""
SHORTEST: Final = 0.25
"""Ship lengths below which an approach is not made shorter."""
AT_THE_END: Final = 4.0
"""Error of a parabola's slope at its end over that of a straight line, for even white noise."""
FEW: Final = 5


@dataclass(frozen=True, kw_only=True)
class Approach:
    """The run before the order.

    `heading, heading_std`: mean heading on the record's axes and its standard uncertainty
    [rad]. `speed, speed_std`: through the water as far as the current is known [m/s].
    `measured`: false where the record begins too late and the stated speed is taken. `seconds`:
    how long before the order it was watched. `steady`: whether the speed was the same all that
    time; else only its end is taken.
    """

    heading: float
    heading_std: float
    speed: float
    speed_std: float
    measured: bool
    seconds: float
    steady: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialPath:
    """A path from the order on: origin where midship was then, x along the approach.

    `t, x, y, psi`: time from the order, place without the current, heading from that of the
    approach. `x_ground, y_ground`: the place as measured. `approach`: the run before the order.
    `psi_noise`: standard deviation of a single heading [rad]. `half, step, grid`: half of the
    window of local fits, usual time between samples [s], spacing of the digits of the positions
    [m].
    """

    t: Array
    x: Array
    y: Array
    psi: Array
    x_ground: Array
    y_ground: Array
    approach: Approach
    current: Current | None
    noise: PositionNoise
    psi_noise: float
    half: float
    step: float
    grid: float
    L: float

    def place(self, at: float) -> tuple[float, float]:
        """Smoothed place at an instant [m]."""
        return (
            local(self.t, self.x, at, self.half).value,
            local(self.t, self.y, at, self.half).value,
        )

    def velocity(self, at: ArrayLike, half: float | None = None) -> tuple[Any, Any]:
        """Smoothed velocity through the water along and across the approach [m/s], at an instant
        or at several."""
        return velocity(self.t, self.x, self.y, at, self.half if half is None else 0.5 * half)

    def motion(self, phi: Array) -> tuple[Array, Array, Array]:
        """Surge, sway [m/s] and yaw rate [rad/s] through the water at all instants; heel that is
        not known counts as none."""
        heading = local(self.t, self.psi, self.t, self.half)
        u, v = Attitude(psi=heading.value, phi=np.nan_to_num(phi)).in_ship_axes(
            *self.velocity(self.t)
        )
        return u, v, heading.slope

    def variance(self, at: float, across: bool) -> float:
        """Variance of the way from the order along or across the approach [m²]."""
        here, there = (local(self.t, self.x, one, self.half) for one in (0.0, at))
        found = self.noise.of_difference(at, here.leverage + there.leverage) + self.grid**2 / 6.0
        if self.current is not None:
            heading = self.approach.heading + (0.5 * math.pi if across else 0.0)
            found += self.current.variance_along(heading) * at**2
        for one in (here, there):
            if one.gap > GAP * self.step:
                bend = abs(local(self.t, self.psi, at, max(self.half, one.gap)).slope)
                found += (bend * self.approach.speed * one.gap**2 / 16.0) ** 2
        return found

    def heading(self, at: float) -> tuple[float, float, float]:
        """Smoothed heading, its standard uncertainty [rad] and the yaw rate [rad/s]."""
        found = local(self.t, self.psi, at, self.half)
        return found.value, self.psi_noise * math.sqrt(found.leverage), found.slope


def path_of(
    record: Record,
    order: Order,
    *,
    L: float,
    speed: float,
    current: Current | None,
    noise: PositionNoise,
) -> TrialPath:
    """The path of a record from an order on.

    L, speed [m].
    """
    t = record.t
    if not t[0] - record.step <= order.t < t[-1]:
        raise DataError(
            f"The order at t = {order.t:.4g} s lies outside the record, {t[0]:.6g} to "
            f"{t[-1]:.6g} s. Check the instant of the order."
        )
    drift = (0.0, 0.0) if current is None else (current.x, current.y)
    psi_noise = white_noise(record.psi)
    approach = _approach(record, order, drift, L=L, speed=speed, current=current, noise=noise)
    heading = approach.heading
    half = half_window(t, L, speed)
    since = t - order.t
    ground = _turned(record.x, record.y, heading)
    water = _turned(record.x - drift[0] * since, record.y - drift[1] * since, heading)
    at = max(0.0, float(since[0]))
    zero = [local(since, part, at, half).value for part in water]
    return TrialPath(
        t=since,
        x=water[0] - zero[0],
        y=water[1] - zero[1],
        psi=record.psi - heading,
        x_ground=ground[0] - zero[0],
        y_ground=ground[1] - zero[1],
        approach=approach,
        current=current,
        noise=noise,
        psi_noise=psi_noise,
        half=half,
        step=record.step,
        grid=record.grid,
        L=L,
    )


def _approach(
    record: Record,
    order: Order,
    drift: tuple[float, float],
    *,
    L: float,
    speed: float,
    current: Current | None,
    noise: PositionNoise,
) -> Approach:
    """The run before an order, as far back as its speed is the same."""
    t = record.t
    whole = max(MINUTE * min(math.sqrt(L / 100.0), 1.0), APPROACH * L / speed)
    if np.count_nonzero((t <= order.t) & (t >= order.t - whole)) < FEW:
        return Approach(
            heading=float(np.mean(record.psi[: int(np.searchsorted(t, order.t)) + 2])),
            heading_std=white_noise(record.psi),
            speed=speed,
            speed_std=math.nan,
            measured=False,
            seconds=0.0,
            steady=True,
        )
    seconds = min(whole, order.t - float(t[0]))
    while _changes(record, order.t, seconds, drift) and 0.5 * seconds > SHORTEST * L / speed:
        seconds *= 0.5
    before = (t <= order.t) & (t >= order.t - seconds)
    some = record.psi[before]
    heading = float(np.mean(some))
    (vx, sx), (vy, sy) = (
        straight_line(t[before], part[before], noise) for part in (record.x, record.y)
    )
    steady = not _changes(record, order.t, whole, drift)
    if not steady:
        since = t[before] - order.t
        vx, vy = (
            float(np.polynomial.Polynomial.fit(since, part[before], 2).deriv()(0.0))
            for part in (record.x, record.y)
        )
        sx, sy = AT_THE_END * sx, AT_THE_END * sy
    drift_variance = 0.0 if current is None else current.variance_along(heading)
    return Approach(
        heading=heading,
        heading_std=float(np.std(some)) / math.sqrt(max(len(some) / 10.0, 1.0)),
        speed=math.hypot(vx - drift[0], vy - drift[1]),
        speed_std=math.sqrt(0.5 * (sx**2 + sy**2) + drift_variance),
        measured=True,
        seconds=seconds,
        steady=steady,
    )


def _changes(record: Record, at: float, seconds: float, drift: tuple[float, float]) -> bool:
    """Whether the mean speed through the water changes in the seconds before an instant."""
    edges = np.searchsorted(record.t, (at - seconds, at - 0.5 * seconds, at), side="right") - 1
    first, middle, last = np.clip(edges, 0, None).tolist()
    if min(middle - first, last - middle) < FEW:
        return False

    def pace(begin: int, end: int) -> float:
        way = float(record.t[end] - record.t[begin])
        return math.hypot(
            (record.x[end] - record.x[begin]) / way - drift[0],
            (record.y[end] - record.y[begin]) / way - drift[1],
        )

    early, late = pace(first, middle), pace(middle, last)
    return abs(late - early) > UNSTEADY * late


def _turned(x: Array, y: Array, heading: float) -> tuple[Array, Array]:
    cos, sin = math.cos(heading), math.sin(heading)
    return x * cos + y * sin, y * cos - x * sin
