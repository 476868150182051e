"""The instants of the orders, from the record of the rudder or of the revolutions."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE
from pmmkit.signals import white_noise

LOW: Final = 0.2
HIGH: Final = 0.7
BEGUN: Final = 0.03
"""Share of the way from which a control is under way, where it gets there within a sample."""
EASED: Final = 0.7
"""A rudder below this share of the ordered angle is no longer held."""
LASTING: Final = 3
LASTING_TIME: Final = 1.0
"""Samples and seconds that a control must stay beyond a level."""
FLAT: Final = 0.2
"""The median of a rudder that is held lies so near the ordered angle, as a share of it."""
TRAVERSES: Final = 3.0
"""Times that a rudder on its way from side to side may take of the shortest such way."""
LINGERS: Final = 2.0
"""Times that a rudder on its ramp may take for its first half of that for its second."""


@dataclass(frozen=True)
class Order:
    """An order.

    `std`: standard uncertainty of that [s]. `level`: what was reached: rudder angle [rad] or
    revolutions [1/s]. `rate`: at which the control moved [1/s of its unit]; infinite where it
    was there at once.
    """

    t: float
    std: float
    level: float
    rate: float = math.inf


def rudder_orders(t: Array, delta: Array, nominal: float, *, single: bool = False) -> list[Order]:
    """When the rudder was ordered to each new side, from its angle.

    The rudder moves at a steady rate: the line through 20 and 70 % of the way is followed back to
    where the way begins. Executes follow one another without a rest amidships, so that rudder
    that kept the course before a zigzag is none of them.

    t, delta [s].

    Examples
    --------
    >>> t = np.arange(0.0, 60.0)
    >>> delta = np.radians(np.clip(2.5 * (t - 20.0), 0.0, 35.0))
    >>> [round(order.t, 2) for order in rudder_orders(t, delta, np.radians(35))]
    [20.0]
    """
    size = abs(nominal)
    most = float(np.abs(delta).max())
    if most < 0.5 * size:
        raise DataError(
            f"The rudder angle reaches {math.degrees(most):.1f}°, ordered were "
            f"{math.degrees(size):.1f}°. Check the column delta, its unit, and rudder_deg."
        )
    size = float(np.median(np.abs(delta)[np.abs(delta) > 0.6 * min(size, most)]))
    side = np.where(delta > 0.5 * size, 1, np.where(delta < -0.5 * size, -1, 0))
    runs = _held(t, delta, side, size)
    if single and runs:
        runs = [max(runs, key=lambda item: float(t[item[1] - 1] - t[item[0]]))]
    elif runs:
        runs = _longest_chain(t, runs)
    noise = white_noise(delta)
    orders: list[Order] = []
    state, rest = 0, 0.0
    for start, _, value in runs:
        if value == state:
            continue
        if state == 0:
            if start == 0:
                raise DataError(
                    "The record begins with the rudder over, so the instant of the order does not "
                    "show. Give it: order under [trial], or --order."
                )
            began = _back(t, delta, start, 0.0, value * size, noise).t
            quiet = delta[t < began - float(np.median(np.diff(t)))]
            rest = float(np.median(quiet)) if len(quiet) >= LASTING else 0.0
            rest = 0.0 if abs(rest) > 0.3 * size else rest
        origin = rest if state == 0 else state * size
        orders.append(_back(t, delta, start, origin, value * size, noise))
        state = value
    if not orders:
        raise DataError("The rudder never stays over. Check the column delta.")
    return orders


def _held(
    t: Array, delta: Array, side: NDArray[np.int64], size: float
) -> list[tuple[int, int, int]]:
    """First index, index past the last, and side of each stretch in which the rudder is held."""
    edges = np.concatenate(([0], np.flatnonzero(np.diff(side)) + 1, [len(side)])).tolist()
    least = LASTING_TIME - 1e-9
    return [
        (start, stop, int(side[start]))
        for start, stop in itertools.pairwise(edges)
        if side[start]
        and stop - start >= LASTING
        and t[stop - 1] - t[start] >= least
        and abs(float(np.median(np.abs(delta[start:stop]))) / size - 1.0) < FLAT
    ]


def _longest_chain(t: Array, runs: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """The most stretches that follow each other from side to side without a rest between."""
    ways = [float(t[after[0]] - t[before[1] - 1]) for before, after in itertools.pairwise(runs)]
    across = [
        way
        for way, (before, after) in zip(ways, itertools.pairwise(runs), strict=True)
        if before[2] != after[2]
    ]
    most = TRAVERSES * min(across, default=0.0) + LASTING_TIME
    chains = [[runs[0]]]
    for way, run in zip(ways, runs[1:], strict=True):
        if way <= most:
            chains[-1].append(run)
        else:
            chains.append([run])
    return max(chains, key=len)


def _back(t: Array, values: Array, start: int, origin: float, goal: float, noise: float) -> Order:
    """The beginning of a ramp that is on its way at an index."""
    share = (values - origin) / (goal - origin)
    low = start
    while low > 0 and share[low - 1] >= LOW:
        low -= 1
    high = low
    while high < len(share) - 1 and share[high] < HIGH:
        high += 1
    step = float(np.median(np.diff(t)))
    before = _rested(t, values, share, (low, start), step)
    if before is not None and abs(goal - before) > noise:
        return _back(t, values, start, before, goal, noise)
    t_low, t_high = _through(t, share, low, LOW), _through(t, share, high, HIGH)
    level = float(goal)
    if t_high - t_low < step:
        under_way = max(BEGUN, 4.0 * noise / abs(goal - origin))
        while low > 1 and min(share[low - 1], share[low - 1] - share[low - 2]) > under_way:
            low -= 1
        between = 0.5 * float(t[max(low - 1, 0)] + t[low])
        return Order(between, step / math.sqrt(12.0), level)
    began = t_low - LOW / (HIGH - LOW) * (t_high - t_low)
    rate = (HIGH - LOW) * abs(goal - origin) / (t_high - t_low)
    return Order(began, math.hypot(0.1 * step, 1.5 * noise / rate), level, rate)


def _rested(
    t: Array, values: Array, share: Array, span: tuple[int, int], step: float
) -> float | None:
    """Where a control stood before its ramp, if it lingered on what looks like the way."""
    low, start = span
    near = share[start]
    goal = start + int(np.argmax(share[start:] >= 0.5 * (1.0 + near)))
    ramp = max(float(t[goal] - t[start]), 0.0) * near / (1.0 - near) * 2.0 if near < 1.0 else 0.0
    lingered = float(t[start] - t[low])
    if lingered <= LINGERS * ramp + LASTING * step:
        return None
    waiting = (t >= t[low]) & (t < t[start] - ramp - step)
    return float(np.median(values[waiting])) if np.count_nonzero(waiting) >= LASTING else None


def _through(t: Array, share: Array, index: int, level: float) -> float:
    if index == 0 or share[index] == share[index - 1]:
        return float(t[index])
    part = (level - share[index - 1]) / (share[index] - share[index - 1])
    return float(t[index - 1] + np.clip(part, 0.0, 1.0) * (t[index] - t[index - 1]))


def held_until(t: Array, delta: Array, order: Order) -> float:
    """Last instant at which the rudder is still held after an order [s]."""
    over = delta * math.copysign(1.0, order.level) >= EASED * abs(order.level)
    reached = np.flatnonzero(over & (t > order.t))
    if not len(reached):
        return float(t[-1])
    eased = np.flatnonzero(~over[reached[0] :])
    lasting = [place for place in eased if not over[reached[0] + place :][:LASTING].any()]
    return float(t[reached[0] + lasting[0] - 1]) if lasting else float(t[-1])


def astern_order(t: Array, n: Array) -> Order:
    """When the engine was reversed, from the revolutions.

    t, n [s].

    Examples
    --------
    >>> t = np.arange(0.0, 60.0)
    >>> n = np.clip(1.5 - 0.1 * (t - 20.0), -0.9, 1.5)
    >>> round(astern_order(t, n).t, 2)
    20.0
    """
    ahead = float(np.median(n[: max(len(n) // 20, 5)]))
    if ahead <= 0 or float(n.min()) > 0.5 * ahead:
        raise DataError(
            "The revolutions do not fall to half of those of the approach, so the order astern "
            "does not show. Give its instant: order under [trial], or --order."
        )
    start = int(np.argmax(n < 0.5 * ahead))
    noise = white_noise(n)
    order = _back(t, n, start, ahead, 0.0, noise)
    begun = _first_fall(t, n[: start + 1], ahead, noise)
    return order if begun is None or abs(begun.t - order.t) < WIDE * order.std else begun


def _first_fall(t: Array, n: Array, ahead: float, noise: float) -> Order | None:
    """The beginning of a fall that slows down, as that of a shaft which the water drives on: by the
    line through its first tenths, or between the samples that hold them. None where the record
    begins with it."""
    gone = 1.0 - n / ahead
    least = max(BEGUN, WIDE * noise / ahead)
    still = np.flatnonzero(gone < least)
    first = int(still[-1]) + 1 if len(still) else 0
    last = first + int(np.argmax(gone[first:] >= least + LOW))
    if first == 0:
        return None
    step = float(t[first] - t[first - 1])
    if last - first < LASTING:
        return Order(float(t[first]) - 0.5 * step, step / math.sqrt(12.0), 0.0)
    t_first, t_last = _through(t, gone, first, least), _through(t, gone, last, least + LOW)
    began = t_first - least / LOW * (t_last - t_first)
    return Order(began, 0.5 * (t_first - began), 0.0, LOW * ahead / (t_last - t_first))
