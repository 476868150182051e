"""Facts about recorded motions: velocities against positions, lags, jumps, scales."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Attitude
from pmmkit.intake.checks.positions import position_facts
from pmmkit.numerics import Array, last_digits, unwrapped
from pmmkit.signals import white_noise

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.campaigns import Run

NDArrayInt = NDArray[np.int64]
NDArrayBool = NDArray[np.bool_]

DIGITS: Final = 20
"""Last digits of a column without which its rate of change is that of the rounding."""
WINDOW: Final = 1.0
LONG: Final = 6.0
LAGS: Final = 3.0
KEPT: Final = 0.9
JUMPS: Final = 6.0
TRIMMED: Final = 0.744
"""Mean square of normal noise in a plane without its largest tenth, over that of all of it."""
_POINTS: Final = 1500
_GRID: Final = 61


def velocity_facts(
    t: Array,
    x: Array,
    y: Array,
    psi: Array,
    u: Array,
    v: Array,
    phi: Array | None = None,
    *,
    white: bool = False,
) -> Mapping[str, float]:
    """Compare recorded velocities with the positions, in ship axes and in earth axes.

    Both are averaged over the same stretches of about a second (a position difference is the mean
    of the true velocity over the stretch), so that neither noise nor smoothing biases the answer.

    t, x, y, psi [s]; u, v [m/s].

    Examples
    --------
    >>> t = np.arange(0, 60, 0.1)
    >>> psi = 0.02 * t
    >>> north, east = np.sin(psi) / 0.02, (1 - np.cos(psi)) / 0.02
    >>> facts = velocity_facts(t, north, east, psi, np.cos(psi), np.sin(psi))
    >>> facts["earth"] < 1e-4, facts["body"] > 0.5
    (True, True)
    """
    ahead, across = Attitude(psi=psi, phi=0.0 if phi is None else phi).over_ground(u, v)
    start, stop = _stretches(t)
    span = t[stop] - t[start]
    noise = _noise_of_rates((x, y), (u, v), span, int(stop[0] - start[0])) if white else 0.0
    truth = np.stack([x[stop] - x[start], y[stop] - y[start]]) / span
    body = np.stack([_averages(t, ahead, start, stop), _averages(t, across, start, stop)])
    earth = np.stack([_averages(t, u, start, stop), _averages(t, v, start, stop)])
    best = body if _usual(body - truth) <= _usual(earth - truth) else earth
    lag, lagged = _lag(t, np.stack([x, y]), best, start, stop)
    power = float(np.sum(truth**2)) - len(span) * noise
    flow = np.mean(truth - body, axis=1)
    steps = np.diff(np.stack([x, y]))
    rows = np.stack([ahead, across]) if best is body else np.stack([u, v])
    moved = 0.5 * (rows[:, 1:] + rows[:, :-1]) * np.diff(t)
    miss = np.hypot(*(steps - moved))
    usual = float(np.median(miss)) + 1e-9
    jumps = miss > np.maximum(20 * usual, 0.05 * _rms(truth) + 0.02)
    return {
        "speed": _without(_rms(truth), noise),
        "body": _without(_usual(body - truth), TRIMMED * noise),
        "earth": _without(_usual(earth - truth), TRIMMED * noise),
        "lag": lag,
        "lagged": _without(lagged, TRIMMED * noise),
        "scale": float(np.sum(best * truth)) / power if power else math.nan,
        "jump": float(miss.max()) if jumps.any() else 0.0,
        "jumps": float(np.count_nonzero(jumps)),
        "flow_x": float(flow[0]),
        "flow_y": float(flow[1]),
        "flown": _without(_usual(body + flow[:, None] - truth), TRIMMED * noise),
        "swung": float(np.ptp(psi)),
    }


def _noise_of_rates(
    places: Sequence[Array], columns: Sequence[Array], span: Array, width: int
) -> float:
    """Variance that white noise gives the difference of both over stretches [m²/s²]."""
    fixes = sum(white_noise(part) ** 2 for part in places)
    samples = sum(white_noise(part) ** 2 for part in columns)
    return float(2.0 * fixes * np.mean(1.0 / span**2) + samples / width)


def _without(rms: float, variance: float) -> float:
    return math.sqrt(max(rms**2 - variance, 0.0)) if variance else rms


def rate_facts(t: Array, angle: Array, rate: Array) -> Mapping[str, float]:
    """Compare a recorded rate with the difference of what it is the rate of.

    Examples
    --------
    >>> t = np.arange(0, 60, 0.1)
    >>> round(rate_facts(t, np.sin(t), np.degrees(np.cos(t)))["slope"])
    57
    """
    start, stop = _stretches(t)
    truth, found = _rates(t, angle, rate, start, stop)
    power = float(np.mean(truth**2))
    if power == 0:
        return {}
    # an angle is written in degrees, or as it stands here
    last = np.maximum(last_digits(angle), np.radians(last_digits(np.degrees(angle))))
    slope = _slope(truth, found, _rounding(t, last, start, stop))
    start_long, stop_long = _stretches(t, LONG)
    long_truth, long_found = _rates(t, angle, rate, start_long, stop_long)
    if float(np.mean(long_truth**2)) > 0.3 * power:
        slope = _slope(long_truth, long_found, _rounding(t, last, start_long, stop_long))
    scaled = found / slope if abs(slope) > 1e-6 else found
    lag, _ = _lag(t, angle[None], scaled[None], start, stop)
    return {"slope": slope, "left": _usual(found - truth) / math.sqrt(power), "lag": lag}


def _rates(
    t: Array, angle: Array, rate: Array, start: NDArrayInt, stop: NDArrayInt
) -> tuple[Array, Array]:
    return (angle[stop] - angle[start]) / (t[stop] - t[start]), _averages(t, rate, start, stop)


def _rounding(t: Array, last: Array, start: NDArrayInt, stop: NDArrayInt) -> Array:
    """Variance that the last digits of an angle give its mean rate over each stretch."""
    both: Array = (last[start] ** 2 + last[stop] ** 2) / 12.0
    return both / (t[stop] - t[start]) ** 2


def _slope(truth: Array, found: Array, variance: Array) -> float:
    """Least squares through the origin, with the variance of the true rates taken off their
    squares, half of them at most; what misses by 6 times the usual is left out."""

    def fitted(use: NDArray[np.bool_]) -> float:
        squares = float(truth[use] @ truth[use])
        own = max(squares - float(np.sum(variance[use])), squares / 2.0, 1e-300)
        return float(truth[use] @ found[use]) / own

    slope = fitted(np.ones(len(truth), bool))
    miss = np.abs(found - slope * truth)
    return fitted(miss <= JUMPS * np.median(miss) + 1e-12)


def free_facts(data: xr.Dataset, t: Array) -> Mapping[str, float]:
    """Facts of a free-running record: positions, velocities, yaw rate, rudder."""
    column = _columns(data)
    psi = unwrapped(column["psi"]) if "psi" in column else None
    facts: dict[str, float] = {}
    if {"x", "y"} <= set(column):
        names = [name for name in ("x", "y", "lat", "lon", "sog") if name in column]
        good = _finite(*(column[name] for name in names))
        if np.count_nonzero(good) > 50:
            facts |= position_facts({name: column[name][good] for name in names}, t[good])
    if psi is not None and {"x", "y", "u", "v"} <= set(column):
        heel = [column["phi"]] if "phi" in column else []
        series = (column["x"], column["y"], psi, column["u"], column["v"], *heel)
        good = _finite(*series)
        if np.count_nonzero(good) > 50:
            facts |= velocity_facts(t[good], *(part[good] for part in series), white=True)
    if psi is not None and {"x", "y", "xdot", "ydot"} <= set(column):
        series = (column["x"], column["y"], psi, column["xdot"], column["ydot"])
        good = _finite(*series)
        if np.count_nonzero(good) > 50:
            found = velocity_facts(t[good], *(part[good] for part in series))
            facts |= {"dot_body": found["body"], "dot_earth": found["earth"]}
            facts.setdefault("speed", found["speed"])
    if psi is not None and "r" in column:
        good = _finite(psi, column["r"])
        if np.count_nonzero(good) > 50:
            facts |= _named("r", rate_facts(t[good], psi[good], column["r"][good]))
    if {"delta", "r"} <= set(column):
        facts |= _rudder_facts(t, column["delta"], column["r"])
    return facts


def motion_facts(run: Run, data: xr.Dataset, t: Array) -> Mapping[str, float]:
    """Facts of a captive record: velocities against positions, accelerations against velocities."""
    column = _columns(data)
    facts: dict[str, float] = {}
    if "psi" in column and "r" in column and np.ptp(column["psi"]) > 1e-3:
        facts |= _named("r", rate_facts(t, unwrapped(column["psi"]), column["r"]))
    if "y" in column and {"u", "v"} <= set(column) and run.dynamic:
        psi = column.get("psi", np.full(len(t), run.settings.drift))
        x = column.get("x", np.zeros(len(t)))
        counted = [x + run.settings.speed * (t - t[0]), *([x] if "x" in column else [])]
        facts |= min(
            (velocity_facts(t, x, column["y"], psi, column["u"], column["v"]) for x in counted),
            key=lambda found: min(found["body"], found["earth"]),
        )
    for name in ("u", "v", "r"):
        rate = f"{name}dot"
        if name in column and rate in column and run.dynamic and _moves(column[name]):
            facts |= _named(rate, rate_facts(t, column[name], column[rate]))
    half = len(t) // 2
    for name in ("u", "v", "r"):
        if name in column:
            facts[f"{name}_mean"] = float(np.mean(column[name][half:]))
    return facts


def _moves(values: Array) -> bool:
    """Whether a column changes by much more than the last digit that is written of it."""
    steps = np.diff(np.unique(values))
    return bool(len(steps)) and float(np.ptp(values)) > max(1e-6, DIGITS * float(steps.min()))


def _columns(data: xr.Dataset) -> Mapping[str, Array]:
    names = (
        "x",
        "y",
        "psi",
        "phi",
        "u",
        "v",
        "r",
        "udot",
        "vdot",
        "rdot",
        "xdot",
        "ydot",
        "delta",
        "lat",
        "lon",
        "sog",
    )
    found = {name: np.asarray(data.variables[name].values, float) for name in names if name in data}
    return {name: part for name, part in found.items() if part.ndim and np.isfinite(part).any()}


def _rudder_facts(t: Array, delta: Array, r: Array) -> Mapping[str, float]:
    """First-order response of the yaw rate: ṙ = a r + b δ; the sign of b tells the rudder's."""
    good = _finite(delta, r)
    if np.count_nonzero(good) < 50 or np.ptp(delta[good]) + abs(delta[good].mean()) < 1e-3:
        return {}
    t, delta, r = t[good], delta[good], r[good]
    start, stop = _stretches(t)
    basis = np.stack([_averages(t, r, start, stop), _averages(t, delta, start, stop)], axis=1)
    growth = (r[stop] - r[start]) / (t[stop] - t[start])
    fitted, left, rank, _ = np.linalg.lstsq(basis, growth, rcond=None)
    if rank < 2 or not left.size:
        return {}
    inverse = np.linalg.inv(basis.T @ basis)
    std = math.sqrt(float(left[0]) / len(growth) * float(inverse[1, 1]) * 10)
    return {"yaw_per_rudder": float(fitted[1])} if abs(fitted[1]) > 3 * std else {}


