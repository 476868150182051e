"""Free-running records as whitened residuals of a model, and how these hang on its values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import MappingProxyType, ModuleType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects.seen import RUDDER_ZERO
from pmmkit.equations.code_generation import ESTIMATING
from pmmkit.equations.compilation import compiled
from pmmkit.equations.histories import rigid_body
from pmmkit.equations.layouts import InputField, Status
from pmmkit.errors import DataError, SimulationError
from pmmkit.identification.binding import FORCES, Binding, bound, driven
from pmmkit.identification.filters import (
    GATE,
    LOST,
    STEP,
    first_state,
    kind_of,
    state_steps,
    with_forces,
)
from pmmkit.identification.record import FreeRecord, sensors_of
from pmmkit.identification.smoother import units
from pmmkit.models import Model
from pmmkit.numerics import Array

PACE: Final = 0.04
"""Records are thinned to instants so far apart, in ship lengths over the speed."""
MEMORIES: Final = ((0.1, 0.5), (0.3, 3.0))
"""Times over which unknown forces hang together, in ship lengths over the speed: each channel has
a fast one and a slow one. The pair that makes the records more likely is taken."""
AGILE: Final = 0.1
"""Size of the unknown forces that follow any ship and tell outliers, over ½ρLdU² and ½ρL²dU²."""
BLOCK: Final = 4.0
"""Length of the blocks whose scores are compared, in ship lengths over the speed."""
FACTORS: Final = (4.0, 4.0, 4.0, 2.0, 1.4)
"""By which the sizes of the unknown forces are varied, round by round."""
NO_GATE: Final = 1e9


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """One record with its equations.

    Parameters
    ----------
    record : FreeRecord
        Thinned, its outliers left out.
    binding, forces : Binding
        Constants over the values that may move; over the unknown forces.
    functions : module
        Compiled.
    first : tuple of array
        First states and their variances.
    """

    record: FreeRecord
    binding: Binding
    forces: Binding
    functions: ModuleType
    first: tuple[Array, Array]


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeSystem:
    """Records, the values that may move, and the size of what no candidate explains.

    Parameters
    ----------
    model : Model
        With a place for every candidate.
    names : tuple of str
        Values that may move.
    start : array (m,)
        Those of the model.
    pieces : tuple of Piece
        The records.
    sensors : mapping of str to float
        Standard deviation of each channel.
    shares : array (f,)
        Standard deviation of the unknown forces X, Y, N (K) over ½ρLdU² (½ρL²dU²).
    least : array (f,)
        What they may not fall below: the floor.
    memories : (float, float)
        Of `MEMORIES`.
    variances : tuple of array (n, c)
        Of the innovations of each record, held; empty before they are.
    """

    model: Model
    names: tuple[str, ...]
    start: Array
    pieces: tuple[Piece, ...]
    sensors: Mapping[str, float]
    shares: Array
    least: Array
    memories: tuple[float, float] = MEMORIES[0]
    variances: tuple[Array, ...] = ()

    def with_shares(self, shares: Array) -> FreeSystem:
        """The same with unknown forces of another size, none below the floor."""
        return replace(self, shares=np.maximum(shares, self.least), variances=())


def build_free(
    model: Model,
    records: Sequence[FreeRecord],
    names: Sequence[str],
    *,
    sensors: Mapping[str, float] | None = None,
    floor: float,
    extrapolate: bool = False,
) -> FreeSystem:
    """The system of records.

    Parameters
    ----------
    model : Model
        With a place for every name.
    records : sequence of FreeRecord
        Records.
    names : sequence of str
        Values that may move.
    sensors : mapping of str to float, optional
        As for `smooth`.
    floor : float
        Unknown forces that hang together over a ship length and are no larger than this share of
        the rms force of a channel do not matter.
    extrapolate : bool
        Allow a speed outside the range of the model's values.
    """
    ready = driven(model)
    known = sensors_of(records, sensors or {})
    given = [name for name in names if name != RUDDER_ZERO]
    words = (FORCES if model.rolls else FORCES[:3]) * len(MEMORIES[0])
    pieces = []
    for record in (_thinned(item, ready.ship.L) for item in records):
        binding = bound(ready, given, record.speed, extrapolate=extrapolate)
        pieces.append(
            Piece(
                record=record,
                binding=binding,
                forces=bound(ready, words, record.speed, extrapolate=extrapolate),
                functions=compiled(binding.structure, ESTIMATING),
                first=first_state(record, binding.structure.states, known, ready.ship.L),
            )
        )
    at = dict(zip(given, pieces[0].binding.mean.tolist(), strict=True))
    start = np.array([at.get(name, 0.0) for name in names])
    system = FreeSystem(
        model=model,
        names=tuple(names),
        start=start,
        pieces=tuple(pieces),
        sensors=MappingProxyType(known),
        shares=np.full(len(words), 0.003),
        least=floor * _usual(ready, pieces, words),
    )
    return _without_outliers(system)


def _thinned(record: FreeRecord, L: float) -> FreeRecord:
    step = float(np.median(np.diff(record.t)))
    every = max(round(PACE * L / record.speed / step), 1)
    return record.at(slice(None, None, every))


def _usual(model: Model, pieces: Sequence[Piece], words: Sequence[str]) -> Array:
    """Root mean square of the force of each channel over its unit, from rates of the heading.

    Surge force of the resistance, side force of m u r, moment of the inertia in a change of the
    yaw rate over a ship length.
    """
    squares = []
    for piece in pieces:
        record, ship = piece.record, model.ship
        pace = record.speed / ship.L
        psi = record.measured.get("psi")
        rate = record.measured.get("r")
        if rate is None:
            if psi is None:
                raise DataError(f"Record {record.name!r} holds neither heading nor yaw rate.")
            rate = np.gradient(psi, record.t)
        r = rate[np.isfinite(rate)]
        size = math.sqrt(float(np.mean(r**2))) if len(r) else 0.0
        motion = {
            "u": np.array([record.speed]),
            "v": np.zeros(1),
            "r": np.array([size]),
            "udot": np.array([0.05 * record.speed * pace]),
            "vdot": np.zeros(1),
            "rdot": np.array([size * pace]),
        }
        force, unit = rigid_body(ship, motion), units(model, record.speed)
        sizes = [force[w[-1]][0] / unit[w[-1]] if w[-1] in force else 0.0 for w in words]
        squares.append(np.array(sizes) ** 2)
    found: Array = np.maximum(np.sqrt(np.mean(squares, axis=0)), 1e-3)
    return found


def _passed(system: FreeSystem, piece: Piece, values: Array, gate: float) -> tuple[Array, Array]:
    """Innovations (n, c) and their variances of one record."""
    record, ready = piece.record, system.model
    moved = dict(zip(system.names, values.tolist(), strict=True))
    inputs = record.inputs
    inputs[:, InputField.rudder] += moved.get(RUDDER_ZERO, 0.0)
    k = piece.binding.constants(np.array([moved[name] for name in piece.binding.names]))
    pace, unit = record.speed / ready.ship.L, units(ready, record.speed)
    words = piece.forces.names
    spread = np.array([s * unit[w[-1]] for s, w in zip(system.shares, words, strict=True)])
    states = piece.binding.structure.states
    fading = np.repeat(pace / np.array(system.memories), len(words) // 2)
    z, P, diffusion = with_forces(*piece.first, spread, fading)
    steps = np.concatenate([state_steps(states, record.speed, ready.ship.L), 1e-3 * spread])
    measured = np.stack([record.measured[name] for name in record.measured], axis=1)
    kinds = np.array([kind_of(name, states) for name in record.measured], np.int64)
    variances = np.array([system.sensors[name] ** 2 for name in record.measured])
    out, totals = np.empty_like(measured), np.empty_like(measured)
    means, kept = np.empty((len(record), 2 * len(z))), np.zeros((0, 1))
    status = piece.functions.extended(
        record.t,
        inputs,
        measured,
        kinds,
        variances,
        k,
        piece.forces.starts,
        piece.forces.places,
        piece.forces.slopes,
        np.zeros(len(words)),
        np.zeros(len(words)),
        z,
        P,
        fading,
        diffusion,
        steps,
        STEP / pace,
        gate,
        means,
        out,
        totals,
        kept,
    )
    if status != Status.done:
        raise SimulationError(LOST[Status(status)].format(record.name))
    return out, totals


def agile(system: FreeSystem) -> FreeSystem:
    """The system with unknown forces so large that the filter follows any ship."""
    return system.with_shares(np.full(len(system.shares), AGILE))


def _without_outliers(system: FreeSystem) -> FreeSystem:
    """What no motion of the ship can explain is left out, once for all."""
    easy = agile(system)
    cleaned = []
    for piece in system.pieces:
        out, totals = _passed(easy, piece, system.start, GATE)
        wild = out**2 > GATE**2 * totals
        measured = {
            name: np.where(wild[:, i], np.nan, x)
            for i, (name, x) in enumerate(piece.record.measured.items())
        }
        cleaned.append(replace(piece, record=piece.record.with_(measured=measured)))
    return replace(system, pieces=tuple(cleaned))


def held(system: FreeSystem, values: Array) -> FreeSystem:
    """The system with the variances of the innovations held as they are at some values.

    Else a fit would make them smaller or larger, by way of the inertia, where the unknown forces
    are not quite what they are taken for.
    """
    found = tuple(_passed(system, piece, values, NO_GATE)[1] for piece in system.pieces)
    return replace(system, variances=found)


def residuals(system: FreeSystem, values: Array) -> Array:
    """Innovations of all records over their standard deviations as held.

    A Kalman filter follows each record with the model and with unknown forces that wander: what it
    does not expect is white and of variance 1 if these have the right size, however long the
    errors of the model last.
    """
    found = []
    for piece, variance in zip(system.pieces, system.variances, strict=True):
        out, _ = _passed(system, piece, values, NO_GATE)
        found.append((out / np.sqrt(variance))[_there(piece)])
    return np.concatenate(found)


def misfit(system: FreeSystem, values: Array) -> float:
    """Half the sum of squares of the residuals; infinite where the motion is lost."""
    try:
        with np.errstate(all="ignore"):
            e = residuals(system, values)
    except (SimulationError, np.linalg.LinAlgError):
        return math.inf
    found = 0.5 * float(e @ e)
    return found if math.isfinite(found) else math.inf


def log_likelihood(system: FreeSystem, values: Array) -> float:
    """Of the records with the unknown forces as they are; minus infinity where they are lost."""
    total = 0.0
    for piece in system.pieces:
        try:
            with np.errstate(all="ignore"):
                out, variance = _passed(system, piece, values, NO_GATE)
        except (SimulationError, np.linalg.LinAlgError):
            return -math.inf
        at = _there(piece)
        total -= 0.5 * float(np.sum(out[at] ** 2 / variance[at] + np.log(variance[at])))
    return total if math.isfinite(total) else -math.inf


def _there(piece: Piece) -> NDArray[np.bool_]:
    """Where a record has measurements."""
    return np.isfinite(np.stack(list(piece.record.measured.values()), axis=1))


@dataclass(frozen=True, kw_only=True, eq=False)
class Linear:
    """Residuals about a point: ``e - slopes @ (θ - point)``.

    Parameters
    ----------
    point : array (m,)
        Values.
    e : array (n,)
        Whitened innovations there.
    slopes : array (n, m)
        By what a value brings them down.
    blocks : array (n,) of int
        Stretch of a record that each belongs to.
    owners : array (n,) of int
        Record that each belongs to.
    """

    point: Array
    e: Array
    slopes: Array
    blocks: NDArray[np.int64]
    owners: NDArray[np.int64]


def linearised(
    system: FreeSystem,
    point: Array,
    steps: Array,
    *,
    only: Sequence[int] | None = None,
    jobs: int = 2,
) -> Linear:
    """Residuals and their slopes about a point by differences, one pass per value.

    Parameters
    ----------
    system : FreeSystem
        Records.
    point : array (m,)
        Values.
    steps : array (m,)
        By which they are moved.
    only : sequence of int, optional
        Values of which the slopes are asked; those of others are zero.
    jobs : int
        Threads.
    """
    e = residuals(system, point)
    asked = list(range(len(point))) if only is None else list(only)

    def column(j: int) -> Array:
        moved = point.copy()
        moved[j] += steps[j]
        slope: Array = (e - residuals(system, moved)) / steps[j]
        return slope

    slopes = np.zeros((len(e), len(point)))
    with ThreadPoolExecutor(jobs) as pool:
        for j, values in zip(asked, pool.map(column, asked), strict=True):
            slopes[:, j] = values
    blocks, owners = _places(system)
    return Linear(point=point, e=e, slopes=slopes, blocks=blocks, owners=owners)


def _places(system: FreeSystem) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    blocks, owners, begun = [], [], 0
    for number, piece in enumerate(system.pieces):
        record = piece.record
        length = BLOCK * system.model.ship.L / record.speed
        own = ((record.t - record.t[0]) / length).astype(np.int64)
        there = _there(piece)
        blocks.append((begun + np.repeat(own[:, None], there.shape[1], axis=1))[there])
        owners.append(np.full(int(there.sum()), number))
        begun += int(own[-1]) + 1
    return np.concatenate(blocks), np.concatenate(owners)


def sized(system: FreeSystem, values: Array, factors: Sequence[float] = FACTORS) -> FreeSystem:
    """Unknown forces of the size and memory that the records make most likely."""
    options = [_sized(replace(system, memories=memories), values, factors) for memories in MEMORIES]
    return max(options, key=lambda item: log_likelihood(item, values))


def _sized(system: FreeSystem, values: Array, factors: Sequence[float]) -> FreeSystem:
    made, known = system, log_likelihood(system, values)
    for factor in factors:
        for i in range(len(system.shares)):
            only = np.arange(len(system.shares)) == i
            for f in (1.0 / factor, factor):
                other = made.with_shares(made.shares * np.where(only, f, 1.0))
                if np.array_equal(other.shares, made.shares):
                    continue
                found = log_likelihood(other, values)
                if found > known:
                    made, known = other, found
                    break
    return made
