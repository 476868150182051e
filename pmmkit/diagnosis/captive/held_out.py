"""How well a model predicts conditions that its fit had not seen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.least_squares import JointFit, Solved, Stack, labels, solved, stacked
from pmmkit.diagnosis.captive.system import CandidateColumns, System, candidate_columns, channels_of
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.inference import of_others
from pmmkit.numerics import Array
from pmmkit.reduction import View

if TYPE_CHECKING:
    import pandas as pd


# The error of left-out conditions that noise alone would give: what the covariances expect.


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
    system: System,
    stack: Stack,
    found: Solved,
    residual: Array,
    folds: Sequence[LeftOut],
    *,
    with_spread: bool,
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
            distance[number] = float(np.sum(np.linalg.solve(root, residual[fold.rows]) ** 2))
            shown = errors.by(_root(system, begins, fold) @ fold.inverse)
            variance = fold.weight * np.maximum(np.diagonal(shown.covariance), 0.0)
            square[number] = np.bincount(fold.channel, variance, minlength=len(begins))
            if not with_spread:
                continue
            white.append(errors.by(np.linalg.inv(root)))
            size = np.where(square[number] > 0.0, square[number], np.inf)[fold.channel]
            scaled = shown.times(np.sqrt(fold.weight / size))
            plain.append([scaled.of(np.flatnonzero(fold.channel == k)) for k in range(len(begins))])
        if with_spread:
            every = [*zip(*plain, strict=True), white]
            sums = [one.with_(more) for one, more in zip(sums, every, strict=True)]
    rows = np.array([len(fold.rows) for fold in folds], float)
    spread = [item.variance if with_spread else np.nan for item in sums]
    return square, distance, rows, np.array(spread)


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


Kind = Literal["error", "force", "level"]
CHANGED: Final = 0.02
"""Share by which an error must change to count as changed."""


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """How far errors of left-out conditions are from their noise level.

    `where`: the channel that is fitted least, ``all`` for all harmonics of all channels.
    `ratio`: root mean square of its errors over what noise gives. `chance`: probability that
    noise gives one so large.
    """

    where: str
    ratio: float
    chance: float


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldOut:
    """Errors of predictions of conditions that a fit had not seen.

    `conditions`: what was left out, one after another: runs of one setting together. `tests`:
    test type of each. `channels`: columns of the arrays. `error, force (conditions, channels)`:
    root mean square of the error and of the measured force over a cycle [N, N m]; NaN where a
    condition has no such channel or the other conditions do not determine it. `level
    (conditions, channels)`: noise level: the error to be expected if nothing is missing, of
    noise, run scatter, the smooth floor and what the other conditions leave unknown [N, N m].
    `distance, rows (conditions,)`: squares of all errors of a condition, harmonic by harmonic,
    over their covariance, and what is expected of them: their number. `spread (channels + 1,)`:
    variance that noise gives the sum over the conditions of (error over level)², by channel,
    and of `distance`.
    """

    conditions: tuple[str, ...]
    tests: tuple[str, ...]
    channels: tuple[str, ...]
    error: Array
    force: Array
    level: Array
    distance: Array
    rows: Array
    spread: Array

    def of_channel(self, test: str | None = None, *, kind: Kind = "error") -> dict[str, float]:
        """Root mean square of error, force or noise level by channel [N, N m], of one test type or
        of all."""
        return dict(zip(self.channels, self._rms(test, kind).tolist(), strict=True))

    def share(self, test: str | None = None, *, kind: Kind = "error") -> float:
        """Errors of one test type or of all over the channels' rms forces, over the channels."""
        return float(_rms((self._rms(test, kind) / _rms(self.force))[:, None])[0])

    def _rms(self, test: str | None, kind: Kind) -> Array:
        at = [i for i, name in enumerate(self.tests) if test in (None, name)]
        values: Mapping[Kind, Array] = {
            "error": self.error,
            "force": self.force,
            "level": self.level,
        }
        return _rms(values[kind][at])

    @property
    def misfit(self) -> Misfit:
        """Errors over what noise gives: of the channel, or of all harmonics, that it fits least.

        The condition that stands out most is not counted: a run may be wrong. The sum over the
        others is one of squares of dependent normal variables: a χ² of its mean and its variance
        (Satterthwaite 1946). The least probability is multiplied by their number (Bonferroni).
        """
        from scipy.special import chdtrc

        squares = np.column_stack([(self.error / self.level) ** 2, self.distance])
        means = np.column_stack([np.where(np.isfinite(self.error), 1.0, np.nan), self.rows])
        worst = np.argmax(np.where(np.isfinite(squares), squares - means, -np.inf), axis=0)
        for values in (squares, means):
            values[worst, np.arange(values.shape[1])] = np.nan
        total, mean = np.nansum(squares, axis=0), np.nansum(means, axis=0)
        known = (mean > 0.0) & (self.spread > 0.0)
        if not known.any():
            return Misfit(where="all", ratio=1.0, chance=1.0)
        total, mean, spread = total[known], mean[known], self.spread[known]
        chances = chdtrc(2.0 * mean**2 / spread, 2.0 * mean * total / spread)
        place = int(np.lexsort((-total / mean, chances))[0])
        names = np.array([*self.channels, "all"])[known]
        return Misfit(
            where=str(names[place]),
            ratio=float(np.sqrt(total[place] / mean[place])),
            chance=min(1.0, len(chances) * float(chances[place])),
        )

    def with_rows_of(self, other: HeldOut, rows: Sequence[int]) -> HeldOut:
        """With some conditions as another set of effects predicts them."""
        fields = ("error", "force", "level", "distance", "rows")
        mixed = {name: getattr(self, name).copy() for name in fields}
        for name, values in mixed.items():
            values[list(rows)] = getattr(other, name)[list(rows)]
        return replace(self, **mixed)

    def better_than(self, other: HeldOut) -> float:
        """Share of conditions and channels with a smaller error, of those that change at all."""
        known = np.isfinite(self.error) & np.isfinite(other.error)
        new, old = self.error[known], other.error[known]
        changed = np.abs(new - old) > CHANGED * old
        return float(np.mean(new[changed] < old[changed])) if changed.any() else 0.0

    def to_pandas(self) -> pd.DataFrame:
        """A row per condition and channel: condition, test, channel, error, force."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "condition": name,
                    "test": test,
                    "channel": channel,
                    "error": self.error[i, j],
                    "force": self.force[i, j],
                }
                for i, (name, test) in enumerate(zip(self.conditions, self.tests, strict=True))
                for j, channel in enumerate(self.channels)
            ]
        )


def _rms(values: Array) -> Array:
    """Root mean square down the columns, over what is known; NaN where nothing is."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    total = np.where(known, values, 0.0) ** 2
    with np.errstate(invalid="ignore"):
        found: Array = np.sqrt(total.sum(axis=0) / np.where(count > 0, count, np.nan))
    return found


