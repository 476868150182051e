"""Terms chosen among a library by sparse regression on the histories, in bags of runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.inference import EffectiveSample, Equations, Resampling, Selection, SparseProblem
from pmmkit.numerics import Array
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.estimate import ChannelFit, optional_columns
from pmmkit.reduction.methods.method import Estimate, MethodInputs, OverTime, determined
from pmmkit.reduction.solve import Solution

TITLE: Final = "sparse regression"
TELLABLE: Final = 1e4
"""Variance inflation up to which a further term can be told from the others at all."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChosenTerms:
    """Terms chosen in one channel.

    `names`: terms that were looked for. `selection`: their shares of the bags, and which stay.
    `fit`: least squares with those that stay. `moved (s, s)`: covariance that the choice itself
    brings, of the terms that stay.
    """

    names: tuple[str, ...]
    selection: Selection
    fit: ChannelFit
    moved: Array


def by_sparse_regression(evidence: MethodInputs, *, seed: int = 0) -> Estimate:
    """Derivatives of those terms of a library that the runs ask for.

    Notes
    -----
    Forces along the recorded motion are linear in the derivatives, so nothing is differenced.
    Rows are whitened by the noise of their record and the scatter between runs; columns have unit
    rms. Terms are chosen by elimination in a hundred bags of whole runs, which give the share in
    which each is taken (Brunton, Proctor and Kutz 2016; Fasel et al. 2022); kept are those of
    60 % and more (`pmmkit.inference.Selection`). Their values are least squares on all runs,
    with the covariance of the regression and, on top, of the choice itself
    (`pmmkit.inference.Selection.covariance_of_choice`).
    """
    found: list[tuple[int, ChosenTerms]] = []
    same: list[tuple[int, ChannelFit]] = []
    rng = np.random.default_rng(seed)
    said = []
    for group, channel in evidence.channels:
        base = determined(channel.base)
        same.append((group, channel.fitted(base)))
        if len(channel.blocks) < Resampling.FEWEST:
            few = f"{len(channel.blocks)} runs are too few to choose from."
            said.append(f"{channel.base.channel}: {few}")
            continue
        found.append((group, chosen(channel, _tellable(channel, len(base)), rng)))
    whole = _with_choice(evidence.over_time((group, item.fit) for group, item in found), found)
    table = evidence.tabled(whole, TITLE, _columns(evidence, found))
    shares = _shares(found, len(table.Fn))
    out = np.stack([shares[name] < Selection.SHARE for name in table.names], axis=1)
    return Estimate(
        method=TITLE,
        table=table.with_(method=np.where(out, f"{TITLE}: left out", table.method)),
        shares=shares,
        same_terms=evidence.tabled(evidence.over_time(same), TITLE),
        notes=(*said, *_undecided(found)),
    )


def _tellable(channel: OverTime, count: int) -> list[str]:
    """The terms that these runs can tell from each other: the first, and what goes with them."""
    white = np.concatenate(channel.design)
    base, more = channel.names[:count], channel.names[count:]
    further = optional_columns(white[:, :count], more, white[:, count:], limit=TELLABLE)
    return [*base, *(more[place] for place in further)]


def chosen(channel: OverTime, names: Sequence[str], rng: np.random.Generator) -> ChosenTerms:
    """Choose among the terms of a channel."""
    at = [channel.names.index(name) for name in names]
    runs = [Equations.of((X[:, at], y)) for X, y in zip(channel.design, channel.rows, strict=True)]
    independent = sum(len(block.rows) for block in channel.base.blocks)
    sample = EffectiveSample(size=independent, variance=np.ones(1))
    selection = Selection.of(
        SparseProblem.single(channel.base.channel, len(names), "elimination"),
        runs,
        Resampling.of(len(runs), Resampling.BAGS, rng),
        sample=sample,
    )
    kept = [name for name, stay in zip(names, selection.stays, strict=True) if stay]
    return ChosenTerms(
        names=tuple(names),
        selection=selection,
        fit=channel.fitted(kept),
        moved=selection.covariance_of_choice(runs, sample),
    )


def _with_choice(solution: Solution, found: Sequence[tuple[int, ChosenTerms]]) -> Solution:
    """A solution with the covariance that the choice of terms brings."""
    covariance = solution.joint.covariance.copy()
    start = 0
    for _, item in found:
        span = slice(start, start + len(item.moved))
        covariance[span, span] += item.moved
        start = span.stop
    return replace(solution, joint=replace(solution.joint, covariance=covariance))


def _columns(evidence: MethodInputs, found: Sequence[tuple[int, ChosenTerms]]) -> DerivativeNames:
    """The terms kept at any Froude number; what the regression took beside stays beside."""
    kept: dict[str, dict[str, None]] = {}
    for _, item in found:
        names = dict.fromkeys(item.fit.fit.names)
        kept[item.fit.channel] = {**kept.get(item.fit.channel, {}), **names}
    optional = evidence.columns.optional
    return DerivativeNames(
        required={c: tuple(n for n in own if n not in optional[c]) for c, own in kept.items()},
        optional={c: tuple(n for n in own if n in optional[c]) for c, own in kept.items()},
    )


def _shares(found: Sequence[tuple[int, ChosenTerms]], groups: int) -> dict[str, Array]:
    shares: dict[str, Array] = {}
    for group, item in found:
        for name, share in zip(item.names, item.selection.shares.tolist(), strict=True):
            shares.setdefault(name, np.full(groups, np.nan))[group] = share
    return shares


def _undecided(found: Sequence[tuple[int, ChosenTerms]]) -> list[str]:
    """Terms on which the bags of runs are of two minds."""
    names = dict.fromkeys(name for _, item in found for name in item.names)
    open_ = {
        name
        for _, item in found
        for name, doubt in zip(item.names, item.selection.undecided, strict=True)
        if doubt
    }
    said = [name for name in names if name in open_]
    if not said:
        return []
    return [f"Taken in some bags of runs and not in others: {', '.join(said)}."]
