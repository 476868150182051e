"""Runs that disagree with the others: a kind of test, a speed, a side, a part of the day.

In the runs S of a group a channel reads F (1 + g) + a + b β in place of F: a gain, an offset and a
slope in the drift angle, each 0 ± s of the channel's force, s averaged over `Run.OTHERWISE`. Such a
group is a rival as thin as an entry of the catalogue. Truths that no entry holds differ in just
this: their means in one kind of test do not go with those of another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.build import predicted_rows
from pmmkit.diagnosis.captive.evidence import columns_at, spread
from pmmkit.diagnosis.captive.system import CandidateColumns, System, offset_column
from pmmkit.diagnosis.captive.whitening import Piece, Places
from pmmkit.diagnosis.evidence import RIVALS
from pmmkit.diagnosis.findings import Disagreement


def disagreements(
    system: System, given: Sequence[CandidateColumns], answer: Sequence[CandidateColumns]
) -> list[Disagreement]:
    """Groups of runs by the evidence that they disagree beside an answer, the best first."""
    views = {view.run.id: view for view in system.views}.values()
    groups = Run.groups([view.run for view in views], [view.day for view in views])
    if not groups:
        return []
    system, blocks = spread(system, [*given, *answer])
    places = [block.places for block in blocks]
    known, whole = (
        np.concatenate([np.zeros(0, np.intp), *some]) for some in (places[: len(given)], places)
    )
    price = math.log(2.0 * len(groups) * len(system.pieces))
    found = [
        item
        for piece in system.pieces
        for item in _of_channel(system, piece, groups, (known, whole), price)
    ]
    return sorted(found, key=lambda item: -item.log_odds)


def telling(
    system: System,
    given: Sequence[CandidateColumns],
    answer: Sequence[CandidateColumns],
    log_evidence: float,
) -> tuple[Disagreement, ...]:
    """The group that disagrees most beside an answer, and the one that explains as much in its
    place, where there are such."""
    every = disagreements(system, given, answer)
    told = [item for item in every[:1] if item.log_odds > RIVALS]
    most = max(every, key=lambda item: item.instead, default=None)
    if most is not None and most not in told and most.instead > log_evidence - RIVALS:
        told.append(replace(most, rival=True))
    return tuple(told)


def _of_channel(
    system: System,
    piece: Piece,
    groups: Mapping[str, frozenset[str]],
    sets: tuple[Places, Places],
    price: float,
) -> Iterator[Disagreement]:
    """The groups of one channel that have a force in it, beside what is given and beside all."""
    channel, views = piece.projection.channel, system.views
    drift = np.array([view.run.settings.drift for view in views])
    steepest = float(np.max(np.abs(drift))) or 1.0
    offset = offset_column(channel, views, system.base)
    columns = np.column_stack([predicted_rows(channel, views, system.base), offset, offset])
    inside = {words: np.zeros(len(channel.y)) for words in groups}
    for i, rows in zip(channel.views, channel.rows, strict=True):
        columns[rows, 2] *= drift[i] / steepest
        for words, ids in groups.items():
            inside[words][rows] = views[i].run.id in ids
    there = [words for words, rows in inside.items() if np.any(rows) and not np.all(rows)]
    if not there:
        return
    left = piece.projection.left(np.column_stack([columns * inside[x][:, None] for x in there]))
    known = [(columns_at(piece, at), system.normal.only(at)) for at in sets]
    for words, own in zip(there, np.split(left, len(there), axis=1), strict=True):
        inner, score = own.T @ own, own.T @ piece.data
        (instead, _), (log_odds, mean) = (
            normal.added(inner, score, beside.T @ own, Run.OTHERWISE) for beside, normal in known
        )
        yield Disagreement(
            channel=channel.name,
            group=words,
            runs=tuple(sorted(groups[words])),
            gain=float(mean[0]),
            offset=float(mean[1]),
            log_odds=log_odds - price,
            instead=instead - price,
        )
