"""Intervals when a model lacks something: what innovations and windows say of it, taken in."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord
from pmmkit.inference import Innovations
from pmmkit.numerics import Array

LENGTHS: Final = (1.0, 2.0, 4.0, 8.0)
"""Ship lengths over the speed over which innovations are summed up."""
BY_CHANCE: Final = 1e-4
"""Probability that the size of a channel's sums is due to chance, below which it is not."""
EVIDENCE: Final = 5.0
"""Gain of the log likelihood from which windows are taken to differ."""
FEWEST: Final = 3
"""Records from which their scatter tells an interval: of two, Student's t is 6 times the normal."""
LONGER: Final = (2, 4, 8)
"""Times that what hangs together over which residuals of forces are summed up."""
SHIFTS: Final = 60
"""Standard deviations of the shift from window to window that are tried before the best is sought
between its neighbours."""
SEEN: Final = 1e-3
"""Information of a window over the prior's from which a direction counts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordPiece:
    """What a stretch of a record says of the parameters about their estimate.

    `record`: number of the record. `information (m, m)`: over the prior's standard deviations.
    `score (m,)`: information times how far the stretch alone would move the estimate.
    """

    record: int
    information: Array
    score: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class LackOfFit:
    """What says that a model lacks something, and the covariance that allows for it.

    `covariance (m, m)`: nowhere narrower than that of the model alone, which it is where
    nothing is lacking and no records are set against each other. `alone (m, m)`: covariance if
    the model is complete. `colour`: variance of summed innovations over that of white ones of the
    stated size, by channel that is beyond chance. `shift`: standard deviation by which the values
    wander from window to window, over the prior's.
    """

    covariance: Array
    alone: Array
    colour: Mapping[str, float]
    shift: float

    @property
    def found(self) -> bool:
        """Whether something is missing."""
        return bool(self.colour) or self.shift > 0.0

    def words(self) -> tuple[str, ...]:
        """What is missing, in words; nothing where nothing is."""
        if not self.found:
            return ()
        signs = []
        if self.colour:
            worst = max(self.colour, key=lambda name: self.colour[name])
            signs.append(
                f"errors of {worst} last, with {self.colour[worst]:.2g} times the variance that "
                f"is expected of their sums"
            )
        if self.shift > 0.0:
            signs.append(
                f"windows of the records ask for values {self.shift:.2g} prior standard deviations "
                f"apart"
            )
        return (
            f"something is missing in the model: {'; '.join(signs)}. The intervals are widened by "
            f"that; what is missing, `pmmkit diagnose` tells",
        )


def lack_of(
    prior: Prior,
    covariance: Array,
    pieces: Sequence[RecordPiece],
    colour: Mapping[str, float],
    sharper: float = 1.0,
    *,
    clustered: bool = False,
    sigma_points: bool = False,
) -> LackOfFit:
    """Widen a covariance by what the records say against the model.

    covariance (m, m).

    Notes
    -----
    Two ways in which a model that lacks something misleads, and in every direction the larger
    counts. Errors that last: n instants that all say the same count as n over the ratio between
    the variance of sums of innovations and that of white ones, so that the information of the
    records is divided by that ratio, of the worst channel. Values that wander: each window w of
    information Λ asks for values off by a shift of variance s²D² (D the prior's standard
    deviations), so that its score has variance Λ + s²ΛD²Λ; s is the most likely one. A shift is
    shared by the windows of a record, whence the estimate's variance grows by s² P Σ(ΛD²Λ) P
    over records (a random effect, as between the studies of a meta-analysis: DerSimonian and Laird
    1986).

    Clustered, the estimate's variance is also that of the jackknife over records (see
    `_between_records`), whatever else is found: what lasts through a whole record is in no
    difference between its windows, and what is wrong with a whole model in none of its innovations.

    By sigma points, the covariance is nowhere narrower than what the pieces tell together, by which
    they are weighed: points that straddle the stall of a rudder are surer along one axis than all
    records, and what is inferred from that is a hundred times as wide as the prior.

    Examples
    --------
    >>> prior = Prior(names=("Yv",), mean=np.zeros(1), covariance=np.eye(1))
    >>> pieces = [RecordPiece(record=i, information=np.array([[1e4]]), score=np.array([x * 1e4]))
    ...           for i, x in enumerate([-0.3, 0.1, 0.4, -0.2])]
    >>> found = lack_of(prior, np.array([[2.5e-5]]), pieces, {})
    >>> round(found.shift, 2), (found.covariance**0.5).round(2)
    (0.27, array([[0.14]]))
    """
    scale = np.outer(prior.std, prior.std)
    narrow: Array = covariance / scale
    alone, weights = covariance, narrow
    if sigma_points:
        weights = _told_by(prior, pieces)
        narrow = _larger(narrow, weights)
        alone = narrow * scale
    shift = _shift(pieces, sharper)
    between = _between_records(narrow, pieces) if clustered else np.zeros_like(narrow)
    if not (colour or shift or between.any()):
        return LackOfFit(covariance=alone, alone=alone, colour={}, shift=0.0)
    wide = _told_less(narrow, prior.covariance / scale, max(colour.values())) if colour else narrow
    if shift > 0.0:
        groups = sorted({item.record for item in pieces})
        by_record = [
            np.sum([item.information for item in pieces if item.record == group], axis=0)
            for group in groups
        ]
        spread = shift**2 * sum((x @ x for x in by_record), np.zeros_like(narrow))
        wide = _larger(wide, narrow + weights @ spread @ weights)
    wide = _larger(wide, between)
    return LackOfFit(
        covariance=_larger(narrow, wide) * scale, alone=alone, colour=dict(colour), shift=shift
    )


def _told_by(prior: Prior, pieces: Sequence[RecordPiece]) -> Array:
    """Covariance of what pieces of records tell together, over the prior's standard deviations."""
    told = sum((item.information for item in pieces), prior.precision)
    _, inverse = _root(told)
    found: Array = inverse.T @ inverse
    return found


