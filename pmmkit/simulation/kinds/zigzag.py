"""Zigzag."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.conventions import METRICS
from pmmkit.equations import Ask, End, Phase, Plan, Probe, ProbeResults, State
from pmmkit.simulation.kinds.manoeuvre import (
    Manoeuvre,
    Setting,
    chosen,
    degrees,
    hypot,
    rudder_setting,
)


def zigzag(pace: float, *, rudder_deg: float, switch_deg: float, executes: int) -> Plan:
    """Zigzag δ/ψ: the rudder is laid over each time the heading passes ±ψ."""
    if executes < 2:
        raise DataError(f"A zigzag has at least two executes; {executes} were asked for.")
    rudder, switch = math.radians(rudder_deg), math.radians(switch_deg)
    first = math.copysign(1.0, rudder)
    sides = [first * (-1.0) ** i for i in range(executes)]
    longest = 200.0 / pace
    phases = [
        Phase(
            rudder=side * abs(rudder),
            until=End.heading,
            level=side * switch,
            side=side,
            longest=longest,
        )
        for side in sides[:-1]
    ]
    phases.append(
        Phase(
            rudder=sides[-1] * abs(rudder),
            until=End.yaw_rate,
            level=0.0,
            side=sides[-1],
            longest=longest,
        )
    )
    probes: dict[str, Probe] = {}
    for i in range(1, executes):
        probes[f"execute_{i + 1}"] = Probe(ask=Ask.begin, first=i, last=i)
        probes[f"peak_{i}"] = Probe(
            ask=Ask.extreme, state=State.psi, side=sides[i - 1], first=i, last=i
        )
        probes[f"turned_{i}"] = Probe(ask=Ask.reached, first=i, last=i)
        probes[f"zero_{i}"] = Probe(
            ask=Ask.crossing, state=State.psi, side=sides[i], first=i, last=min(i + 1, executes - 1)
        )

    def measure(a: ProbeResults) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for i in range(1, executes):
            over = sides[i - 1] * a.at(f"peak_{i}", "psi") - switch
            found[f"overshoot_{i}_deg"] = degrees(chosen(a.t(f"turned_{i}") > 0.0, over, math.nan))
        for i in range(1, executes):
            found[f"time_execute_{i + 1}"] = a.t(f"execute_{i + 1}")
        found["reach"] = a.t("zero_1")
        if executes > 3:
            found["period"] = a.t("zero_3") - a.t("zero_1")
        found["initial_turning_time"] = a.t("execute_2")
        found["speed_ratio_end"] = (
            hypot(a.at(f"peak_{executes - 1}", "u"), a.at(f"peak_{executes - 1}", "v")) / a.speed
        )
        return found

    return Plan(phases=tuple(phases), probes=probes, measure=measure, rudder=rudder)


ZIGZAG: Final = Manoeuvre(
    name="zigzag",
    title="zigzag",
    settings=(
        rudder_setting(10.0),
        Setting(
            name="switch_deg",
            text="heading at which the rudder is laid over",
            unit="deg",
            default=10.0,
        ),
        Setting(name="executes", text="orders in all", unit="-", default=5, whole=True),
    ),
    orders=zigzag,
    drawn="zigzag",
    metrics=METRICS.named(
        "overshoot_{}_deg",
        "time_execute_{}",
        "reach",
        "period",
        "initial_turning_time",
        "speed_ratio_end",
    ),
)
MANOEUVRES: Final = (ZIGZAG,)


def executed_at(headings_deg: Sequence[float]) -> Manoeuvre:
    """A zigzag whose rudder is laid over at headings of its own, as a helmsman did.

    Parameters
    ----------
    headings_deg : sequence of float
        Heading of each execute after the first, to the side that the ship turns to [deg]; of those
        that follow it is ``switch_deg``.

    Returns
    -------
    Manoeuvre
        Overshoots count from these headings.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> from pmmkit.simulation.single import simulate
    >>> ship = load_model("kvlcc2-l7")
    >>> late = simulate(ship, executed_at([11.0, 10.0]), speed=1.179, executes=3)
    >>> nominal = simulate(ship, "zigzag", speed=1.179, executes=3)
    >>> [round(x.metrics["time_execute_2"], 1) for x in (nominal, late)]
    [10.6, 11.2]
    """

    def orders(pace: float, *, switch_deg: float, **settings: Any) -> Plan:
        plan = zigzag(pace, switch_deg=switch_deg, **settings)
        given = [*headings_deg, *[switch_deg] * len(plan.phases)]
        phases = tuple(
            replace(phase, level=phase.side * math.radians(heading))
            if phase.until is End.heading
            else phase
            for phase, heading in zip(plan.phases, given, strict=False)
        )

        def measure(a: ProbeResults) -> dict[str, Any]:
            found = dict(plan.measure(a))
            for number, heading in enumerate(given[: len(phases) - 1], start=1):
                found[f"overshoot_{number}_deg"] += switch_deg - heading
            return found

        return replace(plan, phases=phases, measure=measure)

    return replace(ZIGZAG, orders=orders)
