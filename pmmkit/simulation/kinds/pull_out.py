"""Pull-out."""

from __future__ import annotations

import math
from typing import Any, Final

from pmmkit.conventions import METRICS
from pmmkit.equations import Ask, End, Phase, Plan, Probe, ProbeResults
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, degrees, rudder_setting


def pull_out(pace: float, *, rudder_deg: float) -> Plan:
    """Pull-out: a steady turn, then rudder amidships; a stable ship stops turning."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    phases = (
        Phase(
            rudder=rudder,
            until=End.steady,
            level=Phase.STEADY,
            shortest=5.0 / pace,
            longest=100.0 / pace,
        ),
        Phase(
            rudder=0.0,
            until=End.steady,
            level=Phase.STEADY,
            shortest=10.0 / pace,
            longest=150.0 / pace,
        ),
    )
    probes = {
        "turn": Probe(ask=Ask.end, first=0, last=0),
        "end": Probe(ask=Ask.end, first=1, last=1),
    }

    def measure(a: ProbeResults) -> dict[str, Any]:
        return {
            "steady_yaw_rate_deg_s": side * degrees(a.at("turn", "r")),
            "residual_yaw_rate_deg_s": side * degrees(a.at("end", "r")),
            "residual_share": a.at("end", "r") / a.at("turn", "r"),
            "time_turn": a.t("turn"),
            "time_end": a.t("end"),
        }

    return Plan(phases=phases, probes=probes, measure=measure, rudder=rudder)


MANOEUVRES: Final = (
    Manoeuvre(
        name="pull_out",
        title="pull-out",
        settings=(rudder_setting(15.0),),
        orders=pull_out,
        metrics=METRICS.named(
            "steady_yaw_rate_deg_s",
            "residual_yaw_rate_deg_s",
            "residual_share",
            "time_turn",
            "time_end",
        ),
    ),
)
