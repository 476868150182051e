"""What runs tell of effects, run by run: it adds up, so that a run can be tried before it is made.

Rows of a run are whitened by its noise and scatter; their columns are the base and the smooth floor
(the null, whatever they are), the candidates in units of their prior standard deviation, and the
data. Products of columns add up over runs. What they say of the candidates is what is left when
the null is taken off, as in `build`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.build import predicted_rows, prior_sizes
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.system import (
    FEATURES,
    WIDER,
    CandidateColumns,
    candidate_columns,
    channels_of,
    floor_features,
    run_columns,
)
from pmmkit.diagnosis.captive.whitening import Places, whitened
from pmmkit.inference import Normal
from pmmkit.numerics import Array
from pmmkit.reduction import View

UNKNOWN: Final = 1e-9
"""Prior precision of a base coefficient, over the precision that all runs together give."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WhitenedRows:
    """Whitened rows of runs.

    `base`: derivatives, of which every channel's first columns are. `blocks`: candidates at
    their grid points, with their places among the candidates' columns. `centre (k,)`: expected
    coefficients of the candidates, in units of their prior. `given`: columns of effects that
    the base has, of unknown size within their prior. `null`: columns of base and floor. `of_run
    (m, null + k + 1)`: base, floor, candidates, data. `prior (null,)`: prior precision of the
    null's coefficients.
    """

    base: CaptiveBase
    blocks: tuple[CandidateColumns, ...]
    centre: Array
    given: Places
    null: Mapping[str, int]
    of_run: Mapping[str, Mapping[str, Array]]
    prior: Mapping[str, Array]

    @property
    def width(self) -> int:
        """Number of the candidates' columns."""
        return len(self.centre)

    def condition_on(self, values: Mapping[str, Sequence[float]]) -> WhitenedRows:
        """Rows for a base that has effects, at some values of their grids; others take part."""
        own = [b.places for b in self.blocks if b.value in values.get(b.candidate.name, ())]
        return replace(
            self,
            given=np.concatenate([self.given, *own]),
            blocks=tuple(b for b in self.blocks if b.candidate.name not in values),
        )


def rows_of(
    views: Sequence[View],
    base: CaptiveBase,
    candidates: Sequence[Candidate],
    *,
    floor: float,
    scatter: Mapping[str, Array],
    scale: Mapping[str, float] | None = None,
) -> WhitenedRows:
    """Whitened rows of measured and of planned runs together.

    scatter (4,); scale [N/(m/s)²].
    """
    channels = [
        replace(c, scale=(scale or {}).get(c.name, c.scale)) for c in channels_of(views, base)
    ]
    views = base.expecting(views)
    blocks, centre = _blocks(candidates)
    raw = [
        candidate_columns(block.candidate, block.value, channels, views, base) for block in blocks
    ]
    of_run: dict[str, dict[str, Array]] = {view.run.id: {} for view in views}
    null, prior = {}, {}
    predicted = {c.name: predicted_rows(c, views, base) for c in channels}
    own = run_columns(channels, views, base, predicted)
    for c in channels:
        p = c.design.shape[1]
        effects = np.zeros((len(c.y), len(centre)))
        for block, by_channel in zip(blocks, raw, strict=True):
            if c.name in by_channel:
                effects[:, block.columns] = by_channel[c.name] * prior_sizes(block.candidate)
        features = floor * floor_features(c, views, base)
        columns = np.column_stack([c.design, features, effects, c.y])
        white = whitened(c, columns, own[c.name], scatter[c.name])
        size = np.linalg.norm(white[:, :p], axis=0)
        white[:, :p] /= np.where(size > 0, size, 1.0)
        null[c.name] = p + FEATURES
        prior[c.name] = np.concatenate([np.full(p, UNKNOWN), np.ones(FEATURES)])
        ids = dict.fromkeys(views[i].run.id for i in c.views)
        for name, rows in zip(ids, c.runs, strict=True):
            of_run[name][c.name] = white[rows]
    return WhitenedRows(
        base=base,
        blocks=blocks,
        centre=centre,
        given=np.zeros(0, int),
        null=MappingProxyType(null),
        of_run=MappingProxyType(of_run),
        prior=MappingProxyType(prior),
    )


def _blocks(candidates: Sequence[Candidate]) -> tuple[tuple[CandidateColumns, ...], Array]:
    blocks, at, centres = [], 0, [np.zeros(0)]
    for candidate in candidates:
        for value in candidate.grid:
            end = at + candidate.size
            blocks.append(
                CandidateColumns(candidate=candidate, value=value, columns=slice(at, end))
            )
            own = np.array(candidate.centre) / prior_sizes(candidate) if candidate.centre else None
            centres.append(np.zeros(candidate.size) if own is None else own)
            at = end
    return tuple(blocks), np.concatenate(centres)


def drawn_once(candidate: Candidate) -> Candidate:
    """A candidate that each run draws, as one share of the force of all runs."""

    def columns(
        views: Sequence[View], base: CaptiveBase, value: float
    ) -> Sequence[Mapping[str, Array]]:
        found = []
        for view, columns_of_view in zip(views, candidate.columns(views, base, value), strict=True):
            forces = base.forces(view.motion, view.speed)
            found.append(
                {
                    name: float(np.linalg.norm(view.project(forces[name]))) * own
                    for name, own in columns_of_view.items()
                    if name in forces
                }
            )
        return found

    return replace(candidate, columns=columns, each_run=False) if candidate.each_run else candidate


