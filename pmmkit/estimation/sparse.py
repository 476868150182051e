"""Sparse least squares on compressed equations: thresholds, held-out runs, bags of runs."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

Flags = NDArray[np.bool_]
SINGULAR: Final = 1e-10
"""Singular values below this share of the largest are zero."""
EXCITED: Final = 0.05
"""Rms of a column in a bag, over that in all runs, below which the bag does not excite it."""
GRID: Final = 30
DEPTH: Final = 1e-6
"""Smallest threshold over the largest group."""
FOLDS: Final = 8


class Optimizer(Protocol):
    """What is asked of an optimizer of pysindy: ``fit(x, y)``, then ``coef_`` (1, m)."""

    coef_: Array

    def fit(self, x_: Array, y: Array) -> Any:
        """Fit one target (n, 1) on a library (n, m)."""
        ...


Method = Literal["stlsq", "stepwise"] | Optimizer


class Triangle(NamedTuple):
    """Equations of one channel, turned into a triangle that has the same least squares."""

    both: Array
    """Design and target side by side, (at most m + 1, m + 1)."""
    rows: int


System = tuple[Triangle, ...]
"""Equations of a run, or of many, channel by channel."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is solved together: channels that share a term or a group.

    Parameters
    ----------
    channels : tuple of str
        The channels.
    columns : tuple of int
        Places of the terms in the library.
    groups : tuple of tuple of int
        Terms that enter or leave together, as places in `columns`.
    always : tuple of bool
        Groups that never leave.
    method : "stlsq", "stepwise" or Optimizer
        How terms are chosen.
    """

    channels: tuple[str, ...]
    columns: tuple[int, ...]
    groups: tuple[tuple[int, ...], ...]
    always: tuple[bool, ...]
    method: Method

    @property
    def thresholds(self) -> bool:
        """Whether the choice hangs on a threshold (an optimizer brings its own rule)."""
        return isinstance(self.method, str)

    @property
    def plain(self) -> bool:
        """Whether pysindy's STLSQ does all that is asked for."""
        return all(len(group) == 1 for group in self.groups) and not any(self.always)


def compressed(design: Array, target: Array) -> Triangle:
    """Turn equations into a triangle; orthogonal, so that no digits are lost."""
    return Triangle(_triangle(np.column_stack([design, target])), len(target))


def joined(systems: Iterable[System]) -> System:
    """The equations of several runs as one; a run may stand more than once."""
    found = []
    for parts in zip(*systems, strict=True):
        both = np.concatenate([part.both for part in parts])
        found.append(Triangle(_triangle(both), sum(part.rows for part in parts)))
    return tuple(found)


def _triangle(both: Array) -> Array:
    if len(both) <= both.shape[1]:
        return both
    return np.asarray(np.linalg.qr(both, mode="r"))


def rms(system: System, x: Array | None = None) -> Array:
    """Rms of each column in the channel where it is largest; of ``columns @ x`` where given."""
    found = []
    for both, rows in system:
        part = both[:, :-1] if x is None else both[:, :-1] @ x
        found.append(np.sqrt(np.sum(part**2, axis=0) / max(rows, 1)))
    return np.asarray(np.max(found, axis=0))


def unit(system: System) -> tuple[Array, Array, Array]:
    """Design with columns of unit rms, target, and what the columns were divided by."""
    both = np.concatenate([part.both for part in system])
    size = rms(system)
    scale = np.where(size > 0, size, 1.0)
    return both[:, :-1] / scale, both[:, -1], scale


def null_space(system: System) -> Array:
    """Mixtures of columns of unit rms that give no force, array (k, m)."""
    design, _, _ = unit(system)
    _, singular, right = np.linalg.svd(design)
    rank = int(np.sum(singular > SINGULAR * max(singular.max(initial=0.0), 1e-300)))
    return np.asarray(right[rank:])


def determined(system: System, usual: Array) -> Flags:
    """Which terms these runs determine.

    Parameters
    ----------
    system : System
        Some of the runs.
    usual : array (m,)
        Rms of the columns in all runs.
    """
    there = rms(system) > EXCITED * usual
    if not there.any():
        return there
    some = tuple(Triangle(both[:, [*np.flatnonzero(there), -1]], rows) for both, rows in system)
    lost = (np.abs(null_space(some)) > 1e-6).any(axis=0)
    there[np.flatnonzero(there)[lost]] = False
    return there