def _stretches(t: Array, seconds: float = WINDOW) -> tuple[NDArrayInt, NDArrayInt]:
    """First and last index of overlapping stretches of so many seconds."""
    step = float(np.median(np.diff(t)))
    width = int(np.clip(round(seconds / step), 2, max(2, len(t) // 10)))
    start = np.unique(np.linspace(0, len(t) - 1 - width, _POINTS).astype(int))
    return start, start + width


def _averages(t: Array, values: Array, start: NDArrayInt, stop: NDArrayInt) -> Array:
    area = np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))))
    averages: Array = (area[stop] - area[start]) / (t[stop] - t[start])
    return averages


def _lag(
    t: Array, places: Array, found: Array, start: NDArrayInt, stop: NDArrayInt
) -> tuple[float, float]:
    """By how much ``found`` is late against the rate of ``places``, and the rms then left; looked
    for further where it is least at the end of what was looked through, and not told where it
    stays there."""
    furthest = 0.2 * float(t[-1] - t[0])
    reach = min(LAGS, furthest)
    while True:
        inner = (t[start] - reach >= t[0]) & (t[stop] + reach <= t[-1])
        if np.count_nonzero(inner) < 20:
            return 0.0, math.nan
        begin, end, seen = t[start[inner]], t[stop[inner]], found[:, inner]

        def left(lag: float, begin: Array = begin, end: Array = end, seen: Array = seen) -> float:
            moved = [np.interp(end - lag, t, x) - np.interp(begin - lag, t, x) for x in places]
            return _usual(seen - np.stack(moved) / (end - begin))

        lags = np.linspace(-reach, reach, _GRID)
        rms = np.array([left(lag) for lag in lags.tolist()])
        best = int(np.argmin(rms))
        if 0 < best < _GRID - 1:
            break
        if reach == furthest:
            return 0.0, math.nan
        reach = min(2.0 * reach, furthest)
    low, mid, high = rms[best - 1 : best + 2] ** 2
    bend = low - 2 * mid + high
    shift = 0.5 * (low - high) / bend if bend > 0 else 0.0
    lag = float(lags[best] + shift * (lags[1] - lags[0]))
    after = left(lag)
    return (lag, after) if after < rms[best] else (float(lags[best]), float(rms[best]))


def _named(prefix: str, facts: Mapping[str, float]) -> Mapping[str, float]:
    return {f"{prefix}_{name}": value for name, value in facts.items()}


def _finite(*series: Array) -> NDArrayBool:
    good: NDArrayBool = np.logical_and.reduce([np.isfinite(part) for part in series])
    return good


def _usual(values: Array) -> float:
    """Root mean square of all but the tenth that is largest, so that jumps do not count."""
    size = np.sort(np.sum(np.atleast_2d(values) ** 2, axis=0))
    return float(np.sqrt(np.mean(size[: max(1, round(KEPT * len(size)))])))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(np.atleast_2d(values) ** 2, axis=0))))
