"""The zeros of the gauges from run to run, in the order of the day."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.conventions import CHANNEL_UNITS, CHANNELS
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, straight_line
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.summary import Summary

FEWEST: Final = 3
"""Records from which a change over the day is told."""
NOISES: Final = 3.0
"""Standard uncertainties of a zero that the zeros must scatter by."""
SHARE: Final = 2e-3
"""Share of a channel's usual force below which their range is of no interest."""
LINE: Final = 3.0
"""Standard errors of its slope from which a straight line is told."""


@dataclass(frozen=True, kw_only=True)
class _Zeros:
    """What one gauge shows at rest: places in the day, values and standard uncertainties."""

    channel: str
    day: Array
    value: Array
    std: Array
    size: float

    @property
    def drifts(self) -> bool:
        """Whether they change by more than each of them is uncertain."""
        noise = float(np.median(self.std))
        spread = float(np.std(self.value, ddof=1))
        return spread > NOISES * noise and float(np.ptp(self.value)) > SHARE * self.size

    def words(self) -> str:
        """How they change, in words."""
        unit = CHANNEL_UNITS[self.channel]
        low, high = figure(float(self.value.min())), figure(float(self.value.max()))
        told = f"{self.channel} {low} to {high} {unit}"
        slope, _, error = straight_line(self.day, self.value)
        if self.drifts and abs(slope) > LINE * error:
            told += (
                f" ({figure(slope)} ± {figure(WIDE * error, 2)} {unit} from the first run to the "
                "last)"
            )
        if self.drifts and self.size > 0:
            told += f", {100 * float(np.ptp(self.value)) / self.size:.2g} % of its usual force"
        return told


def examine_zeros(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Zeros that change over the day; where they are taken off, what was taken.

    They change if they scatter by three times the uncertainty of each, and by more than 0.2 % of
    the usual force.
    """
    runs = [item.run for item in summaries]
    day = campaign.with_(runs=tuple(runs)).places_in_day
    places = dict(zip((run.id for run in runs), day, strict=True))
    seen = [item for item in summaries if any(f"{name}_zero" in item.facts for name in CHANNELS)]
    seen.sort(key=lambda item: places[item.run.id])
    if len(seen) < FEWEST:
        return
    tared = all(item.facts.get("tared") for item in seen)
    found = [zeros for name in CHANNELS if (zeros := _of(name, seen, places)) is not None]
    changing = [zeros for zeros in found if zeros.drifts]
    if not changing and not tared:
        return
    order = (
        "by the times at which they started"
        if all(run.started for run in runs)
        else "as the campaign file has them"
    )
    head = f"The zeros of the gauges at rest in {len(seen)} of {len(summaries)} records"
    told = "; ".join(zeros.words() for zeros in (changing or found))
    if tared:
        change = f"change over the runs, {order}" if changing else "stay where they are"
        message = f"{head} {change}: {told}. They are taken off each record."
    else:
        message = (
            f"{head} change over the runs, {order}: {told}. No zero that is the same for all runs "
            "takes that off."
        )
    yield CheckFinding(
        check="zeros",
        severity="info" if tared else "warning",
        message=message,
        runs=tuple(item.run.id for item in seen),
        remedy="" if tared else "Take it off record by record: tare = true under [defaults].",
        numbers={f"{x.channel}_range": float(np.ptp(x.value)) for x in changing},
        by_run={
            item.run.id: {
                "day": places[item.run.id],
                **{
                    key: item.facts[f"{zeros.channel}_{kind}"]
                    for zeros in found
                    for key, kind in ((zeros.channel, "zero"), (f"{zeros.channel}_std", "zero_std"))
                    if f"{zeros.channel}_{kind}" in item.facts
                },
            }
            for item in seen
        },
    )


def _of(name: str, seen: Sequence[Summary], places: dict[str, float]) -> _Zeros | None:
    own = [item for item in seen if f"{name}_zero" in item.facts]
    if len(own) < FEWEST:
        return None
    sizes = [item.facts[f"{name}_size"] for item in own if f"{name}_size" in item.facts]
    return _Zeros(
        channel=name,
        day=np.array([places[item.run.id] for item in own]),
        value=np.array([item.facts[f"{name}_zero"] for item in own]),
        std=np.array([item.facts[f"{name}_zero_std"] for item in own]),
        size=float(np.median(sizes)) if sizes and math.isfinite(sizes[0]) else 0.0,
    )


CHECKS = (Check("zeros", "zeros of the gauges that change over the day", examine_zeros),)
