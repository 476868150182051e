"""Course change and Williamson turn."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from pmmkit.conventions import METRICS
from pmmkit.equations import Ask, End, Phase, Plan, Probe, ProbeResults
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting, degrees, rudder_setting


def course_change(
    pace: float, *, rudder_deg: float, heading_deg: float, counter_deg: float | None
) -> Plan:
    """Course change: rudder until the heading asked for, then as much against it until the turn
    stops."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    counter = abs(rudder) if counter_deg is None else math.radians(abs(counter_deg))
    phases = (
        Phase(
            rudder=rudder,
            until=End.heading,
            level=side * math.radians(abs(heading_deg)),
            side=side,
            longest=Phase.LONGEST / pace,
        ),
        Phase(
            rudder=-side * counter, until=End.yaw_rate, level=0.0, side=-side, longest=100.0 / pace
        ),
    )
    probes = {
        "counter": Probe(ask=Ask.begin, first=1, last=1),
        "end": Probe(ask=Ask.reached, first=1, last=1),
    }

    def measure(a: ProbeResults) -> dict[str, Any]:
        return {
            "advance": a.at("end", "x"),
            "transfer": side * a.at("end", "y"),
            "time_counter": a.t("counter"),
            "time_end": a.t("end"),
            "heading_end_deg": side * degrees(a.at("end", "psi")),
            "overshoot_deg": side * degrees(a.at("end", "psi")) - abs(heading_deg),
        }

    return Plan(phases=phases, probes=probes, measure=measure, rudder=rudder)


def williamson(pace: float, *, rudder_deg: float, shift_deg: float, ease_deg: float) -> Plan:
    """Williamson turn: hard over to 60°, hard over to the other side, amidships 20° before the
    opposite course."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    opposite = math.pi - math.radians(ease_deg)
    phases = (
        Phase(
            rudder=rudder,
            until=End.heading,
            level=side * math.radians(shift_deg),
            side=side,
            longest=Phase.LONGEST / pace,
        ),
        Phase(
            rudder=-rudder,
            until=End.heading,
            level=-side * opposite,
            side=-side,
            longest=Phase.LONGEST / pace,
        ),
        Phase(
            rudder=0.0, until=End.heading, level=-side * math.pi, side=-side, longest=30.0 / pace
        ),
    )
    probes = {
        "shift": Probe(ask=Ask.begin, first=1, last=1),
        "ease": Probe(ask=Ask.begin, first=2, last=2),
        "end": Probe(ask=Ask.end, first=2, last=2),
    }

    def measure(a: ProbeResults) -> dict[str, Any]:
        return {
            "offset": side * a.at("end", "y"),
            "advance": a.at("end", "x"),
            "time_shift": a.t("shift"),
            "time_ease": a.t("ease"),
            "time_end": a.t("end"),
            "heading_end_deg": degrees(a.at("end", "psi")),
        }

    return Plan(phases=phases, probes=probes, measure=measure, rudder=rudder)


MANOEUVRES: Final = (
    Manoeuvre(
        name="course_change",
        title="course change",
        settings=(
            rudder_setting(15.0),
            Setting(name="heading_deg", text="change of heading", unit="deg", default=45.0),
            Setting(
                name="counter_deg",
                text="counter rudder; as much as the first if absent",
                unit="deg",
            ),
        ),
        orders=course_change,
        metrics=METRICS.named(
            "advance", "transfer", "time_counter", "time_end", "heading_end_deg", "overshoot_deg"
        ),
    ),
    Manoeuvre(
        name="williamson",
        title="Williamson turn",
        settings=(
            rudder_setting(35.0),
            Setting(
                name="shift_deg",
                text="heading at which the rudder is laid over",
                unit="deg",
                default=60.0,
                below=180.0,
            ),
            Setting(
                name="ease_deg",
                text="heading before the opposite course at which the rudder is laid amidships",
                unit="deg",
                default=20.0,
                below=180.0,
            ),
        ),
        orders=williamson,
        metrics=(
            *METRICS.named("offset", "advance", "time_shift", "time_ease", "time_end"),
            *(replace(item, starboard=True) for item in METRICS.named("heading_end_deg")),
        ),
    ),
)