def _between_records(narrow: Array, pieces: Sequence[RecordPiece]) -> Array:
    """Covariance by the jackknife over records; none of fewer than `FEWEST`.

    Without record g, of information Λ and score s, the estimate moves by d = -(P⁻¹ - Λ)⁻¹ s, and
    the variance of G of these is (G - 1)/G Σ d dᵀ: the sandwich (Liang and Zeger 1986) whose scores
    are those of records that their own fit has not drawn towards itself (CV3 of MacKinnon, Nielsen
    and Webb 2023, the least optimistic of their corrections for few clusters), by Student's t of
    G - 1 degrees of freedom over the normal.
    """
    from scipy.stats import norm, t

    groups = sorted({item.record for item in pieces})
    if len(groups) < FEWEST:
        return np.zeros_like(narrow)
    told, free, moved = np.linalg.inv(narrow), len(groups) - 1, []
    for group in groups:
        own = [item for item in pieces if item.record == group]
        rest = told - np.sum([item.information for item in own], axis=0)
        moved.append(np.linalg.solve(rest, np.sum([item.score for item in own], axis=0)))
    few = (t.isf(0.025, free) / norm.isf(0.025)) ** 2
    found: Array = few * free / len(groups) * np.transpose(moved) @ np.array(moved)
    return found


def _shift(pieces: Sequence[RecordPiece], sharper: float) -> float:
    """The most likely shift between windows; none where none is much less likely."""
    from scipy.optimize import minimize_scalar

    found = []
    for item in pieces:
        sizes, vectors = np.linalg.eigh(sharper * item.information)
        found.append(np.stack([sizes, sharper * (vectors.T @ item.score)])[:, sizes > SEEN])
    sizes, part = np.concatenate([*found, np.zeros((2, 0))], axis=1)
    if not np.any(part):
        return 0.0

    def loss(log: float) -> float:
        variance = sizes + math.exp(2.0 * log) * sizes**2
        return 0.5 * float(np.sum(np.log(variance) + part**2 / variance))

    # A shift below the first is lost in noise; none is more likely beyond what a window asks for.
    least = 0.1 / math.sqrt(sizes.max())
    tried = np.log(np.geomspace(least, max(np.max(np.abs(part / sizes)), 2.0 * least), SHIFTS))
    best = int(np.argmin([loss(log) for log in tried.tolist()]))
    between = (tried[max(best - 1, 0)], tried[min(best + 1, SHIFTS - 1)])
    log = float(minimize_scalar(loss, bounds=between, method="bounded").x)
    return math.exp(log) if loss(-math.inf) - loss(log) > EVIDENCE else 0.0


def _root(covariance: Array) -> tuple[Array, Array]:
    """A root of a covariance and its inverse, of one too whose least variance is rounding: that of
    an unscented filter may be 1e-11 of the prior's along what it is most sure of."""
    sizes, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
    own = np.sqrt(np.maximum(sizes, np.finfo(float).eps * sizes.max()))
    return vectors * own, (vectors / own).T


def _told_less(narrow: Array, prior: Array, ratio: float) -> Array:
    """Covariance of which the information beyond the prior's is divided by a ratio.

    Along axes in which the prior is 1 and the covariance λ it is cλ/(1 + (c - 1)λ): no inverse of
    what is nearly certain is taken.
    """
    root, inverse = _root(prior)
    sizes, vectors = np.linalg.eigh(inverse @ narrow @ inverse.T)
    sizes = np.maximum(sizes, 0.0)
    half = root @ (vectors * np.sqrt(ratio * sizes / (1.0 + (ratio - 1.0) * sizes)))
    found: Array = half @ half.T
    return found


