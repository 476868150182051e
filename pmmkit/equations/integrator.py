"""Integration of a model's equations of motion: the functions that run compiled or interpreted.

`pmmkit.equations.code_generation` writes the functions of this file below the equations
of one structure into a module, where `rates` and the capital names are that structure's. They use
flat lists of floats (arrays when compiled), each other and `math`, nothing else.

Steps are those of Dormand and Prince (1980), order 5 with an error estimate of order 4 and dense
output of order 4 (Hairer, Nørsett and Wanner 1993, II.6). A kept step is ``t, h``, the states,
and four coefficients of the dense output for each. Where a control has a corner a step ends.

What stands where in the flat lists (`k` the constants, `gear`, `phases`, `settings`, `steps`,
`events`, `probes`) is said by `pmmkit.equations.layouts`, whose names are written out as
numbers there.
"""

from __future__ import annotations

import math

from pmmkit.equations.equilibrium import chord, complete, narrowed, self_propulsion, settle
from pmmkit.equations.layouts import (
    Constant,
    Control,
    CourseField,
    End,
    EventField,
    GearField,
    PhaseField,
    SettingField,
    State,
    Status,
    StepField,
)
from pmmkit.equations.stand_ins import N_AT, NS, STRIDE, TWICE, rates, vector


def control(t: float, since: float, start: float, order: float, rate: float, lag: float) -> float:
    """A steering gear in closed form: at most at its rate, with a first-order lag at the end."""
    error = order - start
    if error == 0.0:
        return order
    gone = t - since
    size = math.fabs(error)
    side = 1.0 if error >= 0.0 else -1.0
    straight = (size - rate * lag) / rate
    if straight < 0.0:
        straight = 0.0
    if gone <= straight:
        return start + side * rate * gone
    rest = size - rate * straight
    if lag <= 0.0 or rest <= 0.0:
        return order
    return order - side * rest * math.exp(-(gone - straight) / lag)


def controlled(t: float, gear: list[float], which: int) -> float:
    """One of the controls at an instant."""
    g = len(GearField) * which
    return control(
        t,
        gear[g + GearField.since],
        gear[g + GearField.start],
        gear[g + GearField.order],
        gear[g + GearField.rate],
        gear[g + GearField.lag],
    )


def corner(gear: list[float], which: int) -> float:
    """When a control leaves its constant rate; before it began if it has none."""
    g = len(GearField) * which
    straight = (
        math.fabs(gear[g + GearField.order] - gear[g + GearField.start])
        - gear[g + GearField.rate] * gear[g + GearField.lag]
    ) / gear[g + GearField.rate]
    return (
        gear[g + GearField.since] + straight if straight > 0.0 else gear[g + GearField.since] - 1.0
    )


def evaluate(t: float, y: list[float], gear: list[float], k: list[float], out: list[float]) -> None:
    """Rates of the states at an instant, with the controls of that instant."""
    rates(
        y,
        controlled(t, gear, Control.rudder),
        controlled(t, gear, Control.revolutions),
        controlled(t, gear, Control.bucket),
        k,
        out,
    )


def dense(steps: list[float], at: int, theta: float, state: int) -> float:
    """One state inside the step that begins at `at`; `theta` runs from 0 to 1."""
    a = at + len(StepField) + state
    rest = 1.0 - theta
    return steps[a] + theta * (
        steps[a + NS]
        + rest * (steps[a + 2 * NS] + theta * (steps[a + 3 * NS] + rest * steps[a + 4 * NS]))
    )


def keep(
    steps: list[float],
    at: int,
    t: float,
    h: float,
    y: list[float],
    new: list[float],
    k1: list[float],
    k3: list[float],
    k4: list[float],
    k5: list[float],
    k6: list[float],
    k7: list[float],
) -> None:
    """Write a step and the coefficients of its dense output."""
    steps[at + StepField.begin] = t
    steps[at + StepField.length] = h
    for i in range(NS):
        a = at + len(StepField) + i
        change = new[i] - y[i]
        bend = h * k1[i] - change
        steps[a] = y[i]
        steps[a + NS] = change
        steps[a + 2 * NS] = bend
        steps[a + 3 * NS] = change - h * k7[i] - bend
        steps[a + 4 * NS] = h * (
            -12715105075.0 / 11282082432.0 * k1[i]
            + 87487479700.0 / 32700410799.0 * k3[i]
            - 10690763975.0 / 1880347072.0 * k4[i]
            + 701980252875.0 / 199316789632.0 * k5[i]
            - 1453857185.0 / 822651844.0 * k6[i]
            + 69997945.0 / 29380423.0 * k7[i]
        )


