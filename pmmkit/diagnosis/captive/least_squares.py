"""All channels as one weighted least-squares problem: base, effects, and the smooth floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.build import build, predicted_rows, prior_sizes
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.system import (
    CandidateColumns,
    System,
    candidate_columns,
    each_run_columns,
)
from pmmkit.inference import RANK_TOLERANCE, dependent
from pmmkit.numerics import Array
from pmmkit.reduction import View

HELD: Final = 1.0 / RANK_TOLERANCE
"""Pivot of a column that depends on others: its coefficient stays where it is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stack:
    """Rows of all channels, columns of base, effects and the floor's features.

    `plain (n, p + 1)`: base and effects as they are; the data are the last column. `white (k, q
    + 1)`: all over the root of their covariance. With a floor the rows of each channel are
    condensed to a triangle of the same products: they are many, and each has the features of
    its own. `places`: rows of each channel in `plain`. `names`: derivatives, then coefficients
    of effects. `unit`: what gives the values of `names` back. `centre`: expected values of the
    columns from `begin` on, which have a unit prior. `begin`: first column with a prior.
    """

    plain: Array
    white: Array
    places: Mapping[str, slice]
    names: tuple[str, ...]
    unit: Array
    centre: Array
    begin: int


def stacked(system: System, effects: Sequence[CandidateColumns], *, floor: float = 0.0) -> Stack:
    """All channels below each other, whitened run by run."""
    base, channels = system.base, system.channels
    known = [name for c in channels for name in base.names[c.name]]
    parts = [effect_columns(system, block) for block in effects]
    features = [floor * x for x in system.features] if floor > 0 else []
    widths = [len(sizes_of(block)) for block in effects]
    coefficients = len(known) + sum(widths)
    edges = np.cumsum([coefficients, *(x.shape[1] for x in features)]).tolist()
    total = edges[-1]
    plain, white, places, row = [], [], {}, 0
    for number, (c, piece) in enumerate(zip(channels, system.pieces, strict=True)):
        block = np.zeros((len(c.y), coefficients + 1))
        first = sum(len(base.names[x.name]) for x in channels[:number])
        block[:, first : first + c.design.shape[1]] = c.design
        at = len(known)
        for part, width in zip(parts, widths, strict=True):
            if c.name in part:
                block[:, at : at + width] = part[c.name]
            at += width
        block[:, -1] = c.y
        plain.append(block)
        if features:
            acting = [*range(coefficients), *range(edges[number], edges[number + 1]), total]
            every = np.column_stack([block[:, :-1], features[number], c.y])
            root = np.linalg.qr(piece.projection.whitened(every), mode="r")
            condensed = np.zeros((len(root), total + 1))
            condensed[:, acting] = root
            white.append(condensed)
        else:
            white.append(piece.projection.whitened(block))
        places[c.name] = slice(row, row + len(c.y))
        row += len(c.y)
    names = [*known, *(label for block in effects for label in _labels(block))]
    unit = np.concatenate([np.ones(len(known)), *(sizes_of(block) for block in effects)])
    centre = np.zeros(total - len(known))
    expected = [x for block in effects for x in (block.candidate.centre or (0.0,) * block.count)]
    centre[: len(expected)] = expected / unit[len(known) :]
    return Stack(
        plain=np.concatenate(plain),
        white=np.concatenate(white),
        places=places,
        names=tuple(names),
        unit=unit,
        centre=centre,
        begin=len(known),
    )


def effect_columns(system: System, block: CandidateColumns) -> Mapping[str, Array]:
    """Columns of an effect in units of its prior, by channel."""
    if block.made is not None:
        return block.made
    if not block.candidate.each_run:
        found = candidate_columns(
            block.candidate, block.value, system.channels, system.views, system.base
        )
        return {name: x * prior_sizes(block.candidate) for name, x in found.items()}
    base = system.base
    parts = {
        c.name: each_run_columns(
            block.candidate,
            block.value,
            c,
            system.views,
            base,
            predicted_rows(c, system.views, base),
        ).dense()
        for c in system.channels
    }
    edges = np.cumsum([0, *(x.shape[1] for x in parts.values())])
    whole = {}
    for (name, own), begin in zip(parts.items(), edges, strict=False):
        whole[name] = np.zeros((len(own), edges[-1]))
        whole[name][:, begin : begin + own.shape[1]] = prior_sizes(block.candidate) * own
    return whole