def _larger(one: Array, other: Array) -> Array:
    """The smallest covariance, of like axes, that is nowhere narrower than either of two."""
    root, inverse = _root(one)
    sizes, vectors = np.linalg.eigh(inverse @ other @ inverse.T)
    half = root @ (vectors * np.sqrt(np.maximum(sizes, 1.0)))
    larger: Array = half @ half.T
    return larger


def colour_of(
    innovations: Mapping[str, Innovations], samples: Mapping[str, float]
) -> dict[str, float]:
    """Variance of sums of innovations over that of white ones, for channels beyond chance.

    Examples
    --------
    >>> noise = np.random.default_rng(0).normal(size=(2000, 2))
    >>> slow = np.convolve(noise[:, 1], np.ones(5) / 5**0.5, "same")
    >>> item = Innovations(
    ...     names=("psi", "r"), residuals=np.stack([noise[:, 0], slow], axis=1),
    ...     variances=np.ones((2000, 2)))
    >>> {name: round(x) for name, x in colour_of({"zigzag": item}, {"zigzag": 10.0}).items()}
    {'r': 5}
    """
    from scipy.stats import chi2

    found: dict[str, float] = {}
    names = dict.fromkeys(name for item in innovations.values() for name in item.names)
    for name in names:
        for length in LENGTHS:
            sums = np.concatenate(
                [
                    _sums(item, name, max(round(length * samples[record]), 1))
                    for record, item in innovations.items()
                    if name in item.names
                ]
            )
            if len(sums) < 4:
                continue
            size = float(np.mean(sums))
            if len(sums) * size > chi2.isf(BY_CHANCE, len(sums)):
                found[name] = max(found.get(name, 1.0), size)
    return found


def lasting(residuals: Mapping[str, Sequence[tuple[Array, int]]]) -> dict[str, float]:
    """Variance of sums over several times what hangs together, over that of sums that do not.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> short, long = (np.repeat(rng.normal(size=4000 // n), n) for n in (10, 80))
    >>> {name: round(x) for name, x in lasting({"X": [(short, 10)], "Y": [(long, 10)]}).items()}
    {'Y': 8}
    """
    from scipy.stats import chi2

    found: dict[str, float] = {}
    for name, records in residuals.items():
        alone = np.concatenate([_squares(x, count) for x, count in records])
        usual = float(np.mean(alone)) if len(alone) else 0.0
        for times in LONGER:
            sums = np.concatenate([_squares(x, times * count) for x, count in records])
            if len(sums) < 4 or usual == 0.0:
                continue
            size = float(np.mean(sums)) / usual
            if len(sums) * size > chi2.isf(BY_CHANCE, len(sums)):
                found[name] = max(found.get(name, 1.0), size)
    return found


def _squares(values: Array, count: int) -> Array:
    """Squares of sums over blocks of so many instants, over their number."""
    blocks = values[: len(values) // count * count].reshape(-1, count)
    squares: Array = blocks.sum(axis=1) ** 2 / count
    return squares


def stretches(record: FreeRecord, length: float) -> tuple[FreeRecord, ...]:
    """A record cut into stretches of about a length [s], as many as fit.

    Examples
    --------
    >>> t = np.arange(100.0)
    >>> whole = FreeRecord(name="turn", t=t, delta=t, turns=t, measured={"psi": t}, speed=1.0)
    >>> [len(item) for item in stretches(whole, 35.0)]
    [33, 33, 34]
    """
    count = max(round((record.t[-1] - record.t[0]) / length), 1)
    edges = np.linspace(record.t[0], record.t[-1], count + 1)[1:-1]
    places = [0, *np.searchsorted(record.t, edges).tolist(), len(record)]
    return tuple(
        record.cut(float(record.t[begin]), float(record.t[end - 1]))
        for begin, end in pairwise(places)
        if end - begin > 2
    )


def _sums(item: Innovations, name: str, count: int) -> Array:
    """Squares of sums over blocks, over their number; a gated innovation counts as the gate."""
    column = item.names.index(name)
    ratio = item.residuals[:, column] / np.sqrt(item.variances[:, column])
    ratio = np.clip(ratio, -item.gate, item.gate)
    blocks = ratio[: len(ratio) // count * count].reshape(-1, count)
    there: NDArray[np.int64] = np.isfinite(blocks).sum(axis=1)
    sums: Array = np.nansum(blocks, axis=1)[there > 0] ** 2 / there[there > 0]
    return sums
