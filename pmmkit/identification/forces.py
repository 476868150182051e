"""Fit any values of a model to measured forces along measured motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Progress
from pmmkit.equations import Conditions, Prepared, prepare
from pmmkit.identification.binding import (
    Binding,
    PartValues,
    driven,
    places,
    replaced,
    with_parameters,
)
from pmmkit.identification.lack import LackOfFit, RecordPiece, lack_of, lasting
from pmmkit.identification.prior import Prior
from pmmkit.inference import LeastSquares
from pmmkit.models import Model
from pmmkit.numerics import Array

STEP: Final = 1e-6
"""Step of the differences over the size of a parameter."""
ASIDE: Final = 0.05
"""Step over the size of a parameter by which a slope is seen to be the same elsewhere."""
TOGETHER: Final = 4
"""Windows that are set against each other, over the instants that hang together."""
ROUNDS: Final = 4
"""Times that the records are weighed anew against a prior."""
SAME: Final = 0.1
"""Change of the weight from which another round is worth it."""


@dataclass(frozen=True, kw_only=True)
class ForceRecord:
    """Forces of the water on a ship along a motion.

    `forces`: measured X, Y [N], N, K [N m] about midship, those there are, without the inertia
    of the ship; NaN where they are not known. `speed`: carriage speed, or the speed of the
    approach [m/s]. `correlated`: number of instants over which errors hang together: the
    covariance of a fit is widened by how far the sums over so many instants scatter.
    """

    name: str
    motion: Mapping[str, Array]
    forces: Mapping[str, Array]
    std: Mapping[str, float | Array]
    speed: float
    conditions: Conditions = field(default_factory=Conditions)
    correlated: int = 1


@dataclass(frozen=True, kw_only=True, eq=False)
class FittedForces:
    """What a fit found.

    `model`: with the fitted values. `covariance (m, m)`: from the stated standard deviations;
    NaN for what the records do not determine. `rms`: root mean square of the residuals over
    their standard deviation, by channel. `cost`: half the sum of squares. `lack`: what says
    that the model lacks something; None without a prior.
    """

    model: Model
    names: tuple[str, ...]
    values: Array
    covariance: Array
    undetermined: tuple[str, ...]
    rms: Mapping[str, float]
    cost: float
    lack: LackOfFit | None

    @property
    def std(self) -> Array:
        """Standard deviations (m,)."""
        return np.sqrt(np.diagonal(self.covariance))


def fit_to_forces(
    model: Model,
    records: Sequence[ForceRecord],
    names: Sequence[str],
    *,
    prior: Prior | None = None,
    extrapolate: bool = False,
    progress: Progress | None = None,
) -> FittedForces:
    """Fit derivatives and parameters of effects, linear or not, by least squares.

    Parameters
    ----------
    model : Model
        With start values; everything that is not named is held.
    records : sequence of ForceRecord
        Runs.
    names : sequence of str
        Derivatives (``Yv``) and parameters with their effect (``rudder_mmg.aH``).
    prior : Prior, optional
        Of the same names; without it nothing but the records counts.
    extrapolate : bool
        Allow speeds outside the range of the model's values.
    progress : callable, optional
        Told how often the forces were worked out.

    Returns
    -------
    FittedForces

    Raises
    ------
    DataError
        If there is nothing to fit, or to fit to.
    UnknownNameError
        If the model lacks a name.

    Notes
    -----
    Gauss-Newton with a trust region (scipy's ``least_squares``), columns scaled, residuals in
    units of their standard deviation. Slopes over values in which the forces are straight lines,
    whatever the others are, are worked out once, those over the others by central differences at
    each step. Directions that the records do not determine (singular values below 1e-10 of the
    largest) keep their start values.

    Examples
    --------
    >>> from pmmkit.equations import prepare
    >>> from pmmkit.models import load_model
    >>> ship = load_model("s175-3dof")
    >>> motion = {"u": np.full(5, 9.0), "v": np.linspace(-1.0, 1.0, 5), "n": np.full(5, 1.4)}
    >>> ready = prepare(ship, 9.0)
    >>> record = ForceRecord(name="drift", motion=motion, speed=9.0, std={"Y": 1e3},
    ...                      forces=ready.water_forces(motion))
    >>> start = ship.with_values("hull_polynomial", Yv=-0.01, Yvvv=-0.05)
    >>> fit_to_forces(start, [record], ["Yv", "Yvvv"]).values.round(6)
    array([-0.0116, -0.109 ])
    """
    from scipy.optimize import least_squares

    if not names or not records:
        raise DataError("Name at least one value to fit, and give at least one record.")
    at = places(model, names)
    given = [model.values_at(record.speed, extrapolate=extrapolate) for record in records]
    start = np.array([float(given[0][effect][name]) for effect, name in at])
    size = np.where(start != 0.0, np.abs(start), 1e-3)
    if not any(set(record.forces) & set(record.std) for record in records):
        raise DataError("No record has a force with its standard deviation.")
    root = np.zeros((0, len(at)))
    if prior is not None:
        root = np.linalg.inv(np.linalg.cholesky(prior.covariance))

    groups = [(record.speed, record.conditions) for record in records]
    first = {group: number for number, group in reversed(list(enumerate(groups)))}

    packs = {
        group: _packs(model, names, given[number], *group, extrapolate=extrapolate)
        for group, number in first.items()
    }

    def difference(scaled: Array) -> Array:
        equations = {group: pack(scaled * size) for group, pack in packs.items()}
        parts: list[Array] = []
        for record, group in zip(records, groups, strict=True):
            found = equations[group].water_forces(record.motion)
            parts += [
                (found[channel] - values) / record.std[channel]
                for channel, values in record.forces.items()
                if channel in record.std
            ]
        return np.concatenate(parts)

    known = np.isfinite(difference(start / size))
    if not known.any():
        raise DataError("No record has a finite force.")

    rows, width, at_start = len(known), 1.0, start / size
    slopes = _slopes(lambda scaled: np.where(known, difference(scaled), 0.0), at_start)
    count = 0
    for turn in range(ROUNDS):

        def residual(scaled: Array, width: float = width, turn: int = turn) -> Array:
            nonlocal count
            count += 1
            if progress is not None:
                progress(turn, ROUNDS, f"round {turn + 1} of the fit to forces, trial {count}")
            parts = [np.where(known, difference(scaled), 0.0) / width]
            if prior is not None:
                parts.append(root @ (scaled * size - prior.mean))
            return np.concatenate(parts)

        def jacobian(scaled: Array, width: float = width) -> Array:
            return np.vstack([slopes(scaled) / width, root * size])

        found = least_squares(
            residual, at_start, jac=jacobian, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12
        )
        widened = _widened(records, found.jac[:rows] * width, found.fun[:rows] * width)
        at_start = found.x
        if prior is None or abs(math.sqrt(widened) / width - 1.0) < SAME:
            break
        width = math.sqrt(widened)
    values = found.x * size
    slope = np.vstack([found.jac[:rows] * width / math.sqrt(widened), found.jac[rows:]])
    linear = LeastSquares.of(names, slope, np.zeros(len(slope)))
    root, lost = linear.gain * size[:, None], ~linear.determined
    covariance = np.asarray(root @ root.T)
    covariance[lost, :] = covariance[:, lost] = np.nan
    lack = None
    if prior is not None and not lost.any():
        jacobian_now = found.jac[:rows] * width / size
        pieces = _pieces(records, jacobian_now, found.fun[:rows] * width, prior.std, widened)
        left = _by_record(records, found.fun[:rows])
        lack = lack_of(prior, covariance, pieces, lasting(left), clustered=True)
        covariance = lack.covariance
    return FittedForces(
        model=with_parameters(model, at, values),
        names=tuple(names),
        values=values,
        covariance=covariance,
        lack=lack,
        undetermined=tuple(name for name, gone in zip(names, lost, strict=True) if gone),
        rms=MappingProxyType(_by_channel(records, found.fun[:rows] * width, known)),
        cost=float(found.cost),
    )


def _packs(
    model: Model,
    names: Sequence[str],
    numbers: PartValues,
    speed: float,
    conditions: Conditions,
    *,
    extrapolate: bool,
) -> Callable[[Array], Prepared]:
    """The equations for values of parameters; straight lines where they are."""
    at = places(model, names)

    def anew(values: Array) -> Prepared:
        return prepare(
            model, speed, values=replaced(numbers, at, values), conditions=conditions, heeled=True
        )

    if driven(model) is not model:
        return anew
    try:
        line = Binding.of(model, names, speed, conditions=conditions, extrapolate=extrapolate)
    except DataError:
        return anew
    return lambda values: replace(line.equations, k=tuple(line.constants(values).tolist()))


def _slopes(function: Callable[[Array], Array], start: Array) -> Callable[[Array], Array]:
    """The slopes of a function, those that are everywhere the same worked out once."""

    def column(at: Array, number: int, step: float) -> Array:
        ahead, behind = at.copy(), at.copy()
        ahead[number] += step
        behind[number] -= step
        slope: Array = (function(ahead) - function(behind)) / (2.0 * step)
        return slope

    aside = start * (1.0 + ASIDE * np.resize([1.0, -0.7, 0.4, -0.9, 0.6], len(start)))
    fixed: dict[int, Array] = {}
    for number in range(len(start)):
        here, there = column(start, number, ASIDE), column(aside, number, ASIDE)
        if np.max(np.abs(here - there), initial=0.0) <= 1e-8 * np.max(np.abs(here), initial=0.0):
            fixed[number] = here

    def slopes(at: Array) -> Array:
        return np.stack(
            [
                fixed[number]
                if number in fixed
                else column(at, number, STEP * max(abs(at[number]), STEP))
                for number in range(len(at))
            ],
            axis=1,
        )

    return slopes


def _by_record(
    records: Sequence[ForceRecord], residuals: Array
) -> dict[str, list[tuple[Array, int]]]:
    """Residuals by channel and record, where errors hang together."""
    found: dict[str, list[tuple[Array, int]]] = {}
    begin = 0
    for record in records:
        for channel, values in record.forces.items():
            if channel in record.std:
                own = residuals[begin : begin + len(values)]
                begin += len(values)
                if record.correlated > 1:
                    found.setdefault(channel, []).append((own, record.correlated))
    return found


def _widened(records: Sequence[ForceRecord], jacobian: Array, residuals: Array) -> float:
    """Variance of the sums of scores over what hangs together, over that of white residuals."""
    if all(record.correlated <= 1 for record in records):
        return 1.0
    scores, begin = [], 0
    for record in records:
        for channel, values in record.forces.items():
            if channel in record.std:
                rows = slice(begin, begin + len(values))
                edges = np.arange(0, len(values), max(record.correlated, 1))
                scores.append(
                    np.add.reduceat(jacobian[rows] * residuals[rows, None], edges, axis=0)
                )
                begin += len(values)
    stacked = np.concatenate(scores)
    sizes, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    seen = sizes > 1e-10 * sizes[-1]
    whitened = stacked @ vectors[:, seen] / np.sqrt(sizes[seen])
    return max(1.0, float(np.sum(whitened**2) / seen.sum()))


def _pieces(
    records: Sequence[ForceRecord], jacobian: Array, residuals: Array, scale: Array, widened: float
) -> list[RecordPiece]:
    """What windows of the records say, each of several times what hangs together."""
    slopes = jacobian * scale
    found, begin = [], 0
    for number, record in enumerate(records):
        if record.correlated <= 1:
            begin += sum(len(x) for name, x in record.forces.items() if name in record.std)
            continue
        told: dict[int, tuple[Array, Array]] = {}
        for channel, values in record.forces.items():
            if channel not in record.std:
                continue
            edges = [*range(0, len(values), TOGETHER * record.correlated), len(values)]
            for place, (first, last) in enumerate(pairwise(edges)):
                own, off = (item[begin + first : begin + last] for item in (slopes, residuals))
                information, score = told.get(place, (np.zeros((own.shape[1],) * 2), 0.0 * scale))
                told[place] = information + own.T @ own, score - own.T @ off
            begin += len(values)
        found += [
            RecordPiece(record=number, information=information / widened, score=score / widened)
            for information, score in told.values()
        ]
    return found


def _by_channel(
    records: Sequence[ForceRecord], residuals: Array, known: NDArray[np.bool_]
) -> dict[str, float]:
    kinds = np.concatenate(
        [
            np.full(len(values), channel)
            for record in records
            for channel, values in record.forces.items()
            if channel in record.std
        ]
    )
    return {
        str(channel): float(np.sqrt(np.mean(residuals[known & (kinds == channel)] ** 2)))
        for channel in dict.fromkeys(kinds.tolist())
        if np.any(known & (kinds == channel))
    }