def _labels(block: CandidateColumns) -> list[str]:
    c = block.candidate
    if c.each_run:
        return [f"{c.name}: share {number + 1} [-]" for number in range(block.count)]
    return labels(c)


def labels(candidate: Candidate) -> list[str]:
    """Names of an effect's coefficients in a joint fit."""
    return [f"{candidate.name}: {name}" for name in candidate.coefficients]


def sizes_of(block: CandidateColumns) -> Array:
    """Prior standard deviations of the coefficients of an effect, a transient's of each run."""
    if block.candidate.each_run:
        return np.full(block.count, prior_sizes(block.candidate)[0])
    return prior_sizes(block.candidate)


@dataclass(frozen=True, kw_only=True, eq=False)
class Solved:
    """Least squares with a unit prior on the later columns.

    `Q (n, q)`: orthonormal, the rows of the data. `R (q, q)`: triangular, of scaled columns.
    `solution (q,)`: in the units of the columns. `size (q,)`: scales of the columns. `triangle
    (q, q)`: as the columns have it; in `R` the coefficients that nothing determines are held.
    """

    Q: Array
    R: Array
    solution: Array
    size: Array
    triangle: Array

    @cached_property
    def determined(self) -> NDArray[np.bool_]:
        """Whether the data and the prior determine each coefficient (q,)."""
        return ~dependent(self.triangle)


def solved(stack: Stack) -> Solved:
    """The weighted least squares of a stack, by QR of scaled columns."""
    count = stack.white.shape[1] - 1
    free = count - stack.begin
    below = np.zeros((free, count + 1))
    below[:, stack.begin : count] = np.eye(free)
    below[:, -1] = stack.centre
    whole = np.vstack([stack.white, below])
    size = np.linalg.norm(whole[:, :-1], axis=0)
    size = np.where(size > 0, size, 1.0)
    Q, R = np.linalg.qr(whole[:, :-1] / size)
    held = R + np.diag(np.where(np.abs(np.diagonal(R)) > RANK_TOLERANCE, 0.0, HELD))
    return Solved(
        Q=Q[: len(stack.white)],
        R=held,
        size=size,
        triangle=R,
        solution=np.linalg.solve(held, Q.T @ whole[:, -1]) / size,
    )


# Base and effects fitted together, nonlinear parameters off the grid, with uncertainty.


