"""Tests far from straight ahead, which tables and a diagnosis leave out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pmmkit.campaigns import Run
from pmmkit.intake.checks.finding import Check, CheckFinding
from pmmkit.presentation import counted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary


def examine_reach(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Steady runs across the flow, and rows that are no runs."""
    far = tuple(item.run.id for item in summaries if item.run.across_the_flow)
    if far:
        yield CheckFinding(
            check="reach",
            severity="info",
            message=f"The drift is above {math.degrees(Run.FARTHEST):.0f}°, where the flow goes "
            f"across the hull: derivatives and diagnosis leave these runs out.",
            runs=far,
            remedy="A model with cross-flow drag is compared with them.",
            numbers={"runs": float(len(far))},
        )
    reasons: dict[str, list[str]] = {}
    for row, reason in campaign.provenance.get("left_out", {}).items():
        reasons.setdefault(reason, []).append(row)
    for reason, rows in reasons.items():
        yield CheckFinding(
            check="reach",
            severity="info",
            message=f"{counted(len(rows), 'row')} left out, {reason}: "
            f"{' to '.join(dict.fromkeys((rows[0], rows[-1])))}.",
            numbers={"rows": float(len(rows))},
        )


CHECKS = (
    Check(
        "reach",
        "steady runs at a drift above 45°, which derivatives leave out; rows that are no runs",
        examine_reach,
    ),
)
