"""Sparse regression: terms that bags of whole runs ask for, by thresholds or elimination."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, ClassVar, Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pmmkit.inference.equations import Equations, Flags, unit_columns
from pmmkit.inference.linear_fit import RANK_TOLERANCE
from pmmkit.numerics import Array

UNDECIDED: Final = (0.2, 0.8)
"""Shares of the bags between which the runs do not decide on a term."""
GRID: Final = 30
"""Thresholds that are tried."""
DEPTH: Final = 1e-6
"""Smallest threshold over the largest group."""
ROUNDED: Final = 1e-16
"""Squares left, over those of the rows, that are rounding: exact forces fit no better."""
FOLDS: Final = 8
"""Parts into which runs are sorted to be left out."""


class Optimizer(Protocol):
    """What is asked of an optimizer of pysindy: ``fit(x, y)``, then ``coef_`` (1, p)."""

    coef_: Array

    def fit(self, x_: Array, y: Array) -> Any:
        """Fit one target (n, 1) on a library (n, p)."""
        ...


SelectionMethod = Literal["stlsq", "stepwise", "elimination"] | Optimizer


@dataclass(frozen=True, kw_only=True)
class SparseProblem:
    """What is solved together: channels that share a term or a group.

    Parameters
    ----------
    channels : tuple of str
        The channels.
    columns : tuple of int
        Places of the p terms in the library.
    groups : tuple of tuple of int
        Terms that enter or leave together, as places in `columns`.
    always : tuple of bool
        Groups that never leave.
    method : "stlsq", "stepwise", "elimination" or Optimizer
        How terms are chosen.
    """

    channels: tuple[str, ...]
    columns: tuple[int, ...]
    groups: tuple[tuple[int, ...], ...]
    always: tuple[bool, ...]
    method: SelectionMethod

    @classmethod
    def single(cls, channel: str, terms: int, method: SelectionMethod) -> SparseProblem:
        """Of one channel, whose terms stand alone."""
        return cls(
            channels=(channel,),
            columns=tuple(range(terms)),
            groups=tuple((place,) for place in range(terms)),
            always=(False,) * terms,
            method=method,
        )

    @property
    def thresholds(self) -> bool:
        """Whether the choice hangs on a threshold (elimination and optimizers have other rules)."""
        return self.method in ("stlsq", "stepwise")

    @property
    def plain(self) -> bool:
        """Whether pysindy's STLSQ does all that is asked for."""
        return all(len(group) == 1 for group in self.groups) and not any(self.always)


class Elimination:
    """Stepwise sparse regression of pysindy, stopped by the Bayesian information criterion.

    pysindy's SSR leaves out the term whose loss raises the misfit least, again and again
    (Boninsegna, Nüske and Clementi 2018). Unlike a threshold on the size of a term it sees that
    of several like terms one will do, however large their coefficients are against each other.
    Of the sets on its way the one with the least ``misfit + terms log(n)`` is taken (Schwarz
    1978), for equations whose errors have unit variance.

    `independent`: independent measurements n behind the equations.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> v = rng.uniform(-1, 1, 200)
    >>> X = np.stack([v, v**3, v * np.abs(v)], axis=1)
    >>> y = 50 * v - 40 * v**3 + rng.normal(size=200)
    >>> Elimination(200).fit(X, y[:, None]).coef_.round().ravel()
    array([ 50., -41.,   0.])
    """

    def __init__(self, independent: float) -> None:
        self.penalty = float(np.log(max(independent, 2.0)))
        self.coef_: Array = np.zeros((1, 0))

    def fit(self, x_: Array, y: Array) -> Elimination:
        """Fit one target (n, 1) on a library (n, p)."""
        X, scale, count = *unit_columns(x_), x_.shape[1]
        sets = [_solved(X, y), np.zeros((1, count))]
        if count > 1:
            ssr = _stepwise()(
                criteria="model_residual", alpha=0.0, kappa=0.0, max_iter=count, unbias=False
            ).fit(X, y)
            # pysindy 2.1 overwrites the first entry of its history, the fit with all terms
            sets += [np.array(coefficients) for coefficients in ssr.history_[1:]]
        score = [
            float(np.sum((y - X @ theta.T) ** 2)) + self.penalty * np.count_nonzero(theta)
            for theta in sets
        ]
        self.coef_ = sets[int(np.argmin(score))] / scale
        return self


