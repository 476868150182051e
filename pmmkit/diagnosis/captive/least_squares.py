"""All channels as one weighted least-squares problem: base, effects, and the smooth floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.captive.build import prior_sizes
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.system import (
    CandidateColumns,
    System,
    candidate_columns,
    each_run_columns,
)
from pmmkit.inference import RANK_TOLERANCE, dependent
from pmmkit.numerics import Array

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
            c.design @ [base.values[name] for name in base.names[c.name]],
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
