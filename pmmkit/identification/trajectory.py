"""Fit a model to trajectories: Gauss-Newton through the simulator over many short windows."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import MappingProxyType, ModuleType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.equations.code_generation import ESTIMATING
from pmmkit.equations.compilation import compiled
from pmmkit.equations.layouts import Constant, InputField, OverGround, State
from pmmkit.errors import DataError, SimulationError
from pmmkit.identification.binding import Binding, bound, driven
from pmmkit.identification.filters import STEP, first_state, kind_of
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord, sensors_of
from pmmkit.models import Model
from pmmkit.numerics import Array

WINDOW: Final = 8.0
"""Length of a window in ship lengths over the speed of the approach."""
SETTLED: Final = 0.01
"""The fit ends when no parameter moves by more than this share of its standard deviation."""
SMALL: Final = 1e-6
ROUNDS: Final = 4
"""Times that the weights are adapted to the residuals."""
SAME: Final = 0.15
"""Change of the weights from which another round is worth it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrajectoryFit:
    """What a fit to trajectories found.

    Parameters
    ----------
    names : tuple of str
        Parameters.
    values : array (m,)
        Their values.
    covariance : array (m, m)
        From the sensors, the prior, and how far the residuals are from white noise.
    prior : Prior
        Where they came from.
    inflation : float
        By what the variance is larger than white residuals of the sensors' size would make it, on
        the geometric mean of the channels.
    rms : mapping of str to float
        Root mean square of the residuals over the sensor's standard deviation, by channel.
    windows : int
        Number of windows.
    iterations : int
        Steps of the fit.
    converged : bool
        Whether it settled.
    cost : float
        Half the sum of squares, prior included.
    seconds : float
        It took.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    prior: Prior
    inflation: float
    rms: Mapping[str, float]
    windows: int
    iterations: int
    converged: bool
    cost: float
    seconds: float

    @property
    def std(self) -> Array:
        """Standard deviations (m,)."""
        return np.sqrt(np.diagonal(self.covariance))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Problem:
    """All windows of all records, one after another."""

    binding: Binding
    functions: ModuleType
    t: Array
    inputs: Array
    begins: NDArray[np.int64]
    measured: Array
    kinds: NDArray[np.int64]
    sensors: Array
    channels: tuple[str, ...]
    longest: float
    steps: Array
    parameter_steps: Array
    prior: Prior

    @property
    def windows(self) -> int:
        """Their number."""
        return len(self.begins) - 1


def fit_trajectories(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    *,
    sensors: Mapping[str, float] | None = None,
    window: float | None = None,
    iterations: int = 30,
    extrapolate: bool = False,
    jobs: int | None = None,
) -> TrajectoryFit:
    """Fit parameters so that the simulated ship follows the measured one through every window.

    Parameters
    ----------
    model : Model
        Complete; its values outside `prior` are held.
    records : sequence of FreeRecord
        Records, cut into windows.
    prior : Prior
        Parameters with mean and covariance.
    sensors : mapping of str to float, optional
        Standard deviations of channels; those not named are told from the records.
    window : float, optional
        Length of a window [s]; by default 8 ship lengths at the speed of the approach. Longer ones
        weigh slow errors more, and gather more of what the model lacks.
    iterations : int
        Most steps.
    extrapolate : bool
        Allow a speed outside the range of the model's values.
    jobs : int, optional
        Threads.

    Returns
    -------
    TrajectoryFit

    Raises
    ------
    DataError
        If there is nothing to fit.
    SimulationError
        If the simulated motion is lost from the start values.

    Notes
    -----
    Multiple shooting: each window begins with states of its own, which are eliminated by a QR
    factorisation of the window, so that the step for the parameters is that of the whole problem.
    Columns are scaled by the prior, steps damped after Levenberg and Marquardt.

    What a model lacks makes residuals that are larger than the sensors' noise and slow. So each
    channel is weighed by its own residuals, and all by the variance of the windows' scores over
    what white residuals would give (both at least 1), up to four rounds; otherwise the records
    would overrule the prior with thousands of instants that all say the same.
    """
    if not records:
        raise DataError("There is no record to fit to.")
    started = time.perf_counter()
    problem = _problem(model, records, prior, sensors or {}, window, extrapolate)
    first = _first_states(problem, records, sensors or {}, model.ship.L)
    wider = np.ones(len(problem.channels))
    with ThreadPoolExecutor(jobs or 4) as pool:
        for _ in range(ROUNDS):
            widths = wider
            weighed = replace(problem, sensors=problem.sensors * widths)
            found = _solved(weighed, first, iterations, pool, started)
            rms = np.array([found.rms[name] for name in problem.channels]) * widths
            wider = np.maximum(rms, 1.0) * math.sqrt(found.inflation)
            if np.all(np.abs(wider / widths - 1.0) < SAME):
                break
    return replace(
        found,
        rms=MappingProxyType(dict(zip(problem.channels, rms.tolist(), strict=True))),
        inflation=float(np.exp(2.0 * np.mean(np.log(widths)))) * found.inflation,
    )


def _problem(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    sensors: Mapping[str, float],
    window: float | None,
    extrapolate: bool,
) -> _Problem:
    ready = driven(model)
    speed, L = records[0].speed, ready.ship.L
    binding = bound(ready, prior.names, speed, extrapolate=extrapolate)
    length = window or WINDOW * L / speed
    known = sensors_of(records, sensors)
    channels = tuple(known)
    states = binding.structure.states
    begins, pieces, start = [0], [], 0
    for record in records:
        count = max(round((record.t[-1] - record.t[0]) / length), 1)
        edges = np.linspace(record.t[0], record.t[-1], count + 1)[1:-1]
        places = np.searchsorted(record.t, edges)
        begins += [start + int(place) for place in places] + [start + len(record)]
        start += len(record)
        pieces.append(
            np.stack(
                [record.measured.get(name, np.full(len(record), np.nan)) for name in channels],
                axis=1,
            )
        )
    sizes = {"u": speed, "v": speed, "r": speed / L, "x": L, "y": L}
    return _Problem(
        binding=binding,
        functions=compiled(binding.structure, ESTIMATING),
        t=np.concatenate([record.t for record in records]),
        inputs=np.concatenate([record.inputs for record in records]),
        begins=np.array(begins, np.int64),
        measured=np.concatenate(pieces),
        kinds=np.array([kind_of(name, states) for name in channels], np.int64),
        sensors=np.array([known[name] for name in channels]),
        channels=channels,
        longest=STEP * L / speed,
        steps=np.array([SMALL * sizes.get(name, 1.0) for name in states]),
        parameter_steps=1e-4 * prior.std,
        prior=prior,
    )


def _first_states(
    problem: _Problem, records: Sequence[FreeRecord], sensors: Mapping[str, float], L: float
) -> Array:
    """Start values of the states of every window: straight lines through what is measured."""
    states = problem.binding.structure.states
    known = sensors_of(records, sensors)
    default = [first_state(record, states, known, L)[0] for record in records]
    owner = np.cumsum([0, *(len(record) for record in records)])
    first = np.zeros((problem.windows, len(states)))
    for w, begin in enumerate(problem.begins[:-1].tolist()):
        number = int(np.searchsorted(owner, begin, side="right") - 1)
        record = records[number]
        at = begin - int(owner[number])
        stop = int(np.searchsorted(record.t, record.t[at] + 0.5 * L / record.speed))
        rows = slice(at, max(stop, min(at + 3, len(record))))
        lines = {
            name: line
            for name, x in record.measured.items()
            if (line := _line(record.t[rows] - record.t[at], x[rows])) is not None
        }
        first[w] = _start(lines, states, default[number])
    return first


def _line(t: Array, values: Array) -> Array | None:
    """Slope and start of a straight line; None where nothing is measured."""
    there = np.isfinite(values)
    if there.sum() >= 2:
        return np.polyfit(t[there], values[there], 1)
    return np.array([0.0, values[there][0]]) if there.any() else None


def _start(lines: Mapping[str, Array], states: Sequence[str], default: Array) -> Array:
    """States from slopes and starts of the channels."""
    found = default.copy()
    place = {name: i for i, name in enumerate(states)}
    for name, i in place.items():
        if name in lines:
            found[i] = lines[name][1]
    if "psi" in lines and "r" not in lines:
        found[place["r"]] = lines["psi"][0]
    if {"x", "y", "psi"} <= set(lines) and "u" not in lines:
        psi, north, east = lines["psi"][1], lines["x"][0], lines["y"][0]
        found[place["u"]] = north * math.cos(psi) + east * math.sin(psi)
        found[place["v"]] = east * math.cos(psi) - north * math.sin(psi)
    return found


def _solved(
    problem: _Problem, first: Array, most: int, pool: ThreadPoolExecutor, started: float
) -> TrajectoryFit:
    prior = problem.prior
    scale = prior.std
    precision = np.linalg.inv(prior.covariance / np.outer(scale, scale)).astype(float)
    values, damping = prior.mean.copy(), 1e-3
    cost = _cost(problem, values, first, precision)
    if not math.isfinite(cost):
        raise SimulationError(
            "The simulated motion is lost from the start values. Check the signs of rudder and "
            "heading, or give shorter windows."
        )
    converged, count = False, 0
    while count < most and not converged:
        count += 1
        pieces, _ = _linear(problem, values, first, pool)
        A = sum((item.normal for item in pieces), np.zeros_like(precision))
        b = sum((item.score for item in pieces), np.zeros(len(scale)))
        A = A * np.outer(scale, scale) + precision
        b = b * scale + precision @ ((prior.mean - values) / scale)
        std = scale * np.sqrt(np.diagonal(np.linalg.inv(A)))
        while damping < 1e8:
            step = scale * np.linalg.solve(A + damping * np.diag(np.diagonal(A)), b)
            moved, begun = values + step, first + np.stack([item.follow(step) for item in pieces])
            new = _cost(problem, moved, begun, precision)
            if new <= cost * (1 + 1e-12):
                break
            damping *= 10.0
        else:
            converged = True
            break
        gained = cost - new
        values, first, cost = moved, begun, new
        damping = max(damping / 10.0, 1e-9)
        converged = bool(np.max(np.abs(step) / std) < SETTLED and gained < 1e-6 * max(cost, 1.0))
    pieces, residuals = _linear(problem, values, first, pool)
    covariance, inflation = _covariance(pieces, scale, precision)
    rms = {
        name: float(np.sqrt(np.nanmean(residuals[:, i] ** 2)))
        for i, name in enumerate(problem.channels)
    }
    return TrajectoryFit(
        names=prior.names,
        values=values,
        covariance=covariance,
        prior=prior,
        inflation=inflation,
        rms=MappingProxyType(rms),
        windows=problem.windows,
        iterations=count,
        converged=converged,
        cost=cost,
        seconds=time.perf_counter() - started,
    )


def _covariance(pieces: Sequence[_Piece], scale: Array, precision: Array) -> tuple[Array, float]:
    """Covariance of the parameters, and how much wider it is than white residuals make it."""
    scores = np.stack([item.score for item in pieces]) * scale
    A = sum((item.normal for item in pieces), np.zeros_like(precision)) * np.outer(scale, scale)
    sizes, vectors = np.linalg.eigh(A)
    seen = sizes > 1e-8 * sizes[-1]
    whitened = scores @ vectors[:, seen] / np.sqrt(sizes[seen])
    inflation = max(1.0, float(np.sum(whitened**2) / seen.sum()))
    inverse = np.linalg.inv(A / inflation + precision)
    return inverse * np.outer(scale, scale), inflation


def _simulated(problem: _Problem, values: Array, first: Array) -> Array:
    """States at all instants; NaN where the mass matrix is lost."""
    k = problem.binding.constants(values)
    out = np.full((len(problem.t), first.shape[1]), np.nan)
    if problem.functions.complete(k) == 0:
        problem.functions.windows(
            problem.t, problem.inputs, problem.begins, first, k, problem.longest, out
        )
    return out


def _residuals(problem: _Problem, states: Array, values: Array) -> Array:
    """Measured less simulated, over the sensors' standard deviations; NaN where not measured."""
    k = problem.binding.constants(values)
    shown = np.empty((len(states), len(problem.kinds)))
    ahead, aside = np.cos(states[:, State.psi]), np.sin(states[:, State.psi])
    rolls = problem.binding.structure.rolls
    heel = states[:, State.phi] if rolls else problem.inputs[:, InputField.roll]
    level = states[:, State.v] * np.cos(heel)
    north = states[:, State.u] * ahead - level * aside + k[Constant.current_x]
    east = states[:, State.u] * aside + level * ahead + k[Constant.current_y]
    other: dict[int, Array] = {
        OverGround.north: north,
        OverGround.east: east,
        OverGround.size: np.hypot(north, east),
    }
    for i, kind in enumerate(problem.kinds.tolist()):
        shown[:, i] = other[kind] if kind in other else states[:, kind]
    return (problem.measured - shown) / problem.sensors


