"""Groups of runs that read otherwise than the rest: a kind of test, a speed, a side, a part of the
day.

In the runs of a group a channel reads F (1 + g) + a + b β in place of F, each 0 ± s of its rms
force (`Run.OTHERWISE`). The evidence is that of the fits of all Froude numbers together, in which
the derivatives take what they can; a diagnosis asks the same beside its effects.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Campaign, Run
from pmmkit.inference import Normal
from pmmkit.intake import CheckFinding
from pmmkit.models import odds
from pmmkit.numerics import Array
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.observations.equations import Rows
from pmmkit.reduction.solve import Solution

TOLD: Final = math.log(20.0)
"""ln odds, the number of groups paid, from which a group is told. Of fifteen faults of groups in
the virtual tank one is told at each Froude number by itself, six in one fit over all speeds, where
the day and the speed do not stand for each other (scripts.studies.group_faults)."""


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
    price = math.log(2.0 * max(len(groups) * len(asked), 1))
    return tuple(
        finding
        for channel, own in asked.items()
        for finding in _of_channel(channel, own, solution, runs, groups, price)
    )


def _of_channel(
    channel: str,
    fits: Sequence[tuple[int, ChannelFit]],
    solution: Solution,
    runs: Sequence[Run],
    groups: Mapping[str, frozenset[str]],
    price: float,
) -> Iterator[CheckFinding]:
    """The group of a channel with the most evidence, where it is enough."""
    nothing = Normal(information=np.zeros((0, 0)), score=np.zeros(0), centre=np.zeros(0))
    steepest = max((abs(run.settings.drift) for run in runs), default=0.0) or 1.0
    best = (TOLD, "", np.zeros(3))
    parts = [
        _Whitened.of(item, [runs[place] for place in solution.groups[group]], steepest)
        for group, item in fits
    ]
    for words, members in groups.items():
        products = [part.products(members) for part in parts]
        inner = np.sum([x for x, _ in products], axis=0)
        score = np.sum([y for _, y in products], axis=0)
        if not np.any(inner):
            continue
        gain, values = nothing.added(inner, score, np.zeros((0, 3)), Run.OTHERWISE)
        if gain - price > best[0]:
            best = (gain - price, words, values)
    log_odds, words, values = best
    if words:
        size, side = 100.0 * abs(values[0]), "more" if values[0] > 0.0 else "less"
        yield CheckFinding(
            check="odd_group",
            severity="warning",
            message=(
                f"{channel} {words} reads {size:.1f} % {side} than the other runs say, and "
                f"{100.0 * values[1]:+.1f} % of the rms force beside ({odds(log_odds)})."
            ),
            runs=tuple(sorted(groups[words])),
            remedy=(
                "Look at what was changed between them and the others: gauge, zero, model, speed. "
                "Correct or exclude them in the campaign file with the reason."
            ),
            numbers={"gain": float(values[0]), "offset": float(values[1]), "log_odds": log_odds},
            channels=(channel,),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Whitened:
    """What any group may read otherwise in the rows of one fit, beside what the fit has.

    `ids (n,)`: run of each row. `columns (n, 3)`: gain, offset, slope in the drift. `design (n,
    p)`: of the derivatives. `rest (n,)`: what the fit leaves. `gain (p, n)`: rows to derivatives.
    """

    ids: NDArray[np.object_]
    columns: Array
    design: Array
    rest: Array
    gain: Array

    @classmethod
    def of(cls, item: ChannelFit, runs: Sequence[Run], steepest: float) -> _Whitened:
        """Of the runs of a fit."""
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
        return cls(
            ids=np.array(ids, object),
            columns=whole[:, :3],
            rest=whole[:, 3],
            design=whole[:, 4:],
            gain=item.fit.gain,
        )

    def products(self, members: frozenset[str]) -> tuple[Array, Array]:
        """Products of the columns of a group, without what the derivatives take, and its score."""
        inside = np.isin(self.ids, list(members))
        if inside.all() or not inside.any():
            return np.zeros((3, 3)), np.zeros(3)
        own = self.columns * inside[:, None]
        left = own - self.design @ (self.gain @ own)
        return left.T @ left, left.T @ self.rest
