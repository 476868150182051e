"""Groups of runs that disagree with the others beside any model.

What a model misses must not look like one of them. So its errors may be those of any derivatives
of third order, pooled over the speeds and a little at each, of a gain, an offset and a slope in all
runs, and of a scatter of each harmonic of the size that makes the errors most probable.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Campaign, Run
from pmmkit.conventions import STRUCTURES, Convention
from pmmkit.effects import Regressors
from pmmkit.inference import Normal
from pmmkit.intake import Disagreement
from pmmkit.numerics import Array
from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.free_running import FreeRun
from pmmkit.validation.uncertainty import scales

SCATTER: Final = (1e-6, *np.geomspace(0.002, 0.5, 17).tolist())
"""Shares of the rms force by which a model may miss each harmonic, in steps of two fifths; some
where nothing is known of the noise."""
POOLED: Final = 0.3
"""Share of the rms force by which a model may be off in each derivative."""
AT_A_SPEED: Final = 0.05
"""Share by which it may be off beside that at each speed."""
SURE: Final = math.log(100.0)
"""ln odds from which a group is told: by Markov's inequality so of one sound campaign in a hundred
at most. Of 80 of the virtual tank, beside the model of another one, none is; at 20 to 1 two."""
TERMS: Final = (*STRUCTURES["abkowitz3"].derivatives, "Xdd", "Yd", "Nd", "Yddd", "Nddd")
"""Derivatives that may be off."""
DRAWN: Final = ("scatter", "stated", "numerical", "floor")
"""Shares of the validation uncertainty that each harmonic draws beside its noise."""


def groups_off(runs: Sequence[CaptiveRun], campaign: Campaign) -> tuple[Disagreement, ...]:
    """Of each channel of captive tests the group that disagrees most, where it is enough."""
    views = [item.view for item in runs]
    groups = Run.groups([view.run for view in views], [view.day for view in views])
    size = scales(views)
    every = dict.fromkeys(name for item in runs for name in item.channels)
    channels = [name for name in every if groups and size[name] > 0.0]
    price = Disagreement.price(len(groups), len(channels))
    found = (
        item
        for name in channels
        for item in _of_channel(
            name, [x for x in runs if name in x.channels], groups, campaign, size[name], price
        )
    )
    return Disagreement.told(found, SURE)


def _of_channel(
    channel: str,
    runs: Sequence[CaptiveRun],
    groups: Mapping[str, frozenset[str]],
    campaign: Campaign,
    size: float,
    price: float,
) -> Iterator[Disagreement]:
    """The groups of a channel. size [N/(m/s)²], of the rms force."""
    ids, read, off, rest, variance = _rows(channel, runs, campaign, size)
    speeds = np.repeat([item.view.speed for item in runs], [item.view.rows for item in runs])
    off /= np.maximum(np.sqrt(np.mean(off**2, axis=0)), 1e-300)
    every = sorted(set(speeds.tolist()))
    at_one = [AT_A_SPEED * off * (speeds == x)[:, None] for x in every if len(every) > 1]
    beside = np.column_stack([POOLED * off, *at_one, max(Run.OTHERWISE) * read])

    def likely(share: float) -> float:
        whole = variance + share**2
        normal = Normal.of(beside / np.sqrt(whole)[:, None], rest / np.sqrt(whole))
        return normal.log_density - 0.5 * float(np.log(whole).sum())

    std = np.sqrt(variance + max(SCATTER, key=likely) ** 2)
    left = Disagreement.spread_by(beside / std[:, None])
    yield from Disagreement.among(
        channel,
        groups,
        ids,
        read / std[:, None],
        left((rest / std)[:, None])[:, 0],
        price=price,
        left=left,
    )


def _rows(
    channel: str, runs: Sequence[CaptiveRun], campaign: Campaign, size: float
) -> tuple[NDArray[np.object_], Array, Array, Array, Array]:
    """The run of each row (n,), what a group may read otherwise (n, 3), derivatives (n, q), what
    the model misses (n,) and its variance (n,), all over the rms force at the speed of the run."""
    steepest = max(abs(item.view.run.settings.drift) for item in runs) or 1.0
    terms = [name for name in TERMS if name[0] == channel]
    ids: list[str] = []
    parts, variances = [], []
    for item in runs:
        view, force = item.view, size * item.view.speed**2
        mean = np.eye(view.rows)[0] * view.has_mean
        derivatives = Regressors.at(
            terms,
            view.motion,
            ship=campaign.ship,
            water=campaign.water,
            convention=Convention(),
            approach_speed=view.speed,
        )
        own = np.column_stack(
            [
                item.predicted[channel] / force,
                mean,
                mean * view.run.settings.drift / steepest,
                view.project(derivatives.columns) / force,
                -item.error(channel) / force,
            ]
        )
        drawn = sum(item.shares[name][channel] ** 2 for name in DRAWN)
        # Along the axes of its noise the rows of a run are independent, whatever scatter is added.
        variance, axes = np.linalg.eigh(view.covariance[channel] + np.diag(drawn))
        parts.append(axes.T @ own)
        variances.append(np.maximum(variance, 0.0) / force**2)
        ids += [view.run.id] * view.rows
    whole = np.concatenate(parts)
    return (
        np.array(ids, object),
        whole[:, :3],
        whole[:, 3:-1],
        whole[:, -1],
        np.concatenate(variances),
    )


def records_off(runs: Sequence[FreeRun], campaign: Campaign) -> tuple[Disagreement, ...]:
    """Of each force of free-running records the group that disagrees most, where it is enough.

    Of each record two numbers are asked, as of a captive run its mean and its first harmonic: the
    mean of what the model misses, and what of it goes with the force.
    """
    days = dict(zip((run.id for run in campaign.runs), campaign.places_in_day, strict=True))
    held = [replace(item.run, id=item.name) for item in runs]
    groups = Run.groups(held, [days[item.run.id] for item in runs])
    every = dict.fromkeys(name for item in runs for name in item.force)
    channels = list(every) if groups else []
    price = Disagreement.price(len(groups), len(channels))
    found = (
        item
        for name in channels
        for item in _of_records(name, [x for x in runs if name in x.force], groups, price)
    )
    return Disagreement.told(found, SURE)


def _of_records(
    channel: str, runs: Sequence[FreeRun], groups: Mapping[str, frozenset[str]], price: float
) -> Iterator[Disagreement]:
    """The groups of a channel, averaged over the sizes that its scatter may have: few records do
    not tell it."""
    speeds = np.array([item.run.settings.speed for item in runs])
    squares = [np.mean(item.force[channel] ** 2) for item in runs]
    sizes = speeds**2 * math.sqrt(float(np.mean(squares / speeds**4)))
    ids = np.repeat(np.array([item.name for item in runs], object), 2)
    parts = []
    for item, size in zip(runs, sizes.tolist(), strict=True):
        force = item.force_predicted[channel] / size
        drift = np.arctan2(-item.measured["v"], item.measured["u"])
        along = np.column_stack([np.ones_like(force), force - force.mean()])
        along /= np.maximum(np.linalg.norm(along, axis=0), 1e-300)
        missed = item.force[channel] / size - force
        rows = np.column_stack([force, np.ones_like(force), drift, missed])
        parts.append(along.T @ rows / math.sqrt(len(force)))
    whole = np.concatenate(parts)
    read, rest = whole[:, :3], whole[:, 3]
    read[:, 2] /= max(float(np.max(np.abs(read[:, 2]))), 1e-300)
    beside = POOLED * read
    tried = [
        (share, Normal.of(beside / share, rest / share).log_density - len(rest) * math.log(share))
        for share in SCATTER[1:]
    ]
    common = float(np.logaddexp.reduce([x for _, x in tried]))
    of_each: dict[str, list[tuple[float, Disagreement]]] = {}
    for share, likely in tried:
        white = beside / share
        normal = Normal.of(white, rest / share)
        for group in Disagreement.among(
            channel,
            groups,
            ids,
            read / share,
            rest / share,
            price=price,
            beside=((white, normal), (white, normal)),
        ):
            of_each.setdefault(group.group, []).append((likely - common + group.log_odds, group))
    for own in of_each.values():
        log_odds = float(np.logaddexp.reduce([x for x, _ in own]))
        yield replace(max(own, key=lambda x: x[0])[1], log_odds=log_odds, instead=log_odds)