def solved(system: System, columns: Flags) -> Array:
    """Least squares on some of the columns; the others are zero."""
    design, target, scale = unit(system)
    x = np.zeros(design.shape[1])
    if columns.any():
        x[columns] = np.linalg.lstsq(design[:, columns], target, rcond=None)[0]
    return np.asarray(x / scale)


def group_sizes(system: System, x: Array, groups: Sequence[Sequence[int]]) -> Array:
    """Rms force of each group in its largest channel, in standard deviations of a sample."""
    sizes = np.zeros(len(groups))
    for place, group in enumerate(groups):
        own = np.zeros(len(x))
        own[list(group)] = x[list(group)]
        sizes[place] = rms(system, own)
    return sizes


def sparse(task: Task, system: System, usual: Array, threshold: float) -> Array:
    """Coefficients of the terms that stay; zero where left out, NaN where not determined."""
    there = determined(system, usual)
    if not isinstance(task.method, str):
        x = _of_optimizer(task.method, system, there)
    elif task.method == "stlsq" and task.plain:
        x = solved(system, _by_pysindy(system, there, threshold))
    else:
        x = by_groups(task, system, there, threshold)
    x[~there] = np.nan
    return x


def by_groups(task: Task, system: System, there: Flags, threshold: float) -> Array:
    """Sequentially thresholded least squares in which groups enter or leave as a whole.

    A group leaves where the rms of its force is below the threshold: ``stlsq`` drops all such
    groups before it solves again, ``stepwise`` the smallest alone.
    """
    stay, always = np.ones(len(task.groups), bool), np.array(task.always)
    while True:
        columns = np.zeros(len(there), bool)
        for place in np.flatnonzero(stay):
            columns[list(task.groups[place])] = True
        x = solved(system, columns & there)
        size = group_sizes(system, x, task.groups)
        gone = stay & ~always & (size < threshold)
        if not gone.any():
            return x
        if task.method == "stepwise":
            gone = np.arange(len(gone)) == np.argmin(np.where(gone, size, np.inf))
        stay &= ~gone


def _by_pysindy(system: System, there: Flags, threshold: float) -> Flags:
    """Columns that stay by pysindy's STLSQ on columns of unit rms."""
    from pysindy.optimizers import STLSQ

    stay = np.zeros(len(there), bool)
    if there.any():
        design, target, _ = unit(system)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Sparsity parameter is too big")
            chooser = STLSQ(
                threshold=threshold, alpha=0.0, max_iter=len(there) + 2, unbias=False
            ).fit(design[:, there], target[:, None])
        stay[there] = chooser.coef_[0] != 0
    return stay


def _of_optimizer(optimizer: Optimizer, system: System, there: Flags) -> Array:
    design, target, scale = unit(system)
    x = np.zeros(len(there))
    if there.any():
        own = copy.deepcopy(optimizer)
        own.fit(design[:, there], target[:, None])
        x[there] = np.asarray(own.coef_)[0]
    return np.asarray(x / scale)


@dataclass(frozen=True, kw_only=True, eq=False)
class Path:
    """What held-out runs say of each threshold.

    Parameters
    ----------
    channels : tuple of str
        Channels that were solved together.
    thresholds : array (k,)
        Rms force below which a term (a group) leaves, in standard deviations of a sample.
    held_out : array (k,)
        Rms error in runs left out of the fit, in standard deviations.
    terms : array of int (k,)
        Terms that stay in the fit to all runs.
    score : array (k,)
        ``n log(held_out²) + terms log(n)`` with n the independent samples, channels added up.
    chosen : float
        The threshold taken.
    """

    channels: tuple[str, ...]
    thresholds: Array
    held_out: Array
    terms: NDArray[np.int64]
    score: Array
    chosen: float


def held_out(
    task: Task, runs: Sequence[System], folds: Sequence[Sequence[int]], thresholds: Sequence[float]
) -> Array:
    """Sums of squares in each run when the others are fitted, array (runs, channels, k)."""
    usual = rms(joined(runs))
    errors = np.zeros((len(runs), len(task.channels), len(thresholds)))
    for fold in folds:
        rest = joined([system for place, system in enumerate(runs) if place not in fold])
        for at, threshold in enumerate(thresholds):
            x = np.append(np.nan_to_num(sparse(task, rest, usual, threshold)), -1.0)
            for run in fold:
                for channel, part in enumerate(runs[run]):
                    errors[run, channel, at] = np.sum((part.both @ x) ** 2)
    return errors