def _cost(problem: _Problem, values: Array, first: Array, precision: Array) -> float:
    with np.errstate(all="ignore"):
        residuals = _residuals(problem, _simulated(problem, values, first), values)
        there = np.isfinite(problem.measured)
        total = float(np.sum(residuals[there] ** 2))
    away = (values - problem.prior.mean) / problem.prior.std
    return 0.5 * (total + float(away @ precision @ away)) if math.isfinite(total) else math.inf


@dataclass(frozen=True, kw_only=True, eq=False)
class _Piece:
    """A window with its own states eliminated: normal matrix and score of the parameters."""

    normal: Array
    score: Array
    back: Array
    along: Array
    toward: Array

    def follow(self, step: Array) -> Array:
        """Change of the window's first states that goes with a step of the parameters."""
        change: Array = self.back @ (self.toward - self.along @ step)
        return change


def _linear(
    problem: _Problem, values: Array, first: Array, pool: ThreadPoolExecutor
) -> tuple[list[_Piece], Array]:
    """Every window made linear, and all residuals."""
    residuals = _residuals(problem, _simulated(problem, values, first), values)
    size, m = first.shape[1], len(values)

    def column(number: int) -> Array:
        moved, changed = first, values
        if number < size:
            step = problem.steps[number]
            moved = first.copy()
            moved[:, number] += step
        else:
            step = problem.parameter_steps[number - size]
            changed = values.copy()
            changed[number - size] += step
        there = _residuals(problem, _simulated(problem, changed, moved), changed)
        slope: Array = (residuals - there) / step
        return slope

    slopes = np.stack(list(pool.map(column, range(size + m))), axis=-1)
    there = np.isfinite(problem.measured)
    pieces = []
    for begin, end in zip(problem.begins[:-1], problem.begins[1:], strict=True):
        at = there[begin:end]
        J, r = slopes[begin:end][at], residuals[begin:end][at]
        own = np.maximum(np.linalg.norm(J[:, :size], axis=0), 1e-300)
        left, singular, right = np.linalg.svd(J[:, :size] / own, full_matrices=False)
        seen = singular > 1e-9 * np.max(singular, initial=0.0)
        left, back = left[:, seen], (right[seen].T / singular[seen]) / own[:, None]
        along, toward = left.T @ J[:, size:], left.T @ r
        rest, remaining = J[:, size:] - left @ along, r - left @ toward
        pieces.append(
            _Piece(
                normal=rest.T @ rest,
                score=rest.T @ remaining,
                back=back,
                along=along,
                toward=toward,
            )
        )
    return pieces, residuals
