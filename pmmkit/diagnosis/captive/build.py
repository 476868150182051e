"""From runs, a base and candidates to the system that is asked for evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.system import (
    FEATURES,
    MANY,
    WIDER,
    CandidateColumns,
    System,
    candidate_columns,
    channels_of,
    each_run_columns,
    floor_features,
    offset_column,
    run_columns,
    term_columns,
)
from pmmkit.diagnosis.captive.whitening import (
    Channel,
    OwnColumns,
    Piece,
    Places,
    Projection,
    RunEffectColumns,
    alike,
    noise_whitened,
    whitened,
)
from pmmkit.inference import RANK_TOLERANCE, Normal, Restricted, RunEffects
from pmmkit.numerics import Array
from pmmkit.reduction import FLOOR, View

ROUGH: Final = np.array([0.004, 0.0, 0.0, 0.0])
"""Run scatter for the first fit of the base: an offset."""
HARMONICS: Final = RunEffects.KINDS.index("harmonics")
ENOUGH: Final = 240
"""Runs that tell the sizes of their scatter to 5 %; of more, so many are looked at."""
Drawings = tuple[Candidate, float, tuple[OwnColumns, ...]]
"""A candidate that each run draws, at one grid point: its columns by channel."""


def build(
    views: Sequence[View],
    base: CaptiveBase,
    candidates: Sequence[Candidate],
    *,
    floor: float = FLOOR,
    scatter: Mapping[str, Array] | None = None,
    like: System | None = None,
) -> System:
    """The system of a campaign, about its base and what stands beside that.

    scatter (4,). `like`: a system of the same runs and derivatives, of which all stays that hangs
    on the motion alone: what faults change hangs on the base.
    """
    channels = like.channels if like else channels_of(views, base)
    if base.stands_alone:
        base = fitted(base, channels, views)
    views = base.expecting(views)
    predicted = {c.name: predicted_rows(c, views, base) for c in channels}
    for_all = [item for item in candidates if not item.each_run]
    for_each = [item for item in candidates if item.each_run]
    raw = _raw(for_all, channels, views, base, _of_the_motion(like) if like else {})
    own = run_columns(channels, views, base, predicted)
    features = like.features if like else tuple(floor_features(c, views, base) for c in channels)
    floors = {c.name: floor * x for c, x in zip(channels, features, strict=True)}
    if scatter is None:
        models = {c.name: _largest(c, raw) for c in channels}
        scatter = estimated_scatter(channels, views, own, models, floors)
    drawn: list[Drawings] = [
        (
            item,
            value,
            tuple(
                each_run_columns(item, value, c, views, base, predicted[c.name]).times(
                    prior_sizes(item).item()
                )
                for c in channels
            ),
        )
        for item in for_each
        for value in item.grid
    ]
    few = [item for item in drawn if _count(item) <= MANY]
    blocks, of_runs, begin = _placed(raw, few, len(channels))
    width = begin + FEATURES * len(channels)
    gram, score = np.zeros((width, width)), np.zeros(width)
    square, rows = 0.0, 0
    pieces: list[Piece] = []
    for number, c in enumerate(channels):
        acting = [
            (block, item.made[c.name])
            for block, item in zip(blocks, raw, strict=False)
            if item.made and c.name in item.made
        ]
        at = np.concatenate(
            [
                *(block.places for block, _ in acting),
                *of_runs[number],
                begin + FEATURES * number + np.arange(FEATURES),
            ]
        )
        columns = np.column_stack(
            [made for _, made in acting]
            + [by_channel[number].dense() for _, _, by_channel in few]
            + [floors[c.name]]
        )
        projection = _projection(c, floors[c.name], own[c.name], scatter[c.name])
        left = projection.left(np.column_stack([columns, c.y]))
        piece = Piece(projection=projection, columns=left[:, :-1], places=at, data=left[:, -1])
        pieces.append(piece)
        gram[np.ix_(at, at)] += piece.columns.T @ piece.columns
        score[at] += piece.columns.T @ piece.data
        square += float(piece.data @ piece.data)
        rows += projection.freedom
    beside = [
        CandidateColumns(
            candidate=candidate,
            value=value,
            columns=slice(0, 0),
            drawn=RunEffectColumns.of(
                [own.whitened(piece.projection) for own, piece in zip(each, pieces, strict=True)],
                pieces,
                width,
            ),
        )
        for candidate, value, each in drawn
        if _count((candidate, value, each)) > MANY
    ]
    prior, centre = np.ones(width), np.zeros(width)
    for block in blocks[: len(raw)]:
        prior[block.columns] = prior_sizes(block.candidate)
        if block.candidate.centre:
            centre[block.columns] = np.array(block.candidate.centre) / prior[block.columns]
    return System(
        views=tuple(views),
        base=base,
        channels=channels,
        scatter=scatter,
        blocks=(*blocks, *beside),
        normal=Normal(information=gram, score=score, centre=centre, square=square),
        rows=rows,
        floor=floor,
        floor_columns=slice(begin, width),
        prior=prior,
        pieces=tuple(_without_floor(piece) for piece in pieces),
        features=features,
    )


def _without_floor(piece: Piece) -> Piece:
    """A piece without the floor's columns, the last, of which the products are enough."""
    return replace(
        piece,
        columns=piece.columns[:, :-FEATURES].copy(),
        places=piece.places[:-FEATURES],
        data=piece.data.copy(),
    )


