"""Groups of runs that read otherwise than the rest: a kind of test, a speed, a side, a part of the
day.

The evidence (`Disagreement`) is that of the fits of all Froude numbers together, in which the
derivatives take what they can; a diagnosis asks the same beside its effects.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pmmkit.campaigns import Campaign, Run
from pmmkit.intake import CheckFinding, Disagreement
from pmmkit.numerics import Array
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.solve import Solution


def groups_at_odds(
    solution: Solution, rows: Sequence[Rows], campaign: Campaign
) -> tuple[CheckFinding, ...]:
    """The group of each channel that reads otherwise, as the checks say it.

    Channels whose fit lacks something beyond noise are not asked: the lack would look like a group.
    Nor are groups of whole speeds, which derivatives that change with the speed make.
    """
    runs = [item.result.run for item in rows]
    day = dict(zip((run.id for run in campaign.runs), campaign.places_in_day, strict=True))
    speeds = Run.levels(runs)["speed"].values()
    groups = {
        words: own
        for words, own in Run.groups(runs, [day[run.id] for run in runs]).items()
        if any(own & level and level - own for level in speeds)
    }
    fits: dict[str, list[tuple[int, ChannelFit]]] = {}
    for group, item in solution.fits:
        fits.setdefault(item.channel, []).append((group, item))
    asked = {name: own for name, own in fits.items() if not any(x.excessive for _, x in own)}
    price = Disagreement.price(len(groups), len(asked))
    return tuple(
        item.finding
        for item in Disagreement.told(
            item
            for channel, own in asked.items()
            for item in _of_channel(channel, own, solution, runs, groups, price)
        )
    )


def _of_channel(
    channel: str,
    fits: Sequence[tuple[int, ChannelFit]],
    solution: Solution,
    runs: Sequence[Run],
    groups: Mapping[str, frozenset[str]],
    price: float,
) -> Iterator[Disagreement]:
    """The groups of a channel, beside the derivatives at each Froude number."""
    steepest = max((abs(run.settings.drift) for run in runs), default=0.0) or 1.0
    parts = [
        _whitened(item, [runs[place] for place in solution.groups[group]], steepest)
        for group, item in fits
    ]
    ids, columns, rest = (np.concatenate(x) for x in zip(*(x[:3] for x in parts), strict=True))
    designs = [x[3] for x in parts]
    ends = np.cumsum([len(design) for design in designs])[:-1]

    def left(every: Array) -> Array:
        own = zip(np.split(every, ends), designs, fits, strict=True)
        return np.concatenate([x - design @ (item.fit.gain @ x) for x, design, (_, item) in own])

    yield from Disagreement.among(channel, groups, ids, columns, rest, price=price, left=left)


def _whitened(
    item: ChannelFit, runs: Sequence[Run], steepest: float
) -> tuple[Array, Array, Array, Array]:
    """The run of each row of a fit (n,), what a group may read otherwise (n, 3), what the fit
    leaves (n,), and the design of the derivatives (n, p)."""
    ids: list[str] = []
    parts = []
    size = float(np.sqrt(np.mean(np.concatenate([block.rows for block in item.blocks]) ** 2)))
    for block, white, left in zip(item.blocks, item.whiteners, item.residual, strict=True):
        run = runs[block.run]
        mean = np.zeros(len(left))
        mean[0] = size * bool(block.keep[0])
        own = [block.rows - left, mean, mean * run.settings.drift / steepest]
        parts.append(white @ np.column_stack([*own, left, block.design[:, item.chosen]]))
        ids += [run.id] * len(left)
    whole = np.concatenate(parts)
    return np.array(ids, object), whole[:, :3], whole[:, 3], whole[:, 4:]