def step(
    t: float,
    h: float,
    y: list[float],
    gear: list[float],
    k: list[float],
    z: list[float],
    k1: list[float],
    k2: list[float],
    k3: list[float],
    k4: list[float],
    k5: list[float],
    k6: list[float],
    k7: list[float],
    new: list[float],
) -> None:
    """One step of Dormand and Prince from the rates `k1`: fills the stages and `new`."""
    for i in range(NS):
        z[i] = y[i] + h * 0.2 * k1[i]
    evaluate(t + 0.2 * h, z, gear, k, k2)
    for i in range(NS):
        z[i] = y[i] + h * (3.0 / 40.0 * k1[i] + 9.0 / 40.0 * k2[i])
    evaluate(t + 0.3 * h, z, gear, k, k3)
    for i in range(NS):
        z[i] = y[i] + h * (44.0 / 45.0 * k1[i] - 56.0 / 15.0 * k2[i] + 32.0 / 9.0 * k3[i])
    evaluate(t + 0.8 * h, z, gear, k, k4)
    for i in range(NS):
        z[i] = y[i] + h * (
            19372.0 / 6561.0 * k1[i]
            - 25360.0 / 2187.0 * k2[i]
            + 64448.0 / 6561.0 * k3[i]
            - 212.0 / 729.0 * k4[i]
        )
    evaluate(t + 8.0 / 9.0 * h, z, gear, k, k5)
    for i in range(NS):
        z[i] = y[i] + h * (
            9017.0 / 3168.0 * k1[i]
            - 355.0 / 33.0 * k2[i]
            + 46732.0 / 5247.0 * k3[i]
            + 49.0 / 176.0 * k4[i]
            - 5103.0 / 18656.0 * k5[i]
        )
    evaluate(t + h, z, gear, k, k6)
    for i in range(NS):
        new[i] = y[i] + h * (
            35.0 / 384.0 * k1[i]
            + 500.0 / 1113.0 * k3[i]
            + 125.0 / 192.0 * k4[i]
            - 2187.0 / 6784.0 * k5[i]
            + 11.0 / 84.0 * k6[i]
        )
    evaluate(t + h, new, gear, k, k7)


def error_of(
    h: float,
    y: list[float],
    new: list[float],
    rtol: float,
    size: list[float],
    k1: list[float],
    k3: list[float],
    k4: list[float],
    k5: list[float],
    k6: list[float],
    k7: list[float],
) -> float:
    """Root of the mean square of the error over the tolerance."""
    total = 0.0
    for i in range(NS):
        e = h * (
            71.0 / 57600.0 * k1[i]
            - 71.0 / 16695.0 * k3[i]
            + 71.0 / 1920.0 * k4[i]
            - 17253.0 / 339200.0 * k5[i]
            + 22.0 / 525.0 * k6[i]
            - 1.0 / 40.0 * k7[i]
        )
        scale = rtol * (size[i] + max(math.fabs(y[i]), math.fabs(new[i])))
        total += (e / scale) * (e / scale)
    return math.sqrt(total / NS)


def root(
    steps: list[float], at: int, state: int, level: float, side: float, low: float, high: float
) -> float:
    """Where a state passes a level inside a step, between two places of which one is beyond."""
    f_low = side * (dense(steps, at, low, state) - level)
    f_high = side * (dense(steps, at, high, state) - level)
    moved = 0
    for _ in range(200):
        if high - low <= 1e-15 or f_high == f_low:
            break
        middle = chord(low, f_low, high, f_high)
        if math.isnan(middle):
            break
        f_middle = side * (dense(steps, at, middle, state) - level)
        if f_middle == 0.0:
            return middle
        low, f_low, high, f_high, moved = narrowed(
            low, f_low, high, f_high, middle, f_middle, moved
        )
    return high


