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
from pmmkit.equations.stand_ins import NS, complete, rates

Array = NDArray[np.float64]
Places = NDArray[np.int64]
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
    """As `windows`, with more forces [N, N m], each from its instant on."""
    work, y = np.zeros((6, NS)), np.zeros(NS)
    for w in range(len(begins) - 1):
        for i in range(NS):
            y[i] = first[w, i]
            out[begins[w], i] = y[i]
        for t in range(begins[w] + 1, begins[w + 1]):
            for i in range(forces.shape[1]):
                k[Constant.more_X + i] = forces[t - 1, i]
            advance(y, inputs[t - 1], inputs[t], times[t] - times[t - 1], longest, k, work)
            for i in range(NS):
                out[t, i] = y[i]


def along(states: Array, inputs: Array, more: Array, k: Array, out: Array) -> None:
    """Rates of the states at every instant, with more forces than those of the effects."""
    y, rate = np.zeros(NS), np.zeros(NS)
    for t in range(len(states)):
        blown(inputs[t, InputField.wind_speed], inputs[t, InputField.wind_direction], k)
        seaway(inputs[t], k)
        heeled(inputs[t], inputs[t], 0.0, k)
        for i in range(more.shape[1]):
            k[Constant.more_X + i] = more[t, i]
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
