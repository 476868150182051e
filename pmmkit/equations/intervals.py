"""Records carried through their intervals; runs below a structure's equations.

As `engine`, this file is written into a module in which `rates`, `complete` and NS are those of one
structure; it takes arrays and runs compiled. It gives the filters of `pmmkit.inference.estimators`,
which stand below it in the module, the system that they ask for.

Values that are estimated act through the constants ``k``: ``k = base + Σ slope (θ - θ0)`` in the
few places that each touches (`starts`, `places`, `slopes`, as a sparse matrix by rows). `inputs`
holds a row of `InputField` per instant; controls and the measured roll of a ship that has none of
its own are straight lines between instants.

A `System` holds the instants, the inputs, base, starts, places, slopes, the longest step of the
integration, the steps of the differences over states and values, and room for the constants and
for six rows of states.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pmmkit.equations.layouts import Constant, InputField, State, Status
from pmmkit.equations.sensors import drifted, expected, turned_back
from pmmkit.equations.stand_ins import NS, OWN, complete, rates

Array = NDArray[np.float64]
Places = NDArray[np.int64]
Flags = NDArray[np.bool_]
System = tuple[Array, Array, Array, Places, Places, Array, float, Array, Array, Array]


def constants(
    base: Array, starts: Places, places: Places, slopes: Array, change: Array, k: Array
) -> int:
    """Fill the constants for a change of the parameters; 1 if the mass matrix is not positive."""
    for i in range(len(base)):
        k[i] = base[i]
    for j in range(len(change)):
        for s in range(starts[j], starts[j + 1]):
            k[places[s]] += slopes[s] * change[j]
    return complete(k)


def blown(speed: float, direction: float, k: Array) -> None:
    """Set the wind that the drifting water feels from that over ground."""
    k[Constant.wind_speed], k[Constant.wind_direction] = speed, direction
    if k[Constant.current_x] != 0.0 or k[Constant.current_y] != 0.0:
        north = -speed * math.cos(direction) - k[Constant.current_x]
        east = -speed * math.sin(direction) - k[Constant.current_y]
        k[Constant.wind_speed], k[Constant.wind_direction] = (
            math.sqrt(north * north + east * east),
            math.atan2(-east, -north),
        )


def seaway(start: Array, k: Array) -> None:
    """Set the waves."""
    k[Constant.wave_height] = start[InputField.wave_height]
    k[Constant.wave_direction] = start[InputField.wave_direction]


def heeled(start: Array, stop: Array, share: float, k: Array) -> None:
    """Set the measured heel and its two rates at a share of the way between two instants."""
    roll, rate = start[InputField.roll], start[InputField.roll_rate]
    gain = start[InputField.roll_acceleration]
    k[Constant.roll] = roll + share * (stop[InputField.roll] - roll)
    k[Constant.roll_rate] = rate + share * (stop[InputField.roll_rate] - rate)
    k[Constant.roll_acceleration] = gain + share * (stop[InputField.roll_acceleration] - gain)


def advance(
    y: Array, start: Array, stop: Array, time: float, longest: float, k: Array, work: Array
) -> None:
    """Carry the states over an interval by the classical Runge-Kutta method."""
    count = max(math.ceil(time / longest - 1e-9), 1)
    h = time / count
    z, k1, k2, k3, k4 = work[0], work[1], work[2], work[3], work[4]
    blown(start[InputField.wind_speed], start[InputField.wind_direction], k)
    seaway(start, k)
    for i in range(count):
        a, c = i / count, (i + 1.0) / count
        b = 0.5 * (a + c)
        d0 = start[InputField.rudder]
        n0 = start[InputField.revolutions]
        b0 = start[InputField.bucket]
        d1 = stop[InputField.rudder] - d0
        n1 = stop[InputField.revolutions] - n0
        b1 = stop[InputField.bucket] - b0
        heeled(start, stop, a, k)
        rates(y, d0 + a * d1, n0 + a * n1, b0 + a * b1, k, k1)
        for j in range(NS):
            z[j] = y[j] + 0.5 * h * k1[j]
        heeled(start, stop, b, k)
        rates(z, d0 + b * d1, n0 + b * n1, b0 + b * b1, k, k2)
        for j in range(NS):
            z[j] = y[j] + 0.5 * h * k2[j]
        rates(z, d0 + b * d1, n0 + b * n1, b0 + b * b1, k, k3)
        for j in range(NS):
            z[j] = y[j] + h * k3[j]
        heeled(start, stop, c, k)
        rates(z, d0 + c * d1, n0 + c * n1, b0 + c * b1, k, k4)
        for j in range(NS):
            y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j])


def lost_at(y: Array) -> bool:
    """Whether states are beyond all bounds."""
    total = 0.0
    for i in range(NS):
        total += math.fabs(y[i])
    return not total < 1e12


def transition(system: System, t: int, points: Array, changes: Array) -> int:
    """Carry the states of points, a row each, from instant t - 1 to t.

    Gives 0; where they are lost, one more than the `Status` that says how.
    """
    times, inputs, base, starts, places, slopes, longest, _, k, work = system
    start, stop, time, y = inputs[t - 1], inputs[t], times[t] - times[t - 1], work[5]
    for p in range(len(points)):
        if constants(base, starts, places, slopes, changes[p], k) != 0:
            return Status.mass + 1
        for i in range(NS):
            y[i] = points[p, i]
        advance(y, start, stop, time, longest, k, work)
        if lost_at(y):
            return Status.unbound + 1
        for i in range(NS):
            points[p, i] = y[i]
    return 0


def linearised(
    system: System, t: int, z: Array, change: Array, y: Array, A: Array, B: Array
) -> int:
    """States at instant t from those at t - 1, with the slopes over states and values.

    Gives what `transition` gives.
    """
    times, inputs, base, starts, places, slopes, longest, steps, k, work = system
    start, stop, time, moved = inputs[t - 1], inputs[t], times[t] - times[t - 1], work[5]
    if constants(base, starts, places, slopes, change, k) != 0:
        return Status.mass + 1
    for i in range(NS):
        y[i] = z[i]
    advance(y, start, stop, time, longest, k, work)
    if lost_at(y):
        return Status.unbound + 1
    for j in range(NS):
        if j == State.x or j == State.y:
            for i in range(NS):
                A[i, j] = 1.0 if i == j else 0.0
            continue
        for i in range(NS):
            moved[i] = z[i]
        moved[j] += steps[j]
        advance(moved, start, stop, time, longest, k, work)
        for i in range(NS):
            A[i, j] = (moved[i] - y[i]) / steps[j]
    for j in range(len(change)):
        kept = change[j]
        change[j] = kept + steps[NS + j]
        lost = constants(base, starts, places, slopes, change, k)
        change[j] = kept
        if lost != 0:
            return Status.mass + 1
        for i in range(NS):
            moved[i] = z[i]
        advance(moved, start, stop, time, longest, k, work)
        for i in range(NS):
            B[i, j] = (moved[i] - y[i]) / steps[NS + j]
    return 0


def at_instant(system: System, t: int, change: Array) -> None:
    """Constants and heel as they are at an instant."""
    start, k = system[1][t], system[8]
    constants(system[2], system[3], system[4], system[5], change, k)
    heeled(start, start, 0.0, k)


def sensed(system: System, kind: int, z: Array, h: Array) -> float:
    """What a channel should show, and its slopes over states and values."""
    k = system[8]
    shown = expected(kind, z, k, h)
    if kind >= NS:
        drifted(z, k, h, system[3], system[4], system[5])
    return shown


def innovation(difference: float, kind: int) -> float:
    """Measured less expected."""
    return turned_back(difference, kind)


def windows(
    times: Array, inputs: Array, begins: Places, first: Array, k: Array, longest: float, out: Array
) -> None:
    """States at every instant of windows, each from its own first states."""
    work, y = np.zeros((6, NS)), np.zeros(NS)
    for w in range(len(begins) - 1):
        for i in range(NS):
            y[i] = first[w, i]
            out[begins[w], i] = y[i]
        for t in range(begins[w] + 1, begins[w + 1]):
            advance(y, inputs[t - 1], inputs[t], times[t] - times[t - 1], longest, k, work)
            for i in range(NS):
                out[t, i] = y[i]


def pushed(
    times: Array,
    inputs: Array,
    forces: Array,
    begins: Places,
    first: Array,
    k: Array,
    longest: float,
    out: Array,
) -> None:
    """As `windows`, with more forces [N, N m], each from its instant on.

    What effects bring beside the states of a ship, as a flow that remembers, goes on from window to
    window.
    """
    work, y = np.zeros((6, NS)), np.zeros(NS)
    for w in range(len(begins) - 1):
        for t in range(begins[w], begins[w + 1]):
            if t > begins[w] or (w > 0 and OWN < NS):
                for i in range(forces.shape[1]):
                    k[Constant.more_X + i] = forces[t - 1, i]
                advance(y, inputs[t - 1], inputs[t], times[t] - times[t - 1], longest, k, work)
            if t == begins[w]:
                for i in range(NS if w == 0 else OWN):
                    y[i] = first[w, i]
            for i in range(NS):
                out[t, i] = y[i]


def surrounded(start: Array, stop: Array, share: float, more: Array, k: Array) -> None:
    """Set wind, waves, measured heel and more forces at a share of the way between two instants."""
    blown(start[InputField.wind_speed], start[InputField.wind_direction], k)
    seaway(start, k)
    heeled(start, stop, share, k)
    for i in range(len(more)):
        k[Constant.more_X + i] = more[i]


def along(states: Array, inputs: Array, more: Array, k: Array, out: Array) -> None:
    """Rates of the states at every instant, with more forces than those of the effects."""
    y, rate = np.zeros(NS), np.zeros(NS)
    for t in range(len(states)):
        surrounded(inputs[t], inputs[t], 0.0, more[t], k)
        for i in range(NS):
            y[i] = states[t, i]
        rates(
            y,
            inputs[t, InputField.rudder],
            inputs[t, InputField.revolutions],
            inputs[t, InputField.bucket],
            k,
            rate,
        )
        for i in range(NS):
            out[t, i] = rate[i]


def shown(states: Array, inputs: Array, kinds: Places, k: Array, out: Array) -> None:
    """What channels should show at every instant."""
    y, h = np.zeros(NS), np.zeros(NS)
    for q in range(len(kinds)):
        if kinds[q] < NS:
            out[:, q] = states[:, kinds[q]]
            continue
        for t in range(len(states)):
            heeled(inputs[t], inputs[t], 0.0, k)
            for i in range(NS):
                y[i] = states[t, i]
            out[t, q] = expected(kinds[q], y, k, h)


def differenced(
    y: Array,
    start: Array,
    stop: Array,
    share: float,
    more: Array,
    k: Array,
    moved: Array,
    turned: Array,
    acts: Flags,
    steps: Array,
    count: int,
    work: Array,
    out: Array,
) -> None:
    """Slopes of the rates between two instants over the first `count` of states, more forces and
    values.

    `moved` holds the constants a step further in each value, `turned` by how much the rudder is
    further there, `acts` whether the ship minds; `steps` are those of states, forces and values.
    The first row of `work` are the rates.
    """
    delta, revolutions = start[InputField.rudder], start[InputField.revolutions]
    bucket, channels, now, further = start[InputField.bucket], len(more), work[0], work[1]
    delta += share * (stop[InputField.rudder] - delta)
    revolutions += share * (stop[InputField.revolutions] - revolutions)
    bucket += share * (stop[InputField.bucket] - bucket)
    surrounded(start, stop, share, more, k)
    rates(y, delta, revolutions, bucket, k, now)
    for j in range(count):
        value = j - NS - channels
        if j == State.x or j == State.y:
            for i in range(NS):
                out[i, j] = 0.0
            continue
        if j < NS:
            kept = y[j]
            y[j] = kept + steps[j]
            rates(y, delta, revolutions, bucket, k, further)
            y[j] = kept
        elif value < 0:
            k[Constant.more_X + j - NS] = more[j - NS] + steps[j]
            rates(y, delta, revolutions, bucket, k, further)
            k[Constant.more_X + j - NS] = more[j - NS]
        elif acts[value]:
            surrounded(start, stop, share, more, moved[value])
            rates(y, delta + turned[value], revolutions, bucket, moved[value], further)
        else:
            for i in range(NS):
                further[i] = now[i]
        for i in range(NS):
            out[i, j] = (further[i] - now[i]) / steps[j]


def further_on(A: Array, slopes: Array, share: float, before: Array, out: Array) -> None:
    """Rates of what is a share of its rates further: ``slopes + share A before``."""
    for i in range(NS):
        for j in range(slopes.shape[1]):
            out[i, j] = slopes[i, j]
        for l in range(NS):
            gain = share * A[i, l]
            if gain != 0.0:
                for j in range(slopes.shape[1]):
                    out[i, j] += gain * before[l, j]


def tangents(
    times: Array,
    inputs: Array,
    forces: Array,
    begins: Places,
    pieces: Places,
    states: Array,
    k: Array,
    moved: Array,
    turned: Array,
    acts: Flags,
    steps: Array,
    out: Array,
) -> None:
    """Slopes (n, s, s + p f + m) of the states at every instant of windows along a path: over the
    first states, over forces that act in one piece of the window, and over values.

    The slopes of the rates, `differenced` at the instants and halfway, over forces and values only
    there, are carried by the classical Runge-Kutta method; halfway the path is the cubic of its
    ends and their rates.
    """
    channels, values, count = forces.shape[1], len(moved), len(steps)
    width = out.shape[2]
    begin, half, end = np.zeros((NS, count)), np.zeros((NS, count)), np.zeros((NS, count))
    k2, k3, k4 = np.zeros((NS, count)), np.zeros((NS, count)), np.zeros((NS, count))
    work, y, first = np.zeros((2, NS)), np.zeros(NS), np.zeros(NS)
    for w in range(len(begins) - 1):
        for t in range(begins[w], begins[w + 1]):
            if t == begins[w] and (w == 0 or OWN == NS):
                for i in range(NS):
                    for j in range(width):
                        out[t, i, j] = 1.0 if i == j else 0.0
                continue
            start, stop, more = inputs[t - 1], inputs[t], forces[t - 1]
            h, piece = times[t] - times[t - 1], pieces[t - 1]
            for i in range(NS):
                y[i] = states[t - 1, i]
            if t == begins[w] + 1:
                differenced(
                    y, start, stop, 0.0, more, k, moved, turned, acts, steps, NS, work, begin
                )
            surrounded(start, stop, 0.0, more, k)
            rates(
                y,
                start[InputField.rudder],
                start[InputField.revolutions],
                start[InputField.bucket],
                k,
                first,
            )
            for i in range(NS):
                y[i] = states[t, i]
            differenced(y, start, stop, 1.0, more, k, moved, turned, acts, steps, NS, work, end)
            for i in range(NS):
                y[i] = 0.5 * (states[t - 1, i] + states[t, i]) + 0.125 * h * (first[i] - work[0, i])
            differenced(y, start, stop, 0.5, more, k, moved, turned, acts, steps, count, work, half)
            for i in range(NS):
                for j in range(NS, count):
                    begin[i, j], end[i, j] = half[i, j], half[i, j]
            further_on(half, half, 0.5 * h, begin, k2)
            further_on(half, half, 0.5 * h, k2, k3)
            further_on(end, end, h, k3, k4)
            for i in range(NS):
                for j in range(count):
                    k2[i, j] = h / 6.0 * (begin[i, j] + 2.0 * (k2[i, j] + k3[i, j]) + k4[i, j])
                    begin[i, j] = end[i, j]
                for j in range(width):
                    out[t, i, j] = out[t - 1, i, j]
                for l in range(NS):
                    gain = k2[i, l]
                    if gain != 0.0:
                        for j in range(width):
                            out[t, i, j] += gain * out[t - 1, l, j]
                for c in range(channels):
                    out[t, i, NS + piece * channels + c] += k2[i, NS + c]
                for j in range(values):
                    out[t, i, width - values + j] += k2[i, count - values + j]
            if t == begins[w]:
                for i in range(NS):
                    for j in range(width if i < OWN else width - values):
                        out[t, i, j] = 1.0 if i == j else 0.0
