"""Integration of a model's equations of motion: the functions that run compiled or interpreted.

`pmmkit.equations.code_generation` writes the functions of this file below the equations of one
structure into a module, where `rates` and the capital names are that structure's. They use flat
lists of floats (arrays when compiled), each other and `math`, nothing else.

Steps are those of Dormand and Prince (1980), order 5 with an error estimate of order 4 and dense
output of order 4 (Hairer, Nørsett and Wanner 1993, II.6). A kept step is ``t, h``, the states,
and four coefficients of the dense output for each. Where a control has a corner a step ends.

What stands where in the flat lists (`k` the constants, `gear`, `phases`, `settings`, `steps`,
`events`, `probes`) is said by `pmmkit.equations.layouts`, whose names are written out as numbers
there.
"""

from __future__ import annotations

import math

from pmmkit.equations.equilibrium import chord, complete, narrowed, self_propulsion, settle
from pmmkit.equations.layouts import (
    Constant,
    Control,
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
    for _ in range(200):
        if high - low <= 1e-15 or f_high == f_low:
            break
        middle = chord(low, f_low, high, f_high)
        if math.isnan(middle):
            break
        f_middle = side * (dense(steps, at, middle, state) - level)
        if f_middle == 0.0:
            return middle
        low, f_low, high, f_high = narrowed(low, f_low, high, f_high, middle, f_middle)
    return high


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
    if complete(k) == 1:
        return Status.mass, 0, math.nan
    rtol, longest, speed = (
        settings[SettingField.rtol],
        settings[SettingField.longest],
        settings[SettingField.speed],
    )
    pace = speed / k[Constant.L]
    n0 = settings[SettingField.revolutions]
    if not n0 > 0.0:
        n0 = self_propulsion(speed, k, y, z)
        if math.isnan(n0):
            return Status.no_propulsion, 0, n0
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
        gear[g + GearField.rate] = settings[SettingField.rudder_rate + c]
        gear[g + GearField.lag] = settings[SettingField.rudder_lag + c]
    g = len(GearField) * Control.revolutions
    gear[g + GearField.start], gear[g + GearField.order] = n0, n0
    gear[g + GearField.rate] = settings[SettingField.revolutions_rate] * max(n0, 1e-9)
    t, h, kept = 0.0, 0.05 / pace, 0
    before, lost = 1e-4, 0
    for p in range(count):
        a, e = len(PhaseField) * p, len(EventField) * p
        for c in range(len(Control)):
            g = len(GearField) * c
            order = phases[a + PhaseField.rudder + c]
            if c == Control.revolutions:
                order *= n0
            now = controlled(t, gear, c)
            events[e + EventField.rudder + c] = now
            if order == order:
                gear[g + GearField.since] = t
                gear[g + GearField.start], gear[g + GearField.order] = now, order
            events[e + EventField.rudder_order + c] = gear[g + GearField.order]
        events[e + EventField.begin], events[e + EventField.step] = t, kept
        events[e + EventField.finished] = 0.0
        kind = int(phases[a + PhaseField.until])
        level, side = phases[a + PhaseField.level], phases[a + PhaseField.side]
        since, end = t + phases[a + PhaseField.shortest], t + phases[a + PhaseField.longest]
        more = 6
        passing = kind == End.heading or kind == End.yaw_rate or kind == End.surge
        circling = kind == End.steady_turn
        watched = State.psi
        if kind == End.yaw_rate:
            watched = State.r
        elif kind == End.surge:
            watched = State.u
        if lost == 1:
            end = t
        evaluate(t, y, gear, k, k1)
        done = 0
        while done == 0:
            if t >= end - 1e-12 * (1.0 + end):
                break
            past = t >= since - 1e-12 * (1.0 + since)
            ahead = side * (y[watched] - level)
            if past and passing and ahead >= 0.0:
                done = 1
                break
            stop = end
            if not past and since < stop:
                stop = since
            for c in range(len(Control)):
                bend = corner(gear, c)
                if bend > t + 1e-12 * (1.0 + t) and bend < stop:
                    stop = bend
            h = min(h, longest)
            clipped = t + 1.01 * h >= stop
            hh = stop - t if clipped else h
            if STRIDE * (kept + 1) > room:
                return Status.no_room, kept, n0
            step(t, hh, y, gear, k, z, k1, k2, k3, k4, k5, k6, k7, new)
            wrong = error_of(hh, y, new, rtol, size, k1, k3, k4, k5, k6, k7)
            if not wrong <= 1.0:
                h = hh * max(0.1, 0.9 * wrong**-0.2) if wrong == wrong else 0.1 * hh
                if h < 1e-10 / pace:
                    return Status.small_steps, kept, n0
                continue
            at = STRIDE * kept
            keep(steps, at, t, hh, y, new, k1, k3, k4, k5, k6, k7)
            growth = 10.0
            if wrong > 0.0:
                growth = 0.9 * wrong**-0.17 * before**0.04
                growth = min(10.0, max(0.2, growth))
            before = max(wrong, 1e-4)
            h = max(h, hh * growth) if clipped else hh * growth
            behind = side * (new[watched] - level)
            if past and ahead < 0.0 and behind >= 0.0 and (passing or circling):
                place = root(steps, at, watched, level, side, 0.0, 1.0)
                done = 1
                if circling and more > 0:
                    for i in range(NS):
                        z[i] = dense(steps, at, place, i)
                    when = t + place * hh
                    if (
                        settle(
                            z,
                            controlled(when, gear, Control.rudder),
                            controlled(when, gear, Control.revolutions),
                            controlled(when, gear, Control.bucket),
                            speed,
                            n0,
                            k,
                            k2,
                        )
                        == 1
                    ):
                        more -= 1
                        level += side * TWICE
                        done = 0
                if done == 1 and place < 1.0:
                    hh = place * hh
                    step(t, hh, y, gear, k, z, k1, k2, k3, k4, k5, k6, k7, new)
                    keep(steps, at, t, hh, y, new, k1, k3, k4, k5, k6, k7)
            t = stop if clipped and done == 0 else t + hh
            for i in range(NS):
                y[i], k1[i] = new[i], k7[i]
            kept += 1
            if (
                math.sqrt(y[State.u] * y[State.u] + y[State.v] * y[State.v])
                > settings[SettingField.fastest]
            ):
                return Status.unbound, kept, n0
            if k[Constant.rolls] > 0.0 and math.fabs(y[State.phi]) > 0.5 * math.pi:
                return Status.unbound, kept, n0
            if kind == End.steady and past:
                quiet = max(math.fabs(k1[State.u]), math.fabs(k1[State.v])) / (speed * pace)
                quiet = max(quiet, math.fabs(k1[State.r]) / (pace * pace))
                if quiet < level:
                    done = 1
        events[e + EventField.finished] = done
        if done == 0 and (passing or circling):
            lost = 1
    e = len(EventField) * count
    events[e + EventField.begin], events[e + EventField.step] = t, kept
    for c in range(len(Control)):
        events[e + EventField.rudder + c] = controlled(t, gear, c)
    return Status.done, kept, n0