PARAMETER: Final = "nonlinear parameter"
"""Name of what a fit moves a nonlinear parameter by, to know its uncertainty."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointFit:
    """Values of the base's derivatives and of effects, fitted to all runs at once.

    `names`: derivatives of the base, then the effects' coefficients as ``effect: coefficient``.
    `values`: fitted; NaN where the runs do not determine one. `covariance (n, n)`: with noise,
    run scatter, the smooth floor, the effects' prior sizes, and what is not known of their
    nonlinear parameters.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations."""
        deviations: Array = np.sqrt(np.diagonal(self.covariance))
        return deviations

    def of(self, names: Sequence[str]) -> tuple[Array, Array]:
        """Values and standard deviations of some names."""
        at = [self.names.index(name) for name in names]
        return self.values[at], self.std[at]


def joint_fit(
    system: System, effects: Sequence[CandidateColumns] = (), *, floor: float
) -> JointFit:
    """Base and effects fitted to all runs at once."""
    tangents = _tangents(system, effects)
    stack = stacked(system, [*effects, *tangents], floor=floor)
    fit = solved(stack)
    inverse = np.linalg.inv(fit.R) / fit.size[:, None]
    count = len(stack.names)
    covariance = (inverse @ inverse.T)[:count, :count] * np.outer(stack.unit, stack.unit)
    values = np.where(fit.determined[:count], fit.solution[:count] * stack.unit, np.nan)
    return JointFit(names=stack.names, values=values, covariance=covariance)


def _tangents(system: System, effects: Sequence[CandidateColumns]) -> list[CandidateColumns]:
    """The change of each effect with its nonlinear parameter, as effects of their own."""
    if not any(block.candidate.continuous for block in effects):
        return []
    solution = solved(stacked(system, effects)).solution
    made = []
    at = len([name for c in system.channels for name in system.base.names[c.name]])
    for block in effects:
        width = block.count
        if block.candidate.continuous:
            sizes = solution[at : at + width] * sizes_of(block)
            made.append(_tangent(block, sizes))
        at += width
    return made


def _tangent(block: CandidateColumns, sizes: Array) -> CandidateColumns:
    c, value, step = block.candidate, block.value, 0.02 * block.value

    def together(
        views: Sequence[View], base: CaptiveBase, _: float
    ) -> Sequence[Mapping[str, Array]]:
        both = (c.columns(views, base, value + step), c.columns(views, base, value - step))
        return [
            {name: ((more[name] - less[name]) @ sizes / (2 * step))[:, None] for name in more}
            for more, less in zip(*both, strict=True)
        ]

    spread = 0.5 * (max(c.grid) - min(c.grid)) / len(c.grid)
    own = Candidate(
        name=c.name,
        family=c.family,
        kind=c.kind,
        summary=c.summary,
        columns=together,
        coefficients=(PARAMETER,),
        typical=(spread,),
    )
    return CandidateColumns(candidate=own, value=0.0, columns=slice(0, 1))


def refined(system: System, effects: Sequence[CandidateColumns]) -> tuple[CandidateColumns, ...]:
    """Effects with their nonlinear parameters off the grid, where the runs are explained best."""
    from scipy.optimize import minimize_scalar

    blocks = list(effects)
    if any(block.candidate.continuous for block in effects):
        blocks = [_made(system, block, block.value) for block in effects]
    for place, block in enumerate(effects):
        if not block.candidate.continuous:
            continue
        grid = sorted(block.candidate.grid)
        at = grid.index(block.value)
        low, high = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
        if at == 0:
            low = max(2 * grid[0] - grid[1], 0.5 * grid[0])
        if at == len(grid) - 1:
            high = 2 * grid[-1] - grid[-2]

        def misfit(value: float, place: int = place, block: CandidateColumns = block) -> float:
            own = _made(system, block, value)
            return _misfit(stacked(system, [*blocks[:place], own, *blocks[place + 1 :]]))

        result = minimize_scalar(
            misfit, bounds=(low, high), method="bounded", options={"xatol": 0.01 * (high - low)}
        )
        blocks[place] = _made(system, block, float(result.x))
    return tuple(
        replace(block, made=None) if block.candidate.each_run else block for block in blocks
    )


def _made(system: System, block: CandidateColumns, value: float) -> CandidateColumns:
    """An effect at a value of its nonlinear parameter, with its columns made once for several
    fits."""
    own = block if value == block.value else replace(block, value=value, made=None)
    return replace(own, made=effect_columns(system, own))


def _misfit(stack: Stack) -> float:
    """Squared residuals with those of the prior, at the best coefficients."""
    fit = solved(stack)
    left = stack.white[:, -1] - stack.white[:, :-1] @ fit.solution
    away = fit.solution[stack.begin :] - stack.centre
    return float(left @ left + away @ away)


def linearised(
    system: System, effects: Sequence[CandidateColumns], asked: Sequence[Candidate] | None = None
) -> System:
    """A system whose candidates, or those that are asked, act on the base with some effects, at the
    values of a joint fit.

    What a fault of the motion or of the balance changes is the force of the whole ship, so of all
    that is known of her: one round of Gauss and Newton.
    """
    fit = joint_fit(system, effects, floor=system.floor)
    known = dict(zip(fit.names, np.nan_to_num(fit.values).tolist(), strict=True))
    added: dict[str, float] = {}
    beside = []
    for block in effects:
        c = block.candidate
        if c.kind == "fault" or c.each_run:
            continue
        sizes = [known[label] for label in labels(c)]
        for shares, size in zip(c.terms, sizes, strict=False):
            for name, share in shares.items():
                added[name] = added.get(name, 0.0) + share * size
        if not c.terms:
            beside.append((c.columns, block.value, np.array(sizes)))
    base = replace(
        system.base,
        values={name: known.get(name, value) for name, value in system.base.values.items()},
        added=added,
        beside=tuple(beside),
    )
    forms = {(block.candidate.name, block.candidate.size) for block in system.blocks}
    every = {x.candidate.name: x.candidate for x in system.blocks if not x.candidate.partial}
    made = build(
        system.views,
        base,
        list(every.values()) if asked is None else asked,
        floor=system.floor,
        scatter=system.scatter,
        like=system,
    )
    kept = [x for x in made.blocks if (x.candidate.name, x.candidate.size) in forms]
    return replace(made, blocks=tuple(kept), unasked=system.unasked)
