"""Stopping and accelerating."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

from pmmkit.conventions import METRICS
from pmmkit.equations import Ask, End, Phase, Plan, Probe, ProbeResults
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting, chosen, degrees, rudder_setting

TURNS: Final = Setting(
    name="turns",
    text="revolutions over those of the approach, negative astern",
    unit="-",
    takes="any",
)
PUMPS: Final = "of pumps whose thrust a bucket turns the size counts"


def stopping(
    pace: float,
    *,
    turns: float,
    rudder_deg: float,
    reversal_s: float | None = None,
    bucket: bool = False,
) -> Plan:
    """Crash stop: revolutions astern, or the bucket of a waterjet down, until the ship stops."""
    ordered = abs(turns) if bucket else turns
    phases = (
        Phase(
            revolutions=ordered,
            bucket=1.0,
            rudder=math.radians(rudder_deg),
            until=End.surge,
            level=0.0,
            side=-1.0,
            longest=500.0 / pace,
        ),
    )
    probes = {"stop": Probe(ask=Ask.reached), "path": Probe(ask=Ask.path)}

    def measure(a: ProbeResults) -> dict[str, Any]:
        stopped = a.t("stop") > 0.0
        return {
            "head_reach": a.at("stop", "x"),
            "track_reach": chosen(stopped, a.t("path"), math.nan),
            "lateral_deviation": a.at("stop", "y"),
            "time_to_stop": a.t("stop"),
            "heading_at_stop_deg": degrees(a.at("stop", "psi")),
        }

    plan = Plan(phases=phases, probes=probes, measure=measure)
    return _reversed_in(reversal_s, plan, abs(1.0 - ordered))


def astern_to_ahead(
    pace: float,
    *,
    astern: float,
    turns: float,
    share: float,
    speed: float,
    reversal_s: float | None = None,
    bucket: bool = False,
) -> Plan:
    """Astern to ahead: from steady speed astern to a share of the approach speed ahead."""
    backing = astern if bucket else -astern
    phases = (
        Phase(
            revolutions=backing,
            bucket=1.0,
            until=End.steady,
            level=1e-5,
            shortest=2.0 / pace,
            longest=500.0 / pace,
        ),
        Phase(revolutions=turns, bucket=0.0, until=End.surge, level=0.0, longest=500.0 / pace),
        Phase(until=End.surge, level=share * speed, longest=500.0 / pace),
    )
    probes = {
        "order": Probe(ask=Ask.begin, first=1, last=1),
        "stop": Probe(ask=Ask.reached, first=1, last=1),
        "speed": Probe(ask=Ask.reached, first=2, last=2),
    }

    def measure(a: ProbeResults) -> dict[str, Any]:
        return {
            "astern_speed": -a.at("order", "u"),
            "time_to_stop": a.t("stop") - a.t("order"),
            "astern_reach": a.at("order", "x") - a.at("stop", "x"),
            "time_to_speed": a.t("speed") - a.t("order"),
            "way_ahead": a.at("speed", "x") - a.at("stop", "x"),
        }

    plan = Plan(phases=phases, probes=probes, measure=measure)
    return _reversed_in(reversal_s, plan, abs(turns - backing))


def _reversed_in(time: float | None, plan: Plan, change: float) -> Plan:
    """The plan with the revolutions changed, and the bucket moved, in a time that is stated."""
    if time is None:
        return plan
    return replace(plan, revolutions_rate=change / time or None, bucket_rate=1.0 / time)


def accelerating(pace: float, *, turns: float) -> Plan:
    """Accelerating: more revolutions straight ahead until the speed stays."""
    phases = (
        Phase(
            revolutions=turns,
            until=End.steady,
            level=1e-5,
            shortest=2.0 / pace,
            longest=500.0 / pace,
        ),
    )

    def measure(a: ProbeResults) -> dict[str, Any]:
        return {
            "final_speed": a.at("end", "u"),
            "speed_ratio": a.at("end", "u") / a.speed,
            "time": a.t("end"),
            "distance": a.at("end", "x"),
        }

    return Plan(phases=phases, probes={"end": Probe(ask=Ask.end)}, measure=measure)


MANOEUVRES: Final = (
    Manoeuvre(
        name="stopping",
        title="crash stop",
        settings=(
            replace(TURNS, default=-0.7, text=f"{TURNS.text}; {PUMPS}", std=0.08),
            replace(rudder_setting(0.0), takes="angle"),
            Setting(
                name="reversal_s",
                text="time until the revolutions astern are reached, whatever the engine, and the "
                "bucket is down; if absent, the engine of the model decides, or one that is "
                "assumed, and the bucket goes down in two ship lengths over the speed",
                unit="s",
            ),
            Setting(
                name="torque",
                text="largest torque astern over that of the approach; if absent, the engine's",
                unit="-",
                engine=True,
            ),
        ),
        orders=stopping,
        metrics=METRICS.named(
            "head_reach", "track_reach", "lateral_deviation", "time_to_stop", "heading_at_stop_deg"
        ),
        asks_for_bucket=True,
        reverses=True,
    ),
    Manoeuvre(
        name="accelerating",
        title="accelerating straight ahead",
        settings=(replace(TURNS, default=1.5),),
        orders=accelerating,
        metrics=METRICS.named("final_speed", "speed_ratio", "time", "distance"),
    ),
    Manoeuvre(
        name="astern_to_ahead",
        title="astern to ahead, held straight",
        settings=(
            Setting(
                name="astern",
                text="revolutions of the run astern, their size over those of the approach",
                unit="-",
                default=0.7,
            ),
            Setting(
                name="turns",
                text="revolutions ahead over those of the approach",
                unit="-",
                default=1.0,
            ),
            Setting(
                name="share",
                text="speed to be reached over that of the approach",
                unit="-",
                default=0.9,
            ),
            Setting(
                name="reversal_s",
                text="time from the one to the other, and until the bucket is up; if absent, "
                "revolutions change by those of the approach in two ship lengths over the speed, "
                "and the bucket goes up in that time",
                unit="s",
            ),
        ),
        orders=astern_to_ahead,
        metrics=METRICS.named(
            "astern_speed", "time_to_stop", "astern_reach", "time_to_speed", "way_ahead"
        ),
        asks_for_bucket=True,
        asks_for_speed=True,
        held_straight=True,
    ),
)
