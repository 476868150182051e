"""Turning circle, and initial turning."""

from __future__ import annotations

import math
from typing import Any, Final

from pmmkit.conventions import METRICS, Metric
from pmmkit.equations import Ask, End, Phase, Plan, Probe, ProbeResults, State
from pmmkit.simulation.kinds.manoeuvre import (
    Manoeuvre,
    Setting,
    arctan2,
    chosen,
    cos,
    degrees,
    hypot,
    larger,
    rudder_setting,
)

HALF: Final = math.pi / 2
CIRCLES: Final = 3 * math.pi
"""A turning circle ends after this change of heading (540°) when it is steady then."""

WIDEST: Final = 1000.0
"""Steady diameter in ship lengths from which a ship does not turn: one such circle takes three
thousand lengths, ten times as far as a turn is followed."""


def turning_circle(pace: float, *, rudder_deg: float, duration: float | None, wind: bool) -> Plan:
    """Turning circle: one order, until 540° of heading and the turn is steady."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    longest = Phase.LONGEST / pace if duration is None else duration
    phase = Phase(
        rudder=rudder,
        until=End.time if duration else End.heading if wind else End.steady_turn,
        level=side * CIRCLES,
        side=side,
        longest=longest,
    )
    probes = {
        "quarter": Probe(ask=Ask.crossing, state=State.psi, level=side * HALF, side=side),
        "half": Probe(ask=Ask.crossing, state=State.psi, level=side * math.pi, side=side),
        "steady": Probe(ask=Ask.steady),
        "heel_up": Probe(ask=Ask.extreme, state=State.phi, side=1.0),
        "heel_down": Probe(ask=Ask.extreme, state=State.phi, side=-1.0),
    }

    def measure(a: ProbeResults) -> dict[str, Any]:
        rolls = "phi" in a.states
        upright = cos(a.at("steady", "phi")) if rolls else 1.0
        # In the horizontal plane, as the path shows them.
        u, v = a.at("steady", "u"), a.at("steady", "v") * upright
        turn = side * a.at("steady", "r") * upright
        found = {
            "advance": a.at("quarter", "x"),
            "transfer": side * a.at("quarter", "y"),
            "tactical_diameter": side * a.at("half", "y"),
            "steady_diameter": chosen(
                turn * WIDEST * a.L > 2.0 * hypot(u, v),
                2.0 * hypot(u, v) / larger(turn, 1e-300),
                math.nan,
            ),
            "time_90": a.t("quarter"),
            "time_180": a.t("half"),
            "steady_drift_deg": side * degrees(arctan2(-v, u)),
            "speed_ratio": hypot(u, v) / a.speed,
            "steady_yaw_rate_deg_s": degrees(turn),
        }
        if rolls:
            found["heel_max_deg"] = degrees(
                larger(a.at("heel_up", "phi"), -a.at("heel_down", "phi"))
            )
            found["heel_steady_deg"] = -side * degrees(a.at("steady", "phi"))
        return found

    return Plan(
        phases=(phase,),
        probes=probes,
        measure=measure,
        rudder=rudder,
        settles=duration is None and not wind,
    )


def initial_turning(pace: float, *, rudder_deg: float, heading_deg: float) -> Plan:
    """Initial turning: the way travelled until the heading has changed by 10°."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    phase = Phase(
        rudder=rudder,
        until=End.heading,
        level=side * math.radians(heading_deg),
        side=side,
        longest=100.0 / pace,
    )

    def measure(a: ProbeResults) -> dict[str, Any]:
        reached = a.t("there")
        return {
            "initial_turning_distance": chosen(reached > 0, a.t("path"), math.nan),
            "time_to_heading": reached,
            "yaw_rate_deg_s": side * degrees(a.at("there", "r")),
        }

    probes = {"there": Probe(ask=Ask.reached), "path": Probe(ask=Ask.path)}
    return Plan(phases=(phase,), probes=probes, measure=measure, rudder=rudder)


TURNING_CIRCLE: Final = Manoeuvre(
    name="turning",
    title="turning circle",
    settings=(
        rudder_setting(35.0),
        Setting(name="duration", text="length of the turn; until it is steady if absent", unit="s"),
    ),
    orders=turning_circle,
    asks_for_wind=True,
    drawn="turning circle",
    metrics=METRICS.named(
        "advance",
        "transfer",
        "tactical_diameter",
        "steady_diameter",
        "time_90",
        "time_180",
        "steady_drift_deg",
        "speed_ratio",
        "steady_yaw_rate_deg_s",
        "heel_max_deg",
        "heel_steady_deg",
    ),
)
MANOEUVRES: Final = (
    TURNING_CIRCLE,
    Manoeuvre(
        name="initial_turning",
        title="initial turning",
        settings=(
            rudder_setting(10.0),
            Setting(name="heading_deg", text="change of heading", unit="deg", default=10.0),
        ),
        orders=initial_turning,
        metrics=METRICS.named("initial_turning_distance", "time_to_heading", "yaw_rate_deg_s"),
    ),
)
LENGTHS: Final = tuple(
    metric.name + Metric.IN_LENGTHS for metric in TURNING_CIRCLE.metrics if metric.length
)
"""The measures of a turning circle in ship lengths."""
