"""Orders by the clock: a straight run with the rudder amidships, and a weave."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from pmmkit.conventions import METRICS
from pmmkit.equations import Ask, Phase, Plan, Probe, ProbeResults
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting, degrees, rudder_setting

LENGTHS: Final = 20.0
"""Ship lengths of a straight run."""
PERIOD: Final = 8.0
"""Usual period of a weave in ship lengths over the speed."""


def straight(pace: float, *, duration: float | None) -> Plan:
    """Straight run: rudder amidships, and nothing holds the course."""
    return _timed([0.0], LENGTHS / pace if duration is None else duration)


def weave(pace: float, *, rudder_deg: float, period: float | None, cycles: int) -> Plan:
    """Weave: the rudder is laid over by the clock, whatever the heading; a quarter of a period to
    the first side, so that the ship weaves about her course."""
    half = 0.5 * (PERIOD / pace if period is None else period)
    rudder = math.radians(rudder_deg)
    sides = [(-1.0) ** i * rudder for i in range(2 * cycles + 1)]
    return _timed(sides, half, first=0.5 * half)


def _timed(rudders: list[float], seconds: float, first: float | None = None) -> Plan:
    lengths = [seconds] * len(rudders)
    if first is not None:
        lengths[0] = first
    last = len(rudders) - 1

    def measure(a: ProbeResults) -> dict[str, Any]:
        return {
            "lateral_deviation": a.at("end", "y"),
            "heading_end_deg": degrees(a.at("end", "psi")),
            "final_speed": a.at("end", "u"),
        }

    return Plan(
        phases=tuple(
            Phase(rudder=rudder, longest=length)
            for rudder, length in zip(rudders, lengths, strict=True)
        ),
        probes={"end": Probe(ask=Ask.end, first=last, last=last)},
        measure=measure,
        rudder=rudders[0],
    )


_METRICS: Final = (
    *METRICS.named("lateral_deviation", "final_speed"),
    *(replace(item, starboard=True) for item in METRICS.named("heading_end_deg")),
)
MANOEUVRES: Final = (
    Manoeuvre(
        name="straight",
        title="straight run, rudder amidships",
        settings=(
            Setting(name="duration", text="length of the run; 20 ship lengths if absent", unit="s"),
        ),
        orders=straight,
        metrics=_METRICS,
    ),
    Manoeuvre(
        name="weave",
        title="weave: rudder laid over by the clock",
        settings=(
            rudder_setting(15.0),
            Setting(name="period", text="of the rudder; 8 ship lengths if absent", unit="s"),
            Setting(name="cycles", text="periods", unit="-", default=3, whole=True),
        ),
        orders=weave,
        metrics=_METRICS,
    ),
)
