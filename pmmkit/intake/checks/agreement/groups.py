"""Groups of runs that disagree with the others, as far as usual hulls and a polynomial tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag

from pmmkit.campaigns import Run
from pmmkit.intake.checks.agreement.posterior import Agreement
from pmmkit.intake.checks.agreement.rows import CHANNELS
from pmmkit.intake.checks.disagreement import Disagreement
from pmmkit.intake.checks.finding import CheckFinding
from pmmkit.numerics import Array

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign


def groups_apart(
    campaign: Campaign, found: Sequence[Agreement], scatter: float
) -> Iterator[CheckFinding]:
    """The group of each channel that reads otherwise than a polynomial through all runs says.

    Channels whose runs scatter by more than is usual, `scatter` of it, are not asked: what the
    polynomial lacks would look like a group. Of 70 sound campaigns of the virtual tank the best
    group comes to ln odds of -4; it is told from 3 on. Of fifteen faults of groups three are with
    48 runs, one with 13. Of 51 effects and faults of all runs at full size 13 come so far, for
    memory and the like are no polynomial either.
    """
    if not found:
        return
    runs = [item.run for own in found for item in own.group.summaries]
    day = dict(zip((run.id for run in campaign.runs), campaign.places_in_day, strict=True))
    groups = Run.groups(runs, [day[run.id] for run in runs])
    asked = [c for c in range(len(CHANNELS)) if all(own.excess[c] <= scatter for own in found)]
    price = Disagreement.price(len(groups), len(CHANNELS))
    for item in Disagreement.told(x for c in asked for x in _of_channel(c, found, groups, price)):
        said = item.finding
        yield replace(
            said,
            check="agreement",
            remedy=f"{said.remedy} A hull whose forces hang on what was before does so too: "
            f"pmmkit diagnose tells the two apart.",
        )


def _of_channel(
    c: int, found: Sequence[Agreement], groups: Mapping[str, frozenset[str]], price: float
) -> Iterator[Disagreement]:
    """The groups of a channel, beside the derivatives that hulls may have at each speed."""
    ids, rows, beside = zip(*(_rows(own, c) for own in found), strict=True)
    every = np.concatenate(rows)
    left = Disagreement.spread_by(block_diag(*beside))
    yield from Disagreement.among(
        CHANNELS[c],
        groups,
        np.concatenate(ids).astype(object),
        every[:, :3],
        left(every[:, 3:])[:, 0],
        price=price,
        left=left,
    )


def _rows(found: Agreement, c: int) -> tuple[Array, Array, Array]:
    """The run of each row of a speed (n,); what a group may read otherwise and what usual hulls
    leave (n, 4); and by what hulls differ (n, p): all over the usual scatter."""
    group, white, usual = found.group, found.white, found.group.usual
    runs = [item.run for item in group.summaries]
    steepest = max(abs(run.settings.drift) for run in runs) or 1.0
    design = group.design(group.histories())[:, c]
    read = np.zeros((*design.shape[:2], 3))
    read[:, :, 0] = design @ found.value
    read[:, 0, 1] = group.level[c]
    read[:, 0, 2] = [group.level[c] * run.settings.drift / steepest for run in runs]
    rest = white.rows[:, c] - white.design[:, c] @ usual.mean
    whole = np.concatenate(
        [
            white.whitener[:, c] @ read,
            rest[:, :, None],
            white.design[:, c] @ np.linalg.cholesky(usual.covariance),
        ],
        axis=2,
    )
    known = group.known[:, c].ravel()
    rows = whole.reshape(len(known), -1)[known] / np.sqrt(found.excess[c])
    ids = np.repeat([run.id for run in runs], design.shape[1])[known]
    return ids, rows[:, :4], rows[:, 4:]
