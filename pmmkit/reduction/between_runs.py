"""Scatter between runs in the fits: what each run draws for itself, its size, and what it costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.campaigns import Campaign, TypeB
from pmmkit.conventions import CHANNEL_UNITS, Convention
from pmmkit.inference import Restricted, RunEffects
from pmmkit.numerics import Array, coverage_factor
from pmmkit.reduction.estimate import BIRGE_P, ChannelFit, RunBlock, Width
from pmmkit.reduction.observations.equations import Rows, Sensitivity, residuals, sensitivity
from pmmkit.reduction.observations.noise import whiteners

ONE_DEGREE = TypeB(name="drift", std=float(np.radians(1.0)))
STEPS: Final = 60
"""Steps by which a half width is found at most: Newton's, or a bisection where those leave it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BetweenRuns:
    """What runs draw for themselves, and how large that is.

    `drift`: how the equations of each run change with a degree of drift. `readings (m,)`:
    harmonics of each run as measured, zero where not known [N, N m]. `scatter`: sizes;
    estimated from the runs where they are not given.
    """

    drift: tuple[Sensitivity, ...]
    readings: tuple[Mapping[str, Array], ...]
    scatter: RunEffects | None = None

    def of(self, runs: Sequence[int]) -> BetweenRuns:
        """Some of the runs."""
        return replace(
            self,
            drift=tuple(self.drift[place] for place in runs),
            readings=tuple(self.readings[place] for place in runs),
        )

    def unknown(self) -> BetweenRuns:
        """The same with sizes that are to be estimated."""
        return replace(self, scatter=None)

    def in_words(self, channel: str, fits: Sequence[ChannelFit] = ()) -> str:
        """The sizes of a channel of which its runs say anything, in its units.

        fits: those of the channel, for what they leave of runs that state no noise.
        """
        assert self.scatter is not None
        unit = CHANNEL_UNITS[channel]
        words = {
            "offset": f"zero {{:.2g}} {unit}",
            "gain": "gain {:.2%}",
            "drift": "drift setting {:.2g}°",
            "harmonics": f"each harmonic {{:.2g}} {unit}",
        }
        told = [words[kind].format(size) for kind, size in self.scatter.in_units(channel).items()]
        for dynamic, what in ((False, "means"), (True, "harmonics")):
            left = [
                noise[0, 0]
                for item in fits
                for block, noise in zip(item.blocks, item.noise.covariances, strict=True)
                if block.covariance is None and block.dynamic == dynamic
            ]
            if left:
                size = float(np.sqrt(np.mean(left)))
                told.append(f"{what} without noise of their own {size:.2g} {unit}")
        return f"{channel}: {', '.join(told) or 'not told by these runs'}"


def between_runs(rows: Sequence[Rows], campaign: Campaign, convention: Convention) -> BetweenRuns:
    """What the runs of a campaign draw for themselves, sizes not known."""
    rig = campaign.rig
    return BetweenRuns(
        drift=tuple(
            sensitivity(item, ONE_DEGREE, campaign, rig, item.names, convention)
            if item.result.run.has_nominal
            else _unmoved(item)
            for item in rows
        ),
        readings=tuple(
            {channel: np.nan_to_num(x) for channel, x in item.result.measured.items()}
            for item in rows
        ),
    )


