"""The error of left-out conditions that noise alone would give: what the covariances expect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.least_squares import Solved, Stack
from pmmkit.diagnosis.captive.system import System
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.numerics import Array

TOGETHER: Final = 32
"""Conditions whose products are summed at once: of all of them they would fill the memory."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LeftOut:
    """One condition that a fit had not seen.

    `rows`: its rows in the stack. `inverse (n, n)`: of I less their hat matrix: from residuals
    to errors of a fit without them. `counted (m,)`: rows whose errors count. `channel (m,)`:
    number of the channel of each. `weight (m,)`: of its squared error in the mean square of the
    channel over a cycle.
    """

    rows: Places
    inverse: Array
    counted: Places
    channel: Places
    weight: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Errors:
    """Covariance of errors of a condition: own - fit fit' + floor floor'."""

    own: Array
    fit: Array
    floor: Array

    @property
    def covariance(self) -> Array:
        return self.own - self.fit @ self.fit.T + self.floor @ self.floor.T

    def by(self, matrix: Array) -> _Errors:
        """Of what a matrix makes of the errors."""
        return _Errors(
            own=matrix @ self.own @ matrix.T, fit=matrix @ self.fit, floor=matrix @ self.floor
        )

    def times(self, size: Array) -> _Errors:
        """Of the errors, each of another size."""
        return _Errors(
            own=self.own * np.outer(size, size),
            fit=self.fit * size[:, None],
            floor=self.floor * size[:, None],
        )

    def of(self, rows: Places) -> _Errors:
        """Of some of the errors."""
        return _Errors(own=self.own[np.ix_(rows, rows)], fit=self.fit[rows], floor=self.floor[rows])


def expected_errors(
    system: System, stack: Stack, found: Solved, residual: Array, folds: Sequence[LeftOut]
) -> tuple[Array, Array, Array, Array]:
    """What noise, run scatter, smooth floor and the fit to the others give left-out conditions.

    Notes
    -----
    With P = I - H of the whitened fit, the errors of a condition are L (P_hh)⁻¹ (P z)_h, and the
    data z have the covariance I + Φ Φ' of noise, run scatter and smooth floor.
    """
    begins = [part.start for part in stack.places.values()]
    floors = [piece.projection.floor for piece in system.pieces]
    edges = np.cumsum([0, *(x.shape[1] for x in floors)])
    taken = np.hstack([found.Q[b : b + len(x)].T @ x for b, x in zip(begins, floors, strict=True)])
    square, distance = np.zeros((len(folds), len(begins))), np.zeros(len(folds))
    sums = [_Squares() for _ in range(len(begins) + 1)]
    for first in range(0, len(folds), TOGETHER):
        white, plain = [], []
        for number, fold in enumerate(folds[first : first + TOGETHER], first):
            left = -found.Q[fold.rows] @ taken
            for k, (begin, own) in enumerate(zip(begins, floors, strict=True)):
                mine = (fold.rows >= begin) & (fold.rows < begin + len(own))
                left[mine, edges[k] : edges[k + 1]] += own[fold.rows[mine] - begin]
            errors = _Errors(own=np.eye(len(fold.rows)), fit=found.Q[fold.rows], floor=left)
            root = np.linalg.cholesky(errors.covariance)
            white.append(errors.by(np.linalg.inv(root)))
            distance[number] = float(np.sum(np.linalg.solve(root, residual[fold.rows]) ** 2))
            shown = errors.by(_root(system, begins, fold) @ fold.inverse)
            variance = fold.weight * np.maximum(np.diagonal(shown.covariance), 0.0)
            square[number] = np.bincount(fold.channel, variance, minlength=len(begins))
            size = np.where(square[number] > 0.0, square[number], np.inf)[fold.channel]
            scaled = shown.times(np.sqrt(fold.weight / size))
            plain.append([scaled.of(np.flatnonzero(fold.channel == k)) for k in range(len(begins))])
        every = [*zip(*plain, strict=True), white]
        sums = [one.with_(more) for one, more in zip(sums, every, strict=True)]
    rows = np.array([len(fold.rows) for fold in folds], float)
    return square, distance, rows, np.array([item.variance for item in sums])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Squares:
    """Sums over conditions from which the variance of a sum of squares of their errors follows.

    `own`: of each condition by itself. `fit, floor (q, q)`: products of what the conditions
    share. `across (q, D)`: products of the one with the other.
    """

    own: float = 0.0
    fit: Array | float = 0.0
    floor: Array | float = 0.0
    across: Array | float = 0.0

    def with_(self, every: Sequence[_Errors]) -> _Squares:
        """With some conditions more."""
        own = sum(
            float(np.sum(e.own**2) - 2.0 * np.sum((e.own @ e.fit) * e.fit))
            + 2.0 * float(np.sum((e.own @ e.floor) * e.floor))
            for e in every
        )
        fit, floor = (np.concatenate([getattr(e, x) for e in every]) for x in ("fit", "floor"))
        return _Squares(
            own=self.own + own,
            fit=self.fit + fit.T @ fit,
            floor=self.floor + floor.T @ floor,
            across=self.across + fit.T @ floor,
        )

    @property
    def variance(self) -> float:
        """Of the sum of squares of normal errors: 2 tr C² of their covariance C."""
        shared = np.sum(np.square(self.fit)) + np.sum(np.square(self.floor))
        found = self.own + float(shared - 2.0 * np.sum(np.square(self.across)))
        return 2.0 * max(found, 0.0)


def _root(system: System, begins: Sequence[int], fold: LeftOut) -> Array:
    """Root of the covariance of noise and run scatter: counted rows by all rows of a condition."""
    root = np.zeros((len(fold.counted), len(fold.rows)))
    place = {row: k for k, row in enumerate(fold.rows.tolist())}
    counted = {row: k for k, row in enumerate(fold.counted.tolist())}
    for begin, piece in zip(begins, system.pieces, strict=True):
        projection = piece.projection
        for run in projection.runs_of(fold.rows - begin):
            rows = (projection.channel.runs[run] + begin).tolist()
            at = [place[row] for row in rows]
            for k, row in enumerate(rows):
                if row in counted:
                    root[counted[row], at] = projection.roots[run][k]
    return root
