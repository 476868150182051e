"""Scatter between runs in the fits: what each run draws for itself, its size, and what it costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pmmkit.campaigns.motion.inertia import rig_of
from pmmkit.campaigns.motion.nominal import has_nominal
from pmmkit.campaigns.run import Campaign
from pmmkit.campaigns.uncertainty import TypeB
from pmmkit.conventions import Convention
from pmmkit.numerics import Array, coverage_factor
from pmmkit.observations.channels import Channel, Scatter
from pmmkit.observations.equations import Rows, Sensitivity, sensitivity
from pmmkit.observations.scatter import Restricted, RunScatter, half_width, restricted
from pmmkit.reduction.estimate import Block, ChannelFit, Width
from pmmkit.tables.table import CONFIDENCE

ONE_DEGREE = TypeB(name="drift", std=float(np.radians(1.0)))


@dataclass(frozen=True, kw_only=True, eq=False)
class BetweenRuns:
    """What runs draw for themselves, and how large that is.

    Parameters
    ----------
    drift : tuple of Sensitivity
        How the equations of each run change with a degree of drift.
    readings : tuple of mapping of channel to array (m,)
        Harmonics of each run as measured, zero where not known [N, N m].
    scatter : RunScatter, optional
        Sizes; estimated from the runs where they are not given.
    """

    drift: tuple[Sensitivity, ...]
    readings: tuple[Mapping[str, Array], ...]
    scatter: RunScatter | None = None

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


def between_runs(rows: Sequence[Rows], campaign: Campaign, convention: Convention) -> BetweenRuns:
    """What the runs of a campaign draw for themselves, sizes not known.

    Parameters
    ----------
    rows : sequence of Rows
        What each run says.
    campaign, convention
        Ship, rig, and meaning of the derivatives.
    """
    rig = rig_of(campaign)
    return BetweenRuns(
        drift=tuple(
            sensitivity(item, ONE_DEGREE, campaign, rig, item.names, convention)
            if has_nominal(item.result.run)
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
class Drawn:
    """What the runs of one fit draw, block by block.

    Parameters
    ----------
    stated : tuple of array (m_i, q)
        Columns per standard deviation that the campaign states.
    own : tuple of array (m_i, 3)
        Offset, gain and degree of drift at size one; zero where one is stated.
    """

    stated: tuple[Array, ...]
    own: tuple[Array, ...]

    def private(self, blocks: Sequence[Block], sizes: Array) -> dict[int, Array]:
        """Columns of each run as `fit_channel` takes them."""
        return {
            block.run: np.concatenate([stated, own * sizes], axis=1)
            for block, stated, own in zip(blocks, self.stated, self.own, strict=True)
        }


def drawn(
    channel: str,
    blocks: Sequence[Block],
    values: Mapping[str, float],
    residual: Sequence[Array],
    rows: Sequence[Rows],
    changes: Sequence[Sequence[Sensitivity]],
    between: BetweenRuns,
    size: float,
) -> Drawn:
    """What each run of a fit draws for itself.

    Parameters
    ----------
    channel : str
        X, Y, N or K.
    blocks : sequence of Block
        Rows of the fit.
    values : mapping of str to float
        Derivatives as far as they are known.
    residual : sequence of array
        Rows less fit; a gain acts on the fitted reading, since that of the measured one would
        favour readings that are too small.
    rows, changes, between
        Of the same runs: equations, stated uncertainties, what they draw.
    size : float
        The channel's rms force [N, N m].
    """
    stated, own = [], []
    names = Scatter.names()
    for place, block in enumerate(blocks):
        private = [change for change in changes[block.run] if not change.source.shared]
        count = len(block.rows)
        told = [change.residual(channel, values)[block.keep] for change in private]
        stated.append(np.stack(told, axis=1) if told else np.zeros((count, 0)))
        columns = np.zeros((count, len(names)))
        own.append(columns)
        if block.covariance is None:
            continue
        known = {_drawn_by(change.source, channel) for change in private}
        for column, name in zip(columns.T, names, strict=True):
            if name in known:
                continue
            if name == "offset":
                labels = rows[block.run].result.labels
                column[:] = size * (np.array(labels) == "C0")[block.keep]
            elif name == "gain":
                column[:] = between.readings[block.run][channel][block.keep] - residual[place]
            else:
                column[:] = between.drift[block.run].residual(channel, values)[block.keep]
    return Drawn(stated=tuple(stated), own=tuple(own))


def _drawn_by(source: TypeB, channel: str) -> str | None:
    """Which of the three a stated uncertainty takes the place of."""
    if source.kind.channel == channel:
        return "gain" if source.relative else "offset"
    return "drift" if source.name == "drift" else None


def size_of(blocks: Sequence[Block], channel: str, between: BetweenRuns) -> float:
    """Root mean square of the readings of a channel over runs, harmonics together [N, N m]."""
    squares = [
        float(np.sum(between.readings[block.run][channel][block.keep] ** 2)) for block in blocks
    ]
    return float(np.sqrt(np.mean(squares))) or 1.0


def likelihood_of(item: ChannelFit, drawn: Drawn) -> Restricted:
    """The restricted likelihood of what the runs of a fit draw."""
    edges = np.cumsum([0, *(len(block.rows) for block in item.blocks)]).tolist()
    places = tuple(slice(a, b) for a, b in pairwise(edges))
    design = np.concatenate([block.design[:, item.chosen] for block in item.blocks])
    channel = Channel(
        name=item.channel,
        views=tuple(range(len(item.blocks))),
        rows=places,
        runs=tuple(np.arange(a, b) for a, b in pairwise(edges)),
        y=np.concatenate(item.residual),
        design=design,
        noise=tuple(
            noise + stated @ stated.T
            for noise, stated in zip(item.noise.covariances, drawn.stated, strict=True)
        ),
        scale=1.0,
    )
    return restricted(channel, np.concatenate(drawn.own), design)


def widened(item: ChannelFit, drawn: Drawn, scatter: RunScatter) -> ChannelFit:
    """A fit with the intervals of the mixture over all sizes of the scatter.

    Parameters
    ----------
    item : ChannelFit
        Fitted at the mean sizes.
    drawn : Drawn
        What its runs draw.
    scatter : RunScatter
        Sizes with their weights.

    Notes
    -----
    Each standard uncertainty u and its degrees of freedom ν are chosen so that u t(ν) is the half
    width of the mixture's 95 % interval about the value, with the ν of the scaled inverse
    chi-square distribution that has the mixture's mean and variance of the variance.
    """
    sizes = scatter.sizes(item.channel)
    columns = tuple(own * sizes for own in drawn.own)
    nodes, weight = scatter.weighed(item.channel)
    change, variance = likelihood_of(item, drawn).estimates(nodes)
    there = item.fit.determined & np.all(variance > 0, axis=0)
    mean = weight @ variance
    with np.errstate(divide="ignore", invalid="ignore"):
        uneven = np.maximum(weight @ variance**2 / mean**2 - 1.0, 1e-6)
    dof = np.where(there, 4.0 + 2.0 / uneven, np.inf)
    half = half_width(
        change[:, there], variance[:, there], weight, np.zeros(int(there.sum())), CONFIDENCE
    )
    plain = np.zeros(len(there))
    for gain, noise, stated, own in zip(
        item.gains(), item.noise.covariances, drawn.stated, columns, strict=True
    ):
        for part in (stated, own):
            plain += np.sum((gain @ part) ** 2, axis=1)
        plain += np.einsum("pi,ij,pj->p", gain, noise, gain)
    factor = np.ones(len(there))
    factor[there] = half / coverage_factor(dof[there], CONFIDENCE) / np.sqrt(plain[there])
    return replace(item, width=Width(columns=columns, factor=factor, dof=dof))