def set_out(
    k: list[float],
    settings: list[float],
    y: list[float],
    out: list[float],
    size: list[float],
    gear: list[float],
    course: list[float],
) -> None:
    """Put a ship to the begin of its first phase: straight ahead at the speed of the approach."""
    for i in range(len(CourseField)):
        course[i] = 0.0
    course[CourseField.status], course[CourseField.revolutions] = Status.done, math.nan
    if complete(k) == 1:
        course[CourseField.status] = Status.mass
        return
    speed = settings[SettingField.speed]
    pace = speed / k[Constant.L]
    n0 = settings[SettingField.revolutions]
    if not n0 > 0.0:
        height = k[Constant.wave_height]
        if n0 == 0.0:
            k[Constant.wave_height] = 0.0
        n0 = self_propulsion(speed, k, y, out)
        k[Constant.wave_height] = height
        if math.isnan(n0):
            course[CourseField.status] = Status.no_propulsion
            return
    for i in range(NS):
        y[i], size[i] = 0.0, 1.0
    size[State.x], size[State.y], size[State.u], size[State.v], size[State.r] = (
        k[Constant.L],
        k[Constant.L],
        speed,
        speed,
        pace,
    )
    if k[Constant.rolls] > 0.0:
        size[State.p] = pace
    y[State.u] = speed
    if N_AT >= 0:
        y[N_AT], size[N_AT] = n0, n0
    for c in range(len(Control)):
        g = len(GearField) * c
        gear[g + GearField.since] = 0.0
        gear[g + GearField.start], gear[g + GearField.order] = 0.0, 0.0
        gear[g + GearField.rate] = settings[SettingField.rudder_rate + c]
        gear[g + GearField.lag] = settings[SettingField.rudder_lag + c]
    g = len(GearField) * Control.revolutions
    gear[g + GearField.start], gear[g + GearField.order] = n0, n0
    gear[g + GearField.rate] = settings[SettingField.revolutions_rate] * max(n0, 1e-9)
    course[CourseField.h], course[CourseField.before] = 0.05 / pace, 1e-4
    course[CourseField.revolutions] = n0


def opened(
    phases: list[float],
    y: list[float],
    gear: list[float],
    k: list[float],
    events: list[float],
    course: list[float],
    k1: list[float],
) -> None:
    """Give the orders of the phase whose turn it is; `k1` are the rates from then on."""
    p, t = int(course[CourseField.phase]), course[CourseField.t]
    a, e = len(PhaseField) * p, len(EventField) * p
    for c in range(len(Control)):
        g = len(GearField) * c
        order = phases[a + PhaseField.rudder + c]
        if c == Control.revolutions:
            order *= course[CourseField.revolutions]
        now = controlled(t, gear, c)
        events[e + EventField.rudder + c] = now
        if order == order:
            gear[g + GearField.since] = t
            gear[g + GearField.start], gear[g + GearField.order] = now, order
        events[e + EventField.rudder_order + c] = gear[g + GearField.order]
    events[e + EventField.begin], events[e + EventField.step] = t, course[CourseField.kept]
    events[e + EventField.finished] = 0.0
    course[CourseField.since] = t + phases[a + PhaseField.shortest]
    course[CourseField.end] = t + phases[a + PhaseField.longest]
    if course[CourseField.lost] > 0.0:
        course[CourseField.end] = t
    course[CourseField.level] = phases[a + PhaseField.level]
    course[CourseField.more], course[CourseField.opened] = 6.0, 1.0
    evaluate(t, y, gear, k, k1)


