"""What a sea trial gives, in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from pmmkit.campaigns.test_kinds.free_running import STOPPING, TURNING, ZIGZAG
from pmmkit.metrics import unit_of
from pmmkit.presentation import aligned
from pmmkit.trials.table import Trial

SHOWN: Final = {
    TURNING.name: (
        "advance",
        "transfer",
        "tactical_diameter",
        "steady_diameter",
        "speed_loss",
        "time_90",
        "time_180",
    ),
    ZIGZAG.name: (
        "overshoot_1_deg",
        "overshoot_2_deg",
        "overshoot_3_deg",
        "time_execute_2",
        "time_execute_3",
        "reach",
        "period",
        "initial_turning_distance",
    ),
    STOPPING.name: ("head_reach", "track_reach", "lateral_deviation", "time_to_stop"),
}
"""Measures in the text, by test; the files hold all."""


def trial_lines(item: Trial) -> list[str]:
    """A trial for people: approach, current, wind, measures beside their limits, notes."""
    rudder = "" if item.test == STOPPING.name else f", rudder {item.rudder_deg:+.1f}°"
    std = f" ± {item.speed_std:.2f}" if math.isfinite(item.speed_std) else ""
    lines = [
        f"{item.run}: {item.test}{rudder}, approach {item.speed:.2f}{std} m/s on "
        f"{item.heading_deg:05.1f}°, order at t = {item.order:.1f} s"
    ]
    if item.current is not None:
        lines.append(
            f"Current {item.current.speed:.3f} ± {item.current.speed_std:.3f} m/s to "
            f"{item.current.direction_deg:03.0f}° ({item.current.origin})"
        )
    if item.wind is not None:
        lines.append(f"Wind {item.wind}")
    limits = {row["measure"]: row for row in item.rows()}
    rows = [
        [*_cells(name, item), *_limit(limits.get(f"{name}_L", limits[name]))]
        for name in SHOWN.get(item.test, ())
        if name in item.metrics
    ]
    lines.append(aligned(["measure", "value", "std", "in L", "limit", ""], rows))
    return [*lines, *item.notes]


def _cells(name: str, item: Trial) -> list[str]:
    value, std, unit = item.metrics[name], item.std[name], unit_of(name)
    digits = 3 if unit == "-" else 1
    shown = "°" if unit == "deg" else "" if unit == "-" else f" {unit}"
    label = name.removesuffix("_deg").replace("_", " ")
    if not math.isfinite(value):
        return [label, "-", "-", "-"]
    length = item.metrics.get(f"{name}_L")
    return [
        label,
        f"{value:.{digits}f}{shown}",
        f"{std:.{digits}f}{shown}",
        "" if length is None else f"{length:.2f} L",
    ]


def _limit(row: Mapping[str, Any]) -> list[str]:
    if not math.isfinite(row["limit"]):
        return ["", ""]
    unit = " L" if row["unit"] == "L" else "°"
    word = {True: "met", False: "NOT met", None: "not judged"}[row["passed"]]
    return [f"{row['limit']:.4g}{unit}", word]
