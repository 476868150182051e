"""The manoeuvres, each a function that makes its plan."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.equations.layouts import Ask, End, State
from pmmkit.errors import DataError
from pmmkit.simulation.plan import Answers, Phase, Plan, Probe
from pmmkit.simulation.scalars import arctan2, chosen, cos, degrees, hypot, larger

HALF: Final = math.pi / 2
CIRCLES: Final = 3 * math.pi
"""A turning circle ends after this change of heading (540°) when it is steady then."""
LONGEST: Final = 2000.0
"""No phase lasts longer, in ship lengths over the approach speed."""
STEADY: Final = 2e-5
"""Accelerations over U²/L and (U/L)² below which a motion counts as steady."""


def turning(
    pace: float, *, rudder_deg: float = 35.0, duration: float | None = None, wind: bool = False
) -> Plan:
    """Turning circle: one order, until 540° of heading and the turn is steady."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    longest = LONGEST / pace if duration is None else duration
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

    def measure(a: Answers) -> dict[str, Any]:
        u, v = a.at("steady", "u"), a.at("steady", "v")
        rolls = "phi" in a.states
        upright = cos(a.at("steady", "phi")) if rolls else 1.0
        turn = side * a.at("steady", "r") * upright
        found = _lengths(
            a.L,
            advance=a.at("quarter", "x"),
            transfer=side * a.at("quarter", "y"),
            tactical_diameter=side * a.at("half", "y"),
            steady_diameter=2.0 * hypot(u, v * upright) / _positive(turn),
        )
        found |= {
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
        name="turning",
        phases=(phase,),
        probes=probes,
        measure=measure,
        rudder=rudder,
        settles=duration is None and not wind,
    )


def initial_turning(pace: float, *, rudder_deg: float = 10.0, heading_deg: float = 10.0) -> Plan:
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

    def measure(a: Answers) -> dict[str, Any]:
        reached = a.t("there")
        found = _lengths(a.L, initial_turning_distance=chosen(reached > 0, a.t("path"), math.nan))
        return found | {
            "time_to_heading": reached,
            "yaw_rate_deg_s": side * degrees(a.at("there", "r")),
        }

    probes = {"there": Probe(ask=Ask.reached), "path": Probe(ask=Ask.path)}
    return Plan(
        name="initial_turning", phases=(phase,), probes=probes, measure=measure, rudder=rudder
    )


def zigzag(
    pace: float, *, rudder_deg: float = 10.0, switch_deg: float = 10.0, executes: int = 5
) -> Plan:
    """Zigzag δ/ψ: the rudder is laid over each time the heading passes ±ψ."""
    if executes < 2:
        raise DataError(f"A zigzag has at least two executes; {executes} were asked for.")
    rudder, switch = math.radians(rudder_deg), math.radians(switch_deg)
    first = math.copysign(1.0, rudder)
    sides = [first * (-1.0) ** i for i in range(int(executes))]
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

    def measure(a: Answers) -> dict[str, Any]:
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

    return Plan(name="zigzag", phases=tuple(phases), probes=probes, measure=measure, rudder=rudder)


def pull_out(pace: float, *, rudder_deg: float = 15.0) -> Plan:
    """Pull-out: a steady turn, then rudder amidships; a stable ship stops turning."""
    rudder = math.radians(rudder_deg)
    side = math.copysign(1.0, rudder)
    phases = (
        Phase(
            rudder=rudder, until=End.steady, level=STEADY, shortest=5.0 / pace, longest=100.0 / pace
        ),
        Phase(
            rudder=0.0, until=End.steady, level=STEADY, shortest=10.0 / pace, longest=150.0 / pace
        ),
    )
    probes = {
        "turn": Probe(ask=Ask.end, first=0, last=0),
        "end": Probe(ask=Ask.end, first=1, last=1),
    }

    def measure(a: Answers) -> dict[str, Any]:
        return {
            "steady_yaw_rate_deg_s": side * degrees(a.at("turn", "r")),
            "residual_yaw_rate_deg_s": side * degrees(a.at("end", "r")),
            "residual_share": a.at("end", "r") / a.at("turn", "r"),
            "time_turn": a.t("turn"),
            "time_end": a.t("end"),
        }

    return Plan(name="pull_out", phases=phases, probes=probes, measure=measure, rudder=rudder)


