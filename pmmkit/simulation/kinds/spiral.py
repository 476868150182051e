"""Direct spiral."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import METRICS
from pmmkit.equations import Ask, End, Phase, Plan, Probe, ProbeResults
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting, degrees, rudder_setting


def spiral(pace: float, *, rudder_deg: float, step_deg: float) -> Plan:
    """Direct spiral: rudder angles from one side to the other and back, each until steady."""
    if not 0.0 < step_deg <= abs(rudder_deg):
        raise DataError(
            f"step_deg = {step_deg} must lie between 0 and rudder_deg, {abs(rudder_deg):g}."
        )
    steps = max(round(abs(rudder_deg) / step_deg), 1)
    side = math.copysign(1.0, rudder_deg)
    down = [side * i * step_deg for i in range(steps, -steps - 1, -1)]
    angles = [*down, *reversed(down[:-1])]
    phases = tuple(
        Phase(
            rudder=math.radians(angle),
            until=End.steady,
            level=Phase.STEADY,
            shortest=5.0 / pace,
            longest=200.0 / pace,
        )
        for angle in angles
    )
    probes = {f"end_{i}": Probe(ask=Ask.end, first=i, last=i) for i in range(len(angles))}
    back = {angle: len(angles) - 1 - i for i, angle in enumerate(down)}

    def measure(a: ProbeResults) -> dict[str, Any]:
        found: dict[str, Any] = {}
        apart = []
        for i, angle in enumerate(down):
            there, here = a.at(f"end_{i}", "r"), a.at(f"end_{back[angle]}", "r")
            apart.append(np.abs(degrees(there - here)))
            found[f"yaw_rate_deg_s_at_{angle:+g}_first"] = degrees(there)
            found[f"yaw_rate_deg_s_at_{angle:+g}_back"] = degrees(here)
        limit = 0.02 * np.abs(degrees(a.at("end_0", "r")))
        open_at = np.stack([np.asarray(gap > limit, float) for gap in apart])
        loop = {
            "loop_height_deg_s": np.max(np.stack(apart), axis=0),
            "loop_width_deg": open_at.sum(axis=0) * step_deg,
        }
        return loop | found

    return Plan(phases=phases, probes=probes, measure=measure, rudder=math.radians(rudder_deg))


MANOEUVRES: Final = (
    Manoeuvre(
        name="spiral",
        title="direct spiral",
        settings=(
            rudder_setting(20.0),
            Setting(name="step_deg", text="step of the rudder", unit="deg", default=2.5),
        ),
        orders=spiral,
        drawn="spiral",
        metrics=METRICS.named(
            "loop_height_deg_s",
            "loop_width_deg",
            "yaw_rate_deg_s_at_{}_first",
            "yaw_rate_deg_s_at_{}_back",
        ),
    ),
)