def design_effect(runs: Sequence[System]) -> float:
    """By how much the samples of a run, sharing its errors, count for less than independent ones.

    Variance of the coefficients when runs are left out in turn (jackknife) over that of
    independent samples, the median over the terms, at least one (Kish 1965).
    """
    full = joined(runs)
    usual = rms(full)
    there = determined(full, usual)
    x = solved(full, there)
    moved = []
    for left in range(len(runs)):
        rest = joined([system for run, system in enumerate(runs) if run != left])
        known = determined(rest, usual)
        moved.append(np.where(known & there, solved(rest, known) - x, np.nan))
    together = (len(runs) - 1) * np.mean(np.square(moved), axis=0)
    design, target, scale = unit(full)
    squares = float(np.sum((target - design @ (x * scale)) ** 2))
    spare = max(sum(part.rows for part in full) - int(there.sum()), 1)
    root = np.linalg.pinv(design[:, there]) / scale[there, None]
    apart = np.sum(root**2, axis=1) * squares / spare
    ratio = together[there] / np.where(apart > 0, apart, np.nan)
    known = ratio[np.isfinite(ratio)]
    return max(float(np.median(known)), 1.0) if len(known) else 1.0


def choose_threshold(task: Task, runs: Sequence[System], folds: Sequence[Sequence[int]]) -> Path:
    """The threshold with the best score over held-out runs.

    Parameters
    ----------
    task : Task
        What is solved.
    runs : sequence of System
        Equations, run by run.
    folds : sequence of sequence of int
        Runs left out together.

    Returns
    -------
    Path
        Its `chosen` is the geometric middle of the thresholds that leave the same terms as the
        best one, as far as possible from either change of mind.
    """
    full = joined(runs)
    usual = rms(full)
    everything = solved(full, determined(full, usual))
    largest = float(group_sizes(full, everything, task.groups).max(initial=0.0)) or 1.0
    grid = np.geomspace(largest * DEPTH, largest * 1.01, GRID)
    stays = np.array([np.nan_to_num(sparse(task, full, usual, x)) != 0 for x in grid])
    errors = held_out(task, runs, folds, grid.tolist()).sum(axis=0)
    rows = np.array([part.rows for part in full])[:, None]
    floor = np.array([1e-16 * np.sum(part.both[:, -1] ** 2) for part in full])[:, None]
    mean = np.maximum(errors, np.maximum(floor, 1e-300)) / np.maximum(rows, 1)
    number = stays.sum(axis=1)
    independent = rows[:, 0] / design_effect(runs)
    score = independent @ np.log(mean) + number * np.log(max(independent.sum(), 2.0))
    best = int(np.flatnonzero(score <= score.min() + 1e-9 * abs(score.min()))[-1])
    other = np.flatnonzero((stays != stays[best]).any(axis=1))
    first = max((place + 1 for place in other if place < best), default=0)
    last = min((place - 1 for place in other if place > best), default=GRID - 1)
    return Path(
        channels=task.channels,
        thresholds=grid,
        held_out=np.sqrt(errors.sum(axis=0) / max(int(rows.sum()), 1)),
        terms=number.astype(np.int64),
        score=score,
        chosen=float(np.sqrt(grid[first] * grid[last])),
    )


def folds_of(runs: int, rng: np.random.Generator) -> tuple[tuple[int, ...], ...]:
    """Runs sorted at random into `FOLDS` parts, one run each where there are no more."""
    order = rng.permutation(runs)
    return tuple(tuple(order[start::FOLDS].tolist()) for start in range(min(FOLDS, runs)))


def bagged(task: Task, runs: Sequence[System], draws: NDArray[np.int64], threshold: float) -> Array:
    """Coefficients of each bag, array (bags, m); zero where left out, NaN where not determined."""
    usual = rms(joined(runs))
    found = np.empty((len(draws), len(task.columns)))
    for bag, drawn in enumerate(draws):
        found[bag] = sparse(task, joined([runs[run] for run in drawn]), usual, threshold)
    return found


def shares_of(coefficients: Array) -> Array:
    """Part of the bags in which a term is not zero, of those that determine it; NaN if none do."""
    known = np.isfinite(coefficients).sum(axis=0)
    found = (np.nan_to_num(coefficients) != 0).sum(axis=0)
    return np.where(known > 0, found / np.maximum(known, 1), np.nan)
