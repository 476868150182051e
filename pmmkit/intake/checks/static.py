"""What is left at zero drift, and how unlike the two sides are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.finding import Check, CheckFinding, figure

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

ASYMMETRIC: Final = 0.03
HYSTERESIS: Final = 0.05


def examine_sides(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Static drift to port against static drift to starboard, and repeated settings.

    Y and N should be odd in the drift angle and X even. What is not is compared with the largest
    force of the series: above 3 % it is told. Runs at the same settings that differ by more than
    5 % of the largest force are told as well (hysteresis, or a run gone wrong).
    """
    series: dict[tuple[float, float, float | None], list[Summary]] = {}
    for item in summaries:
        settings = item.run.settings
        towed = item.run.kind_of_test.measures_resistance
        if item.run.kind_of_test.upright and not towed and not settings.heel:
            key = (round(settings.speed, 3), round(settings.rudder, 4), settings.propeller_rps)
            series.setdefault(key, []).append(item)
    for group in series.values():
        yield from _mirrored(group)
        yield from _repeated(group)


def _mirrored(group: Sequence[Summary]) -> Iterator[CheckFinding]:
    sides = {round(math.degrees(item.run.settings.drift), 2): item for item in group}
    pairs = [(sides[drift], sides[-drift]) for drift in sides if drift > 0 and -drift in sides]
    if not pairs or abs(group[0].run.settings.rudder) > math.radians(0.3):
        return
    words, numbers = [], {}
    for channel, parity in (("X", -1), ("Y", 1), ("N", 1)):
        left = np.array([[one.mean(channel), other.mean(channel)] for one, other in pairs])
        largest = max(abs(item.mean(channel)) for item in group)
        if not np.all(np.isfinite(left)) or not largest:
            continue
        share = float(np.median(left[:, 0] + parity * left[:, 1])) / 2 / largest
        if abs(share) > ASYMMETRIC:
            words.append(f"{channel} by {100 * share:+.1f} %")
            numbers[channel] = share
    if words:
        yield CheckFinding(
            check="sides",
            severity="info",
            message=f"Drift to both sides differs over {len(pairs)} pairs of runs, in parts of the "
            f"largest force: {', '.join(words)} (0 for a symmetric hull and mount).",
            runs=tuple(item.run.id for pair in pairs for item in pair),
            remedy="Keep the zero offsets (Y0, N0) in the fit; a propeller or a turned model "
            "explains much of it.",
            numbers=numbers,
        )


def _repeated(group: Sequence[Summary]) -> Iterator[CheckFinding]:
    same: dict[float, list[Summary]] = {}
    for item in group:
        same.setdefault(round(item.run.settings.drift, 5), []).append(item)
    for repeats in same.values():
        for channel in ("X", "Y", "N"):
            largest = max((abs(item.mean(channel)) for item in group), default=0.0)
            values = np.array([item.mean(channel) for item in repeats])
            if len(repeats) < 2 or not largest or not np.all(np.isfinite(values)):
                continue
            share = float(np.ptp(values)) / largest
            if share > HYSTERESIS:
                yield CheckFinding(
                    check="sides",
                    severity="info",
                    message=f"{len(repeats)} runs at the same settings differ in {channel} by "
                    f"{figure(float(np.ptp(values)))}, {100 * share:.0f} % of the largest of the "
                    f"series.",
                    runs=tuple(item.run.id for item in repeats),
                    remedy="Look for hysteresis, waiting time between runs, or a wrong setting.",
                    numbers={"share": share},
                )


CHECKS = (
    Check("sides", "drift to port against starboard, and repeats that differ", examine_sides),
)
