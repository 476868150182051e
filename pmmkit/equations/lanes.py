"""Many ships at once, each in a lane of the processor's vectors; runs like `integrator`.

Each lane is a ship of its own, with an instant and a step of its own, so that no ship depends on
those beside it. A lane whose ship has arrived takes the next. The stages of a step run over all
lanes in loops without branches, which the compiler makes instructions on whole vectors of.
"""

from __future__ import annotations

import math

from pmmkit.equations.integrator import accepted, advanced, proposed, set_out
from pmmkit.equations.layouts import (
    Constant,
    Control,
    CourseField,
    EventField,
    GearField,
    LaneMove,
    LaneSlot,
    OutcomeField,
    PhaseField,
    SettingField,
    Status,
    StepField,
)
from pmmkit.equations.queries import probe
from pmmkit.equations.stand_ins import (
    LANES,
    MOVES,
    NS,
    STRIDE,
    TIMES,
    WIDE,
    exponential,
    part,
    rates_of_lanes,
)


def moved(gear: list[float], lane: int, s: list[float]) -> None:
    """How the controls of a lane move from the orders of a phase on, as `control` has it."""
    for c in range(len(Control)):
        g, m = len(GearField) * c, MOVES + len(LaneMove) * LANES * c + lane
        start, order = gear[g + GearField.start], gear[g + GearField.order]
        rate, lag = gear[g + GearField.rate], gear[g + GearField.lag]
        size = math.fabs(order - start)
        side = 1.0 if order >= start else -1.0
        straight = max((size - rate * lag) / rate, 0.0)
        rest = size - rate * straight
        if lag <= 0.0 or rest <= 0.0 or size == 0.0:
            rest = 0.0
        s[m + LaneMove.since * LANES] = gear[g + GearField.since]
        s[m + LaneMove.start * LANES] = start
        s[m + LaneMove.order * LANES] = order
        s[m + LaneMove.pace * LANES] = side * rate if size > 0.0 else 0.0
        s[m + LaneMove.ramp * LANES] = straight
        s[m + LaneMove.rest * LANES] = side * rest
        s[m + LaneMove.lag * LANES] = lag if lag > 0.0 else 1.0
        s[m + LaneMove.value * LANES] = order


def steered(share: float, s: list[float], moving: list[float]) -> None:
    """Controls of all lanes at a share of their steps."""
    for c in range(len(Control)):
        m = MOVES + len(LaneMove) * LANES * c
        if moving[c] > 0.0:
            for lane in range(LANES):
                at = s[TIMES + lane] + share * s[LaneSlot.length * NS * LANES + lane]
                gone = at - s[m + LaneMove.since * LANES + lane]
                over = gone - s[m + LaneMove.ramp * LANES + lane]
                ramp = (
                    s[m + LaneMove.start * LANES + lane]
                    + s[m + LaneMove.pace * LANES + lane] * gone
                )
                tail = s[m + LaneMove.order * LANES + lane] - s[
                    m + LaneMove.rest * LANES + lane
                ] * exponential(-over / s[m + LaneMove.lag * LANES + lane])
                s[m + LaneMove.value * LANES + lane] = ramp if over <= 0.0 else tail


def staged(stage: int, s: list[float]) -> None:
    """States at a stage of the step of Dormand and Prince, as `integrator.step` has them."""
    width = NS * LANES
    y, z, h = LaneSlot.y * width, LaneSlot.z * width, LaneSlot.length * width
    k1, k2, k3 = LaneSlot.k1 * width, LaneSlot.k2 * width, LaneSlot.k3 * width
    k4, k5, k6 = LaneSlot.k4 * width, LaneSlot.k5 * width, LaneSlot.k6 * width
    if stage == 2:
        for i in range(width):
            s[z + i] = s[y + i] + s[h + i] * 0.2 * s[k1 + i]
    elif stage == 3:
        for i in range(width):
            s[z + i] = s[y + i] + s[h + i] * (3.0 / 40.0 * s[k1 + i] + 9.0 / 40.0 * s[k2 + i])
    elif stage == 4:
        for i in range(width):
            s[z + i] = s[y + i] + s[h + i] * (
                44.0 / 45.0 * s[k1 + i] - 56.0 / 15.0 * s[k2 + i] + 32.0 / 9.0 * s[k3 + i]
            )
    elif stage == 5:
        for i in range(width):
            s[z + i] = s[y + i] + s[h + i] * (
                19372.0 / 6561.0 * s[k1 + i]
                - 25360.0 / 2187.0 * s[k2 + i]
                + 64448.0 / 6561.0 * s[k3 + i]
                - 212.0 / 729.0 * s[k4 + i]
            )
    elif stage == 6:
        for i in range(width):
            s[z + i] = s[y + i] + s[h + i] * (
                9017.0 / 3168.0 * s[k1 + i]
                - 355.0 / 33.0 * s[k2 + i]
                + 46732.0 / 5247.0 * s[k3 + i]
                + 49.0 / 176.0 * s[k4 + i]
                - 5103.0 / 18656.0 * s[k5 + i]
            )
    else:
        for i in range(width):
            s[z + i] = s[y + i] + s[h + i] * (
                35.0 / 384.0 * s[k1 + i]
                + 500.0 / 1113.0 * s[k3 + i]
                + 125.0 / 192.0 * s[k4 + i]
                - 2187.0 / 6784.0 * s[k5 + i]
                + 11.0 / 84.0 * s[k6 + i]
            )