def held_out(
    system: System,
    effects: Sequence[CandidateColumns] = (),
    *,
    with_level: bool = True,
    with_spread: bool = True,
) -> HeldOut:
    """Errors of base and effects on each condition, fitted to all other conditions.

    Their noise levels, and what spread these have over all conditions, take longer than they do.

    Notes
    -----
    Weighted least squares without the smooth floor. With the rows of a condition k, e their
    residuals and H the hat matrix, the residuals of a fit without them are (I - H_kk)⁻¹ e; one
    decomposition serves all.
    """
    stack = stacked(system, effects)
    fit = solved(stack)
    residual = stack.white[:, -1] - stack.white[:, :-1] @ fit.solution
    groups = _groups(system, stack)
    channels = tuple(stack.places)
    shape = (len(groups), len(channels))
    error, force, level = (np.full(shape, np.nan) for _ in range(3))
    distance, rows_of = np.full(len(groups), np.nan), np.full(len(groups), np.nan)
    folds: dict[int, LeftOut] = {}
    for number, members in enumerate(groups.values()):
        rows = np.concatenate([at for _, _, at in members])
        Q = fit.Q[rows]
        inverse, determined = of_others(Q)
        if not determined:
            continue
        change = np.linalg.solve(fit.R, Q.T @ inverse @ residual[rows]) / fit.size
        solution = fit.solution - change
        counted = []
        for place, channel in enumerate(channels):
            mine = [at for name, view, at in members if name == channel and not view.early]
            if mine:
                left = [
                    _mean_square(stack.plain[at, -1] - stack.plain[at, :-1] @ solution)
                    for at in mine
                ]
                error[number, place] = np.sqrt(np.mean(left))
                force[number, place] = np.sqrt(
                    np.mean([_mean_square(stack.plain[at, -1]) for at in mine])
                )
                counted += [(place, at, _weights(len(at)) / len(mine)) for at in mine]
        folds[number] = LeftOut(
            rows=rows,
            inverse=inverse,
            counted=np.concatenate([at for _, at, _ in counted]),
            channel=np.repeat([k for k, _, _ in counted], [len(at) for _, at, _ in counted]),
            weight=np.concatenate([weight for _, _, weight in counted]),
        )
    spread = np.full(len(channels) + 1, np.nan)
    if with_level and folds:
        at = list(folds)
        square, distance[at], rows_of[at], spread = expected_errors(
            system, stack, fit, residual, tuple(folds.values()), with_spread=with_spread
        )
        level[at] = np.where(np.isfinite(error[at]), np.sqrt(square), np.nan)
    return HeldOut(
        conditions=tuple(groups),
        channels=channels,
        error=error,
        force=force,
        level=level,
        distance=distance,
        rows=rows_of,
        spread=spread,
        tests=tuple(members[0][1].run.test for members in groups.values()),
    )