def _solved(X: Array, y: Array) -> Array:
    """Least squares of one target (n, 1) on columns of one length, array (1, p)."""
    return np.asarray(np.linalg.lstsq(X, y.reshape(-1, 1), rcond=RANK_TOLERANCE)[0].T)


@cache
def _stepwise() -> Any:
    """pysindy's SSR without the ridge that it solves by scikit-learn: ten times faster."""
    from pysindy.optimizers import SSR

    class Stepwise(SSR):  # type: ignore[misc]  # pysindy has no types
        def _regress(self, x: Array, y: Array) -> Array:
            self.iters += 1
            return _solved(x, y)

    return Stepwise


def group_sizes(equations: Equations, theta: Array, groups: Sequence[Sequence[int]]) -> Array:
    """Rms force of each group in its largest channel, in standard deviations of a sample."""
    sizes = np.zeros(len(groups))
    for place, group in enumerate(groups):
        own = np.zeros(len(theta))
        own[list(group)] = theta[list(group)]
        sizes[place] = equations.rms(own)
    return sizes


def sparse_fit(
    problem: SparseProblem, equations: Equations, usual: Array, threshold: float
) -> Array:
    """θ (p,) of the terms that stay; zero where left out, NaN where not determined."""
    there = equations.determined(usual)
    if not isinstance(problem.method, str):
        theta = _by_optimizer(problem.method, equations, there)
    elif problem.method == "stlsq" and problem.plain:
        theta = equations.least_squares(_by_pysindy(equations, there, threshold))
    else:
        theta = by_groups(problem, equations, there, threshold)
    theta[~there] = np.nan
    return theta


def by_groups(
    problem: SparseProblem, equations: Equations, there: Flags, threshold: float
) -> Array:
    """Sequentially thresholded least squares in which groups enter or leave as a whole.

    A group leaves where the rms of its force is below the threshold: ``stlsq`` drops all such
    groups before it solves again, ``stepwise`` the smallest alone.
    """
    stay, always = np.ones(len(problem.groups), bool), np.array(problem.always)
    while True:
        columns = np.zeros(len(there), bool)
        for place in np.flatnonzero(stay):
            columns[list(problem.groups[place])] = True
        theta = equations.least_squares(columns & there)
        size = group_sizes(equations, theta, problem.groups)
        gone = stay & ~always & (size < threshold)
        if not gone.any():
            return theta
        if problem.method == "stepwise":
            gone = np.arange(len(gone)) == np.argmin(np.where(gone, size, np.inf))
        stay &= ~gone


def _by_pysindy(equations: Equations, there: Flags, threshold: float) -> Flags:
    """Columns that stay by pysindy's STLSQ on columns of unit rms."""
    from pysindy.optimizers import STLSQ

    stay = np.zeros(len(there), bool)
    if there.any():
        X, y, _ = equations.scaled
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Sparsity parameter is too big")
            chooser = STLSQ(
                threshold=threshold, alpha=0.0, max_iter=len(there) + 2, unbias=False
            ).fit(X[:, there], y[:, None])
        stay[there] = chooser.coef_[0] != 0
    return stay


def _by_optimizer(optimizer: Optimizer, equations: Equations, there: Flags) -> Array:
    X, y, scale = equations.scaled
    theta = np.zeros(len(there))
    if there.any():
        own = copy.deepcopy(optimizer)
        own.fit(X[:, there], y[:, None])
        theta[there] = np.asarray(own.coef_)[0]
    return np.asarray(theta / scale)