def _unmoved(rows: Rows) -> Sensitivity:
    """No change with drift, of a run whose settings do not say its motion."""
    return Sensitivity(
        source=ONE_DEGREE,
        force={channel: np.zeros_like(x) for channel, x in rows.force.items()},
        design={channel: np.zeros_like(x) for channel, x in rows.design.items()},
        names=rows.names,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class RunDraws:
    """What the runs of one fit draw, block by block.

    `stated (m_i, q)`: columns per standard deviation that the campaign states. `own (m_i, 3 +
    m_i)`: offset, gain and degree of drift at size one, zero where one is stated; then a column
    for each harmonic.
    """

    stated: tuple[Array, ...]
    own: tuple[Array, ...]

    def private(self, blocks: Sequence[RunBlock], sizes: Array) -> dict[int, Array]:
        """Columns of each run as `fit_channel` takes them."""
        return {
            block.run: np.concatenate(
                [stated, own * RunEffects.per_column(sizes, len(own))], axis=1
            )
            for block, stated, own in zip(blocks, self.stated, self.own, strict=True)
        }


def drawn(
    channel: str,
    blocks: Sequence[RunBlock],
    values: Mapping[str, float],
    residual: Sequence[Array],
    rows: Sequence[Rows],
    changes: Sequence[Sequence[Sensitivity]],
    between: BetweenRuns,
    size: float,
) -> RunDraws:
    """What each run of a fit draws for itself."""
    stated, own = [], []
    for place, block in enumerate(blocks):
        private = [change for change in changes[block.run] if not change.source.shared]
        count = len(block.rows)
        told = residuals([*private, between.drift[block.run]], channel, values)[:, block.keep]
        stated.append(told[:-1].T)
        if block.covariance is None:  # what it draws is part of what the fit leaves of it
            own.append(np.zeros((count, len(RunEffects.KINDS) - 1 + count)))
            continue
        known = {_drawn_by(change.source, channel) for change in private}
        mean = (np.array(rows[block.run].result.labels) == "C0")[block.keep]
        columns = {
            "offset": size * mean,
            "gain": between.readings[block.run][channel][block.keep] - residual[place],
            "drift": told[-1],
        }
        left = [
            np.zeros(count) if name in known else columns[name] for name in RunEffects.KINDS[:-1]
        ]
        own.append(np.column_stack([*left, size * np.diag(~mean)]))
    return RunDraws(stated=tuple(stated), own=tuple(own))


def _drawn_by(source: TypeB, channel: str) -> str | None:
    """Which of the three a stated uncertainty takes the place of."""
    if source.kind.channel == channel:
        return "gain" if source.relative else "offset"
    return "drift" if source.name == "drift" else None


def size_of(blocks: Sequence[RunBlock], channel: str, between: BetweenRuns) -> float:
    """Root mean square of the readings of a channel over runs, harmonics together [N, N m]."""
    squares = [
        float(np.sum(between.readings[block.run][channel][block.keep] ** 2)) for block in blocks
    ]
    return float(np.sqrt(np.mean(squares))) or 1.0


def likelihood_of(item: ChannelFit, drawn: RunDraws) -> Restricted:
    """The restricted likelihood of what the runs of a fit draw."""
    white = whiteners(_record_noise(item, drawn))
    groups = [
        (
            np.stack([white[i] @ _columns(item, i) for i in places]),
            np.stack([white[i] @ drawn.own[i] for i in places]),
        )
        for places in _equal_rows(item.blocks)
    ]
    return RunEffects.likelihood(groups, len(item.chosen))


def repeats_of(item: ChannelFit, drawn: RunDraws) -> Restricted | None:
    """The likelihood of what repeated runs alone say of it; None where no run was repeated."""
    covariances = _record_noise(item, drawn)
    return RunEffects.repeatability(
        (
            np.stack([item.residual[i] for i in places]),
            np.mean([drawn.own[i] for i in places], axis=0),
            np.mean([covariances[i] for i in places], axis=0),
        )
        for places in _conditions(item.blocks)
    )


def _conditions(blocks: Sequence[RunBlock]) -> list[list[int]]:
    """Places of the blocks of runs that repeat each other, and have as many rows."""
    found: dict[tuple[str, int], list[int]] = {}
    for place, block in enumerate(blocks):
        found.setdefault((block.origin, len(block.rows)), []).append(place)
    return list(found.values())


def _record_noise(item: ChannelFit, drawn: RunDraws) -> list[Array]:
    """Covariance of each block by its noise and what is stated of it."""
    return [
        noise + stated @ stated.T
        for noise, stated in zip(item.noise.covariances, drawn.stated, strict=True)
    ]


def _columns(item: ChannelFit, place: int) -> Array:
    """Model and what is left of the data, of one block."""
    block = item.blocks[place]
    return np.column_stack([block.design[:, item.chosen], item.residual[place]])


def _equal_rows(blocks: Sequence[RunBlock]) -> list[list[int]]:
    """Places of blocks of as many rows together."""
    found: dict[int, list[int]] = {}
    for place, block in enumerate(blocks):
        found.setdefault(len(block.rows), []).append(place)
    return list(found.values())


def widened(
    item: ChannelFit, drawn: RunDraws, scatter: RunEffects, likelihood: Restricted
) -> ChannelFit:
    """A fit with the intervals of the mixture over all sizes of the scatter.

    Notes
    -----
    Each standard uncertainty u and its degrees of freedom ν are chosen so that u t(ν) is the half
    width of the mixture's 95 % interval about the value, with the ν of the scaled inverse
    chi-square distribution that has the mixture's mean and variance of the variance.
    """
    sizes = scatter.sizes(item.channel)
    columns = tuple(own * RunEffects.per_column(sizes, len(own)) for own in drawn.own)
    nodes, weight = scatter.nodes[item.channel], scatter.weights[item.channel]
    change, variance = likelihood.estimates(nodes)
    there = item.fit.determined & np.all(variance > 0, axis=0)
    mean = weight @ variance
    with np.errstate(divide="ignore", invalid="ignore"):
        uneven = np.maximum(weight @ variance**2 / mean**2 - 1.0, 1e-6)
    dof = np.where(there, 4.0 + 2.0 / uneven, np.inf)
    half = half_width(
        change[:, there], variance[:, there], weight, np.zeros(int(there.sum())), 0.95
    )
    plain = np.zeros(len(there))
    for gain, noise, stated, own in zip(
        item.gains(), item.noise.covariances, drawn.stated, columns, strict=True
    ):
        for part in (stated, own):
            plain += np.sum((gain @ part) ** 2, axis=1)
        plain += np.einsum("pi,ij,pj->p", gain, noise, gain)
    factor = np.ones(len(there))
    factor[there] = half / coverage_factor(dof[there]) / np.sqrt(plain[there])
    return replace(item, width=Width(columns=columns, factor=factor, dof=dof))


def half_width(
    value: Array, variance: Array, weight: Array, centre: Array, confidence: float
) -> Array:
    """Half width of the symmetric interval about a centre that holds a mixture of normals.

    value, variance (g, p): of each coefficient at each node, whose weights (g,) sum to one.

    Examples
    --------
    >>> one = np.ones((1, 1))
    >>> half_width(0 * one, one, np.ones(1), np.zeros(1), 0.95).round(3)
    array([1.96])
    """
    from scipy.special import ndtr

    std = np.sqrt(variance)
    away = value - centre
    low = np.zeros_like(centre)
    high: Array = np.max(np.abs(away) + 10.0 * std, axis=0)
    half: Array = 2.0 * np.sqrt(weight @ (variance + away**2))
    for _ in range(STEPS):
        right, left = (half - away) / std, (-half - away) / std
        short = weight @ (ndtr(right) - ndtr(left)) - confidence
        density = weight @ ((np.exp(-0.5 * right**2) + np.exp(-0.5 * left**2)) / std)
        low, high = np.where(short < 0, half, low), np.where(short < 0, high, half)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = half - short / density * np.sqrt(2.0 * np.pi)
        before = half
        half = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
        if np.all(np.abs(half - before) <= 1e-14 * half):
            break
    return half


def judged(
    item: ChannelFit, scatter: RunEffects, expected: RunEffects, likelihood: Restricted
) -> ChannelFit:
    """A fit with how far its misfit is beyond what repeats, or a usual laboratory, allow.

    Notes
    -----
    What a structure lacks looks like scatter between runs, so that sizes by all that a fit leaves
    explain any misfit; they make the intervals. Whether it is one, repeats say: the chance is that
    of an F variable by the sizes that they show, or a usual laboratory has.
    """
    from scipy.special import fdtrc

    if any(block.covariance is None for block in item.blocks):
        return _lack_of_fit(item)
    freedom = item.freedom
    sizes = np.stack([scatter.sizes(item.channel), expected.sizes(item.channel)])
    found, usual = likelihood.misfits(sizes).tolist()
    strength = float(np.clip(np.median(item.noise.dof), 3.0, 1e6))
    return replace(
        item,
        chi_square=found,
        scale=usual / freedom if freedom else 1.0,
        excessive=freedom > 0 and bool(fdtrc(freedom, strength, usual / freedom) <= BIRGE_P),
    )


def _lack_of_fit(item: ChannelFit) -> ChannelFit:
    """The test for lack of fit of runs that state no noise: their misfit over that of repeats."""
    from scipy.special import fdtrc

    white = whiteners(item.noise.covariances)
    left = [w @ rest for w, rest in zip(white, item.residual, strict=True)]
    repeated = [
        np.stack([left[i] for i in own]) for own in _conditions(item.blocks) if len(own) > 1
    ]
    pure = sum(float(np.sum((x - x.mean(axis=0)) ** 2)) for x in repeated)
    freedom = sum((len(x) - 1) * x.shape[1] for x in repeated)
    others = item.freedom - freedom
    if not pure or others <= 0:
        return item
    lack = (float(sum(x @ x for x in left)) - pure) / others * freedom / pure
    return replace(
        item,
        scale=float(sum(x @ x for x in left)) / item.freedom * freedom / pure,
        excessive=bool(fdtrc(others, freedom, lack) <= BIRGE_P),
    )