def share_of(stage: int) -> float:
    """Share of the step at which a stage stands."""
    share = 1.0
    if stage == 2:
        share = 0.2
    elif stage == 3:
        share = 0.3
    elif stage == 4:
        share = 0.8
    elif stage == 5:
        share = 8.0 / 9.0
    return share


def noted(stage: int, s: list[float]) -> None:
    """Keep the rates of a stage; the states of the seventh are those of the step's end."""
    to = (LaneSlot.k1 + stage - 1) * NS * LANES
    for i in range(NS * LANES):
        s[to + i] = s[LaneSlot.rate * NS * LANES + i]


def errors_of_lanes(rtol: float, s: list[float]) -> None:
    """The mean square of the error over the tolerance of each lane, as `error_of` has its root."""
    width = NS * LANES
    y, new, size = LaneSlot.y * width, LaneSlot.z * width, LaneSlot.size * width
    k1, k3, k4 = LaneSlot.k1 * width, LaneSlot.k3 * width, LaneSlot.k4 * width
    k5, k6, k7 = LaneSlot.k5 * width, LaneSlot.k6 * width, LaneSlot.k7 * width
    error = LaneSlot.error * width
    for i in range(width):
        e = s[LaneSlot.length * width + i] * (
            71.0 / 57600.0 * s[k1 + i]
            - 71.0 / 16695.0 * s[k3 + i]
            + 71.0 / 1920.0 * s[k4 + i]
            - 17253.0 / 339200.0 * s[k5 + i]
            + 22.0 / 525.0 * s[k6 + i]
            - 1.0 / 40.0 * s[k7 + i]
        )
        before, after = math.fabs(s[y + i]), math.fabs(s[new + i])
        scale = rtol * (s[size + i] + (after if after > before else before))
        s[error + i] = (e / scale) * (e / scale)
    for lane in range(LANES):
        total = 0.0
        for i in range(NS):
            total += s[error + i * LANES + lane]
        s[error + lane] = math.sqrt(total / NS)


def bends_of_lanes(s: list[float], bends: list[float]) -> None:
    """What `integrator.keep` writes of each state, for all lanes."""
    width = NS * LANES
    k1, k3, k4 = LaneSlot.k1 * width, LaneSlot.k3 * width, LaneSlot.k4 * width
    k5, k6, k7 = LaneSlot.k5 * width, LaneSlot.k6 * width, LaneSlot.k7 * width
    for i in range(width):
        h, y = s[LaneSlot.length * width + i], s[LaneSlot.y * width + i]
        change = s[LaneSlot.z * width + i] - y
        bend = h * s[k1 + i] - change
        bends[i] = y
        bends[width + i] = change
        bends[2 * width + i] = bend
        bends[3 * width + i] = change - h * s[k7 + i] - bend
        bends[4 * width + i] = h * (
            -12715105075.0 / 11282082432.0 * s[k1 + i]
            + 87487479700.0 / 32700410799.0 * s[k3 + i]
            - 10690763975.0 / 1880347072.0 * s[k4 + i]
            + 701980252875.0 / 199316789632.0 * s[k5 + i]
            - 1453857185.0 / 822651844.0 * s[k6 + i]
            + 69997945.0 / 29380423.0 * s[k7 + i]
        )


def memory_size(lanes: int, wide: int, states: int, width: int, count: int, asked: int) -> int:
    """How many numbers `run_many` keeps beside the steps; `wide` of them before the constants.

    Its caller makes room for them: a stack that is taken by more than a page at a time has to be
    felt for its end on Windows.
    """
    of_a_lane = 2 * width + 5 * states + len(EventField) * (count + 1)
    of_a_lane += len(Control) * len(GearField) + len(CourseField) + 1
    return wide + lanes * of_a_lane + len(Control) + 4 * states + (1 + states) * asked