def closed(
    done: int,
    phases: list[float],
    count: int,
    gear: list[float],
    events: list[float],
    course: list[float],
) -> None:
    """End a phase; `done` tells whether what it waited for ended it."""
    p = int(course[CourseField.phase])
    kind = int(phases[len(PhaseField) * p + PhaseField.until])
    events[len(EventField) * p + EventField.finished] = done
    if done == 0 and kind != End.time and kind != End.steady:
        course[CourseField.lost] = 1.0
    course[CourseField.phase], course[CourseField.opened] = p + 1, 0.0
    if p + 1 == count:
        e = len(EventField) * count
        events[e + EventField.begin] = course[CourseField.t]
        events[e + EventField.step] = course[CourseField.kept]
        for c in range(len(Control)):
            events[e + EventField.rudder + c] = controlled(course[CourseField.t], gear, c)


def watched_by(kind: int) -> int:
    """The state whose level ends a phase."""
    watched: int = State.psi
    if kind == End.yaw_rate:
        watched = State.r
    elif kind == End.surge:
        watched = State.u
    return watched


def proposed(
    phases: list[float],
    count: int,
    settings: list[float],
    room: int,
    y: list[float],
    gear: list[float],
    k: list[float],
    events: list[float],
    course: list[float],
    k1: list[float],
) -> float:
    """Length of the next step; phases end and open before it. Nothing where the last has ended."""
    if course[CourseField.exact] > 0.0:
        return course[CourseField.exact]
    while course[CourseField.phase] < count:
        if course[CourseField.opened] == 0.0:
            opened(phases, y, gear, k, events, course, k1)
        a, t = len(PhaseField) * int(course[CourseField.phase]), course[CourseField.t]
        kind, side = int(phases[a + PhaseField.until]), phases[a + PhaseField.side]
        since, end = course[CourseField.since], course[CourseField.end]
        if t >= end - 1e-12 * (1.0 + end):
            closed(0, phases, count, gear, events, course)
            continue
        past = t >= since - 1e-12 * (1.0 + since)
        ahead = side * (y[watched_by(kind)] - course[CourseField.level])
        passing = kind == End.heading or kind == End.yaw_rate or kind == End.surge
        if past and passing and ahead >= 0.0:
            closed(1, phases, count, gear, events, course)
            continue
        stop = end
        if not past and since < stop:
            stop = since
        for c in range(len(Control)):
            bend = corner(gear, c)
            if bend > t + 1e-12 * (1.0 + t) and bend < stop:
                stop = bend
        course[CourseField.h] = min(course[CourseField.h], settings[SettingField.longest])
        clipped = t + 1.01 * course[CourseField.h] >= stop
        course[CourseField.past] = 1.0 if past else 0.0
        course[CourseField.ahead], course[CourseField.stop] = ahead, stop
        course[CourseField.clipped] = 1.0 if clipped else 0.0
        if STRIDE * (course[CourseField.kept] + 1) > room:
            course[CourseField.status] = Status.no_room
            return 0.0
        return stop - t if clipped else course[CourseField.h]
    return 0.0


def accepted(wrong: float, hh: float, least: float, course: list[float]) -> int:
    """Whether a step is good enough, and how long the next one is."""
    if course[CourseField.exact] > 0.0:
        return 1
    if not wrong <= 1.0:
        shorter = hh * max(0.1, 0.9 * wrong**-0.2) if wrong == wrong else 0.1 * hh
        course[CourseField.h] = shorter
        if shorter < least:
            course[CourseField.status] = Status.small_steps
        return 0
    growth = 10.0
    if wrong > 0.0:
        growth = 0.9 * wrong**-0.17 * course[CourseField.before] ** 0.04
        growth = min(10.0, max(0.2, growth))
    course[CourseField.before] = max(wrong, 1e-4)
    if course[CourseField.clipped] > 0.0:
        course[CourseField.h] = max(course[CourseField.h], hh * growth)
    else:
        course[CourseField.h] = hh * growth
    return 1


