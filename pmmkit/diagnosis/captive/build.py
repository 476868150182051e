"""From runs, a base and candidates to the system that is asked for evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.campaigns import Run, repeats
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.drawn import OwnColumns, RunEffectColumns
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
from pmmkit.inference import (
    KINDS,
    RANK_TOLERANCE,
    Normal,
    RepeatedRuns,
    Restricted,
    by_kind,
    repeatability,
    run_effects,
)
from pmmkit.numerics import Array
from pmmkit.reduction import (
    FLOOR,
    Channel,
    Places,
    Projection,
    View,
    WhitenedChannel,
    alike,
    noise_whitened,
    whitened,
)

ROUGH: Final = np.array([0.004, 0.0, 0.0, 0.0])
"""Run scatter for the first fit of the base: an offset."""
HARMONICS: Final = KINDS.index("harmonics")
ENOUGH: Final = 240
"""Runs that tell the sizes of their scatter to 5 %; of more, so many are looked at."""


def build(
    views: Sequence[View],
    base: CaptiveBase,
    candidates: Sequence[Candidate],
    *,
    floor: float = FLOOR,
    scatter: Mapping[str, Array] | None = None,
) -> System:
    """The system of a campaign.

    scatter (4,).
    """
    channels = channels_of(views, base)
    base = fitted(base, channels, views)
    views = [replace(view, expected=base.predicted(view)) for view in views]
    predicted = {
        c.name: c.design @ [base.values[name] for name in base.names[c.name]] for c in channels
    }
    for_all = [item for item in candidates if not item.each_run]
    for_each = [item for item in candidates if item.each_run]
    raw = _raw(for_all, channels, views, base)
    own = run_columns(channels, views, base, predicted)
    features = tuple(floor_features(c, views, base) for c in channels)
    floors = {c.name: floor * x for c, x in zip(channels, features, strict=True)}
    if scatter is None:
        models = {c.name: _largest(c, raw) for c in channels}
        scatter = estimated_scatter(channels, views, base, own, models, floors)
    drawn = [
        _EachRun(
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
    few = [item for item in drawn if item.count <= MANY]
    layout = _layout(raw, few, len(channels))
    gram, score = np.zeros((layout.width, layout.width)), np.zeros(layout.width)
    square, rows = 0.0, 0
    pieces: list[WhitenedChannel] = []
    for number, c in enumerate(channels):
        at = layout.of_channel(number, c.name, raw)
        columns = np.column_stack(
            [
                item.columns[c.name] * prior_sizes(item.candidate)
                for item in raw
                if c.name in item.columns
            ]
            + [item.own[number].dense() for item in few]
            + [floors[c.name]]
        )
        projection = _projection(c, floors[c.name], own[c.name], scatter[c.name])
        left = projection.left(np.column_stack([columns, c.y]))
        piece = WhitenedChannel(
            projection=projection, columns=left[:, :-1], places=at, data=left[:, -1]
        )
        pieces.append(piece)
        gram[np.ix_(at, at)] += piece.columns.T @ piece.columns
        score[at] += piece.columns.T @ piece.data
        square += float(piece.data @ piece.data)
        rows += projection.freedom
    beside = [
        CandidateColumns(
            candidate=item.candidate,
            value=item.value,
            columns=slice(0, 0),
            drawn=RunEffectColumns.of(
                [x.whitened(piece.projection) for x, piece in zip(item.own, pieces, strict=True)],
                pieces,
                layout.width,
            ),
        )
        for item in drawn
        if item.count > MANY
    ]
    prior, centre = np.ones(layout.width), np.zeros(layout.width)
    for block in layout.blocks[: len(raw)]:
        prior[block.columns] = prior_sizes(block.candidate)
        if block.candidate.centre:
            centre[block.columns] = np.array(block.candidate.centre) / prior[block.columns]
    return System(
        views=tuple(views),
        base=base,
        channels=channels,
        scatter=scatter,
        blocks=(*layout.blocks, *beside),
        normal=Normal(information=gram, score=score, centre=centre, square=square),
        rows=rows,
        floor=floor,
        floor_columns=layout.floor,
        prior=prior,
        pieces=tuple(pieces),
        features=features,
    )


def estimated_scatter(
    channels: Sequence[Channel],
    views: Sequence[View],
    base: CaptiveBase,
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
    scale = {c.name: c.scale * base.reference**2 for c in channels}
    groups = repeats(tuple({view.run.id: view.run for view in views}.values()))
    repeated = {c.name: _repeatability(c, views, own[c.name], groups) for c in channels}
    known = run_effects(repeated, scale).mode
    likelihoods = {}
    for c in channels:
        model, floor, drawn = models[c.name], floors[c.name], own[c.name]
        white = noise_whitened(c, np.column_stack([model, floor, c.y, drawn]))
        whole = model.shape[1] + floor.shape[1] + 1
        every = math.ceil(len(c.runs) / ENOUGH)
        taken = [
            (white[rows][..., :whole], by_kind(white[rows][..., whole:]))
            for rows in (rows[::every] for rows in alike(c))
        ]
        likelihoods[c.name] = [
            Restricted.of(taken, model.shape[1], floor.shape[1]).given(HARMONICS, known[c.name][-1])
        ]
    mode = run_effects(likelihoods, scale).mode
    return {name: np.append(sizes[:-1], known[name][-1]) for name, sizes in mode.items()}


def _repeatability(
    c: Channel, views: Sequence[View], own: Array, groups: Sequence[Sequence[Run]]
) -> list[Restricted]:
    """What repeated runs say of one channel."""
    place = {name: number for number, name in enumerate(dict.fromkeys(_runs(c, views)))}
    conditions: dict[tuple[str, int], list[int]] = {}
    for group in groups:
        for number in (place[run.id] for run in group if run.id in place):
            conditions.setdefault((group[0].id, len(c.runs[number])), []).append(number)
    found = repeatability(
        [
            RepeatedRuns(
                rows=np.stack([c.y[c.runs[i]] for i in numbers]),
                drawn=np.mean([own[c.runs[i]] for i in numbers], axis=0),
                noise=np.mean([c.noise[i] for i in numbers], axis=0),
            )
            for numbers in conditions.values()
        ]
    )
    return [] if found is None else [found]


def _runs(c: Channel, views: Sequence[View]) -> list[str]:
    """The run of each view of a channel."""
    return [views[i].run.id for i in c.views]


def fitted(base: CaptiveBase, channels: Sequence[Channel], views: Sequence[View]) -> CaptiveBase:
    """The base with values by weighted least squares, run scatter at usual sizes."""
    values: dict[str, float] = dict(base.values)
    for c in channels:
        own = np.zeros((len(c.y), len(ROUGH)))
        own[:, 0] = offset_column(c, views, base)
        white = whitened(c, np.column_stack([c.design, c.y]), own, ROUGH)
        size = np.linalg.norm(white[:, :-1], axis=0)
        size = np.where(size > 0, size, 1.0)
        found = np.linalg.lstsq(white[:, :-1] / size, white[:, -1], rcond=RANK_TOLERANCE)[0] / size
        values |= dict(zip(base.names[c.name], found.tolist(), strict=True))
    return replace(base, values=values)


def prior_sizes(candidate: Candidate) -> Array:
    """Prior standard deviations of the coefficients of a candidate."""
    return np.array([WIDER * abs(size) for size in candidate.typical])


@dataclass(frozen=True)
class _Raw:
    """One candidate at one grid point: its columns by channel, as they are."""

    candidate: Candidate
    value: float
    columns: Mapping[str, Array]


@dataclass(frozen=True)
class _EachRun:
    """One candidate that each run draws, at one grid point: its columns by channel."""

    candidate: Candidate
    value: float
    own: tuple[OwnColumns, ...]

    @property
    def count(self) -> int:
        return sum(item.count for item in self.own)


def _raw(
    candidates: Sequence[Candidate],
    channels: Sequence[Channel],
    views: Sequence[View],
    base: CaptiveBase,
) -> list[_Raw]:
    """All candidates in all their forms at their grid points."""
    asked = [(form, value) for item in candidates for form in item.forms for value in item.grid]
    terms = [item for item, _ in asked if item.terms]
    made = iter(term_columns(terms, channels, views, base))
    return [
        _Raw(item, value, next(made) if item.terms else
             candidate_columns(item, value, channels, views, base))
        for item, value in asked
    ]  # fmt: skip


def _largest(channel: Channel, raw: Sequence[_Raw]) -> Array:
    """The base with every candidate once."""
    seen: dict[str, Array] = {}
    for item in raw:
        if channel.name in item.columns:
            seen.setdefault(item.candidate.name, item.columns[channel.name])
    return np.concatenate([channel.design, *seen.values()], axis=1)


@dataclass(frozen=True, kw_only=True)
class _Layout:
    """Where columns stand: candidates, a transient of each run and channel, the floor's features.

    A candidate has one place for all channels; transients have one per channel and run.
    """

    blocks: tuple[CandidateColumns, ...]
    transients: tuple[tuple[Places, ...], ...]
    floors: tuple[Places, ...]
    floor: slice
    width: int

    def of_channel(self, number: int, name: str, raw: Sequence[_Raw]) -> Places:
        """Places of the columns of a channel: its candidates, transients, features."""
        own = [
            block.places
            for block, item in zip(self.blocks, raw, strict=False)
            if name in item.columns
        ]
        return np.concatenate([*own, *self.transients[number], self.floors[number]])


def _layout(raw: Sequence[_Raw], drawn: Sequence[_EachRun], channels: int) -> _Layout:
    """Places of candidates, of those that each run draws (by channel and draw), and features."""
    blocks, at = [], 0
    for item in raw:
        end = at + item.candidate.size
        blocks.append(
            CandidateColumns(candidate=item.candidate, value=item.value, columns=slice(at, end))
        )
        at = end
    transients: list[list[Places]] = [[] for _ in range(channels)]
    for one in drawn:
        begin = at
        for own, places in zip(one.own, transients, strict=True):
            places.append(np.arange(at, at + own.count))
            at += own.count
        if at > begin:
            blocks.append(
                CandidateColumns(candidate=one.candidate, value=one.value, columns=slice(begin, at))
            )
    begin = at
    floors = []
    for _ in transients:
        floors.append(np.arange(at, at + FEATURES))
        at += FEATURES
    return _Layout(
        blocks=tuple(blocks),
        transients=tuple(tuple(x) for x in transients),
        floors=tuple(floors),
        floor=slice(begin, at),
        width=at,
    )


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

    found: tuple[Array, Array, Places] = qr(
        matrix, mode="economic", pivoting=True, check_finite=False
    )
    return found
