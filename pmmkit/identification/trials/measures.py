"""Measures of turning circles, zigzags and stops out of their paths."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from pmmkit.campaigns import Attitude
from pmmkit.identification.local_fits import crossing, local, way_along
from pmmkit.identification.trials.circle import Circle
from pmmkit.identification.trials.orders import Order
from pmmkit.identification.trials.path import TrialPath, straight_line
from pmmkit.identification.trials.record import GAP
from pmmkit.identification.trials.table import Measures
from pmmkit.presentation import number

SHORTEST: Final = 0.15
"""Least way between two places of a path whose length is taken, in ship lengths."""


def of_turning(path: TrialPath, order: Order, circle: Circle | None, notes: list[str]) -> Measures:
    """Advance, transfer, tactical and steady diameter, times and loss of speed."""
    found = Measures(path.L)
    side = math.copysign(1.0, order.level)
    approach = path.approach
    instants: dict[float, tuple[float, float]] = {}
    for angle in (90.0, 180.0):
        level = math.radians(angle)
        at = crossing(path.t, side * path.psi, level, path.half, 0.0)
        if at is None:
            turned = math.degrees(float((side * path.psi[path.t >= 0]).max(initial=0.0)))
            notes.append(f"The heading changes by {turned:.0f}°, not by {angle:g}°.")
            instants[angle] = (math.nan, math.nan)
            continue
        _, psi_std, rate = path.heading(at)
        std = math.hypot(psi_std, approach.heading_std) / max(side * rate, 1e-6)
        gap = local(path.t, path.psi, at, path.half).gap
        if gap > GAP * path.step:
            std = math.hypot(std, 0.05 * gap)
            notes.append(f"The heading passes {angle:g}° within a gap of {gap:.4g} s.")
        instants[angle] = (at, std)

    def reach(angle: float, across: bool) -> tuple[float, float]:
        at, at_std = instants[angle]
        if math.isnan(at):
            return math.nan, math.nan
        place, pace = path.place(at), path.velocity(at)
        turned = place[0] if across else place[1]
        begun = 0.0 if across else order.std * approach.speed
        parts = (
            pace[across] * at_std,
            turned * approach.heading_std,
            begun,
            math.sqrt(path.variance(at, across)),
        )
        return (side if across else 1.0) * place[across], math.hypot(*parts)

    found.add("advance", *reach(90, across=False))
    found.add("transfer", *reach(90, across=True))
    found.add("tactical_diameter", *reach(180, across=True))
    if circle is not None:
        speed, rate = math.hypot(circle.u, circle.v), abs(circle.r)
        share = math.hypot(circle.speed_std / speed, circle.r_std / rate)
        found.add("steady_diameter", 2.0 * speed / rate, 2.0 * speed / rate * share)
        ratio = speed / approach.speed
        ratio_std = ratio * math.hypot(
            circle.speed_std / speed, np.nan_to_num(approach.speed_std) / approach.speed
        )
        drift = side * math.degrees(math.atan2(-circle.v, circle.u))
        found.add("steady_drift_deg", drift, math.degrees(circle.speed_std / speed))
        found.add("speed_ratio", ratio, ratio_std)
        found.add("speed_loss", 1.0 - ratio, ratio_std)
        found.add("steady_yaw_rate_deg_s", math.degrees(rate), math.degrees(circle.r_std))
    for angle, (at, std) in instants.items():
        found.add(f"time_{angle:g}", at, math.hypot(std, order.std))
    return found


_OFF: Final = 1.0
"""From how far a reversal of the rudder is told that is not where it was ordered [°]."""


def of_zigzag(
    path: TrialPath, orders: Sequence[Order], switch: float, notes: list[str]
) -> tuple[Measures, list[float]]:
    """Overshoots from the heading at each reversal, times, and the way to the first."""
    found = Measures(path.L)
    first = orders[0]
    headings: list[float] = []
    ends = [*(order.t - first.t for order in orders[1:]), float(path.t[-1])]
    if len(orders) < 2:
        notes.append("The rudder is never reversed: no overshoot.")
    zeros: list[float] = []
    for count, (begin, end) in enumerate(itertools.pairwise(ends), start=1):
        side = math.copysign(1.0, orders[count - 1].level)
        heading, std, rate = path.heading(begin)
        headings.append(side * math.degrees(heading))
        inside = np.flatnonzero((path.t >= begin) & (path.t <= end))
        peak = math.nan
        if len(inside) > 3:
            smooth = side * local(path.t, path.psi, path.t[inside], path.half).value
            top = int(np.argmax(smooth))
            if top < len(smooth) - 2 or count < len(ends) - 1:
                peak = float(smooth[top])
            else:
                notes.append(f"The record ends before the heading turns back (overshoot {count}).")
        over = math.degrees(peak - side * heading)
        spread = math.degrees(math.hypot(math.sqrt(2.0) * std, rate * orders[count].std))
        found.add(f"overshoot_{count}_deg", over, spread if math.isfinite(over) else math.nan)
        back = crossing(path.t, -side * path.psi, 0.0, path.half, begin)
        if back is not None:
            zeros.append(back)
    off = [value for value in headings if abs(value - math.degrees(switch)) > _OFF]
    if off:
        low, high = f"{min(off):.1f}", f"{max(off):.1f}"
        notes.append(
            f"The rudder is reversed at {low if low == high else f'{low} to {high}'}° of heading "
            f"({len(off)} of {len(headings)} times), not at {math.degrees(switch):g}°."
        )
    for count, order in enumerate(orders[1:], start=2):
        std = math.hypot(order.std, first.std)
        found.add(f"time_execute_{count}", order.t - first.t, std)
    if zeros:
        found.add("reach", zeros[0], math.hypot(first.std, path.step / 3.5))
    if len(zeros) > 2:
        found.add("period", zeros[2] - zeros[0], path.step / 2.5)
    side = math.copysign(1.0, first.level)
    at = crossing(path.t, side * path.psi, switch, path.half, 0.0)
    if at is not None:
        way = way_along(path.t, path.x, path.y, 0.0, at, max(at / 4.0, 4.0 * path.step))
        _, psi_std, rate = path.heading(at)
        late = math.hypot(psi_std, path.approach.heading_std) / max(side * rate, 1e-6)
        std = math.hypot(
            path.approach.speed * math.hypot(late, first.std),
            math.sqrt(path.variance(at, across=False)),
        )
        if abs(math.degrees(switch) - 10.0) < 0.5:
            found.add("initial_turning_distance", way, std)
        found.add("initial_turning_time", at, math.hypot(late, first.std))
    return found, headings


def of_stopping(path: TrialPath, order: Order, notes: list[str]) -> Measures:
    """Head reach, track reach, lateral deviation and time until the ship lies still."""
    found = Measures(path.L)
    half = max(3.0 * path.half, 10.0 * path.step)
    at = np.arange(half, float(path.t[-1]), path.step)
    heading = np.interp(at, path.t, path.psi)
    surge, _ = Attitude(psi=heading).in_ship_axes(*path.velocity(at, half))
    still = np.flatnonzero(surge <= 0.0)
    if not len(still):
        left = f"{number(surge[-1], 2)} m/s" if len(surge) else "way on"
        notes.append(f"The record ends before the ship stops: she still makes {left}.")
        for name in ("head_reach", "track_reach", "lateral_deviation"):
            found.add(name, math.nan, math.nan)
        found.add("time_to_stop", math.nan, math.nan)
        return found
    place = int(still[0])
    stop = float(at[place])
    if place and surge[place - 1] > 0:
        stop -= path.step * float(surge[place] / (surge[place] - surge[place - 1]))
    near = np.abs(at - stop) <= half
    slowing = math.nan
    if near.sum() > 5:
        fall, level = np.polyfit(at[near] - stop, surge[near], 1)
        slowing = abs(float(fall))
        if fall < 0:
            stop += float(np.clip(-level / fall, -half, half))
    window = path.t[np.abs(path.t - stop) <= half]
    pace_std = straight_line(window, np.zeros_like(window), path.noise)[1]
    if path.current is not None:
        pace_std = math.hypot(
            pace_std, math.sqrt(path.current.variance_along(path.approach.heading + heading[place]))
        )
    stop_std = pace_std / max(slowing, 1e-6)
    ahead, aside = path.place(stop)
    left_over = 0.5 * slowing * stop_std**2
    begun = order.std * path.approach.speed
    turned = path.approach.heading_std
    along, across = (math.sqrt(path.variance(stop, one)) for one in (False, True))
    found.add("head_reach", ahead, math.hypot(along, begun, aside * turned, left_over))
    every = max(0.25 * path.L / path.approach.speed, 10.0 * path.step)
    way = way_along(path.t, path.x, path.y, 0.0, stop, every, SHORTEST * path.L)
    found.add("track_reach", way, math.hypot(along, begun, left_over))
    found.add("lateral_deviation", aside, math.hypot(across, ahead * turned))
    found.add("time_to_stop", stop, math.hypot(stop_std, order.std))
    value, std, _ = path.heading(stop)
    found.add("heading_at_stop_deg", math.degrees(value), math.degrees(std))
    return found
