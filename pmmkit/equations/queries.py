"""What is asked of integrated manoeuvres; runs like `integrator`.

A step is looked at through its dense output only, so that nothing depends on how finely a history
is sampled.
"""

from __future__ import annotations

import math

from pmmkit.equations.equilibrium import settle
from pmmkit.equations.integrator import control, dense, root
from pmmkit.equations.layouts import (
    Ask,
    Control,
    EventField,
    ProbeField,
    SettingField,
    State,
    StepField,
)
from pmmkit.equations.stand_ins import N_AT, NS, STRIDE, rates, vector


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
    results[to] = steps[at + StepField.begin] + theta * steps[at + StepField.length]
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
    z, found = vector(NS), vector(NS)
    for p in range(count):
        to, a = (1 + NS) * p, len(ProbeField) * p
        for i in range(1 + NS):
            results[to + i] = math.nan
        kind, state = int(probes[a + ProbeField.ask]), int(probes[a + ProbeField.state])
        level, side = probes[a + ProbeField.level], probes[a + ProbeField.side]
        begin = len(EventField) * int(probes[a + ProbeField.first])
        end = len(EventField) * (int(probes[a + ProbeField.last]) + 1)
        first, last = int(events[begin + EventField.step]), int(events[end + EventField.step])
        if last <= first or state >= NS:
            continue
        if kind == Ask.crossing:
            for place in range(first, last):
                at = STRIDE * place
                here = side * (steps[at + len(StepField) + state] - level)
                there = side * (dense(steps, at, 1.0, state) - level)
                if here < 0.0 and there >= 0.0:
                    take(steps, place, root(steps, at, state, level, side, 0.0, 1.0), results, to)
                    break
        elif kind == Ask.extreme:
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
        elif kind == Ask.end or (
            kind == Ask.reached and events[end - len(EventField) + EventField.finished] > 0.0
        ):
            take(steps, last - 1, 1.0, results, to)
        elif kind == Ask.begin:
            take(steps, first, 0.0, results, to)
        elif kind == Ask.path:
            length = 0.0
            for place in range(first, last):
                at = STRIDE * place
                x = steps[at + len(StepField) + State.x]
                y = steps[at + len(StepField) + State.y]
                for j in range(1, 9):
                    x_next = dense(steps, at, 0.125 * j, State.x)
                    y_next = dense(steps, at, 0.125 * j, State.y)
                    along, across = x_next - x, y_next - y
                    length += math.sqrt(along * along + across * across)
                    x, y = x_next, y_next
            results[to] = length
        elif kind == Ask.steady:
            at = STRIDE * (last - 1)
            for i in range(NS):
                z[i] = dense(steps, at, 1.0, i)
            lost = settle(
                z,
                events[end + EventField.rudder],
                events[end + EventField.revolutions],
                events[end + EventField.bucket],
                settings[SettingField.speed],
                n0,
                k,
                found,
            )
            if lost == 0:
                results[to] = steps[at + StepField.begin] + steps[at + StepField.length]
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
        while place < kept - 1 and steps[STRIDE * (place + 1) + StepField.begin] <= t:
            place += 1
        while phase < count - 1 and events[len(EventField) * (phase + 1) + EventField.begin] <= t:
            phase += 1
        at = STRIDE * place
        theta = min(max((t - steps[at + StepField.begin]) / steps[at + StepField.length], 0.0), 1.0)
        for i in range(NS):
            out[i * size + j] = dense(steps, at, theta, i)
        e = len(EventField) * phase
        begin = events[e + EventField.begin]
        for c in range(len(Control)):
            start = events[e + EventField.rudder + c]
            order = events[e + EventField.rudder_order + c]
            rate = settings[SettingField.rudder_rate + c]
            lag = settings[SettingField.rudder_lag + c]
            if c == Control.revolutions:
                rate *= max(n0, 1e-9)
            out[(NS + c) * size + j] = control(t, begin, start, order, rate, lag)


def repeat(y: list[float], k: list[float], times: int, out: list[float]) -> float:
    """Right-hand sides one after another at slightly different states, for timing."""
    total = 0.0
    for i in range(times):
        y[State.u] += 1e-9
        rates(y, 0.3 + 1e-9 * i, y[N_AT] if N_AT >= 0 else 1.0, 0.0, k, out)
        total += out[State.u] + out[State.v] + out[State.r]
    return total