def advanced(
    hh: float,
    phases: list[float],
    count: int,
    settings: list[float],
    steps: list[float],
    new: list[float],
    k7: list[float],
    gear: list[float],
    k: list[float],
    events: list[float],
    course: list[float],
    z: list[float],
    found: list[float],
) -> int:
    """Go on to the end of a kept step; 0 where the step has to end at a level inside it first."""
    speed, n0 = settings[SettingField.speed], course[CourseField.revolutions]
    pace = speed / k[Constant.L]
    a, at = len(PhaseField) * int(course[CourseField.phase]), STRIDE * int(course[CourseField.kept])
    kind, side = int(phases[a + PhaseField.until]), phases[a + PhaseField.side]
    past, done = course[CourseField.past] > 0.0, 0
    circling = kind == End.steady_turn
    passing = kind == End.heading or kind == End.yaw_rate or kind == End.surge
    if course[CourseField.exact] > 0.0:
        course[CourseField.exact], done = 0.0, 1
    elif past and course[CourseField.ahead] < 0.0 and (passing or circling):
        watched, level = watched_by(kind), course[CourseField.level]
        if side * (new[watched] - level) >= 0.0:
            place = root(steps, at, watched, level, side, 0.0, 1.0)
            done = 1
            if circling and course[CourseField.more] > 0.0:
                for i in range(NS):
                    z[i] = dense(steps, at, place, i)
                when = course[CourseField.t] + place * hh
                if (
                    settle(
                        z,
                        controlled(when, gear, Control.rudder),
                        controlled(when, gear, Control.revolutions),
                        controlled(when, gear, Control.bucket),
                        speed,
                        n0,
                        k,
                        found,
                    )
                    == 1
                ):
                    course[CourseField.more] -= 1.0
                    course[CourseField.level] = level + side * TWICE
                    done = 0
            if done == 1 and place < 1.0:
                course[CourseField.exact] = place * hh
                return 0
    if course[CourseField.clipped] > 0.0 and done == 0:
        course[CourseField.t] = course[CourseField.stop]
    else:
        course[CourseField.t] = course[CourseField.t] + hh
    course[CourseField.kept] += 1.0
    fast = math.sqrt(new[State.u] * new[State.u] + new[State.v] * new[State.v])
    rolls = k[Constant.rolls] > 0.0
    if fast > settings[SettingField.fastest] or (
        rolls and math.fabs(new[State.phi]) > 0.5 * math.pi
    ):
        course[CourseField.status] = Status.unbound
        return 1
    if kind == End.steady and past:
        quiet = max(math.fabs(k7[State.u]), math.fabs(k7[State.v])) / (speed * pace)
        quiet = max(quiet, math.fabs(k7[State.r]) / (pace * pace))
        if quiet < course[CourseField.level]:
            done = 1
    if done == 1:
        closed(1, phases, count, gear, events, course)
    return 1


def run(
    k: list[float],
    phases: list[float],
    count: int,
    settings: list[float],
    steps: list[float],
    room: int,
    events: list[float],
) -> tuple[int, int, float]:
    """Integrate one ship through its phases.

    Gives a `Status`, the number of kept steps and the revolutions of the approach.
    """
    y, z, new = vector(NS), vector(NS), vector(NS)
    k1, k2, k3, k4 = vector(NS), vector(NS), vector(NS), vector(NS)
    k5, k6, k7 = vector(NS), vector(NS), vector(NS)
    size, gear = vector(NS), vector(len(Control) * len(GearField))
    course = vector(len(CourseField))
    set_out(k, settings, y, z, size, gear, course)
    rtol, least = settings[SettingField.rtol], 1e-10 * k[Constant.L] / settings[SettingField.speed]
    while course[CourseField.status] == Status.done:
        hh = proposed(phases, count, settings, room, y, gear, k, events, course, k1)
        if hh == 0.0:
            break
        t = course[CourseField.t]
        step(t, hh, y, gear, k, z, k1, k2, k3, k4, k5, k6, k7, new)
        wrong = error_of(hh, y, new, rtol, size, k1, k3, k4, k5, k6, k7)
        if accepted(wrong, hh, least, course) == 1:
            at = STRIDE * int(course[CourseField.kept])
            keep(steps, at, t, hh, y, new, k1, k3, k4, k5, k6, k7)
            if (
                advanced(
                    hh, phases, count, settings, steps, new, k7, gear, k, events, course, z, k2
                )
                == 1
            ):
                for i in range(NS):
                    y[i], k1[i] = new[i], k7[i]
    return (
        int(course[CourseField.status]),
        int(course[CourseField.kept]),
        course[CourseField.revolutions],
    )
