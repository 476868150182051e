"""Runs that disagree with the others: a kind of test, a speed, a side, a part of the day.

In the runs S of a group a channel reads F (1 + g) + a + b β in place of F: a gain, an offset and a
slope in the drift angle, each 0 ± s of the channel's force, s averaged over `SIZES`. A group is
a rival as thin as an entry of the catalogue. Truths that no entry holds differ in just this: their
means in one kind of test do not go with those of another.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.build import predicted_rows
from pmmkit.diagnosis.captive.evidence import columns_at, spread
from pmmkit.diagnosis.captive.system import CandidateColumns, System, offset_column
from pmmkit.diagnosis.captive.whitening import Piece, Places
from pmmkit.diagnosis.evidence import RIVALS
from pmmkit.diagnosis.findings import Disagreement
from pmmkit.inference import Normal
from pmmkit.numerics import Array
from pmmkit.reduction import View

SIZES: Final = (0.005, 0.01, 0.02, 0.04, 0.08)
"""Sizes of what a group may read otherwise, over the rms force of its channel."""
FEWEST: Final = 2
"""Runs that a group has at least, and that stand beside it."""
PARTS: Final = (1.0 / 3.0, 0.5, 2.0 / 3.0)
"""Where the day may change."""


def disagreements(
    system: System, given: Sequence[CandidateColumns], answer: Sequence[CandidateColumns]
) -> list[Disagreement]:
    """Groups of runs by the evidence that they disagree beside an answer, the best first."""
    groups = groups_of(system.views)
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


Levels = Mapping[str, frozenset[str]]
"""Runs by the level of a factor in words."""


def levels_of(views: Sequence[View]) -> dict[str, Levels]:
    """Kinds of test, speeds, sides and frequencies of some runs."""
    of_run = {view.run.id: view for view in views}
    sides = {1.0: "at positive drift", -1.0: "at negative drift"}

    def by(words: Callable[[View], str], order: Callable[[View], float]) -> Levels:
        levels: dict[str, list[str]] = {}
        for name, view in sorted(of_run.items(), key=lambda item: order(item[1])):
            levels.setdefault(words(view), []).append(name)
        return {level: frozenset(own) for level, own in levels.items() if level}

    return {
        "kind of test": by(lambda view: f"in {view.run.kind_of_test.title}", lambda _: 0.0),
        "speed": by(lambda view: f"at {round(view.speed, 6):g} m/s", lambda view: view.speed),
        "side": by(
            lambda view: sides.get(float(np.sign(view.run.settings.drift)), ""), lambda _: 0.0
        ),
        "frequency": by(
            lambda view: f"at {view.omega:.3g} rad/s" if view.omega else "", lambda view: view.omega
        ),
    }


def groups_of(views: Sequence[View]) -> dict[str, frozenset[str]]:
    """Groups of runs that may have been tested otherwise than the rest, in words."""
    of_run = {view.run.id: view for view in views}
    levels = levels_of(views)
    steady = frozenset(name for name, view in of_run.items() if not view.run.dynamic)
    asked = {**levels["kind of test"], "in steady runs": steady}
    asked |= {**levels["speed"], **levels["side"]}
    day = sorted(of_run, key=lambda name: of_run[name].day)
    for part in PARTS:
        later = day[int(part * len(day)) :]
        asked[f"from {later[0]} on"] = frozenset(later)
    for kind, own in levels["kind of test"].items():
        later = [name for name in day if name in own][len(own) // 2 :]
        asked[f"{kind} from {later[0]} on"] = frozenset(later)
    groups: dict[frozenset[str], str] = {}
    for words, ids in asked.items():
        if FEWEST <= len(ids) <= len(of_run) - FEWEST:
            groups.setdefault(ids, words)
    return {words: ids for ids, words in groups.items()}


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
        (instead, _), (log_odds, mean) = (_added(*one, own, piece.data) for one in known)
        yield Disagreement(
            channel=channel.name,
            group=words,
            runs=tuple(sorted(groups[words])),
            gain=float(mean[0]),
            offset=float(mean[1]),
            log_odds=log_odds - price,
            instead=instead - price,
        )


def _added(columns: Array, known: Normal, own: Array, data: Array) -> tuple[float, Array]:
    """ln evidence that columns of a group add to what is known, averaged over `SIZES`, and their
    values at the most probable size."""
    inner, score, cross = own.T @ own, own.T @ data, columns.T @ own
    tried = []
    for size in SIZES:
        both = replace(
            known,
            information=np.block(
                [[known.information, size * cross], [size * cross.T, size**2 * inner]]
            ),
            score=np.concatenate([known.score, size * score]),
            centre=np.concatenate([known.centre, np.zeros(len(score))]),
        )
        tried.append((float(both.log_evidence - known.log_evidence), size, both))
    _, size, best = max(tried, key=lambda item: item[0])
    total = float(np.logaddexp.reduce([value for value, _, _ in tried]))
    return total - math.log(len(SIZES)), size * best.posterior[0][-len(score) :]
