"""Mass matrix, self-propulsion and steady motion: functions that run compiled or interpreted.

They stand in the module of a structure as those of `pmmkit.equations.integrator` do.
"""

from __future__ import annotations

import math

from pmmkit.equations.layouts import Constant, State
from pmmkit.equations.stand_ins import BALANCE, FREE, N_AT, NS, REVOLUTIONS, rates, vector


def complete(k: list[float]) -> int:
    """Fill the inverse of the mass matrix into the constants; 1 if it is not positive."""
    mass, xG, zG, Izz, Ixx, rolls = (
        k[Constant.mass],
        k[Constant.xG],
        k[Constant.zG],
        k[Constant.Izz],
        k[Constant.Ixx],
        k[Constant.rolls],
    )
    a11, a12, a13 = (
        mass - k[Constant.Yvdot],
        mass * xG - k[Constant.Yrdot],
        -mass * zG - k[Constant.Ypdot],
    )
    a21, a22, a23 = mass * xG - k[Constant.Nvdot], Izz - k[Constant.Nrdot], -k[Constant.Npdot]
    a31, a32, a33 = -mass * zG - k[Constant.Kvdot], -k[Constant.Krdot], Ixx - k[Constant.Kpdot]
    if rolls == 0.0:
        a13, a23, a31, a32, a33 = 0.0, 0.0, 0.0, 0.0, 1.0
    k[Constant.surge_mass] = mass - k[Constant.Xudot]
    minor = a11 * a22 - a12 * a21
    c11, c12, c13 = a22 * a33 - a23 * a32, a13 * a32 - a12 * a33, a12 * a23 - a13 * a22
    det = a11 * c11 + a21 * c12 + a31 * c13
    if not (
        k[Constant.surge_mass] > 0.0
        and a11 > 0.0
        and a22 > 0.0
        and a33 > 0.0
        and minor > 0.0
        and det > 0.0
    ):
        return 1
    k[Constant.i11], k[Constant.i12], k[Constant.i13] = c11 / det, c12 / det, c13 / det
    k[Constant.i21], k[Constant.i22] = (a23 * a31 - a21 * a33) / det, (a11 * a33 - a13 * a31) / det
    k[Constant.i23] = (a13 * a21 - a11 * a23) / det
    k[Constant.i31], k[Constant.i32] = (a21 * a32 - a22 * a31) / det, (a12 * a31 - a11 * a32) / det
    k[Constant.i33] = minor / det
    return 0


def chord(low: float, f_low: float, high: float, f_high: float) -> float:
    """Where the chord of a bracket is zero, or else its middle; NaN where no number is between."""
    middle = high - f_high * (high - low) / (f_high - f_low)
    if not low < middle < high:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return math.nan
    return middle


def narrowed(
    low: float, f_low: float, high: float, f_high: float, middle: float, f_middle: float, moved: int
) -> tuple[float, float, float, float, int]:
    """A bracket, negative below and positive above, with a place inside as one of its ends.

    An end that stays for the second time counts half, so that neither stays for ever: the method of
    Illinois (Dowell and Jarratt 1971). The last number says which end moved: 1 the upper, -1 the
    lower, 0 none yet.
    """
    if f_middle > 0.0:
        return low, 0.5 * f_low if moved == 1 else f_low, middle, f_middle, 1
    return middle, f_middle, high, 0.5 * f_high if moved == -1 else f_high, -1


def surge_rate(n: float, speed: float, k: list[float], y: list[float], out: list[float]) -> float:
    """Surge acceleration straight ahead, rudder amidships [m/s²]."""
    for i in range(NS):
        y[i] = 0.0
    y[State.u] = speed
    if N_AT >= 0:
        y[N_AT] = n
    rates(y, 0.0, n, 0.0, k, out)
    return out[State.u]