@dataclass(frozen=True, kw_only=True, eq=False)
class ThresholdPath:
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Resampling:
    """Runs left out together, and bags of runs: whole runs, since samples of one share its errors.

    Parameters
    ----------
    folds : tuple of tuple of int
        Runs in parts at random, one run each where there are no more than `FOLDS`.
    draws : array of int (bags, runs)
        Runs drawn with replacement.
    """

    BAGS: ClassVar[int] = 100
    FEWEST: ClassVar[int] = 3
    """Runs without which there are no bags of runs."""

    folds: tuple[tuple[int, ...], ...]
    draws: NDArray[np.int64]

    @classmethod
    def of(cls, runs: int, bags: int, rng: np.random.Generator) -> Resampling:
        """Of so many runs."""
        order = rng.permutation(runs)
        return cls(
            folds=tuple(tuple(order[start::FOLDS].tolist()) for start in range(min(FOLDS, runs))),
            draws=rng.integers(runs, size=(bags, runs)),
        )

    def held_out(
        self, problem: SparseProblem, runs: Sequence[Equations], threshold: float
    ) -> Array:
        """Sum of squares in each run when its fold is left out of the fit, (runs, channels)."""
        own, scaled = _with_rule(problem, runs, None)
        squares = _held_out(own, scaled, self.folds, [threshold])[:, :, 0]
        return squares if scaled is runs else squares * EffectiveSample.of(runs).variance


@dataclass(frozen=True, kw_only=True, eq=False)
class EffectiveSample:
    """Independent measurements that have the information of rows which share errors.

    Parameters
    ----------
    size : float
        Their number n, over all channels.
    variance : array (c,)
        Variance of a row of each channel that stands for one of them as many times as there are
        rows: that of the row itself times the design effect.
    """

    size: float
    variance: Array

    @classmethod
    def of(cls, runs: Sequence[Equations]) -> EffectiveSample:
        """By what a fit of all terms leaves in each channel, and the design effect (Kish 1965)."""
        full = Equations.joined(runs)
        there = full.determined(full.rms())
        squares = full.squares(full.least_squares(there))
        rows, effect = full.rows, _design_effect(runs)
        free = rows * max(1.0 - there.sum() / max(rows.sum(), 1), 1e-3)
        size = np.array([np.sum(part.both[:, -1] ** 2) for part in full.channels])
        floor = np.maximum(ROUNDED * size / np.maximum(rows, 1), 1e-300)
        return cls(
            size=max(float(rows.sum()) / effect, 2.0),
            variance=effect * np.maximum(squares / np.maximum(free, 1.0), floor),
        )