def run_many(
    ships: list[float],
    first: int,
    last: int,
    width: int,
    phases: list[float],
    count: int,
    settings: list[float],
    probes: list[float],
    asked: int,
    room: int,
    steps: list[float],
    memory: list[float],
    results: list[float],
    outcomes: list[float],
) -> None:
    """Ships from `first` on: their probes, their status and revolutions of the approach.

    memory: `memory_size` zeros.
    """
    marks, geared = len(EventField) * (count + 1), len(Control) * len(GearField)
    lists, bent, asks = WIDE + width * LANES, 5 * NS * LANES, (1 + NS) * asked
    s, at = part(memory, 0, lists), lists
    bends, at = part(memory, at, bent), at + bent
    own, at = part(memory, at, LANES * width), at + LANES * width
    events, at = part(memory, at, LANES * marks), at + LANES * marks
    gears, at = part(memory, at, LANES * geared), at + LANES * geared
    courses, at = part(memory, at, LANES * len(CourseField)), at + LANES * len(CourseField)
    whose, at = part(memory, at, LANES), at + LANES
    moving, at = part(memory, at, len(Control)), at + len(Control)
    y, new = part(memory, at, NS), part(memory, at + NS, NS)
    k1, found, at = part(memory, at + 2 * NS, NS), part(memory, at + 3 * NS, NS), at + 4 * NS
    answers = part(memory, at, asks)
    rtol, taken, busy = settings[SettingField.rtol], first, LANES
    for c in range(len(Control)):
        for p in range(count):
            order = phases[len(PhaseField) * p + PhaseField.rudder + c]
            if order == order:
                moving[c] = 1.0
    for lane in range(LANES):
        whose[lane] = -1.0
    while busy > 0:
        busy = 0
        for lane in range(LANES):
            k, gear = part(own, lane * width, width), part(gears, lane * geared, geared)
            course = part(courses, lane * len(CourseField), len(CourseField))
            kept, event = part(steps, lane * room, room), part(events, lane * marks, marks)
            hh = 0.0
            while True:
                if whose[lane] < 0.0:
                    if taken >= last:
                        break
                    whose[lane] = taken
                    for i in range(width):
                        k[i] = ships[taken * width + i]
                    taken += 1
                    set_out(k, settings, y, new, found, gear, course)
                    for i in range(width):
                        s[WIDE + i * LANES + lane] = k[i]
                    for i in range(NS):
                        s[(LaneSlot.y * NS + i) * LANES + lane] = y[i]
                        s[(LaneSlot.size * NS + i) * LANES + lane] = found[i]
                if course[CourseField.status] == Status.done:
                    for i in range(NS):
                        y[i] = s[(LaneSlot.y * NS + i) * LANES + lane]
                    phase = course[CourseField.phase]
                    fresh = course[CourseField.opened] == 0.0
                    hh = proposed(phases, count, settings, room, y, gear, k, event, course, k1)
                    if fresh or course[CourseField.phase] != phase:
                        moved(gear, lane, s)
                        for i in range(NS):
                            s[(LaneSlot.k1 * NS + i) * LANES + lane] = k1[i]
                    if hh > 0.0:
                        break
                ship = int(whose[lane])
                n0, status = course[CourseField.revolutions], course[CourseField.status]
                outcomes[len(OutcomeField) * ship + OutcomeField.status] = status
                outcomes[len(OutcomeField) * ship + OutcomeField.revolutions] = n0
                if status == Status.done:
                    probe(kept, event, probes, asked, n0, settings, k, answers)
                for i in range((1 + NS) * asked):
                    results[ship * (1 + NS) * asked + i] = (
                        answers[i] if status == Status.done else math.nan
                    )
                whose[lane] = -1.0
            busy += 1 if hh > 0.0 else 0
            s[TIMES + lane] = course[CourseField.t]
            for i in range(NS):
                s[(LaneSlot.length * NS + i) * LANES + lane] = hh
        if busy == 0:
            break
        for stage in range(2, 8):
            staged(stage, s)
            steered(share_of(stage), s, moving)
            rates_of_lanes(s)
            noted(stage, s)
        errors_of_lanes(rtol, s)
        bends_of_lanes(s, bends)
        for lane in range(LANES):
            if whose[lane] < 0.0:
                continue
            k, gear = part(own, lane * width, width), part(gears, lane * geared, geared)
            course = part(courses, lane * len(CourseField), len(CourseField))
            kept, event = part(steps, lane * room, room), part(events, lane * marks, marks)
            hh, wrong = (
                s[LaneSlot.length * NS * LANES + lane],
                s[LaneSlot.error * NS * LANES + lane],
            )
            least = 1e-10 * k[Constant.L] / settings[SettingField.speed]
            if accepted(wrong, hh, least, course) == 0:
                continue
            at = STRIDE * int(course[CourseField.kept])
            kept[at + StepField.begin], kept[at + StepField.length] = s[TIMES + lane], hh
            for i in range(5 * NS):
                kept[at + len(StepField) + i] = bends[i * LANES + lane]
            for i in range(NS):
                new[i] = s[(LaneSlot.z * NS + i) * LANES + lane]
                k1[i] = s[(LaneSlot.k7 * NS + i) * LANES + lane]
            if (
                advanced(
                    hh, phases, count, settings, kept, new, k1, gear, k, event, course, y, found
                )
                == 1
            ):
                for i in range(NS):
                    s[(LaneSlot.y * NS + i) * LANES + lane] = new[i]
                    s[(LaneSlot.k1 * NS + i) * LANES + lane] = k1[i]