def spiral(pace: float, *, rudder_deg: float = 20.0, step_deg: float = 2.5) -> Plan:
    """Direct spiral: rudder angles from one side to the other and back, each until steady."""
    if not 0.0 < step_deg <= abs(rudder_deg):
        raise DataError(f"step_deg = {step_deg} must lie between 0 and {abs(rudder_deg):g}.")
    steps = max(round(abs(rudder_deg) / step_deg), 1)
    side = math.copysign(1.0, rudder_deg)
    down = [side * i * step_deg for i in range(steps, -steps - 1, -1)]
    angles = [*down, *reversed(down[:-1])]
    phases = tuple(
        Phase(
            rudder=math.radians(angle),
            until=End.steady,
            level=STEADY,
            shortest=5.0 / pace,
            longest=200.0 / pace,
        )
        for angle in angles
    )
    probes = {f"end_{i}": Probe(ask=Ask.end, first=i, last=i) for i in range(len(angles))}
    back = {angle: len(angles) - 1 - i for i, angle in enumerate(down)}

    def measure(a: Answers) -> dict[str, Any]:
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

    return Plan(
        name="spiral",
        phases=phases,
        probes=probes,
        measure=measure,
        rudder=math.radians(rudder_deg),
    )


def accelerating(pace: float, *, turns: float = 1.5) -> Plan:
    """Accelerating: more revolutions straight ahead until the speed stays."""
    phases = (
        Phase(turns=turns, until=End.steady, level=1e-5, shortest=2.0 / pace, longest=500.0 / pace),
    )

    def measure(a: Answers) -> dict[str, Any]:
        found = _lengths(a.L, distance=a.at("end", "x"))
        return {
            "final_speed": a.at("end", "u"),
            "speed_ratio": a.at("end", "u") / a.speed,
            "time": a.t("end"),
        } | found

    return Plan(
        name="accelerating", phases=phases, probes={"end": Probe(ask=Ask.end)}, measure=measure
    )


def stopping(pace: float, *, turns: float = -0.7, rudder_deg: float = 0.0) -> Plan:
    """Crash stop: revolutions astern (and the bucket of a waterjet down) until the ship stops."""
    phases = (
        Phase(
            turns=turns,
            bucket=1.0,
            rudder=math.radians(rudder_deg),
            until=End.surge,
            level=0.0,
            side=-1.0,
            longest=500.0 / pace,
        ),
    )
    probes = {"stop": Probe(ask=Ask.reached), "path": Probe(ask=Ask.path)}

    def measure(a: Answers) -> dict[str, Any]:
        stopped = a.t("stop") > 0.0
        found = _lengths(
            a.L,
            head_reach=a.at("stop", "x"),
            track_reach=chosen(stopped, a.t("path"), math.nan),
            lateral_deviation=a.at("stop", "y"),
        )
        return found | {
            "time_to_stop": a.t("stop"),
            "heading_at_stop_deg": degrees(a.at("stop", "psi")),
        }

    return Plan(name="stopping", phases=phases, probes=probes, measure=measure)


def course_change(
    pace: float,
    *,
    rudder_deg: float = 15.0,
    heading_deg: float = 45.0,
    counter_deg: float | None = None,
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
            longest=LONGEST / pace,
        ),
        Phase(
            rudder=-side * counter, until=End.yaw_rate, level=0.0, side=-side, longest=100.0 / pace
        ),
    )
    probes = {
        "counter": Probe(ask=Ask.begin, first=1, last=1),
        "end": Probe(ask=Ask.reached, first=1, last=1),
    }

    def measure(a: Answers) -> dict[str, Any]:
        found = _lengths(a.L, advance=a.at("end", "x"), transfer=side * a.at("end", "y"))
        return found | {
            "time_counter": a.t("counter"),
            "time_end": a.t("end"),
            "heading_end_deg": side * degrees(a.at("end", "psi")),
            "overshoot_deg": side * degrees(a.at("end", "psi")) - abs(heading_deg),
        }

    return Plan(name="course_change", phases=phases, probes=probes, measure=measure, rudder=rudder)


def williamson(
    pace: float, *, rudder_deg: float = 35.0, shift_deg: float = 60.0, ease_deg: float = 20.0
) -> Plan:
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
            longest=LONGEST / pace,
        ),
        Phase(
            rudder=-rudder,
            until=End.heading,
            level=-side * opposite,
            side=-side,
            longest=LONGEST / pace,
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

    def measure(a: Answers) -> dict[str, Any]:
        found = _lengths(a.L, offset=side * a.at("end", "y"), advance=a.at("end", "x"))
        return found | {
            "time_shift": a.t("shift"),
            "time_ease": a.t("ease"),
            "time_end": a.t("end"),
            "heading_end_deg": degrees(a.at("end", "psi")),
        }

    return Plan(name="williamson", phases=phases, probes=probes, measure=measure, rudder=rudder)


MANOEUVRES: Final[Mapping[str, Callable[..., Plan]]] = MappingProxyType(
    {
        function.__name__: function
        for function in (
            turning,
            initial_turning,
            zigzag,
            spiral,
            pull_out,
            stopping,
            accelerating,
            course_change,
            williamson,
        )
    }
)


def _lengths(L: float, **values: Any) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in values.items():
        found |= {name: value, f"{name}_L": value / L}
    return found


def _positive(rate: Any) -> Any:
    """A yaw rate; infinitely small where the ship turns the other way."""
    return larger(rate, 1e-300)
