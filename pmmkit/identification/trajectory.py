"""Fit a model to trajectories: Gauss-Newton through the simulator over many short windows."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import MappingProxyType, ModuleType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Progress, SimulationError
from pmmkit.identification.binding import Binding, driven
from pmmkit.identification.lack import LackOfFit, RecordPiece, lack_of
from pmmkit.identification.passes import Steps, kind_of
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord, sensors_of
from pmmkit.models import Model
from pmmkit.numerics import Array

# Start values of the states of windows, from what is measured there and no model.


WINDOW: Final = 8.0
"""Length of a window in ship lengths over the speed of the approach."""
SETTLED: Final = 0.01
"""The fit ends when no parameter moves by more than this share of its standard deviation."""
SMALL: Final = 1e-6
ROUNDS: Final = 12
"""Times that the weights are adapted to the residuals at most."""
SAME: Final = 0.15
"""Change of the weights from which another round is worth it."""
SHORTER: Final = (1.0, 0.5, 0.25, 0.125, 0.0625)
"""Windows that are tried, over what was asked for, until no motion is lost."""
LASTING: Final = 1.5
"""Variance of the windows' scores over that of white residuals from which errors last."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrajectoryFit:
    """What a fit to trajectories found.

    `covariance (m, m)`: from the sensors, the prior, and how far the residuals are from white
    noise. `prior`: where they came from. `lack`: what says that the model lacks something.
    `inflation`: by what the variance is larger than white residuals of the sensors' size would
    make it, on the geometric mean of the channels. `rms`: root mean square of the residuals
    over the sensor's standard deviation, by channel. `tried`: what had to be tried before the
    motion was not lost. `iterations`: steps of the fit. `cost`: half the sum of squares, prior
    included.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    prior: Prior
    lack: LackOfFit
    inflation: float
    rms: Mapping[str, float]
    windows: int
    tried: tuple[str, ...]
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
    owners: NDArray[np.int64]
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
    progress: Progress | None = None,
) -> TrajectoryFit:
    """Fit parameters so that the simulated ship follows the measured one through every window.

    window [s].

    Notes
    -----
    Multiple shooting: each window begins with states of its own, which are eliminated by a QR
    factorisation of the window, so that the step for the parameters is that of the whole problem.
    Columns are scaled by the prior, steps damped after Levenberg and Marquardt.

    Where the motion is lost from the prior's mean, windows are halved until it is not, and then
    doubled again, each fit beginning from the last; the prior stays.

    What a model lacks makes residuals that are larger than the sensors' noise and slow. So each
    channel is weighed by its own residuals, and all by the variance of the windows' scores over
    what white residuals would give (both at least 1), until that is settled; otherwise the records
    would overrule the prior with thousands of instants that all say the same. What windows and
    prior still disagree about widens the covariance: see `lack_of`.
    """
    if not records:
        raise DataError("There is no record to fit to.")
    started = time.perf_counter()
    length = window or WINDOW * driven(model).ship.L / records[0].speed

    def cut(share: float) -> tuple[_Problem, Array]:
        problem = _problem(model, records, prior, sensors or {}, share * length, extrapolate)
        return problem, _first_states(problem, records, sensors or {}, model.ship.L)

    steps = Steps(most=iterations, progress=progress)
    with ThreadPoolExecutor(jobs or 4) as pool:
        begin, longest, tried = _begun(cut, prior, steps)
        found = None
        for share in [item for item in reversed(SHORTER) if item >= longest]:
            problem, first = cut(share)
            start = begin if found is None else found.values
            if not math.isfinite(_cost(problem, start, first, prior.precision)):
                tried.append(f"windows of {share * length:.3g} s, lost again")
                break
            found = _weighed(problem, first, start, steps, pool, share)
    assert found is not None
    return replace(found, tried=tuple(tried), seconds=time.perf_counter() - started)


def _begun(
    cut: Callable[[float], tuple[_Problem, Array]], prior: Prior, steps: Steps
) -> tuple[Array, float, list[str]]:
    """The longest windows through which the motion is not lost, and the values they begin from."""
    tried: list[str] = []
    for share in SHORTER:
        problem, first = cut(share)
        own = problem.binding.mean
        for word, values in {
            "the start values": prior.mean,
            "values halfway to those of the model": 0.5 * (prior.mean + own),
            "the model's own values": own,
        }.items():
            length = (problem.t[-1] - problem.t[0]) / problem.windows
            text = f"{word} through {problem.windows} windows"
            if math.isfinite(_cost(problem, values, first, prior.precision)):
                return values, share, tried
            tried.append(text)
            steps.tell(0, f"the motion is lost from {text} of about {length:.3g} s")
    raise SimulationError(
        f"The simulated motion is lost from the start values. Tried: {'; '.join(tried)}. Check the "
        f"signs of rudder and heading, and the values that are held."
    )


def _weighed(
    problem: _Problem,
    first: Array,
    start: Array,
    steps: Steps,
    pool: ThreadPoolExecutor,
    share: float,
) -> TrajectoryFit:
    """The fit with channels weighed by their own residuals."""
    afresh = start, first
    widths, lasting = np.ones(len(problem.channels)), 1.0
    settled, count = False, 0
    for turn in range(ROUNDS):
        weighed = replace(problem, sensors=problem.sensors * widths)
        words = "" if share == 1.0 else f", windows {share:g} of their length"
        found, first, ratio, pieces = _solved(
            weighed, first, start, steps, pool, f"round {turn + 1}{words}"
        )
        start, count = found.values, count + found.iterations
        rms = np.array([found.rms[name] for name in problem.channels]) * widths
        lasting = max(lasting * math.sqrt(ratio), 1.0)
        wider = np.maximum(rms, 1.0) * lasting
        settled = bool(np.all(np.abs(wider / widths - 1.0) < SAME))
        if settled:
            break
        widths = wider
        if turn == 0:
            start, first = afresh  # sharp weights may have caught the first round in a hollow
    lack = _lack(problem, found, pieces, lasting)
    return replace(
        found,
        covariance=lack.covariance,
        lack=lack,
        rms=MappingProxyType(dict(zip(problem.channels, rms.tolist(), strict=True))),
        inflation=float(np.exp(2.0 * np.mean(np.log(widths)))) * found.inflation,
        iterations=count,
        converged=found.converged and settled,
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
    binding = Binding.of(
        ready, prior.names, speed, conditions=records[0].conditions, extrapolate=extrapolate
    )
    length = window or WINDOW * L / speed
    known = sensors_of(records, sensors)
    channels = tuple(known)
    states = binding.states
    begins, owners, pieces, start = [0], [], [], 0
    for number, record in enumerate(records):
        count = max(round((record.t[-1] - record.t[0]) / length), 1)
        edges = np.linspace(record.t[0], record.t[-1], count + 1)[1:-1]
        places = np.searchsorted(record.t, edges)
        begins += [start + int(place) for place in places] + [start + len(record)]
        owners += [number] * count
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
        functions=binding.functions,
        t=np.concatenate([record.t for record in records]),
        inputs=np.concatenate([record.inputs for record in records]),
        begins=np.array(begins, np.int64),
        owners=np.array(owners, np.int64),
        measured=np.concatenate(pieces),
        kinds=np.array([kind_of(name, states) for name in channels], np.int64),
        sensors=np.array([known[name] for name in channels]),
        channels=channels,
        longest=Binding.STEP * L / speed,
        steps=np.array([SMALL * sizes.get(name, 1.0) for name in states]),
        parameter_steps=1e-4 * prior.std,
        prior=prior,
    )


def _first_states(
    problem: _Problem, records: Sequence[FreeRecord], sensors: Mapping[str, float], L: float
) -> Array:
    """Start values of the states of every window: straight lines through what is measured."""
    states = problem.binding.states
    known = sensors_of(records, sensors)
    default = [record.first_state(states, known, L)[0] for record in records]
    found, begun = [], 0
    for number, record in enumerate(records):
        own = problem.begins[:-1][problem.owners == number] - begun
        begins = np.append(own, len(record))
        length = 0.5 * L / record.speed
        found.append(record.first_states(begins, states, default[number], length))
        begun += len(record)
    return np.concatenate(found)


def _lack(
    problem: _Problem, found: TrajectoryFit, pieces: Sequence[_Piece], lasting: float
) -> LackOfFit:
    """What the windows say against the model.

    Of what the windows' scores are too large by, one half (of its logarithm) is laid to errors that
    last longer than a window, the other to values that wander.
    """
    scale, share = problem.prior.std, 1.0 / found.inflation
    told = [
        RecordPiece(
            record=int(record),
            information=share * item.normal * np.outer(scale, scale),
            score=share * item.score * scale,
        )
        for record, item in zip(problem.owners, pieces, strict=True)
    ]
    colour = {"windows": lasting} if lasting**2 > LASTING else {}
    return lack_of(problem.prior, found.covariance, told, colour, sharper=lasting)


def _solved(
    problem: _Problem, first: Array, start: Array, steps: Steps, pool: ThreadPoolExecutor, word: str
) -> tuple[TrajectoryFit, Array, float, list[_Piece]]:
    """The fit with these weights, how its windows begin, how errors last, and its windows."""
    prior = problem.prior
    scale, precision = prior.std, prior.precision
    values, damping = start.copy(), 1e-3
    cost = _cost(problem, values, first, precision)
    converged, count = False, 0
    pieces, residuals = _linear(problem, values, first, pool)
    while count < steps.most and not converged:
        count += 1
        steps.tell(count, f"step {count} of the fit, {word}, cost {cost:.4g}")
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
    covariance, ratio = _covariance(pieces, scale, precision)
    rms = {
        name: float(np.sqrt(np.nanmean(residuals[:, i] ** 2)))
        for i, name in enumerate(problem.channels)
    }
    found = TrajectoryFit(
        names=prior.names,
        values=values,
        covariance=covariance,
        prior=prior,
        lack=lack_of(prior, covariance, [], {}),
        inflation=max(ratio, 1.0),
        rms=MappingProxyType(rms),
        windows=problem.windows,
        tried=(),
        iterations=count,
        converged=converged,
        cost=cost,
        seconds=0.0,
    )
    return found, first, ratio, pieces


def _covariance(pieces: Sequence[_Piece], scale: Array, precision: Array) -> tuple[Array, float]:
    """Covariance of the parameters, and variance of the scores over that of white residuals."""
    scores = np.stack([item.score for item in pieces]) * scale
    A = sum((item.normal for item in pieces), np.zeros_like(precision)) * np.outer(scale, scale)
    sizes, vectors = np.linalg.eigh(A)
    seen = sizes > 1e-8 * sizes[-1]
    whitened = scores @ vectors[:, seen] / np.sqrt(sizes[seen])
    ratio = float(np.sum(whitened**2) / seen.sum())
    inverse = np.linalg.inv(A / max(ratio, 1.0) + precision)
    return inverse * np.outer(scale, scale), ratio


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
    shown = np.empty(problem.measured.shape)
    k = problem.binding.constants(values)
    problem.functions.shown(states, problem.inputs, problem.kinds, k, shown)
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
