"""All runs as one linear system by channel: forces, base, and the columns of what may differ.

y = X θ + Σ A c + Φ w + Z s + e: base X of free values θ; effects A, coefficients c ~ N(c₀, prior²);
the smooth floor Φ, w ~ N(0, 1); what each run draws, Z; noise e of the records.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import (
    Candidate,
    channels_of_terms,
    columns_of,
    of_derivatives,
)
from pmmkit.diagnosis.captive.whitening import Channel, OwnColumns, Piece, Places, RunEffectColumns
from pmmkit.effects import CATALOGUE
from pmmkit.inference import Normal
from pmmkit.numerics import Array
from pmmkit.reduction import View

WIDER: Final = 1.5
"""Prior standard deviation of a coefficient over its typical size."""
MANY: Final = 200
"""Columns from which those that each run draws stand beside the system."""
FEATURES: Final = 128
"""Random features of the smooth floor, per channel: half of them of the channel's own parity."""
TURNED: Final = 6
"""Variables of the smooth floor that change sign in a mirrored motion."""
SMOOTH: Final = 0.8
"""Length scale of the floor over the range of each variable."""
LEAST: Final = 1e-4
"""Least standard deviation of a mean or harmonic, over the channel's rms force."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CandidateColumns:
    """One candidate at one grid point: its columns, whitened and projected, over prior sizes.

    Columns that each of very many runs draws stand beside the system, as `drawn`. `made`: the
    columns before they are whitened, by channel (n, q); None of what each run draws.
    """

    candidate: Candidate
    value: float
    columns: slice
    drawn: RunEffectColumns | None = None
    made: Mapping[str, Array] | None = None

    @property
    def places(self) -> Places:
        """Places of the columns in the system, which has those of very many runs only `spread`."""
        assert self.drawn is None
        return np.arange(self.columns.start, self.columns.stop)

    @property
    def count(self) -> int:
        """Number of columns."""
        return self.columns.stop - self.columns.start if self.drawn is None else self.drawn.count


@dataclass(frozen=True, kw_only=True, eq=False)
class System:
    """Everything that evidence needs.

    `blocks`: candidates; columns in units of their prior standard deviation. `normal`: what the
    data say of the coefficients of all columns. `rows`: rows less base coefficients. `floor`:
    what is smooth and too small to matter, over the rms force of a channel. `floor_columns`:
    where the features of the smooth floor stand, at the size of the floor. `prior (q,)`: prior
    standard deviation of each column, to give coefficients back. `pieces`: the channels, one by
    one. `features (n, D)`: of the smooth floor in each channel, at size one. `unasked`: those
    for which these runs hold nothing.
    """

    views: tuple[View, ...]
    base: CaptiveBase
    channels: tuple[Channel, ...]
    scatter: Mapping[str, Array]
    blocks: tuple[CandidateColumns, ...]
    normal: Normal
    rows: int
    floor: float
    floor_columns: slice
    prior: Array
    pieces: tuple[Piece, ...]
    features: tuple[Array, ...]
    unasked: tuple[Candidate, ...] = ()

    def whole(self, names: Sequence[str]) -> System:
        """With all coefficients of some effects, which a base has already."""
        kept = [
            block
            for block in self.blocks
            if block.candidate.name not in names or not block.candidate.partial
        ]
        return replace(self, blocks=tuple(kept))

    def taking_part(self, names: Sequence[str]) -> tuple[str, ...]:
        """Of some effects those for which these runs hold anything."""
        absent = {item.name for item in self.unasked}
        return tuple(name for name in names if name not in absent)


def channels_of(views: Sequence[View], base: CaptiveBase) -> tuple[Channel, ...]:
    """Rows of every channel, in the order of the views."""
    channels = []
    for name, names in base.names.items():
        having = [i for i, view in enumerate(views) if name in view.force]
        if not having:
            continue
        edges = np.cumsum([0, *(views[i].rows for i in having)]).tolist()
        rows = tuple(slice(a, b) for a, b in pairwise(edges))
        y = np.concatenate([views[i].force[name] for i in having])
        design = base.design(names, [views[i] for i in having])
        scale = scale_of(name, [views[i] for i in having])
        groups: dict[str, list[int]] = {}
        for place, i in enumerate(having):
            groups.setdefault(views[i].run.id, []).append(place)
        channels.append(
            Channel(
                name=name,
                views=tuple(having),
                rows=rows,
                y=y,
                design=design,
                runs=tuple(
                    np.concatenate([np.arange(rows[p].start, rows[p].stop) for p in views_of_run])
                    for views_of_run in groups.values()
                ),
                noise=tuple(
                    _diagonal([_noise(views[having[p]], name, scale) for p in views_of_run])
                    for views_of_run in groups.values()
                ),
                scale=scale,
            )
        )
    return tuple(channels)


def scale_of(channel: str, views: Sequence[View]) -> float:
    """Root mean square of a force over U², of the views that have it [N/(m/s)²].

    All harmonics of a run count together.
    """
    sizes = [
        float(np.linalg.norm(view.force[channel])) / view.speed**2
        for view in views
        if channel in view.force
    ]
    return float(np.sqrt(np.mean(np.square(sizes))))


def _noise(view: View, channel: str, scale: float) -> Array:
    """Covariance of the harmonics of a view; none is known better than a share of the force."""
    least = (LEAST * scale * view.speed**2) ** 2
    covariance: Array = view.covariance[channel] + least * np.eye(view.rows)
    return covariance


def _diagonal(blocks: Sequence[Array]) -> Array:
    """Blocks along the diagonal of a square array."""
    size = sum(len(block) for block in blocks)
    whole, begin = np.zeros((size, size)), 0
    for block in blocks:
        end = begin + len(block)
        whole[begin:end, begin:end] = block
        begin = end
    return whole


def offset_column(channel: Channel, views: Sequence[View], base: CaptiveBase) -> Array:
    """An offset of each run in a channel, at size one (n,)."""
    column = np.zeros(len(channel.y))
    for i, rows in zip(channel.views, channel.rows, strict=True):
        if views[i].has_mean:
            column[rows.start] = channel.scale * base.reference**2
    return column


def run_columns(
    channels: Sequence[Channel],
    views: Sequence[View],
    base: CaptiveBase,
    predicted: Mapping[str, Array],
) -> dict[str, Array]:
    """What each run draws for itself, at size one: offset, gain, degree of drift, and each of the
    k harmonics, which its pieces have in common (n, 3 + k)."""
    harmonics = max(view.rows for view in views)
    drifting = [
        i
        for i, view in enumerate(views)
        if view.run.settings.drift and not view.run.kind_of_test.swings_hull
    ]
    misaligned = columns_of(CATALOGUE["fault_misalignment"])([views[i] for i in drifting], base, 0)
    turned = dict(zip(drifting, misaligned, strict=True))
    columns = {}
    for c in channels:
        drift, each = np.zeros(len(c.y)), np.zeros((len(c.y), harmonics))
        for i, rows in zip(c.views, c.rows, strict=True):
            if i in turned:
                drift[rows] = turned[i][c.name][:, 0]
            first = int(views[i].has_mean)
            own = range(rows.start + first, rows.stop)
            each[own, range(first, views[i].rows)] = c.scale * base.reference**2
        offset = offset_column(c, views, base)
        columns[c.name] = np.column_stack([offset, predicted[c.name], drift, each])
    return columns


def floor_features(
    channel: Channel, views: Sequence[View], base: CaptiveBase, seed: int = 12345
) -> Array:
    """A smooth function of the motion as random features, of unit size over the scale (n, D).

    Its covariance k(x, x') is that of two functions, k± = ½[k(x, x') ± k(x, P x')], where P turns
    sway, yaw, their rates, rudder and heel over: a symmetric ship has odd Y and N and even X. The
    first half of the columns are of the parity that such a ship has, the others of the other.
    """
    variables = [_variables(views[i], base) for i in channel.views]
    ranges = np.max([np.max(np.abs(x), axis=0) for x in variables], axis=0)
    live = ranges > 1e-9
    half = FEATURES // 2
    rng = np.random.default_rng([seed, ord(channel.name)])
    omega = np.zeros((len(ranges), half))
    omega[live] = rng.normal(size=(int(live.sum()), half)) / SMOOTH
    phase = rng.uniform(0, 2 * math.pi, half)
    rows = []
    for i, x in zip(channel.views, variables, strict=True):
        view = views[i]
        scaled = x / np.where(live, ranges, 1.0)
        turned = scaled[:, :TURNED] @ omega[:TURNED]
        kept = scaled[:1, TURNED:] @ omega[TURNED:] + phase  # the speed of the run, which stays
        even, odd = np.cos(turned) * np.cos(kept), np.sin(turned) * np.sin(kept)
        both = (even, odd) if is_even(channel.name) else (odd, even)
        unit = channel.scale * view.motion.speed**2
        features = math.sqrt(2.0 / half) * np.concatenate(both, axis=1)
        rows.append(view.project(features * unit[:, None]))
    return np.concatenate(rows)


def is_even(channel: str) -> bool:
    """Whether a channel of a symmetric ship is the same in a mirrored motion."""
    return channel == "X"


def _variables(view: View, base: CaptiveBase) -> Array:
    """What a smooth force may depend on; the first `TURNED` change sign in a mirrored motion."""
    m, L = view.motion, base.ship.L
    U = m.speed
    return np.stack(
        [
            m.v / U,
            m.r * L / U,
            m.vdot * L / U**2,
            m.rdot * L**2 / U**2,
            m.delta,
            m.phi,
            np.full_like(U, base.law(view.speed)),
        ],
        axis=1,
    )


def each_run_columns(
    candidate: Candidate,
    value: float,
    channel: Channel,
    views: Sequence[View],
    base: CaptiveBase,
    predicted: Array,
) -> OwnColumns:
    """A candidate of which each run draws a share: a column per run that knows it.

    A unit is the force of the run, that of its later cycles where it stands in two pieces.
    """
    own_views = candidate.columns([views[i] for i in channel.views], base, value)
    by_view = {i: own.get(channel.name) for i, own in zip(channel.views, own_views, strict=True)}
    ids = dict.fromkeys(views[i].run.id for i, own in by_view.items() if own is not None)
    number = {run: place for place, run in enumerate(ids)}
    values, column = np.zeros(len(channel.y)), np.full(len(channel.y), -1, np.intp)
    sizes: dict[str, float] = {}
    for i, rows in zip(channel.views, channel.rows, strict=True):
        column[rows] = number.get(views[i].run.id, -1)
        if by_view[i] is not None and not views[i].early:
            sizes[views[i].run.id] = float(np.linalg.norm(predicted[rows]))
    for i, rows in zip(channel.views, channel.rows, strict=True):
        own = by_view[i]
        if own is not None:
            size = sizes.get(views[i].run.id, float(np.linalg.norm(predicted[rows])))
            values[rows] = size * own[:, 0]
    return OwnColumns(values=values, column=column, count=len(number))


def candidate_columns(
    candidate: Candidate,
    value: float,
    channels: Sequence[Channel],
    views: Sequence[View],
    base: CaptiveBase,
) -> Mapping[str, Array]:
    """Columns of a candidate by channel (n, q)."""
    if candidate.terms:
        return term_columns([candidate], channels, views, base)[0]
    by_view = candidate.columns(views, base, value)
    columns = {}
    for channel in channels:
        block = np.zeros((len(channel.y), candidate.size))
        for i, rows in zip(channel.views, channel.rows, strict=True):
            if channel.name in by_view[i]:
                block[rows] = by_view[i][channel.name]
        if np.any(block):
            columns[channel.name] = block
    return columns


def term_columns(
    candidates: Sequence[Candidate],
    channels: Sequence[Channel],
    views: Sequence[View],
    base: CaptiveBase,
) -> list[Mapping[str, Array]]:
    """`candidate_columns` of candidates that stand for derivatives, each motion looked at once."""
    every = [candidate.terms for candidate in candidates]
    acting = channels_of_terms(every)
    by_channel = {
        c.name: of_derivatives(every, c.name, [views[i] for i in c.views], base)
        for c in channels
        if c.name in acting
    }
    return [
        {name: columns[k] for name, columns in by_channel.items() if np.any(columns[k])}
        for k in range(len(every))
    ]
