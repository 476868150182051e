"""Runs that disagree with the others: a kind of test, a speed, a side, a part of the day.

Such a group (`Disagreement`) is a rival as thin as an entry of the catalogue. Truths that no entry
holds differ in just this: their means in one kind of test do not go with those of another.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.build import predicted_rows
from pmmkit.diagnosis.captive.evidence import columns_at, spread
from pmmkit.diagnosis.captive.system import CandidateColumns, System, offset_column
from pmmkit.diagnosis.captive.whitening import Piece, Places
from pmmkit.intake import Disagreement


def disagreements(
    system: System, given: Sequence[CandidateColumns], answer: Sequence[CandidateColumns]
) -> list[Disagreement]:
    """Groups of runs with the evidence that they disagree, beside an answer and in its place."""
    views = {view.run.id: view for view in system.views}.values()
    groups = Run.groups([view.run for view in views], [view.day for view in views])
    if not groups:
        return []
    system, blocks = spread(system, [*given, *answer])
    places = [block.places for block in blocks]
    known, whole = (
        np.concatenate([np.zeros(0, np.intp), *some]) for some in (places[: len(given)], places)
    )
    price = Disagreement.price(len(groups), len(system.pieces))
    return [
        item
        for piece in system.pieces
        for item in _of_channel(system, piece, groups, (known, whole), price)
    ]


def telling(
    system: System,
    given: Sequence[CandidateColumns],
    answer: Sequence[CandidateColumns],
    log_evidence: float,
) -> tuple[Disagreement, ...]:
    """The group that disagrees most beside an answer, and the one that explains as much in its
    place, where there are such."""
    return Disagreement.telling(disagreements(system, given, answer), log_evidence)


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
    ids = np.empty(len(channel.y), object)
    for i, rows in zip(channel.views, channel.rows, strict=True):
        columns[rows, 2] *= drift[i] / steepest
        ids[rows] = views[i].run.id
    known = (
        (columns_at(piece, sets[0]), system.normal.only(sets[0])),
        (columns_at(piece, sets[1]), system.normal.only(sets[1])),
    )
    yield from Disagreement.among(
        channel.name,
        groups,
        ids,
        columns,
        piece.data,
        price=price,
        left=piece.projection.left,
        beside=known,
    )
