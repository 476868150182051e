"""Filters, smoothers and windows over measured histories; runs below a structure's equations.

As `engine`, this file is written into a module in which `rates`, `complete` and NS are those of one
structure; it takes arrays and runs compiled.

The state of a filter is ``z``: the NS states of the ship, then `m` parameters, which may wander.
Parameters act through the constants ``k``: ``k = base + Σ slope (θ - θ0)`` in the few places that
each touches (`starts`, `places`, `slopes`, as a sparse matrix by rows). `inputs` holds a row of
`InputField` per instant; controls and the measured roll of a ship that has none of its own are
straight lines between instants. `sensors` says what `measured` and `kinds` hold.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pmmkit.equations.covariances import divided, grown, line_through, predict, scatter
from pmmkit.equations.layouts import Constant, InputField, State, Status
from pmmkit.equations.sensors import take_in
from pmmkit.equations.stand_ins import NS, complete, rates

Array = NDArray[np.float64]
Places = NDArray[np.int64]


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


def linearised(
    z: Array,
    y: Array,
    start: Array,
    stop: Array,
    time: float,
    longest: float,
    base: Array,
    starts: Places,
    places: Places,
    slopes: Array,
    change: Array,
    steps: Array,
    k: Array,
    work: Array,
    A: Array,
    B: Array,
) -> int:
    """States after an interval into `y`, and their slopes over states and parameters."""
    m = len(change)
    if constants(base, starts, places, slopes, change, k) != 0:
        return 1
    for i in range(NS):
        y[i] = z[i]
    advance(y, start, stop, time, longest, k, work)
    moved = work[5]
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
    for j in range(m):
        kept = change[j]
        change[j] = kept + steps[NS + j]
        lost = constants(base, starts, places, slopes, change, k)
        change[j] = kept
        if lost != 0:
            return 1
        for i in range(NS):
            moved[i] = z[i]
        advance(moved, start, stop, time, longest, k, work)
        for i in range(NS):
            B[i, j] = (moved[i] - y[i]) / steps[NS + j]
    return 0


def extended(
    times: Array,
    inputs: Array,
    measured: Array,
    kinds: Places,
    variances: Array,
    base: Array,
    starts: Places,
    places: Places,
    slopes: Array,
    about: Array,
    frozen: Array,
    z: Array,
    P: Array,
    fading: Array,
    diffusion: Array,
    steps: Array,
    longest: float,
    gate: float,
    means: Array,
    residuals: Array,
    spreads: Array,
    kept: Array,
) -> int:
    """Extended Kalman filter over one record; `z` and `P` end as those of the last instant.

    `fading` are the inverse times in which parameters forget, `diffusion` the growth of the
    variances per second. `about` is the point about which frozen parameters are linearised. Where
    `kept` has room (N rows), filtered and predicted means and covariances and A, B of each
    interval go there for the smoother. Gives a `Status`.
    """
    N, n = len(times), len(z)
    m = n - NS
    k, work = np.zeros(len(base)), np.zeros((6, NS))
    A, B, Q = np.zeros((NS, NS)), np.zeros((NS, m)), np.zeros((NS, NS))
    y, h, gain, left = np.zeros(NS), np.zeros(n), np.zeros(n), np.zeros(n)
    change, keep, noise = np.zeros(m), np.ones(m), np.zeros(m)
    store = len(kept) == N
    nn = n * n
    for t in range(N):
        if t > 0:
            time = times[t] - times[t - 1]
            for j in range(m):
                change[j] = (about[j] if frozen[j] > 0.0 else z[NS + j]) - about[j]
                keep[j] = math.exp(-fading[j] * time)
            lost = linearised(
                z,
                y,
                inputs[t - 1],
                inputs[t],
                time,
                longest,
                base,
                starts,
                places,
                slopes,
                change,
                steps,
                k,
                work,
                A,
                B,
            )
            if lost != 0:
                return Status.mass
            for i in range(NS):
                for j in range(m):
                    if frozen[j] > 0.0:
                        y[i] += B[i, j] * (z[NS + j] - about[j])
                if not math.fabs(y[i]) < 1e12:
                    return Status.unbound
            for j in range(m):
                noise[j] = grown(diffusion[NS + j], fading[j], time)
            scatter(A, diffusion, time, Q)
            predict(P, A, B, keep, Q, noise)
            for i in range(NS):
                z[i] = y[i]
            for j in range(m):
                z[NS + j] *= keep[j]
            if store:
                for i in range(NS):
                    for j in range(NS):
                        kept[t, 2 * nn + 2 * n + i * NS + j] = A[i, j]
                    for j in range(m):
                        kept[t, 2 * nn + 2 * n + NS * NS + i * m + j] = B[i, j]
                for j in range(m):
                    kept[t, 2 * nn + 2 * n + NS * n + j] = keep[j]
        if store:
            for i in range(n):
                kept[t, i] = z[i]
                for j in range(n):
                    kept[t, 2 * n + i * n + j] = P[i, j]
        for j in range(m):
            change[j] = (about[j] if frozen[j] > 0.0 else z[NS + j]) - about[j]
        constants(base, starts, places, slopes, change, k)
        heeled(inputs[t], inputs[t], 0.0, k)
        take_in(
            measured[t],
            kinds,
            variances,
            z,
            P,
            k,
            starts,
            places,
            slopes,
            about,
            change,
            gate,
            h,
            gain,
            left,
            residuals[t],
            spreads[t],
        )
        if store:
            for i in range(n):
                kept[t, n + i] = z[i]
                for j in range(n):
                    kept[t, 2 * n + nn + i * n + j] = P[i, j]
        for i in range(n):
            means[t, i] = z[i]
            means[t, n + i] = P[i, i]
    return Status.done


def smoothed(kept: Array, n: int, means: Array, covariances: Array) -> None:
    """Rauch, Tung and Striebel's smoother over what `extended` kept."""
    N, m, nn = len(kept), n - NS, n * n
    F, ahead, cross, change = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    scale = np.zeros(n)
    for i in range(n):
        means[N - 1, i] = kept[N - 1, n + i]
        for j in range(n):
            covariances[N - 1, i, j] = kept[N - 1, 2 * n + nn + i * n + j]
    for t in range(N - 2, -1, -1):
        row, here = kept[t + 1], kept[t]
        at, of = 2 * nn + 2 * n, 2 * n + nn
        for i in range(NS):
            for j in range(NS):
                F[i, j] = row[at + i * NS + j]
            for j in range(m):
                F[i, NS + j] = row[at + NS * NS + i * m + j]
        for j in range(m):
            F[NS + j, NS + j] = row[at + NS * n + j]
        for i in range(n):
            scale[i] = 1.0 / math.sqrt(max(row[2 * n + i * n + i], 1e-300))
        for i in range(n):
            for j in range(n):
                ahead[i, j] = row[2 * n + i * n + j] * scale[i] * scale[j]
                cross[i, j] = 0.0
                for l in range(n):
                    cross[i, j] += F[i, l] * here[of + l * n + j]
                cross[i, j] *= scale[i]
            ahead[i, i] += 1e-13
        divided(ahead, cross)
        # Now its columns are the rows of the gain but for the scale of what lies ahead.
        for i in range(n):
            for j in range(n):
                cross[i, j] *= scale[i]
        for i in range(n):
            for j in range(n):
                change[i, j] = 0.0
                for l in range(n):
                    moved = covariances[t + 1, l, j] - row[2 * n + l * n + j]
                    change[i, j] += cross[l, i] * moved
        for i in range(n):
            total = here[n + i]
            for j in range(n):
                total += cross[j, i] * (means[t + 1, j] - row[j])
                back = 0.0
                for l in range(n):
                    back += change[i, l] * cross[l, j] + change[j, l] * cross[l, i]
                covariances[t, i, j] = here[of + i * n + j] + 0.5 * back
            means[t, i] = total