@dataclass(frozen=True, kw_only=True, eq=False)
class RunInformation:
    """What runs tell together.

    `rows`: of all runs there are or could be. `sums (w, w)`: products of the columns over the
    runs that are made.
    """

    rows: WhitenedRows
    sums: Mapping[str, Array]

    def joined(self, run: str) -> RunInformation:
        """With one more run."""
        added = self.rows.of_run[run]
        sums = {
            name: total + added[name].T @ added[name] if name in added else total
            for name, total in self.sums.items()
        }
        return replace(self, sums=MappingProxyType(sums))

    def plain(self) -> Array:
        """Products of the candidates' columns as if base and floor were known (k, k)."""
        found = np.zeros((self.rows.width, self.rows.width))
        for name, total in self.sums.items():
            n = self.rows.null[name]
            found += total[n:-1, n:-1]
        return found

    def reduced(self) -> Reduced:
        """What is said of the candidates, whatever base and floor are."""
        from scipy.linalg import solve_triangular

        k = self.rows.width
        gram, score = np.zeros((k, k)), np.zeros(k)
        inverse, solved = {}, {}
        for name, total in self.sums.items():
            n = self.rows.null[name]
            root = np.linalg.cholesky(total[:n, :n] + np.diag(self.rows.prior[name]))
            inverse[name] = solve_triangular(root, np.eye(n), lower=True, check_finite=False)
            half = inverse[name] @ total[:n, n:]
            solved[name] = inverse[name].T @ half
            left = total[n:, n:] - half.T @ half
            gram += left[:k, :k]
            score += left[:k, k]
        whole = Normal(information=gram, score=score, centre=self.rows.centre)
        taken = whole.taken(self.rows.given)
        beside = whole.given(taken)
        answer = np.column_stack([taken.across, np.linalg.inv(taken.root)])
        return Reduced(
            rows=self.rows,
            normal=replace(beside, information=(beside.information + beside.information.T) / 2),
            of_given=np.asarray(np.linalg.solve(taken.root.T, answer), float),
            inverse=MappingProxyType(inverse),
            solved=MappingProxyType(solved),
        )


def known(rows: WhitenedRows, runs: Iterable[str] = ()) -> RunInformation:
    """What some runs tell, in any order."""
    width = {name: n + rows.width + 1 for name, n in rows.null.items()}
    found = RunInformation(
        rows=rows, sums=MappingProxyType({name: np.zeros((w, w)) for name, w in width.items()})
    )
    for run in runs:
        found = found.joined(run)
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Reduced:
    """What runs say of the candidates, and how to add a run to it.

    `normal`: what they say of the candidates' coefficients, the null taken off. `of_given (g, k
    + g)`: what the effects of the base answer to candidates, and their covariance. `inverse,
    solved`: inverse root of the null's precision, and the null's answer to candidates and data.
    """

    rows: WhitenedRows
    normal: Normal
    of_given: Array
    inverse: Mapping[str, Array]
    solved: Mapping[str, Array]

    def added(self, run: str, times: int = 1) -> Array:
        """What a run adds: columns of the candidates in its rows, the null refitted (m, k).

        The rows have unit covariance whatever the null; the Gram matrix grows by their products.
        """
        from scipy.linalg import solve_triangular

        found = [np.zeros((0, self.rows.width))]
        for name, white in self.rows.of_run[run].items():
            n = self.rows.null[name]
            part = np.sqrt(times) * white
            own = part[:, n:-1] - part[:, :n] @ self.solved[name][:, :-1]
            root = self._root(name, part)[1]
            found.append(solve_triangular(root, own, lower=True, check_finite=False))
        whole = np.concatenate(found)
        held = whole[:, self.rows.given]
        covariance = np.eye(len(whole)) + held @ self.of_given[:, self.rows.width :] @ held.T
        spread = np.linalg.cholesky(covariance)
        return np.asarray(
            np.linalg.solve(spread, whole - held @ self.of_given[:, : self.rows.width]), float
        )

    def precision(self, run: str | None = None) -> dict[str, Array]:
        """Precision of every base coefficient by channel, with one more run where one is named.

        Coefficients are in units in which a column has the length one over all rows there are.
        """
        from scipy.linalg import solve_triangular

        found = {}
        for name, inverse in self.inverse.items():
            p = self.rows.null[name] - FEATURES
            variance = np.sum(inverse[:, :p] ** 2, axis=0)
            white = self.rows.of_run[run].get(name) if run is not None else None
            if white is not None:
                half, root = self._root(name, white)
                taken = solve_triangular(
                    root, half @ inverse[:, :p], lower=True, check_finite=False
                )
                variance -= np.sum(taken**2, axis=0)
            found[name] = 1.0 / np.maximum(variance, 1e-300)
        return found

    def _root(self, name: str, white: Array) -> tuple[Array, Array]:
        """Rows over the root of the null's precision, and the root of their covariance."""
        half = white[:, : self.rows.null[name]] @ self.inverse[name].T
        root = np.asarray(np.linalg.cholesky(np.eye(len(white)) + half @ half.T), float)
        return half, root


def at_usual_size(block: CandidateColumns) -> Array:
    """Coefficients of a candidate at its usual size, in units of the prior."""
    candidate = block.candidate
    if candidate.centre:
        return np.array(candidate.centre) / prior_sizes(candidate)
    found: Array = np.sign(np.array(candidate.typical)) / WIDER
    return found