def estimated_scatter(
    channels: Sequence[Channel],
    views: Sequence[View],
    own: Mapping[str, Array],
    models: Mapping[str, Array],
    floors: Mapping[str, Array],
) -> dict[str, Array]:
    """The most probable sizes of what runs draw for themselves, by channel (4,).

    own (n, 3 + k); models (n, p); floors (n, D).

    Notes
    -----
    What acts in single harmonics may be physics that no candidate holds, and looks like their
    scatter: of that repeated runs alone are asked.
    """
    groups = Run.repeats(tuple({view.run.id: view.run for view in views}.values()))
    repeated = {c.name: _repeatability(c, views, own[c.name], groups) for c in channels}
    known = RunEffects.most_probable(repeated)
    likelihoods = {}
    for c in channels:
        model, floor, drawn = models[c.name], floors[c.name], own[c.name]
        white = noise_whitened(c, np.column_stack([model, floor, c.y, drawn]))
        whole = model.shape[1] + floor.shape[1] + 1
        every = math.ceil(len(c.runs) / ENOUGH)
        taken = [
            (white[rows][..., :whole], white[rows][..., whole:])
            for rows in (rows[::every] for rows in alike(c))
        ]
        likelihoods[c.name] = [
            RunEffects.likelihood(taken, model.shape[1], floor.shape[1]).given(
                HARMONICS, known[c.name][-1]
            )
        ]
    mode = RunEffects.most_probable(likelihoods)
    return {name: np.append(sizes[:-1], known[name][-1]) for name, sizes in mode.items()}


def _repeatability(
    c: Channel, views: Sequence[View], own: Array, groups: Sequence[Sequence[Run]]
) -> list[Restricted]:
    """What repeated runs say of one channel."""
    place = {
        name: number for number, name in enumerate(dict.fromkeys(views[i].run.id for i in c.views))
    }
    conditions: dict[tuple[str, int], list[int]] = {}
    for group in groups:
        for number in (place[run.id] for run in group if run.id in place):
            conditions.setdefault((group[0].id, len(c.runs[number])), []).append(number)
    likelihood = RunEffects.repeatability(
        (
            np.stack([c.y[c.runs[i]] for i in numbers]),
            np.mean([own[c.runs[i]] for i in numbers], axis=0),
            np.mean([c.noise[i] for i in numbers], axis=0),
        )
        for numbers in conditions.values()
    )
    return [] if likelihood is None else [likelihood]


def fitted(base: CaptiveBase, channels: Sequence[Channel], views: Sequence[View]) -> CaptiveBase:
    """The base with values by weighted least squares, run scatter at usual sizes."""
    values: dict[str, float] = dict(base.values)
    for c in channels:
        drawn = np.zeros((len(c.y), len(ROUGH)))
        drawn[:, 0] = offset_column(c, views, base)
        white = whitened(c, np.column_stack([c.design, c.y]), drawn, ROUGH)
        size = np.linalg.norm(white[:, :-1], axis=0)
        size = np.where(size > 0, size, 1.0)
        solution = (
            np.linalg.lstsq(white[:, :-1] / size, white[:, -1], rcond=RANK_TOLERANCE)[0] / size
        )
        values |= dict(zip(base.names[c.name], solution.tolist(), strict=True))
    return replace(base, values=values)


def predicted_rows(c: Channel, views: Sequence[View], base: CaptiveBase) -> Array:
    """What a base, and all that acts beside it, predicts of the rows of a channel (n,)."""
    found: Array = c.design @ [base.values[name] for name in base.names[c.name]]
    if not base.stands_alone:
        for i, rows in zip(c.views, c.rows, strict=True):
            found[rows] = views[i].pick(views[i].expected[c.name])
    return found


