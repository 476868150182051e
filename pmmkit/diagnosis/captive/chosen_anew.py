"""Predictions of left-out conditions by the set that the other conditions would have chosen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.adequacy import blocks_of
from pmmkit.diagnosis.captive.evidence import wide
from pmmkit.diagnosis.captive.held_out import HeldOut, condition, held_out
from pmmkit.diagnosis.captive.leave_one_out import columns_at, taken_with
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.diagnosis.evidence import RankedSet
from pmmkit.inference import Normal
from pmmkit.numerics import Array

MOST: Final = 12
"""Sets that stand for election beside the best."""
HELD: Final = 2**17
"""Numbers of products that are weighed at once."""


def chosen_anew(
    system: System,
    entries: Sequence[RankedSet],
    best: RankedSet,
    predicted: HeldOut,
    given: Sequence[CandidateColumns] = (),
) -> HeldOut:
    """Held-out errors with the effects chosen anew for each condition, from all others."""
    blocks = blocks_of(system, best)
    if any(wide(block) for block in (*blocks, *given)):
        return predicted
    loss_of_best = _losses(system, [blocks], given)[0]
    least = best.log_evidence + min(loss_of_best.values(), default=0.0)
    rivals = [
        item
        for item in entries
        if item is not best
        and item.log_evidence > least
        and not any(wide(block) for block in blocks_of(system, item))
    ][:MOST]
    losses = [loss_of_best, *_losses(system, [blocks_of(system, item) for item in rivals], given)]
    elected: dict[int, list[int]] = {}
    for number, name in enumerate(predicted.conditions):
        left = [
            item.log_evidence + loss.get(name, 0.0)
            for item, loss in zip((best, *rivals), losses, strict=True)
        ]
        elected.setdefault(int(np.argmax(left)), []).append(number)
    for winner, rows in elected.items():
        if winner:
            other = held_out(system, [*given, *blocks_of(system, rivals[winner - 1])])
            predicted = predicted.with_rows_of(other, rows)
    return predicted


def _losses(
    system: System, sets: Sequence[Sequence[CandidateColumns]], given: Sequence[CandidateColumns]
) -> list[Mapping[str, float]]:
    """Change of the ln evidence of each set, beside what is given, without each condition."""
    if not sets:
        return []
    every = {id(block): block for own in sets for block in (*own, *given)}
    at = np.concatenate([block.places for block in every.values()])
    place = {column: k for k, column in enumerate(at.tolist())}
    where = [
        np.array([place[x] for block in (*own, *given) for x in block.places.tolist()])
        for own in sets
    ]
    beside = np.array([place[x] for block in given for x in block.places.tolist()], np.intp)
    columns = [np.column_stack([columns_at(p, at), p.data]) for p in system.pieces]
    whole = system.normal.only(at)
    taken = taken_with(system, columns, condition)
    names = list(taken)

    def loss(cut: Places) -> Array:
        if not len(cut):
            return np.zeros(len(names))
        known = whole.only(cut)
        left, few = [], max(1, HELD // len(cut) ** 2)
        for begin in range(0, len(names), few):
            own = np.stack([taken[name] for name in names[begin : begin + few]])
            left.append((known - Normal.of_products(own).only(cut)).log_evidences)
        return np.concatenate(left) - known.log_evidence

    before = loss(beside)
    return [dict(zip(names, (loss(cut) - before).tolist(), strict=True)) for cut in where]