def unscented(
    times: Array,
    inputs: Array,
    measured: Array,
    kinds: Places,
    variances: Array,
    base: Array,
    starts: Places,
    places: Places,
    slopes: Array,
    about: Array,
    z: Array,
    P: Array,
    fading: Array,
    diffusion: Array,
    longest: float,
    gate: float,
    means: Array,
    residuals: Array,
    spreads: Array,
) -> int:
    """Unscented Kalman filter with 2n equally weighted points; as `extended`."""
    N, n = len(times), len(z)
    m = n - NS
    k, work, h = np.zeros(len(base)), np.zeros((6, NS)), np.zeros(n)
    points, y, change = np.zeros((2 * n, n)), np.zeros(NS), np.zeros(m)
    A, L = np.zeros((NS, n)), np.zeros((n, n))
    gain, left, Q = np.zeros(n), np.zeros(n), np.zeros((NS, NS))
    root = math.sqrt(float(n))
    for t in range(N):
        if t > 0:
            time = times[t] - times[t - 1]
            scale = np.zeros(n)
            for i in range(n):
                scale[i] = math.sqrt(max(P[i, i], 1e-300))
            S = np.zeros((n, n))
            for i in range(n):
                for j in range(n):
                    S[i, j] = P[i, j] / (scale[i] * scale[j])
                S[i, i] += 1e-12
            L[:, :] = np.linalg.cholesky(S)
            for p in range(n):
                for i in range(n):
                    shift = root * scale[i] * L[i, p]
                    points[2 * p, i] = z[i] + shift
                    points[2 * p + 1, i] = z[i] - shift
            for p in range(2 * n):
                for j in range(m):
                    change[j] = points[p, NS + j] - about[j]
                if constants(base, starts, places, slopes, change, k) != 0:
                    return Status.mass
                for i in range(NS):
                    y[i] = points[p, i]
                advance(y, inputs[t - 1], inputs[t], time, longest, k, work)
                for i in range(NS):
                    if not math.fabs(y[i]) < 1e12:
                        return Status.unbound
                    points[p, i] = y[i]
                for j in range(m):
                    points[p, NS + j] *= math.exp(-fading[j] * time)
            for i in range(n):
                total = 0.0
                for p in range(2 * n):
                    total += points[p, i]
                z[i] = total / (2.0 * n)
            for p in range(2 * n):
                for i in range(n):
                    points[p, i] -= z[i]
            P[:, :] = points.T.copy() @ points / (2.0 * n)
            line_through(points, scale, L, A)
            scatter(A, diffusion, time, Q)
            for i in range(NS):
                for j in range(NS):
                    P[i, j] += Q[i, j]
            for j in range(m):
                P[NS + j, NS + j] += grown(diffusion[NS + j], fading[j], time)
        for j in range(m):
            change[j] = z[NS + j] - about[j]
        constants(base, starts, places, slopes, change, k)
        heeled(inputs[t], inputs[t], 0.0, k)
        take_in(
            measured[t],
            kinds,
            variances,
            z,
            P,
            k,
            starts,
            places,
            slopes,
            about,
            change,
            gate,
            h,
            gain,
            left,
            residuals[t],
            spreads[t],
        )
        for i in range(n):
            means[t, i] = z[i]
            means[t, n + i] = P[i, i]
    return Status.done


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