def prior_sizes(candidate: Candidate) -> Array:
    """Prior standard deviations of the coefficients of a candidate."""
    return np.array([WIDER * abs(size) for size in candidate.typical])


Asked = tuple[str, int, float]
"""A candidate in one of its forms, at one grid point."""


def _asked(candidate: Candidate, value: float) -> Asked:
    return candidate.name, candidate.size, value


def _of_the_motion(system: System) -> dict[Asked, Mapping[str, Array]]:
    """Columns of the candidates of a system that no base changes."""
    return {
        _asked(x.candidate, x.value): x.made
        for x in system.blocks
        if x.candidate.kind == "physics" and x.made is not None
    }


def _raw(
    candidates: Sequence[Candidate],
    channels: Sequence[Channel],
    views: Sequence[View],
    base: CaptiveBase,
    known: Mapping[Asked, Mapping[str, Array]],
) -> list[CandidateColumns]:
    """All candidates in all their forms at their grid points, with their columns; some are
    known."""
    asked = [(form, value) for item in candidates for form in item.forms for value in item.grid]
    terms = [item for item, value in asked if item.terms and _asked(item, value) not in known]
    of_terms = iter(term_columns(terms, channels, views, base))
    blocks = []
    for item, value in asked:
        made = known.get(_asked(item, value))
        if made is None:
            found = (
                next(of_terms)
                if item.terms
                else candidate_columns(item, value, channels, views, base)
            )
            made = {name: x * prior_sizes(item) for name, x in found.items()}
        blocks.append(CandidateColumns(candidate=item, value=value, columns=slice(0, 0), made=made))
    return blocks


def _count(drawings: Drawings) -> int:
    """Number of columns in all channels."""
    return sum(own.count for own in drawings[-1])


def _largest(channel: Channel, raw: Sequence[CandidateColumns]) -> Array:
    """The base with every candidate once."""
    once: dict[str, Array] = {}
    for block in raw:
        if block.made and channel.name in block.made:
            once.setdefault(block.candidate.name, block.made[channel.name])
    return np.concatenate([channel.design, *once.values()], axis=1)


def _placed(
    raw: Sequence[CandidateColumns], drawn: Sequence[Drawings], channels: int
) -> tuple[list[CandidateColumns], list[list[Places]], int]:
    """Where columns stand: those of candidates, one for all channels, then what each run draws, by
    channel and draw; and how many they are."""
    blocks, at = [], 0
    for item in raw:
        end = at + item.candidate.size
        blocks.append(replace(item, columns=slice(at, end)))
        at = end
    of_runs: list[list[Places]] = [[] for _ in range(channels)]
    for candidate, value, by_channel in drawn:
        begin = at
        for own, places in zip(by_channel, of_runs, strict=True):
            places.append(np.arange(at, at + own.count))
            at += own.count
        if at > begin:
            blocks.append(
                CandidateColumns(candidate=candidate, value=value, columns=slice(begin, at))
            )
    return blocks, of_runs, at


def _projection(c: Channel, floor: Array, own: Array, scatter: Array) -> Projection:
    """Whitening of a channel, and what the base and the smooth floor span in it.

    The floor stands as columns with a unit prior, rows of their own below the data; what is left
    after a projection has the products of the inverse covariance of noise, scatter and floor.
    """
    p, q = c.design.shape[1], floor.shape[1]
    white = whitened(c, np.column_stack([c.design, floor]), own, scatter)
    size = np.linalg.norm(white[:, :p], axis=0)
    design = white[:, :p] / np.where(size > 0, size, 1.0)
    below = np.zeros((q, p + q))
    below[:, p:] = np.eye(q)
    Q, R, _ = _pivoted(np.vstack([np.column_stack([design, white[:, p:]]), below]))
    rank = int(np.sum(np.abs(np.diagonal(R)) > RANK_TOLERANCE * abs(R[0, 0])))
    return Projection(
        channel=c,
        own=own,
        scatter=scatter,
        floor=white[:, p:],
        span=Q[:, :rank],
        freedom=len(white) - (rank - q),
    )


def _pivoted(matrix: Array) -> tuple[Array, Array, Places]:
    from scipy.linalg import qr

    decomposed: tuple[Array, Array, Places] = qr(
        matrix, mode="economic", pivoting=True, check_finite=False
    )
    return decomposed
