"""The model of a laboratory that has not tested yet: what all share, and by what it may differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import ModelError
from pmmkit.diagnosis.evidence import integrated_out
from pmmkit.diagnosis.free_running.base import SPREAD
from pmmkit.diagnosis.free_running.findings import model_of
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.free_running.hypotheses import WIDER, Numbers
from pmmkit.diagnosis.joint.belongs import SCATTER
from pmmkit.diagnosis.joint.captive_vote import Ballot, Beside, CaptiveVote, Names, Vote
from pmmkit.diagnosis.joint.records_vote import RecordsVote
from pmmkit.diagnosis.joint.result import BASE, Another, Belonging
from pmmkit.diagnosis.joint.scatter import FLAT, Groups, Learned, next_laboratory, scatter_of_base
from pmmkit.models import Model
from pmmkit.numerics import Array, precision_over

BETWEEN: Final = 0.025
"""Scale of the half-normal prior of what laboratories differ by in values of the base, over their
usual sizes. A choice: with it the first overshoot of KVLCC2's 10/10 zigzag differs by about 15 %
between laboratories, the tactical diameter by 8 % (docs/diagnose.md)."""
OFFSET: Final = SPREAD
"""Scale of that of what captive tests are off for a ship that sails free."""
FACTORS: Final = (1.0, 0.5, 2.0)
"""Scales that are tried, over the priors; the first is the one to use."""
NOTE: Final = (
    "Stands for a laboratory that has not tested yet: the ship's values from several campaigns, "
    "with a covariance that holds by what laboratories differ."
)


def others(
    votes: Sequence[Vote], names: Names, ballots: Mapping[str, Ballot], belongs: Sequence[Belonging]
) -> tuple[Another, ...]:
    """Models of a laboratory that has not tested yet, one for each of `FACTORS`."""
    records = [item for item in votes if isinstance(item, RecordsVote)]
    if not records:
        return ()
    first = records[0]
    faults = {item.name: ballots.get(item.name, Ballot(log_evidence=0.0)).faults for item in votes}
    mine = tuple(x for x in names if x in first.contest.zero.question.numbers.columns)
    fit = first.steady(frozenset((*mine, *faults[first.name])))
    if fit is None:
        return ()
    numbers, labels = fit.place.question.numbers, labels_of(first, mine)
    typical = [x for item in first.system.every if item.name in mine for x in item.typical.values()]
    scale = np.concatenate([numbers.base.sizes, WIDER * np.array(typical)])
    tests = [
        (item.name, item.beside(names, faults[item.name]))
        for item in votes
        if isinstance(item, CaptiveVote)
    ]
    given = tests[0] if tests else None
    learned = [_given(first, fit, given, labels, scale)]
    for name, beside in tests[1:]:
        information, score = _of_effects(beside, labels, scale)
        learned.append(Learned(laboratory=name, information=information, score=score, offset=True))
    unsure = _given(first, fit, given, labels, scale, alone=True)
    moved = []
    for item in records:
        own = item.steady(frozenset((*item.asked.intersection(mine), *faults[item.name])))
        if own is None:
            continue
        learned.append(_of_records(item, own, mine, faults[item.name], labels))
        if own.spread:
            moved.append((own.spread, _directions(learned[-1], own)))
    sizes = {item.effect: item.size for item in belongs}
    scales = SCATTER * np.array([sizes.get(name, 1.0) for name in mine])
    made = []
    for factor in FACTORS:
        between, offset = scatter_of_base(moved, factor * BETWEEN, OFFSET)
        groups = _groups(numbers, mine, between, offset, factor * scales)
        # The fit of the records, near which their linear problem holds, knew no uncertainty that a
        # value states by itself: it widens the interval, and moves no mean.
        found = next_laboratory(learned, groups)
        wide = next_laboratory([unsure, *learned[1:]], groups)
        try:
            model = _model(first, fit, mine, found.values, wide.covariance)
            ship = wide.covariance - np.diag(wide.between)
            alone = _model(first, fit, mine, found.values, ship)
        except ModelError:
            # Beyond what a value can be: there is no such ship to sail.
            return ()
        made.append(
            Another(
                model=model,
                ship=alone,
                scales=MappingProxyType(
                    {BASE: factor * BETWEEN}
                    | dict(zip(mine, (factor * scales).tolist(), strict=True))
                ),
                scatter=MappingProxyType(
                    dict(zip(groups.names, found.scatter.tolist(), strict=True))
                ),
            )
        )
    return tuple(made)


def labels_of(vote: RecordsVote, names: Names) -> tuple[tuple[str, str], ...]:
    """Effect (none of the base) and name of each value that a set moves."""
    every = {item.name: item for item in vote.system.every}
    return (
        *(("", name) for name in vote.system.base.names),
        *((name, label) for name in names for label in every[name].typical),
    )


def _groups(numbers: Numbers, names: Names, base: float, offset: float, scales: Array) -> Groups:
    counts = [numbers.width, *(len(numbers.columns[name]) for name in names)]
    return Groups(
        names=(BASE, *names),
        base=base,
        of=np.repeat(np.arange(len(counts)), counts),
        usual=np.repeat([1.0, *(1.0 / WIDER for _ in names)], counts),
        scales=scales,
        shared=np.repeat([FLAT, *(1.0 for _ in names)], counts),
        offset=np.repeat([offset, *(1.0 for _ in names)], counts),
    )


def _given(
    vote: RecordsVote,
    fit: SetFit,
    tests: tuple[str, Beside] | None,
    labels: Sequence[tuple[str, str]],
    scale: Array,
    *,
    alone: bool = False,
) -> Learned:
    """The values as the model has them, with what comes to them by effects; those of the first
    captive tests, which they are taken to be of, with what these say of effects and how the base
    moves with them; with uncertainties that values of the base state alone, or without."""
    names = tuple(dict.fromkeys(effect for effect, _ in labels if effect))
    numbers, known = fit.place.question.numbers, vote.known
    there = [i for i, name in enumerate(known.names) if name in numbers.values]
    at = [numbers.values.index(known.names[i]) for i in there]
    values = numbers.T[at][:, numbers.used(names)] / known.sizes[there, None]
    information, score = np.zeros((len(labels),) * 2), np.zeros(len(labels))
    if tests is not None:
        information, score = _of_effects(tests[1], labels, scale)
        values[: numbers.width] -= _along(tests[1], labels, scale, numbers.width)
    whole = known.covariance if alone else known.held
    covariance = whole[np.ix_(there, there)]
    return Learned(
        laboratory=tests[0] if tests is not None else vote.model.name,
        information=information + values.T @ np.linalg.solve(covariance, values),
        score=score,
        offset=True,
    )


def _of_effects(
    found: Beside, labels: Sequence[tuple[str, str]], scale: Array
) -> tuple[Array, Array]:
    """What captive tests say of effects, without what was known before them."""
    information, score = np.zeros((len(labels),) * 2), np.zeros(len(labels))
    kept = [k for k, label in enumerate(found.labels) if label in labels]
    if kept:
        at = [labels.index(found.labels[k]) for k in kept]
        size = scale[at]
        S: Array = found.covariance[np.ix_(kept, kept)]
        told = precision_over(S, size)
        score[at] = told @ (found.values[kept] / size)
        information[np.ix_(at, at)] = _positive(
            told - np.diag(np.square(size / found.before[kept]))
        )
    return information, score


def _along(found: Beside, labels: Sequence[tuple[str, str]], scale: Array, b: int) -> Array:
    """By how much the base (b, n) moves in captive tests with the effects."""
    moved = np.zeros((b, len(labels)))
    for j, name in enumerate(found.base):
        for k, label in enumerate(found.labels):
            if ("", name) in labels and label in labels:
                row, column = labels.index(("", name)), labels.index(label)
                moved[row, column] = found.along[j, k] * scale[column] / scale[row]
    return moved


def _of_records(
    vote: RecordsVote, fit: SetFit, names: Names, faults: Names, labels: Sequence[tuple[str, str]]
) -> Learned:
    """What records say of the base and the effects, their faults taken out."""
    mine = tuple(x for x in names if x in fit.names)
    numbers, known = fit.place.question.numbers, fit.known.normal
    own = labels_of(vote, mine)
    rest = known.given(known.taken(numbers.at(faults))).only(numbers.used(mine))
    at = [labels.index(label) for label in own]
    information, score = np.zeros((len(labels),) * 2), np.zeros(len(labels))
    information[np.ix_(at, at)], score[at] = _positive(rest.information), rest.score
    return Learned(
        laboratory=vote.name, information=information, score=score, moves=bool(fit.spread)
    )


def _directions(found: Learned, fit: SetFit) -> float:
    """Number of directions in which records move the base: Σ s²λ/(1 + s²λ)."""
    base, b = fit.place.question.numbers.base, fit.place.question.numbers.width
    G = found.information
    own, _ = integrated_out(G[b:, b:], G[b:, :b], G[:b, :b])
    whole = base.known[:b, :b] + fit.spread**2 * np.eye(b)
    return float(fit.spread**2 * np.trace(np.linalg.solve(np.eye(b) + own @ whole, own)))


def _positive(matrix: Array) -> Array:
    """A symmetric matrix without what is below zero by rounding."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    found: Array = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return found


def _model(vote: RecordsVote, fit: SetFit, names: Names, values: Array, covariance: Array) -> Model:
    """The ship of the records with the values of another laboratory and their covariance."""
    numbers = fit.place.question.numbers
    used = numbers.used(names)
    z = np.zeros_like(fit.z)
    z[used] = values
    whole = np.zeros_like(fit.covariance)
    whole[np.ix_(used, used)] = covariance
    own = replace(fit, names=names, z=z, covariance=whole)
    made = model_of(vote.model, vote.system.every, own, vote.system.speed, "several campaigns")
    return replace(made, name=f"{made.name}, another laboratory", notes=(*made.notes, NOTE))