def self_propulsion(speed: float, k: list[float], y: list[float], out: list[float]) -> float:
    """Revolutions that hold a speed straight ahead; NaN if none do, 0 without a propeller.

    Bracketed by growing steps from almost none, then found by chords.
    """
    if REVOLUTIONS == 0:
        return 0.0
    low = 0.1 * speed / k[Constant.L]
    f_low = surge_rate(low, speed, k, y, out)
    high, f_high = low, f_low
    if not f_low < 0.0:
        return math.nan
    for _ in range(100):
        high = 1.5 * high
        f_high = surge_rate(high, speed, k, y, out)
        if f_high >= 0.0:
            break
        low, f_low = high, f_high
    if not f_high >= 0.0:
        return math.nan
    moved = 0
    for _ in range(100):
        if high - low <= 4e-16 * high or f_high == f_low:
            break
        middle = chord(low, f_low, high, f_high)
        if math.isnan(middle):
            break
        f_middle = surge_rate(middle, speed, k, y, out)
        if f_middle == 0.0:
            return middle
        low, f_low, high, f_high, moved = narrowed(
            low, f_low, high, f_high, middle, f_middle, moved
        )
    return high


def solve(a: list[float], b: list[float], m: int) -> int:
    """Solve a small system in place by elimination with pivots; 1 if it is singular."""
    for c in range(m):
        best = c
        for r in range(c + 1, m):
            if math.fabs(a[r * m + c]) > math.fabs(a[best * m + c]):
                best = r
        if not math.fabs(a[best * m + c]) > 0.0:
            return 1
        if best != c:
            for j in range(m):
                a[c * m + j], a[best * m + j] = a[best * m + j], a[c * m + j]
            b[c], b[best] = b[best], b[c]
        for r in range(c + 1, m):
            share = a[r * m + c] / a[c * m + c]
            for j in range(c, m):
                a[r * m + j] -= share * a[c * m + j]
            b[r] -= share * b[c]
    for c in range(m - 1, -1, -1):
        for j in range(c + 1, m):
            b[c] -= a[c * m + j] * b[j]
        b[c] = b[c] / a[c * m + c]
    return 0


def settle(
    y: list[float],
    delta: float,
    revolutions: float,
    bucket: float,
    speed: float,
    n0: float,
    k: list[float],
    found: list[float],
) -> int:
    """The motion without accelerations next to the states `y`, by Newton's method.

    Fills `found` and gives 0; gives 1 if there is none near.
    """
    m = len(FREE)
    size, unit, b = vector(len(FREE)), vector(len(FREE)), vector(len(FREE))
    a, above, below = vector(len(FREE) * len(FREE)), vector(NS), vector(NS)
    pace = speed / k[Constant.L]
    for i in range(m):
        at = FREE[i]
        if at == State.u or at == State.v:
            size[i], unit[i] = speed, speed * pace
        elif at == State.r:
            size[i], unit[i] = pace, pace * pace
        elif at == N_AT:
            size[i], unit[i] = max(n0, 1e-9), max(n0, 1e-9) * pace
        elif at == State.phi and k[Constant.rolls] > 0.0:
            size[i], unit[i] = 1.0, pace * pace
        else:
            size[i], unit[i] = 1.0, pace
    for i in range(NS):
        found[i] = y[i]
    if k[Constant.rolls] > 0.0:
        found[State.p] = 0.0
    for _ in range(40):
        rates(found, delta, revolutions, bucket, k, above)
        worst = 0.0
        for i in range(m):
            b[i] = above[BALANCE[i]] / unit[i]
            worst = max(worst, math.fabs(b[i]))
        if math.isnan(worst):
            return 1
        if worst < 1e-11:
            break
        for j in range(m):
            kept = found[FREE[j]]
            found[FREE[j]] = kept + 1e-6 * size[j]
            rates(found, delta, revolutions, bucket, k, above)
            found[FREE[j]] = kept - 1e-6 * size[j]
            rates(found, delta, revolutions, bucket, k, below)
            found[FREE[j]] = kept
            for i in range(m):
                a[i * m + j] = (above[BALANCE[i]] - below[BALANCE[i]]) / (2e-6 * unit[i])
        if solve(a, b, m) == 1:
            return 1
        largest = 0.0
        for i in range(m):
            found[FREE[i]] -= b[i] * size[i]
            largest = max(largest, math.fabs(b[i]))
        if not largest <= 1.0:
            return 1
        if largest < 1e-11:
            break
    else:
        return 1
    for i in range(m):
        if math.fabs(found[FREE[i]] - y[FREE[i]]) > 0.02 * size[i]:
            return 1
    return 0