def _design_effect(runs: Sequence[Equations]) -> float:
    """By how much the samples of a run, sharing its errors, count for less than independent ones.

    Variance of the coefficients when runs are left out in turn (jackknife) over that of
    independent samples, the median over the terms, at least one (Kish 1965).
    """
    full = Equations.joined(runs)
    usual = full.rms()
    there = full.determined(usual)
    theta = full.least_squares(there)
    moved = []
    for left in range(len(runs)):
        rest = Equations.joined([run for place, run in enumerate(runs) if place != left])
        known = rest.determined(usual)
        moved.append(np.where(known & there, rest.least_squares(known) - theta, np.nan))
    together = (len(runs) - 1) * np.mean(np.square(moved), axis=0)
    X, _, scale = full.scaled
    squares = float(np.sum(full.squares(theta)))
    spare = max(int(full.rows.sum()) - int(there.sum()), 1)
    root = np.linalg.pinv(X[:, there], rcond=RANK_TOLERANCE) / scale[there, None]
    apart = np.sum(root**2, axis=1) * squares / spare
    ratio = together[there] / np.where(apart > 0, apart, np.nan)
    finite = ratio[np.isfinite(ratio)]
    return max(float(np.median(finite)), 1.0) if len(finite) else 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Selection:
    """Terms chosen in bags of runs (Brunton, Proctor and Kutz 2016; Fasel et al. 2022).

    Parameters
    ----------
    coefficients : array (bags, p)
        Values in each bag; zero where left out, NaN where the bag does not determine the term.
    shares : array (p,)
        Part of the bags in which a term is not zero, of those that determine it; NaN if none do.
    stays : array of bool (p,)
        Terms with at least the share asked for, and those that no bag judges.
    threshold : float
        Rms force below which a term left, in standard deviations of a sample.
    path : ThresholdPath, optional
        Thresholds tried, where one had to be chosen.
    """

    SHARE: ClassVar[float] = 0.6
    """Part of the bags in which a term must be taken."""

    coefficients: Array
    shares: Array
    stays: Flags
    threshold: float = 0.0
    path: ThresholdPath | None = None

    @classmethod
    def of(
        cls,
        problem: SparseProblem,
        runs: Sequence[Equations],
        resampling: Resampling,
        *,
        threshold: float | None = None,
        share: float = SHARE,
        sample: EffectiveSample | None = None,
    ) -> Selection:
        """Choose the terms that bags of runs ask for.

        Parameters
        ----------
        problem : SparseProblem
            Terms, groups and method.
        runs : sequence of Equations
            Equations, run by run.
        resampling : Resampling
            Folds and bags of these runs.
        threshold : float, optional
            Rms force below which a term leaves, in standard deviations of a sample; by default
            chosen by the runs that are left out, unless an optimizer brings its own rule.
        share : float
            Part of the bags in which a term must be taken.
        sample : EffectiveSample, optional
            What the rows are worth, for elimination; by default as they show.

        Examples
        --------
        >>> rng, runs = np.random.default_rng(0), []
        >>> for _ in range(8):
        ...     v = rng.uniform(-1, 1, 40)
        ...     X = np.stack([v, v**3, v**5], axis=1)
        ...     runs.append(Equations.of((X, X @ [50, -40, 0] + rng.normal(size=40))))
        >>> problem = SparseProblem.single("Y", 3, "stepwise")
        >>> Selection.of(problem, runs, Resampling.of(8, 20, rng)).stays
        array([ True,  True, False])
        """
        path = None
        problem, runs = _with_rule(problem, runs, sample)
        if threshold is None and problem.thresholds:
            path = choose_threshold(problem, runs, resampling.folds)
            threshold = path.chosen
        cut = threshold or 0.0
        usual = Equations.joined(runs).rms()
        coefficients = np.stack(
            [
                sparse_fit(problem, Equations.joined([runs[run] for run in drawn]), usual, cut)
                for drawn in resampling.draws
            ]
        )
        known = np.isfinite(coefficients).sum(axis=0)
        taken = (np.nan_to_num(coefficients) != 0).sum(axis=0)
        shares = np.where(known > 0, taken / np.maximum(known, 1), np.nan)
        return cls(
            coefficients=coefficients,
            shares=shares,
            stays=~(shares < share),
            threshold=cut,
            path=path,
        )

    @classmethod
    def combined(
        cls, selections: Sequence[Selection], columns: Sequence[Sequence[int]]
    ) -> Selection:
        """Selections of other terms in the same bags as one; `columns` are their places."""
        order = np.argsort([column for own in columns for column in own])
        return cls(
            coefficients=np.hstack([item.coefficients for item in selections])[:, order],
            shares=np.concatenate([item.shares for item in selections])[order],
            stays=np.concatenate([item.stays for item in selections])[order],
        )

    @property
    def undecided(self) -> Flags:
        """Terms on which the bags are of two minds, array (p,)."""
        low, high = UNDECIDED
        return np.asarray((self.shares > low) & (self.shares < high))

    def covariance(self, runs: Sequence[Equations], sample: EffectiveSample) -> Array:
        """Covariance of least squares with the s terms that stay, array (s, s).

        That of the regression, with the variance of the sample, and that of the choice.
        """
        whole = Equations.joined(runs)
        regression = whole.covariance(self.stays, sample.variance)
        return regression + self.covariance_of_choice(runs, sample)

    def covariance_of_choice(self, runs: Sequence[Equations], sample: EffectiveSample) -> Array:
        """What the choice of terms adds to the covariance of the s that stay, array (s, s).

        The squared changes of the values with each set of terms that a bag took, weighted by
        exp(-½ BIC) of its fit to all runs (Buckland, Burnham and Augustin 1997).

        Parameters
        ----------
        runs : sequence of Equations
            All runs.
        sample : EffectiveSample
            What their rows are worth.
        """
        whole = Equations.joined(runs)
        own = np.where(np.isnan(self.coefficients), self.stays, self.coefficients != 0)
        sets = np.unique(np.concatenate([own, self.stays[None]]), axis=0)
        values = np.stack([whole.least_squares(columns) for columns in sets])
        misfit = np.array([np.sum(whole.squares(theta) / sample.variance) for theta in values])
        score = misfit + np.log(max(sample.size, 2)) * sets.sum(axis=1)
        weight = np.exp((score.min() - score) / 2)
        change = (values - whole.least_squares(self.stays))[:, self.stays]
        return np.asarray((change.T * (weight / weight.sum())) @ change)


