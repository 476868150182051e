"""Terms chosen among a library by sparse regression on the histories, in bags of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.estimation.elimination import Elimination
from pmmkit.estimation.sparse import (
    Method,
    System,
    Task,
    bagged,
    choose_threshold,
    compressed,
    folds_of,
    joined,
    shares_of,
    solved,
)
from pmmkit.inference import optional_columns
from pmmkit.numerics import Array
from pmmkit.reduction.derivatives import Columns
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.methods.method import Estimate, Evidence
from pmmkit.reduction.methods.over_time import OverTime, determined
from pmmkit.reduction.solve import Solution

TITLE: Final = "sparse regression"
BAGS: Final = 100
SHARE: Final = 0.6
"""Part of the bags in which a term must be taken."""
UNDECIDED: Final = (0.2, 0.8)
"""Shares between which the runs do not decide on a term."""
FEWEST: Final = 3
"""Runs of a channel without which there are no bags of runs."""
TELLABLE: Final = 1e4
"""Variance inflation up to which a further term can be told from the others at all."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """Terms chosen in one channel.

    Parameters
    ----------
    names : tuple of str
        Terms that were looked for.
    shares : array (m,)
        Part of the bags in which each was taken.
    fit : ChannelFit
        Least squares with those that are kept.
    moved : array (s, s)
        Covariance that the choice itself brings, of the kept terms.
    """

    names: tuple[str, ...]
    shares: Array
    fit: ChannelFit
    moved: Array


def by_sparse_regression(
    evidence: Evidence, *, chooser: Method | None = None, seed: int = 0
) -> Estimate:
    """Derivatives of those terms of a library that the runs ask for.

    Parameters
    ----------
    evidence : Evidence
        With the runs over time, and the library.
    chooser : "stlsq", "stepwise" or optimizer of pysindy, optional
        How terms are chosen: by thresholds that runs held out choose, as in
        `pmmkit.estimation.sparse`, or by the rule of an optimizer. By default `Elimination`.
    seed : int
        Of the bags.

    Notes
    -----
    Forces along the recorded motion are linear in the derivatives, so nothing is differenced.
    Rows are whitened by the noise of their record and the scatter between runs; columns have unit
    rms. A hundred bags of whole runs give the share in which each term is taken (Brunton, Proctor
    and Kutz 2016; Fasel et al. 2022); kept are those of `SHARE` and more. Their values are least
    squares on all runs, with the covariance of the regression. What the choice itself brings
    stands on top: the squared differences to the values with each set of terms that a bag took,
    weighted by exp(-½ BIC) of its fit to all runs (Buckland, Burnham and Augustin 1997).
    """
    found: list[tuple[int, Choice]] = []
    same: list[tuple[int, ChannelFit]] = []
    rng = np.random.default_rng(seed)
    said = []
    for group, channel in evidence.channels:
        base = determined(channel.base)
        same.append((group, channel.fitted(base)))
        if len(channel.blocks) < FEWEST:
            few = f"{len(channel.blocks)} runs are too few to choose from."
            said.append(f"{channel.base.channel}: {few}")
            continue
        found.append((group, chosen(channel, _tellable(channel, len(base)), chooser, rng)))
    whole = _with_choice(evidence.over_time((group, item.fit) for group, item in found), found)
    table = evidence.tabled(whole, TITLE, _columns(evidence, found))
    shares = _shares(found, len(table.Fn))
    out = np.stack([shares[name] < SHARE for name in table.names], axis=1)
    return Estimate(
        method=TITLE,
        table=table.with_(method=np.where(out, f"{TITLE}: left out", table.method)),
        shares=shares,
        same_terms=evidence.tabled(evidence.over_time(same), TITLE),
        notes=(*said, *_undecided(shares)),
    )


def _tellable(channel: OverTime, count: int) -> list[str]:
    """The terms that these runs can tell from each other: the first, and what goes with them."""
    white = np.concatenate(channel.design)
    base, more = channel.names[:count], channel.names[count:]
    further = optional_columns(white[:, :count], more, white[:, count:], limit=TELLABLE)
    return [*base, *(more[place] for place in further)]


def chosen(
    channel: OverTime, names: Sequence[str], chooser: Method | None, rng: np.random.Generator
) -> Choice:
    """Choose among the terms of a channel.

    Parameters
    ----------
    channel : OverTime
        Whitened equations.
    names : sequence of str
        Terms to choose among.
    chooser : "stlsq", "stepwise" or optimizer of pysindy, optional
        As for `by_sparse_regression`.
    rng : Generator
        Of folds and bags.
    """
    at = [channel.names.index(name) for name in names]
    systems = [
        (compressed(X[:, at], y),) for X, y in zip(channel.design, channel.rows, strict=True)
    ]
    independent = sum(len(block.rows) for block in channel.base.blocks)
    task = Task(
        channels=(channel.base.channel,),
        columns=tuple(range(len(names))),
        groups=tuple((place,) for place in range(len(names))),
        always=(False,) * len(names),
        method=Elimination(independent) if chooser is None else chooser,
    )
    folds = folds_of(len(systems), rng)
    cut = choose_threshold(task, systems, folds).chosen if task.thresholds else 0.0
    draws = rng.integers(len(systems), size=(BAGS, len(systems)))
    coefficients = bagged(task, systems, draws, cut)
    shares = shares_of(coefficients)
    stays = ~(shares < SHARE)
    taken = np.where(np.isnan(coefficients), stays, coefficients != 0)
    return Choice(
        names=tuple(names),
        shares=shares,
        fit=channel.fitted([name for name, stay in zip(names, stays, strict=True) if stay]),
        moved=_moved(joined(systems), stays, taken, np.log(max(independent, 2))),
    )


def _moved(
    whole: System, stays: NDArray[np.bool_], taken: NDArray[np.bool_], penalty: float
) -> Array:
    """How far sets of terms that fit all runs as well move the values of those that stay."""
    sets = np.unique(np.concatenate([taken, stays[None]]), axis=0)
    values = np.stack([solved(whole, own) for own in sets])
    left = [sum(np.sum((both[:, :-1] @ x - both[:, -1]) ** 2) for both, _ in whole) for x in values]
    score = np.array(left) + penalty * sets.sum(axis=1)
    weight = np.exp((score.min() - score) / 2)
    change = (values - solved(whole, stays))[:, stays]
    return np.asarray((change.T * (weight / weight.sum())) @ change)


def _with_choice(solution: Solution, found: Sequence[tuple[int, Choice]]) -> Solution:
    """A solution with the covariance that the choice of terms brings."""
    covariance = solution.joint.covariance.copy()
    start = 0
    for _, item in found:
        span = slice(start, start + len(item.moved))
        covariance[span, span] += item.moved
        start = span.stop
    return replace(solution, joint=replace(solution.joint, covariance=covariance))


def _columns(evidence: Evidence, found: Sequence[tuple[int, Choice]]) -> Columns:
    """The terms kept at any Froude number; what the regression took beside stays beside."""
    kept: dict[str, dict[str, None]] = {}
    for _, item in found:
        names = dict.fromkeys(item.fit.fit.names)
        kept[item.fit.channel] = {**kept.get(item.fit.channel, {}), **names}
    optional = evidence.columns.optional
    return Columns(
        required={c: tuple(n for n in own if n not in optional[c]) for c, own in kept.items()},
        optional={c: tuple(n for n in own if n in optional[c]) for c, own in kept.items()},
    )


def _shares(found: Sequence[tuple[int, Choice]], groups: int) -> dict[str, Array]:
    shares: dict[str, Array] = {}
    for group, item in found:
        for name, share in zip(item.names, item.shares.tolist(), strict=True):
            shares.setdefault(name, np.full(groups, np.nan))[group] = share
    return shares


def _undecided(shares: Mapping[str, Array]) -> list[str]:
    """Terms on which the bags of runs are of two minds."""
    low, high = UNDECIDED
    names = [name for name, own in shares.items() if np.any((own > low) & (own < high))]
    if not names:
        return []
    return [f"Taken in some bags of runs and not in others: {', '.join(names)}."]
