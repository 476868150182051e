"""Extended and unscented Kalman filters: parameters of a model as states beside the motion."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType, ModuleType
from typing import Final, Literal

import numpy as np

from pmmkit.base import DataError, Progress, SimulationError
from pmmkit.identification.binding import Binding, driven
from pmmkit.identification.lack import LackOfFit, RecordPiece, colour_of, lack_of, stretches
from pmmkit.identification.passes import Pass, Process, Steps, passed, seen, state_steps
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord, sensors_of
from pmmkit.inference import Consistency, Innovations
from pmmkit.models import Model
from pmmkit.numerics import Array, precision_over

GATE: Final = 5.0
"""Residuals beyond so many of their standard deviations are not taken in."""
SETTLED: Final = 0.02
"""Iterations end when no parameter changes by more than this share of its standard deviation."""
ROUGHNESS: Final = (0.0, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0)
"""Process noise that is tried, in U²/L over the root of L/U."""
FIRST: Final = 0.03
"""Process noise of the passes before it is chosen."""
NEAR: Final = 0.5
"""As `SETTLED`, for the passes before the process noise is chosen."""
WINDOW: Final = 8.0
"""Length of the windows that are set against each other, in ship lengths over the speed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Filtered:
    """What a filter found.

    Parameters
    ----------
    method : {"ekf", "ukf"}
        Which.
    names : tuple of str
        Parameters.
    values : array (m,)
        At the end of the last record.
    covariance : array (m, m)
        Of them, widened by what the model lacks.
    prior : Prior
        Where they came from.
    lack : LackOfFit
        What says that the model lacks something.
    histories : mapping of str to array
        By record: states and parameters at each instant (n, NS + m).
    spreads : mapping of str to array
        Their variances.
    innovations : mapping of str to Innovations
        By record.
    iterations : int
        Passes over the records.
    converged : bool
        Whether the last pass changed nothing of weight.
    roughness : float
        Process noise of the accelerations, in U²/L over the root of L/U.
    seconds : float
        It took.
    """

    method: Literal["ekf", "ukf"]
    names: tuple[str, ...]
    values: Array
    covariance: Array
    prior: Prior
    lack: LackOfFit
    histories: Mapping[str, Array]
    spreads: Mapping[str, Array]
    innovations: Mapping[str, Innovations]
    iterations: int
    converged: bool
    roughness: float
    seconds: float

    @property
    def std(self) -> Array:
        """Standard deviations (m,)."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def log_likelihood(self) -> float:
        """Of all records."""
        return sum(item.log_likelihood() for item in self.innovations.values())

    @property
    def consistency(self) -> Consistency:
        """Whether the innovations are as large as the filter thinks, and white.

        Notes
        -----
        The filters take the channels of an instant one after another, so the innovations of a right
        filter are independent across channels too, and n times the mean of the normalised squares
        is chi square distributed with n degrees of freedom (Bar-Shalom, Li and Kirubarajan 2001,
        section 5.4). Pairs with a gap between them, or across records, are left out of the
        correlations.
        """
        return Consistency.of(self.innovations)


@dataclass(frozen=True, kw_only=True)
class _Setup:
    """All that stays the same over the passes."""

    binding: Binding
    functions: ModuleType
    records: tuple[FreeRecord, ...]
    sensors: Mapping[str, float]
    prior: Prior
    speed: float
    L: float
    gate: float
    longest: float
    wander: Array = field(repr=False)


def kalman(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    *,
    method: Literal["ekf", "ukf"] = "ekf",
    sensors: Mapping[str, float] | None = None,
    roughness: float | None = None,
    wander: Mapping[str, float] | None = None,
    gate: float = GATE,
    iterations: int = 10,
    extrapolate: bool = False,
    about: Array | None = None,
    first: float = FIRST,
    step: float = Binding.STEP,
    progress: Progress | None = None,
) -> Filtered:
    """Identify parameters by a Kalman filter over free-running records, one after another.

    about (m,).

    Notes
    -----
    Between instants the equations of motion are carried by the classical Runge-Kutta method with
    steps of at most 0.05 L/U; slopes are differences of that map. A pass of the extended filter is
    linearised in the parameters about the result of the pass before (the prior stays), until
    nothing changes by more than 2 % of its standard deviation. Process noise acts through the whole
    interval, so that it reaches heading and position too and is damped (Van Loan 1978); its size is
    the best of a scale of values, climbed from the first. What wanders does so all the time. The
    unscented filter makes one pass. Revolutions are inputs, even where the model has a shaft. What
    the model lacks widens the covariance: see `lack_of`; its windows are 8 ship lengths long and
    begin from what is measured there.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan 2001, sections 5 and 10; Julier and Uhlmann 2004; Van Loan 1978;
    Särkkä and Solin 2019, chapter 6.
    """
    if not records:
        raise DataError("There is no record to identify from.")
    started = time.perf_counter()
    ready = driven(model)
    speed = records[0].speed
    binding = Binding.of(
        ready, prior.names, speed, conditions=records[0].conditions, extrapolate=extrapolate
    )
    pace = speed / ready.ship.L
    wander = wander or {}
    setup = _Setup(
        binding=binding,
        functions=binding.functions,
        records=tuple(records),
        sensors=MappingProxyType(sensors_of(records, sensors or {})),
        prior=prior,
        speed=speed,
        L=ready.ship.L,
        gate=gate,
        longest=step / pace,
        wander=np.array([wander.get(name, 0.0) ** 2 * pace for name in prior.names]),
    )
    begin = prior.mean if about is None else about
    passes = Steps(most=2 * iterations + len(ROUGHNESS), progress=progress)
    if method == "ukf":
        chosen = roughness if roughness is not None else _roughest(setup, begin, first, passes)
        return _filtered(setup, "ukf", chosen, begin, 1, True, started)
    tried = first if roughness is None else roughness
    goal = SETTLED if roughness is not None else NEAR
    begin, count, done = _iterated(setup, tried, begin, iterations, goal, passes)
    if roughness is None:
        tried = _roughest(setup, begin, first, passes)
        begin, more, done = _iterated(setup, tried, begin, iterations, SETTLED, passes)
        count += more
    return _filtered(setup, "ekf", tried, begin, count, done, started)


def _iterated(
    setup: _Setup, roughness: float, about: Array, most: int, goal: float, passes: Steps
) -> tuple[Array, int, bool]:
    """The point about which the parameters are linearised, until it is their estimate."""
    change = math.inf
    for count in range(1, most + 1):
        moved = f", values moved by {change:.2g} of their spread" if count > 1 else ""
        passes.tell(count, f"pass {count} over the records{moved}")
        z, P = _pass(setup, "ekf", roughness, about)[:2]
        std = np.sqrt(np.diagonal(P))
        change = float(np.max(np.abs(z - about) / np.maximum(std, 1e-300), initial=0.0))
        about = z
        if change < goal:
            return about, count, True
    return about, most, False


def _roughest(setup: _Setup, about: Array, first: float, passes: Steps) -> float:
    """Process noise of the greatest likelihood, climbed to from the first."""
    found: dict[int, float] = {}

    def likelihood(place: int) -> float:
        if not 0 <= place < len(ROUGHNESS):
            return -math.inf
        if place not in found:
            passes.tell(len(found), f"process noise {ROUGHNESS[place]:g}")
            try:
                runs = _pass(setup, "ekf", ROUGHNESS[place], about)[2]
                found[place] = sum(run.innovations.log_likelihood() for run in runs)
            except SimulationError:
                found[place] = -math.inf
        return found[place]

    at = int(np.argmin(np.abs(np.array(ROUGHNESS) - first)))
    while (best := max((at, at + 1, at - 1), key=likelihood)) != at:
        at = best
    if likelihood(at) == -math.inf:
        at = max(range(len(ROUGHNESS)), key=likelihood)
    return ROUGHNESS[at]


def _lack(
    setup: _Setup,
    roughness: float,
    values: Array,
    covariance: Array,
    innovations: Mapping[str, Innovations],
    method: Literal["ekf", "ukf"],
) -> LackOfFit:
    """What the records say against the model; values that wander need no more room.

    Windows are linearised about the values whichever filter found them: sigma points as wide as a
    prior tell a window of a stalling rudder more than all records hold.
    """
    if np.any(setup.wander > 0.0):
        return lack_of(setup.prior, covariance, [], {})
    scale = setup.prior.std
    known = setup.prior.precision
    start, there = setup.prior.mean / scale, values / scale
    pieces = []
    for number, record in enumerate(setup.records):
        for window in stretches(record, WINDOW * setup.L / record.speed):
            alone = replace(setup, records=(window,))
            try:
                z, P, _ = _pass(alone, "ekf", roughness, values)
            except SimulationError:
                continue
            told = precision_over(P, scale)
            score = told @ (z / scale - there) - known @ (start - there)
            pieces.append(RecordPiece(record=number, information=told - known, score=score))
    samples = {
        record.name: setup.L / record.speed / float(np.median(np.diff(record.t)))
        for record in setup.records
    }
    colour = colour_of(innovations, samples)
    return lack_of(setup.prior, covariance, pieces, colour, sigma_points=method == "ukf")


def _filtered(
    setup: _Setup,
    method: Literal["ekf", "ukf"],
    roughness: float,
    about: Array,
    count: int,
    done: bool,
    started: float,
) -> Filtered:
    z, P, runs = _pass(setup, method, roughness, about)
    by_name = {record.name: run for record, run in zip(setup.records, runs, strict=True)}
    innovations = {name: run.innovations for name, run in by_name.items()}
    lack = _lack(setup, roughness, z, P, innovations, method)
    return Filtered(
        method=method,
        names=setup.prior.names,
        values=z,
        covariance=lack.covariance,
        prior=setup.prior,
        lack=lack,
        histories=MappingProxyType({name: run.means for name, run in by_name.items()}),
        spreads=MappingProxyType({name: run.variances for name, run in by_name.items()}),
        innovations=MappingProxyType(innovations),
        iterations=count,
        converged=done,
        roughness=roughness,
        seconds=time.perf_counter() - started,
    )


def _pass(
    setup: _Setup, method: Literal["ekf", "ukf"], roughness: float, about: Array
) -> tuple[Array, Array, list[Pass]]:
    """One pass over all records: parameters, their covariance, and what each record shows."""
    prior, states = setup.prior, setup.binding.states
    size, binding = len(states), setup.binding.about(about)
    values, covariance = prior.mean, prior.covariance
    moving = Process(
        diffusion=np.concatenate([process(states, roughness, setup.speed, setup.L), setup.wander]),
        fading=np.zeros(len(prior.names)),
        frozen=np.where(setup.wander > 0.0, 0.0, 1.0),
        steps=np.concatenate([state_steps(states, setup.speed, setup.L), 1e-4 * prior.std]),
        longest=setup.longest,
    )
    runs = []
    for record in setup.records:
        y, spread = record.first_state(states, setup.sensors, setup.L)
        P = np.diag(np.concatenate([spread, np.zeros(len(values))]))
        P[size:, size:] = covariance
        run = passed(
            setup.functions,
            binding,
            seen(record, states, setup.sensors),
            moving,
            np.concatenate([y, values]),
            P,
            method=method,
            gate=setup.gate,
        )
        values, covariance = run.z[size:], run.P[size:, size:]
        runs.append(run)
    return values, covariance, runs


def process(states: Sequence[str], roughness: float, speed: float, L: float) -> Array:
    """Growth of the variances of the velocities per second."""
    unit = (roughness * speed**2 / L) ** 2 * L / speed
    growth = {"u": unit, "v": unit, "r": unit / L**2, "p": unit / L**2}
    return np.array([growth.get(name, 0.0) for name in states])


def with_forces(
    y: Array, variances: Array, spread: Array, fading: Array
) -> tuple[Array, Array, Array]:
    """State, covariance and diffusion of a filter that looks for unknown forces too.

    spread, fading (m,); spread, fading [1/s].
    """
    return (
        np.concatenate([y, np.zeros(len(spread))]),
        np.diag(np.concatenate([variances, spread**2])),
        np.concatenate([np.zeros(len(y)), 2.0 * spread**2 * fading]),
    )
