"""A ship that is carried from one instant to the next while its orders are held.

The functions stand in the module of a structure as those of
`pmmkit.equations.integrator` do, whose steps they take. Programs in other languages are
made of them (`pmmkit.exports.fmu`).
"""

from __future__ import annotations

import math

from pmmkit.equations.integrator import corner, error_of, evaluate, step
from pmmkit.equations.layouts import Constant, Control, GearField, State
from pmmkit.equations.stand_ins import N_AT, NS, vector


def gear_rate(now: float, order: float, rate: float, lag: float) -> float:
    """Rate of a steering gear whose angle is `now`: `integrator.control` as an equation [rad/s].

    Examples
    --------
    >>> gear_rate(0.0, 0.6, 0.04, 1.0), gear_rate(0.59, 0.6, 0.04, 1.0)
    (0.04, 0.01...)
    """
    return max(min((order - now) / lag, rate), -rate)


def ordered(
    gear: list[float], which: int, t: float, now: float, order: float, rate: float, lag: float
) -> None:
    """Give an order to a control that stands at `now`."""
    g = len(GearField) * which
    gear[g + GearField.since], gear[g + GearField.start] = t, now
    gear[g + GearField.order], gear[g + GearField.rate] = order, rate
    gear[g + GearField.lag] = lag


def carried(
    t: float,
    end: float,
    h: float,
    y: list[float],
    gear: list[float],
    k: list[float],
    rtol: float,
    longest: float,
) -> tuple[float, float]:
    """Carry the states `y` from an instant to another, with a first step `h` or shorter.

    Gives the instant that was reached, which is before the end where the motion grows without
    bound, and the step to go on with.
    """
    z, new, size = vector(NS), vector(NS), vector(NS)
    k1, k2, k3, k4 = vector(NS), vector(NS), vector(NS), vector(NS)
    k5, k6, k7 = vector(NS), vector(NS), vector(NS)
    pace = k[Constant.speed] / k[Constant.L]
    for i in range(NS):
        size[i] = 1.0
    size[State.x], size[State.y], size[State.r] = k[Constant.L], k[Constant.L], pace
    size[State.u], size[State.v] = k[Constant.speed], k[Constant.speed]
    if State.p < NS and k[Constant.rolls] > 0.0:
        size[State.p] = pace
    if N_AT >= 0:
        size[N_AT] = max(math.fabs(y[N_AT]), 1e-3 * pace)
    before, near = 1e-4, 1e-12 * (1.0 + math.fabs(end))
    evaluate(t, y, gear, k, k1)
    while t < end - near:
        stop = end
        for c in range(len(Control)):
            bend = corner(gear, c)
            if bend > t + near and bend < stop:
                stop = bend
        h = min(h, longest)
        clipped = t + 1.01 * h >= stop
        hh = stop - t if clipped else h
        step(t, hh, y, gear, k, z, k1, k2, k3, k4, k5, k6, k7, new)
        wrong = error_of(hh, y, new, rtol, size, k1, k3, k4, k5, k6, k7)
        if not wrong <= 1.0:
            h = hh * max(0.1, 0.9 * wrong**-0.2) if wrong == wrong else 0.1 * hh
            if h < 1e-10 / pace:
                break
            continue
        growth = 10.0
        if wrong > 0.0:
            growth = 0.9 * wrong**-0.17 * before**0.04
            growth = min(10.0, max(0.2, growth))
        before = max(wrong, 1e-4)
        h = max(h, hh * growth) if clipped else hh * growth
        t = stop if clipped else t + hh
        for i in range(NS):
            y[i], k1[i] = new[i], k7[i]
    return t, h
