"""How well a model predicts conditions that its fit had not seen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.least_squares import Stack, solved, stacked
from pmmkit.diagnosis.captive.noise_level import LeftOut, expected_errors
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.inference import of_others
from pmmkit.numerics import Array
from pmmkit.reduction import View

if TYPE_CHECKING:
    import pandas as pd

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
    system: System, effects: Sequence[CandidateColumns] = (), *, with_level: bool = True
) -> HeldOut:
    """Errors of base and effects on each condition, fitted to all other conditions.

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
            system, stack, fit, residual, tuple(folds.values())
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