def _with_rule(
    problem: SparseProblem, runs: Sequence[Equations], sample: EffectiveSample | None
) -> tuple[SparseProblem, Sequence[Equations]]:
    """Elimination by the effective sample, whose rows have unit variance then."""
    if problem.method != "elimination":
        return problem, runs
    sample = sample or EffectiveSample.of(runs)
    std = np.sqrt(sample.variance)
    return replace(problem, method=Elimination(sample.size)), [run.over(std) for run in runs]


def _held_out(
    problem: SparseProblem,
    runs: Sequence[Equations],
    folds: Sequence[Sequence[int]],
    thresholds: Sequence[float],
) -> Array:
    """Sums of squares in each run when the others are fitted, array (runs, channels, k)."""
    usual = Equations.joined(runs).rms()
    errors = np.zeros((len(runs), len(problem.channels), len(thresholds)))
    for fold in folds:
        rest = Equations.joined([run for place, run in enumerate(runs) if place not in fold])
        for at, threshold in enumerate(thresholds):
            theta = np.nan_to_num(sparse_fit(problem, rest, usual, threshold))
            for run in fold:
                errors[run, :, at] = runs[run].squares(theta)
    return errors


def choose_threshold(
    problem: SparseProblem, runs: Sequence[Equations], folds: Sequence[Sequence[int]]
) -> ThresholdPath:
    """The threshold with the best score over held-out runs.

    Its `chosen` is the geometric middle of the thresholds that leave the same terms as the best
    one, as far as possible from either change of mind; of equal scores the sparsest counts.
    """
    full = Equations.joined(runs)
    usual = full.rms()
    everything = full.least_squares(full.determined(usual))
    largest = float(group_sizes(full, everything, problem.groups).max(initial=0.0)) or 1.0
    grid = np.geomspace(largest * DEPTH, largest * 1.01, GRID)
    stays = np.array([np.nan_to_num(sparse_fit(problem, full, usual, x)) != 0 for x in grid])
    errors = _held_out(problem, runs, folds, grid.tolist()).sum(axis=0)
    rows = full.rows[:, None]
    floor = ROUNDED * np.array([np.sum(part.both[:, -1] ** 2) for part in full.channels])[:, None]
    mean = np.maximum(errors, np.maximum(floor, 1e-300)) / np.maximum(rows, 1)
    number = stays.sum(axis=1)
    independent = full.rows / _design_effect(runs)
    score = independent @ np.log(mean) + number * np.log(max(independent.sum(), 2.0))
    best = int(np.flatnonzero(score <= score.min() + 1e-9 * abs(score.min()))[-1])
    other = np.flatnonzero((stays != stays[best]).any(axis=1))
    first = max((place + 1 for place in other if place < best), default=0)
    last = min((place - 1 for place in other if place > best), default=GRID - 1)
    return ThresholdPath(
        channels=problem.channels,
        thresholds=grid,
        held_out=np.sqrt(errors.sum(axis=0) / max(int(rows.sum()), 1)),
        terms=number.astype(np.int64),
        score=score,
        chosen=float(np.sqrt(grid[first] * grid[last])),
    )
