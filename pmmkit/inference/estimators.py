"""Kalman filters and the smoother of a system that is given: prediction, update, backward pass.

The state of a filter is ``z``: NS states x of the system, whose rates are known, then m values θ,
which may wander and may forget (an Ornstein-Uhlenbeck process each). What is a system stands in
five functions that whoever makes a module of this file gives (`pmmkit.inference.system`); what they
need comes through `system`, which nothing here looks into. `pmmkit.equations` writes
this file below the equations of a ship, where it runs compiled; taken as it is, with functions of
Python, it runs as Python. The theory stands in docs/theory/filters.md.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmmkit.inference.system import at_instant, innovation, linearised, sensed, transition

Array = NDArray[np.float64]
Kinds = NDArray[np.int64]

NS = 6
"""Stands for the number of states of a system."""


def scatter(P: Array, A: Array, C: Array, keep: Array, diffusion: Array, time: float) -> None:
    """Add to a covariance what white noise in states and values makes of an interval.

    Q = ∫ Φ(s) D Φ(s)ᵀ ds (Van Loan 1978) of states and values together, whose slopes over the
    whole interval are F = (A C; 0 keep), by Gauss's rule of three points, which keeps Q positive.
    Φ over a share s of the interval is F to the power of s, by Newton's series in F - I, and needs
    no slopes of its own. So a value that forgets (an Ornstein-Uhlenbeck force) acts on the states
    all through the interval.
    """
    power, moved = np.zeros(NS + 1), np.zeros(NS + 1)
    # Columns of Φ: the states, then what is left of the value itself.
    columns, away = np.zeros((3, NS + 1)), 0.5 * math.sqrt(0.6)
    for l in range(len(P)):
        if diffusion[l] == 0.0:
            continue
        own = max(l - NS, 0)
        last = NS + 1 if l >= NS else NS
        for i in range(NS + 1):
            power[i] = 1.0 if i == min(l, NS) else 0.0
            for q in range(3):
                columns[q, i] = power[i]
        weights = np.ones(3)
        # Eight terms leave 1e-5 at F - I = -.45: what dies away in 1/3 L/U, over .2 L/U.
        for k in range(1, 9):
            for i in range(NS):
                moved[i] = -power[i]
                for j in range(NS):
                    moved[i] += A[i, j] * power[j]
                if l >= NS:
                    moved[i] += C[i, own] * power[NS]
            moved[NS] = (keep[own] - 1.0) * power[NS] if l >= NS else 0.0
            for i in range(last):
                power[i] = moved[i]
            for q in range(3):
                weights[q] *= (0.5 + (q - 1) * away + 1.0 - k) / k
                for i in range(last):
                    columns[q, i] += weights[q] * power[i]
        for q in range(3):
            share = diffusion[l] * time * (8.0 if q == 1 else 5.0) / 18.0
            for i in range(last):
                row = l if i == NS else i
                for j in range(i + 1):
                    column = l if j == NS else j
                    P[row, column] += share * columns[q, i] * columns[q, j]
    for i in range(len(P)):
        for j in range(i):
            P[j, i] = P[i, j]


def forgotten(fading: Array, time: float, keep: Array) -> None:
    """What values keep of themselves over an interval."""
    for j in range(len(keep)):
        keep[j] = math.exp(-fading[j] * time)


def halfway(value: float, keep: float) -> float:
    """Mean over an interval of a value that is `keep` times itself at the end."""
    return value * (0.5 * (1.0 + keep))


def predict(P: Array, A: Array, B: Array, keep: Array) -> None:
    """Carry a covariance over an interval: states by A and B, values by what they `keep`."""
    n, m = len(P), len(keep)
    W, new = np.zeros((NS, n)), np.zeros((NS, NS))
    for i in range(NS):
        for j in range(n):
            for l in range(NS):
                W[i, j] += A[i, l] * P[l, j]
            for l in range(m):
                W[i, j] += B[i, l] * P[NS + l, j]
    for i in range(NS):
        for j in range(NS):
            for l in range(NS):
                new[i, j] += W[i, l] * A[j, l]
            for l in range(m):
                new[i, j] += W[i, NS + l] * B[j, l]
    for i in range(NS):
        for j in range(NS):
            P[i, j] = 0.5 * (new[i, j] + new[j, i])
        for j in range(m):
            P[i, NS + j] = W[i, NS + j] * keep[j]
            P[NS + j, i] = P[i, NS + j]
    for i in range(m):
        for j in range(m):
            P[NS + i, NS + j] *= keep[i] * keep[j]


def correct(
    z: Array,
    P: Array,
    h: Array,
    residual: float,
    variance: float,
    gate: float,
    gain: Array,
    left: Array,
) -> float:
    """Take in one measurement, in Joseph's form, but for one beyond the gate.

    Gives the variance of its residual.
    """
    n = len(z)
    seen = 0.0
    for i in range(n):
        left[i] = 0.0
    for j in range(n):
        if h[j] != 0.0:
            for i in range(n):
                left[i] += P[i, j] * h[j]
    for j in range(n):
        seen += h[j] * left[j]
    total = seen + variance
    if residual * residual > gate * gate * total:
        return total
    for i in range(n):
        gain[i] = left[i] / total
        z[i] += gain[i] * residual
    for i in range(n):
        again = variance * gain[i] - (left[i] - gain[i] * seen)
        for j in range(i + 1):
            P[i, j] += again * gain[j] - gain[i] * left[j]
    for i in range(n):
        for j in range(i):
            P[j, i] = P[i, j]
    return total


def take_in(
    system: Any,
    measured: Array,
    kinds: Kinds,
    variances: Array,
    z: Array,
    P: Array,
    about: Array,
    change: Array,
    gate: float,
    work: Array,
    residuals: Array,
    spreads: Array,
) -> None:
    """Take in the measurements of an instant that there are, one after another."""
    m = len(about)
    h, gain, left = work[0], work[1], work[2]
    for q in range(len(kinds)):
        residuals[q] = math.nan
        spreads[q] = math.nan
        if math.isnan(measured[q]):
            continue
        shown = sensed(system, kinds[q], z, h)
        for j in range(m):
            shown += h[NS + j] * (z[NS + j] - about[j] - change[j])
        residuals[q] = innovation(measured[q] - shown, kinds[q])
        spreads[q] = correct(z, P, h, residuals[q], variances[q], gate, gain, left)


def extended(
    system: Any,
    times: Array,
    measured: Array,
    kinds: Kinds,
    variances: Array,
    about: Array,
    frozen: Array,
    z: Array,
    P: Array,
    fading: Array,
    diffusion: Array,
    gate: float,
    means: Array,
    residuals: Array,
    spreads: Array,
    kept: Array,
) -> int:
    """Extended Kalman filter over one record; `z` and `P` end as those of the last instant.

    `fading` are the inverse times in which values forget, `diffusion` the growth of the variances
    per second. `about` is the point about which frozen values are linearised. Where `kept` has
    room (N rows), filtered and predicted means and covariances and A, B of each interval go there
    for the smoother. Gives 0, or what `linearised` says where the states are lost.
    """
    N, n = len(times), len(z)
    m = n - NS
    A, B, C = np.zeros((NS, NS)), np.zeros((NS, m)), np.zeros((NS, m))
    y, work = np.zeros(NS), np.zeros((3, n))
    change, keep = np.zeros(m), np.ones(m)
    store = len(kept) == N
    nn = n * n
    for t in range(N):
        if t > 0:
            time = times[t] - times[t - 1]
            forgotten(fading, time, keep)
            for j in range(m):
                change[j] = halfway(about[j] if frozen[j] > 0.0 else z[NS + j], keep[j]) - about[j]
            lost = linearised(system, t, z, change, y, A, B)
            if lost != 0:
                return lost
            for i in range(NS):
                for j in range(m):
                    C[i, j] = halfway(B[i, j], keep[j])
                    if frozen[j] > 0.0:
                        y[i] += C[i, j] * (z[NS + j] - about[j])
            predict(P, A, C, keep)
            scatter(P, A, C, keep, diffusion, time)
            for i in range(NS):
                z[i] = y[i]
            for j in range(m):
                z[NS + j] *= keep[j]
            if store:
                for i in range(NS):
                    for j in range(NS):
                        kept[t, 2 * nn + 2 * n + i * NS + j] = A[i, j]
                    for j in range(m):
                        kept[t, 2 * nn + 2 * n + NS * NS + i * m + j] = C[i, j]
                for j in range(m):
                    kept[t, 2 * nn + 2 * n + NS * n + j] = keep[j]
        if store:
            for i in range(n):
                kept[t, i] = z[i]
                for j in range(n):
                    kept[t, 2 * n + i * n + j] = P[i, j]
        for j in range(m):
            change[j] = (about[j] if frozen[j] > 0.0 else z[NS + j]) - about[j]
        at_instant(system, t, change)
        take_in(
            system,
            measured[t],
            kinds,
            variances,
            z,
            P,
            about,
            change,
            gate,
            work,
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
    return 0


def divided(S: Array, C: Array) -> None:
    """Solve S x = C in place of C, by Cholesky's factor in place of S, whose diagonal is about one.

    S is symmetric and positive but for rounding: a pivot that is no larger is taken as that.
    """
    n = len(S)
    for j in range(n):
        for i in range(j, n):
            total = S[i, j]
            for l in range(j):
                total -= S[i, l] * S[j, l]
            S[i, j] = math.sqrt(max(total, 1e-15)) if i == j else total / S[j, j]
    for c in range(C.shape[1]):
        for i in range(n):
            for l in range(i):
                C[i, c] -= S[i, l] * C[l, c]
            C[i, c] /= S[i, i]
        for i in range(n - 1, -1, -1):
            for l in range(i + 1, n):
                C[i, c] -= S[l, i] * C[l, c]
            C[i, c] /= S[i, i]


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


def scaled_root(P: Array, scale: Array, L: Array) -> None:
    """Cholesky's factor of a covariance over the roots of its diagonal, which go into `scale`."""
    n = len(scale)
    S = np.zeros((n, n))
    for i in range(n):
        scale[i] = math.sqrt(max(P[i, i], 1e-300))
    for i in range(n):
        for j in range(n):
            S[i, j] = P[i, j] / (scale[i] * scale[j])
        S[i, i] += 1e-12
    L[:, :] = np.linalg.cholesky(S)