FORCE: Final = "force"
"""All channels of captive tests together, each over its rms force."""


def missed(
    views: Sequence[View], base: CaptiveBase, effects: Sequence[CandidateColumns], fit: JointFit
) -> dict[str, float]:
    """Root mean square errors of runs that a fit had not seen: of all channels together over their
    rms forces [%], and of each [N, N m]. What an effect draws for each run by itself is not known.
    """
    channels = channels_of(views, base)
    values = dict(zip(fit.names, np.nan_to_num(fit.values).tolist(), strict=True))
    shown = {c.name: c.design @ [values.get(x, 0.0) for x in base.names[c.name]] for c in channels}
    for block in effects:
        if not block.candidate.each_run:
            sizes = [values[x] for x in labels(block.candidate)]
            own = candidate_columns(block.candidate, block.value, channels, views, base)
            shown |= {name: shown[name] + columns @ sizes for name, columns in own.items()}
    errors, shares = {}, []
    for c in channels:
        rows = [x for i, x in zip(c.views, c.rows, strict=True) if not views[i].early]
        pairs = [(_mean_square((c.y - shown[c.name])[x]), _mean_square(c.y[x])) for x in rows]
        error, force = np.sqrt(np.mean(pairs, axis=0)).tolist()
        errors[c.name] = error
        shares.append(error / force if force else 0.0)
    return {FORCE: 100.0 * float(np.sqrt(np.mean(np.square(shares)))), **errors}


def _weights(rows: int) -> Array:
    """Of squared mean and harmonics in the mean square over a cycle."""
    return np.where(np.arange(rows) > 0, 0.5, 1.0)


def _mean_square(harmonics: Array) -> float:
    """Mean square over a cycle of a history with these harmonics."""
    return float(_weights(len(harmonics)) @ harmonics**2)


def _groups(system: System, stack: Stack) -> dict[str, list[tuple[str, View, Places]]]:
    """Channel, view and rows by condition."""
    groups: dict[str, list[tuple[str, View, Places]]] = {}
    runs = {view.run.id: view.run for view in system.views}
    named = conditions(tuple(runs.values()))
    for c in system.channels:
        for i, rows in zip(c.views, c.rows, strict=True):
            view = system.views[i]
            begin = stack.places[c.name].start
            at = np.arange(begin + rows.start, begin + rows.stop)
            groups.setdefault(named[view.run.id], []).append((c.name, view, at))
    return groups


def conditions(runs: Sequence[Run]) -> dict[str, str]:
    """The condition of each run; two that the digits of words do not tell apart by their runs."""
    groups = Run.repeats(runs)
    often = Counter(condition(runs_alike[0]) for runs_alike in groups)
    named: dict[str, str] = {}
    for runs_alike in groups:
        name = condition(runs_alike[0])
        name = f"{name} ({runs_alike[0].id})" if often[name] > 1 else name
        named |= {run.id: name for run in runs_alike}
    return named


def condition(run: Run) -> str:
    """The setting of a run in words: runs with one setting repeat each other."""
    return f"{run.test.replace('_', ' ')}, {run.setting}"
