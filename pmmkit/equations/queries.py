"""What is asked of integrated manoeuvres, and many ships in turn; runs like `engine`.

A step is looked at through its dense output only, so that nothing depends on how finely a history
is sampled.
"""

from __future__ import annotations

import math

from pmmkit.equations.integrator import (
    N_AT,
    NS,
    STRIDE,
    control,
    dense,
    rates,
    root,
    run,
    settle,
    vector,
)


def peak(steps: list[float], at: int, state: int, side: float, low: float, high: float) -> float:
    """Where a state is largest (`side` 1) or least inside a step, by golden section."""
    share = 0.6180339887498949
    a, b = high - share * (high - low), low + share * (high - low)
    f_a, f_b = side * dense(steps, at, a, state), side * dense(steps, at, b, state)
    for _ in range(60):
        if f_a > f_b:
            high, b, f_b = b, a, f_a
            a = high - share * (high - low)
            f_a = side * dense(steps, at, a, state)
        else:
            low, a, f_a = a, b, f_b
            b = low + share * (high - low)
            f_b = side * dense(steps, at, b, state)
    return 0.5 * (low + high)


def take(steps: list[float], place: int, theta: float, results: list[float], to: int) -> None:
    """Write the instant and the states of a place inside a step."""
    at = STRIDE * place
    results[to] = steps[at] + theta * steps[at + 1]
    for i in range(NS):
        results[to + 1 + i] = dense(steps, at, theta, i)


def probe(
    steps: list[float],
    events: list[float],
    probes: list[float],
    count: int,
    n0: float,
    settings: list[float],
    k: list[float],
    results: list[float],
) -> None:
    """What is asked of a history: (1 + NS) numbers a probe, the instant and the states; or NaN."""
    y, found = vector(NS), vector(NS)
    for p in range(count):
        to, a = (1 + NS) * p, 6 * p
        for i in range(1 + NS):
            results[to + i] = math.nan
        kind, state, level, side = int(probes[a]), int(probes[a + 1]), probes[a + 2], probes[a + 3]
        first = int(events[9 * int(probes[a + 4]) + 7])
        end = 9 * (int(probes[a + 5]) + 1)
        last = int(events[end + 7])
        if last <= first:
            continue
        if kind == 0:
            for place in range(first, last):
                at = STRIDE * place
                here = side * (steps[at + 2 + state] - level)
                there = side * (dense(steps, at, 1.0, state) - level)
                if here < 0.0 and there >= 0.0:
                    take(steps, place, root(steps, at, state, level, side, 0.0, 1.0), results, to)
                    break
        elif kind == 1:
            best, where, theta = -1e300, first, 0.0
            for place in range(first, last):
                for j in range(5):
                    value = side * dense(steps, STRIDE * place, 0.25 * j, state)
                    if value > best:
                        best, where, theta = value, place, 0.25 * j
            middle, edge = where, theta
            for beside in range(-1, 2):
                low, high = max(edge - 0.25, 0.0), min(edge + 0.25, 1.0)
                if beside < 0:
                    low, high = 0.75, 1.0
                elif beside > 0:
                    low, high = 0.0, 0.25
                near = (beside < 0 and edge <= 0.0) or (beside > 0 and edge >= 1.0) or beside == 0
                if near and first <= middle + beside < last:
                    at = STRIDE * (middle + beside)
                    inside = peak(steps, at, state, side, low, high)
                    value = side * dense(steps, at, inside, state)
                    if value > best:
                        best, where, theta = value, middle + beside, inside
            take(steps, where, theta, results, to)
        elif kind == 2 or (kind == 6 and events[end - 1] > 0.0):
            take(steps, last - 1, 1.0, results, to)
        elif kind == 3:
            take(steps, first, 0.0, results, to)
        elif kind == 4:
            length = 0.0
            for place in range(first, last):
                at = STRIDE * place
                x, way = steps[at + 2], steps[at + 3]
                for j in range(1, 9):
                    x_next = dense(steps, at, 0.125 * j, 0)
                    way_next = dense(steps, at, 0.125 * j, 1)
                    length += math.sqrt((x_next - x) ** 2 + (way_next - way) ** 2)
                    x, way = x_next, way_next
            results[to] = length
        elif kind == 5:
            for i in range(NS):
                y[i] = dense(steps, STRIDE * (last - 1), 1.0, i)
            lost = settle(
                y, events[end + 1], events[end + 2], events[end + 3], settings[2], n0, k, found
            )
            if lost == 0:
                results[to] = steps[STRIDE * (last - 1)] + steps[STRIDE * (last - 1) + 1]
                for i in range(NS):
                    results[to + 1 + i] = found[i]


def sample(
    steps: list[float],
    kept: int,
    events: list[float],
    count: int,
    settings: list[float],
    times: list[float],
    size: int,
    n0: float,
    out: list[float],
) -> None:
    """States and controls at ascending instants: NS + 3 rows of `size` numbers."""
    place, phase = 0, 0
    for j in range(size):
        t = times[j]
        while place < kept - 1 and steps[STRIDE * (place + 1)] <= t:
            place += 1
        while phase < count - 1 and events[9 * (phase + 1)] <= t:
            phase += 1
        at = STRIDE * place
        theta = min(max((t - steps[at]) / steps[at + 1], 0.0), 1.0)
        for i in range(NS):
            out[i * size + j] = dense(steps, at, theta, i)
        begin = events[9 * phase]
        for c in range(3):
            start, order = events[9 * phase + 1 + c], events[9 * phase + 4 + c]
            rate, lag = settings[3 + 2 * c], settings[4 + 2 * c]
            if c == 1:
                rate *= max(n0, 1e-9)
            out[(NS + c) * size + j] = control(t, begin, start, order, rate, lag)


def run_many(
    ships: list[float],
    first: int,
    last: int,
    width: int,
    phases: list[float],
    count: int,
    settings: list[float],
    probes: list[float],
    asked: int,
    room: int,
    results: list[float],
    states: list[float],
) -> None:
    """Ships one after another: their probes, their status and revolutions of the approach."""
    k, steps, events = vector(width), vector(room), vector(9 * (count + 1))
    found = vector((1 + NS) * asked)
    for ship in range(first, last):
        for i in range(width):
            k[i] = ships[ship * width + i]
        status, _, n0 = run(k, phases, count, settings, steps, room, events)
        states[2 * ship], states[2 * ship + 1] = status, n0
        if status == 0:
            probe(steps, events, probes, asked, n0, settings, k, found)
        for i in range((1 + NS) * asked):
            results[ship * (1 + NS) * asked + i] = found[i] if status == 0 else math.nan


def repeat(y: list[float], k: list[float], times: int, out: list[float]) -> float:
    """Right-hand sides one after another at slightly different states, for timing."""
    total = 0.0
    for i in range(times):
        y[3] += 1e-9
        rates(y, 0.3 + 1e-9 * i, y[NS - 1] if N_AT >= 0 else 1.0, 0.0, k, out)
        total += out[3] + out[4] + out[5]
    return total