def unscented(
    system: Any,
    times: Array,
    measured: Array,
    kinds: Kinds,
    variances: Array,
    about: Array,
    z: Array,
    P: Array,
    fading: Array,
    diffusion: Array,
    gate: float,
    means: Array,
    residuals: Array,
    spreads: Array,
) -> int:
    """Unscented Kalman filter with 2n equally weighted points; as `extended`."""
    N, n = len(times), len(z)
    m = n - NS
    points, changes = np.zeros((2 * n, n)), np.zeros((2 * n, m))
    change, keep, work = np.zeros(m), np.ones(m), np.zeros((3, n))
    A, L, scale = np.zeros((NS, n)), np.zeros((n, n)), np.zeros(n)
    root = math.sqrt(float(n))
    for t in range(N):
        if t > 0:
            time = times[t] - times[t - 1]
            forgotten(fading, time, keep)
            scaled_root(P, scale, L)
            for p in range(n):
                for i in range(n):
                    shift = root * scale[i] * L[i, p]
                    points[2 * p, i] = z[i] + shift
                    points[2 * p + 1, i] = z[i] - shift
            for p in range(2 * n):
                for j in range(m):
                    changes[p, j] = halfway(points[p, NS + j], keep[j]) - about[j]
                    points[p, NS + j] *= keep[j]
            lost = transition(system, t, points, changes)
            if lost != 0:
                return lost
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
            scatter(P, A[:, :NS].copy(), A[:, NS:].copy(), keep, diffusion, time)
        for j in range(m):
            change[j] = z[NS + j] - about[j]
        at_instant(system, t, change)
        take_in(
            system,
            measured[t],
            kinds,
            variances,
            z,
            P,
            about,
            change,
            gate,
            work,
            residuals[t],
            spreads[t],
        )
        for i in range(n):
            means[t, i] = z[i]
            means[t, n + i] = P[i, i]
    return 0


def line_through(points: Array, scale: Array, L: Array, A: Array) -> None:
    """Slopes of the straight line through the points of `unscented`, less their mean.

    Before, they lay at distances of √n times the columns of L, each row times its scale.
    """
    n = len(scale)
    far = 2.0 * math.sqrt(float(n))
    for i in range(NS):
        for p in range(n - 1, -1, -1):
            A[i, p] = (points[2 * p, i] - points[2 * p + 1, i]) / far
            for j in range(p + 1, n):
                A[i, p] -= A[i, j] * L[j, p]
            A[i, p] /= L[p, p]
        for j in range(n):
            A[i, j] /= scale[j]
