"""From the runs of a sea trial to its measures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.campaigns import TEST_KINDS, Campaign, Run
from pmmkit.conventions import METRICS, Criterion
from pmmkit.identification.local_fits import local, true_wind, velocity
from pmmkit.identification.trials.circle import Circle, fit_circle
from pmmkit.identification.trials.current import Current, mean_current
from pmmkit.identification.trials.measures import of_stopping, of_turning, of_zigzag
from pmmkit.identification.trials.orders import Order, astern_order, held_until, rudder_orders
from pmmkit.identification.trials.path import PositionNoise, path_of
from pmmkit.identification.trials.record import Record, read_record
from pmmkit.identification.trials.table import Trial, Wind
from pmmkit.imo import Condition, FullAstern, Verdict, judge
from pmmkit.numerics import Array
from pmmkit.presentation import listed
from pmmkit.signals import white_noise

# Criteria of IMO MSC.137(76) beside the measures of a trial.


def verdicts_of(
    test: str,
    metrics: Mapping[str, float],
    std: Mapping[str, float],
    *,
    L: float,
    speed: float,
    rudder_deg: float,
    switch_deg: float = math.nan,
    conditions: tuple[str, ...] = (),
    full_astern: FullAstern | None = None,
) -> tuple[Verdict, ...]:
    """Every criterion that a run of that kind is judged by.

    L, speed [m].

    Examples
    --------
    >>> found = verdicts_of("stopping", {"track_reach_L": 14.2}, {"track_reach_L": 0.1}, L=170.0,
    ...                     speed=7.25, rudder_deg=0.0)
    >>> [(item.criterion, item.limit, item.passed, round(item.probability, 6)) for item in found]
    [('track_reach', 15.0, True, 1.0)]
    """
    size = abs(rudder_deg)
    asked = [pair for pair in METRICS.criteria if _applies(pair[1], test, size, switch_deg)]
    own_first = sorted(asked, key=lambda pair: pair[1].manoeuvre != test)
    kind = TEST_KINDS[test]
    found = [
        judge(
            metric,
            criterion,
            metrics,
            std=std,
            L=L,
            speed=speed,
            scale=f"as measured, L = {L:.4g} m",
            manoeuvre=test,
            rudder_deg=rudder_deg if kind.turns_rudder else 0.0,
            switch_deg=switch_deg if kind.switches else None,
            conditions=(*conditions, *([Verdict.LARGE] if kind is TEST_KINDS["stopping"] else [])),
            alone=kind is TEST_KINDS["turning"],
            measured=True,
        )
        for metric, criterion in own_first
    ]
    return tuple(replace(verdict, full_astern=full_astern) for verdict in found)


def _applies(criterion: Criterion, test: str, rudder: float, switch: float) -> bool:
    """Whether a run is the test of a criterion: the manoeuvre, and its angles within reach."""
    if test not in (criterion.manoeuvre, *criterion.shown_by):
        return False
    if not TEST_KINDS[test].switches:
        return True
    settings = criterion.settings
    heading = settings.get("switch_deg", settings.get("heading_deg", math.nan))
    return abs(rudder - settings["rudder_deg"]) < 1.0 and abs(switch - heading) < 0.5


# Heel of a turning circle: the largest, and that of the steady turn.


SMOOTH: Final = 0.05
"""Half of the window in which heel is smoothed, in ship lengths over the speed."""
SETTLED: Final = math.pi
"""Change of heading from which a turn counts as steady."""
LEAST: Final = math.pi / 2.0
"""Change of heading over which the steady heel is averaged at least."""
LISTED: Final = math.radians(0.5)
"""Heel of the approach that is said."""


@dataclass(frozen=True, kw_only=True)
class Heel:
    """Heel of a turning circle [rad].

    `upright`: mean of the approach, positive to starboard, from which the others count: a list,
    or the zero of the instrument. `largest, largest_std`: either way; its uncertainty is that
    of the noise, waves are part of it. `steady, steady_std`: outwards; NaN where the turn is
    too short.
    """

    upright: float
    largest: float
    largest_std: float
    steady: float
    steady_std: float

    @property
    def words(self) -> str:
        """The heel of the approach, if it is worth a word."""
        if abs(self.upright) < LISTED:
            return ""
        side = "starboard" if self.upright > 0.0 else "port"
        return (
            f"The ship heels by {math.degrees(abs(self.upright)):.1f}° to {side} in the approach; "
            "heel counts from there."
        )


def heel_of_turn(
    t: Array, phi: Array, psi: Array, *, order: float, until: float, side: float, pace: float
) -> Heel | None:
    """Heel of a turning circle; None where too little of it was recorded.

    t, phi, psi [s]; order, until [s]; pace [s].

    Notes
    -----
    The largest heel is that of parabolas through the samples about each; the steady one a mean from
    half a turn on, with the scatter of means over a ship length and half of what it still changes
    by. Without an approach heel counts from zero.
    """
    known = np.isfinite(phi)
    t, phi, psi = t[known], phi[known], psi[known]
    before, turning = t < order, (t >= order) & (t <= until)
    if np.count_nonzero(turning) < 10:
        return None
    upright = float(phi[before].mean()) if np.count_nonzero(before) >= 5 else 0.0
    heel, own = phi[turning] - upright, t[turning]
    found = local(own, heel, own, SMOOTH * pace)
    most = int(np.argmax(np.abs(found.value)))
    # Third differences hold the noise alone: 20 is the sum of their squared weights.
    noise = math.sqrt(float(np.mean(np.diff(heel, 3) ** 2)) / 20.0)
    turned = side * (psi[turning] - np.interp(order, t, psi))
    late = turned >= SETTLED
    steady, std = math.nan, math.nan
    if late.any() and turned[late].max() - turned[late].min() >= LEAST:
        steady = -side * float(heel[late].mean())
        block = ((own[late] - own[late][0]) / pace).astype(int)
        means = np.bincount(block, heel[late]) / np.maximum(np.bincount(block), 1)
        means = means[np.bincount(block) > 0]
        if len(means) > 1:
            # What the heel still changes by is no noise, and does not go down with the blocks.
            half = len(means) // 2
            change = float(means[half:].mean() - means[:half].mean())
            std = math.hypot(float(means.std(ddof=1)) / math.sqrt(len(means)), 0.5 * change)
    return Heel(
        upright=upright,
        largest=abs(float(found.value[most])),
        largest_std=noise * math.sqrt(found.leverage[most]),
        steady=steady,
        steady_std=std,
    )


# What is around a trial: the wind, and the noise of the fixes where no circle shows it.


SLOW_TIME: Final = 100.0
"""Correlation time of a stated uncertainty of the fixes [s]."""


def noise_of(
    record: Record, circles: Sequence[Circle], stated: float | None, notes: list[str]
) -> PositionNoise:
    """Noise of the fixes of a run that is no fitted circle: as stated, or that of the circles.

    stated [m].
    """
    fast = math.sqrt(0.5 * (white_noise(record.x) ** 2 + white_noise(record.y) ** 2))
    if stated is not None:
        slow = math.sqrt(max(stated**2 - fast**2, 0.0))
        return PositionNoise(fast=min(fast, stated), slow=slow, time=SLOW_TIME, origin="as stated")
    if circles:
        known = [item.noise for item in circles]
        return PositionNoise(
            fast=max(fast, math.sqrt(float(np.mean([item.fast**2 for item in known])))),
            slow=math.sqrt(float(np.mean([item.slow**2 for item in known]))),
            time=float(np.mean([item.time for item in known])),
            origin="what the fitted circles leave",
        )
    notes.append(
        "The uncertainty holds the noise from fix to fix, not a drift of the fixes: state "
        "position_std under [trial] for that."
    )
    return PositionNoise(fast=fast, origin="what changes from fix to fix")


def mean_wind(record: Record, half: float) -> Wind | None:
    """Mean true wind from the relative one, the heading and the velocity over ground.

    half [s].
    """
    felt = [record.others.get(name) for name in ("wind_speed", "wind_direction")]
    if felt[0] is None or felt[1] is None:
        return None
    north, east = velocity(record.t, record.x, record.y, record.t, half)
    speed, direction = true_wind(record.psi, felt[0], felt[1], north, east)
    mean = np.nanmean(speed * np.exp(1j * direction))
    return Wind(
        speed=float(np.abs(mean)),
        direction_deg=math.degrees(np.angle(mean)) % 360.0,
        spread=float(np.nanstd(speed)),
    )


# The conditions of the standard beside those of a trial, as recorded and as stated.


def trial_conditions(
    campaign: Campaign, *, speed: float, wind: float | None, current: Current | None
) -> tuple[Condition, ...]:
    """What the standard asks of a trial, and what this one was.

    speed [m/s]; wind [m/s].
    """
    ship, stated = campaign.ship, campaign.imo
    shown = ""
    if current is not None:
        shown = f"{current.speed:.2f} m/s to {current.direction_deg:03.0f}°, removed"
    draught = campaign.draught
    return (
        Condition.of_length(ship.L),
        Condition.of_depth(campaign.water.depth, draught),
        Condition.of_wind(wind, stated.get("wind_beaufort")),
        Condition.of_sea(stated.get("sea_state")),
        Condition.of_current(current is not None, shown),
        Condition.of_draught(draught, stated.get("full_load_draught")),
        Condition.of_approach(speed, stated.get("speed_85")),
    )


def said(conditions: Sequence[Condition]) -> tuple[str, ...]:
    """What a test does not meet, a sentence each; and all that it does not show, in one."""
    unknown = [item.title for item in conditions if item.met is None]
    return (
        *(item.words for item in conditions if item.met is False),
        *([f"Not shown of what the standard asks for: {listed(unknown)}."] if unknown else []),
    )


# The current by the drift between equal headings of a turn, as the explanatory notes have it.


FROM: Final = math.pi
"""Change of heading from which on data count [rad]: MSC/Circ.1053, 3.4.2.5."""
TURN: Final = 2.0 * math.pi
EVERY: Final = math.radians(5.0)
"""Spacing of the headings that are compared [rad]."""


def equal_headings(t: Array, x: Array, y: Array, psi: Array) -> Current | None:
    """The current from places that lie a whole turn apart.

    t, x, y, psi [s].

    Notes
    -----
    In a steady turn the ship is back on her circle after 360°, and has moved by the current alone.
    A ship that still loses speed has not: there `fit_circle`, which lets the speed die away, is the
    better one. Neighbouring differences share their fixes, so the scatter is not divided by their
    number.

    References
    ----------
    IMO MSC/Circ.1053, Explanatory notes to the Standards for ship manoeuvrability, 2002, 3.4.2.5.

    Examples
    --------
    >>> t = np.arange(0.0, 1300.0, 2.0)
    >>> psi = 0.01 * t
    >>> x, y = 500 * np.sin(psi) + 0.3 * t, 500 * (1 - np.cos(psi)) - 0.1 * t
    >>> found = equal_headings(t, x, y, psi)
    >>> round(found.x, 3), round(found.y, 3)
    (0.3, -0.1)
    """
    turned = np.abs(psi - psi[0])
    rising = np.maximum.accumulate(turned)
    kept = np.concatenate(([True], np.diff(rising) > 0.0))
    headings = np.arange(FROM, float(rising[-1]) - TURN, EVERY)
    if not len(headings):
        return None

    def at(level: Array, values: Array) -> Array:
        return np.interp(level, rising[kept], values[kept])

    lasted = at(headings + TURN, t) - at(headings, t)
    moved = np.stack([(at(headings + TURN, p) - at(headings, p)) / lasted for p in (x, y)])
    mean, spread = (
        moved.mean(axis=1),
        np.cov(moved, ddof=0) if len(headings) > 1 else np.zeros((2, 2)),
    )
    return Current(
        x=float(mean[0]),
        y=float(mean[1]),
        covariance=(float(spread[0, 0]), float(spread[1, 1]), float(spread[0, 1])),
        origin="drift between equal headings",
    )


SPEEDS_DIFFER: Final = 0.05


@dataclass(frozen=True, kw_only=True, eq=False)
class _Part:
    """What is known of a run before the current of the others is."""

    run: Run
    record: Record
    orders: tuple[Order, ...]
    circle: Circle | None
    notes: tuple[str, ...]
    drift: Current | None = None
    turned_deg: float = math.nan
    heel: Heel | None = None


def evaluate_trials(
    campaign: Campaign,
    *,
    runs: Sequence[str] | None = None,
    order: Mapping[str, float] | None = None,
    current: tuple[float, float] | None = None,
) -> tuple[Trial, ...]:
    """Measures of the turning circles, zigzags and stops of a sea trial.

    Parameters
    ----------
    campaign : Campaign
        Free-running, as `open_campaign` gives it.
    runs : sequence of str, optional
        Ids of the runs that are wanted; all by default. The current is always taken from every
        turning circle of the campaign.
    order : mapping of str to float, optional
        Instant of the order by run [s], where the rudder or the engine does not show it.
    current : tuple of float, optional
        A current that is known: its velocity along x (north) and y (east) [m/s]. By default each
        turning circle gives its own, and the other runs are given the mean of the circles'.

    Returns
    -------
    tuple of Trial
        In the order of the campaign.

    Raises
    ------
    DataError
        If the campaign has no such runs, or with everything that keeps runs from being
        evaluated.

    Notes
    -----
    Lengths run along and across the heading of the approach, from where midship was at the order,
    through the water where the current is known. The order is where the ramp of the rudder (or of
    the revolutions) begins. Places at a heading come from parabolas through the fixes about it.
    """
    wanted = [run for run in campaign.runs if run.kind_of_test.of_standard]
    unknown = sorted(set(runs or ()) - {run.id for run in wanted})
    if unknown or not wanted:
        raise DataError(
            f"{campaign.title!r} has no turning, zigzag or stopping run"
            f"{' ' + ', '.join(unknown) if unknown else ''}; it has "
            f"{', '.join(run.id for run in wanted) or 'none'}."
        )
    given = {**campaign.trial.get("order", {}), **(order or {})}
    parts: list[_Part] = []
    problems: list[Problem] = []
    for run in wanted:
        asked = not runs or run.id in runs
        if not asked and run.test != "turning":
            continue
        try:
            parts.append(_part(run, campaign, given.get(run.id)))
        except DataError as error:
            if asked:
                problems += [replace(item, run=item.run or run.id) for item in error.problems]
    if problems:
        raise DataError(problems, title="The trial cannot be evaluated")
    known = None if current is None else Current(x=current[0], y=current[1], origin="as given")
    common = known or mean_current(
        {part.run.id: part.circle.current for part in parts if part.circle and part.record.north}
    )
    circles = [part.circle for part in parts if part.circle]
    return tuple(
        _trial(part, campaign, common, known, circles)
        for part in parts
        if not runs or part.run.id in runs
    )


def _part(run: Run, campaign: Campaign, given: float | None) -> _Part:
    record = read_record(run)
    notes = list(record.notes)
    orders = _orders(run, record, given, notes)
    circle, drift, turned, heel = None, None, math.nan, None
    if run.test == "turning":
        delta, pace = record.others.get("delta"), campaign.ship.L / run.settings.speed
        end = float(record.t[-1]) if delta is None else held_until(record.t, delta, orders[0])
        inside = (record.t >= orders[0].t) & (record.t <= end)
        held = [part[inside] for part in (record.t, record.x, record.y, record.psi)]
        try:
            if np.count_nonzero(inside) < 2:
                raise DataError("The record ends with the order.")
            drift = equal_headings(*held)
            turned = math.degrees(float(np.abs(held[-1] - held[-1][0]).max()))
            circle = fit_circle(*held, pace=pace)
            circle = replace(
                circle, current=replace(circle.current, origin=f"turning circle {run.id}")
            )
        except DataError as error:
            notes.append(f"No current from this turn. {error}")
        if "phi" in record.others:
            heel = heel_of_turn(
                record.t,
                record.others["phi"],
                record.psi,
                order=orders[0].t,
                until=end,
                side=math.copysign(1.0, orders[0].level),
                pace=pace,
            )
    return _Part(
        run=run,
        record=record,
        orders=tuple(orders),
        circle=circle,
        notes=tuple(notes),
        drift=drift,
        turned_deg=turned,
        heel=heel,
    )


def _rudder_rate(orders: Sequence[Order]) -> float:
    """The usual rate of the rudder [deg/s]; NaN where it steps."""
    rate = float(np.median([order.rate for order in orders]))
    return math.degrees(rate) if math.isfinite(rate) else math.nan


def _engine(part: _Part, stopped: float) -> tuple[float, FullAstern | None]:
    """Revolutions of the approach [1/s], and what the engine did in a stop."""
    n, order = part.record.others.get("n"), part.orders[0].t
    if n is None:
        return math.nan, None
    before = part.record.t <= order
    ahead = float(np.median(n[before])) if before.any() else math.nan
    if part.run.test != "stopping" or not ahead > 0.0 or math.isnan(stopped):
        return ahead, None
    until = (part.record.t >= order) & (part.record.t <= order + stopped)
    return ahead, FullAstern.of_a_stop(part.record.t[until] - order, n[until], ahead)


def _orders(run: Run, record: Record, given: float | None, notes: list[str]) -> list[Order]:
    channel = record.others.get("n" if run.test == "stopping" else "delta")
    rounding = record.step / math.sqrt(12.0)
    if run.test == "stopping":
        if given is not None:
            return [Order(given, rounding, 0.0)]
        if channel is None:
            raise DataError(
                "The record has no revolutions (column n), so the order astern does not show. "
                "Give its instant: order under [trial], or --order."
            )
        return [astern_order(record.t, channel)]
    nominal = run.settings.rudder
    if channel is None:
        if given is None or run.test == "zigzag":
            raise DataError(
                "The record has no rudder angle (column delta), so the orders do not show. "
                + ("Add the column." if run.test == "zigzag" else "Give order under [trial].")
            )
        return [Order(given, rounding, nominal)]
    if given is None:
        orders = rudder_orders(record.t, channel, nominal, single=run.test == "turning")
    else:
        late = record.t >= given - 1e-9
        held = channel[late][np.abs(channel[late]) > 0.6 * abs(nominal)]
        level = float(np.median(held)) if len(held) else nominal
        orders = [Order(given, rounding, level)]
        if run.test == "zigzag":
            orders = rudder_orders(record.t, channel, nominal)
            orders[0] = replace(orders[0], t=given, std=rounding)
    if nominal and orders[0].level * nominal < 0:
        notes.append("The rudder goes to the side opposite to rudder_deg.")
    turned = np.interp(orders[0].t + np.array([0.0, 60.0]), record.t, record.psi)
    later = record.psi[record.t > orders[0].t]
    swing = later[np.argmax(np.abs(later - turned[0]))] - turned[0] if len(later) else 0.0
    if run.test == "turning" and swing * orders[0].level < 0:
        raise DataError(
            "The ship turns against the rudder: a positive rudder must turn her to starboard. "
            'Say rudder_positive = "port" under [campaign], or turn psi.'
        )
    return orders


def _trial(
    part: _Part,
    campaign: Campaign,
    common: Current | None,
    known: Current | None,
    others: Sequence[Circle],
) -> Trial:
    run, record, ship = part.run, part.record, campaign.ship
    notes = list(part.notes)
    own = part.circle.current if part.circle else None
    shared = common if record.north or known is not None else None
    current = known or own or shared
    if current is None:
        notes.append("The current is not known: lengths and speeds are over ground.")
    elif current is shared and known is None:
        notes.append(f"The current is that of {current.origin}.")
    noise = (
        part.circle.noise
        if part.circle
        else noise_of(record, others, campaign.trial.get("position_std"), notes)
    )
    path = path_of(
        record, part.orders[0], L=ship.L, speed=run.settings.speed, current=current, noise=noise
    )
    approach = path.approach
    if not approach.measured:
        notes.append("The record has no approach: speed as stated, heading of the first samples.")
    elif abs(approach.speed / run.settings.speed - 1.0) > SPEEDS_DIFFER:
        notes.append(
            f"The approach speed is {approach.speed:.2f} m/s by the positions; the campaign file "
            f"says {run.settings.speed:.2f} m/s."
        )
    if not approach.steady:
        notes.append(
            f"The speed is not steady before the order: that of the last {approach.seconds:.3g} s "
            "is taken."
        )
    level = math.degrees(part.orders[0].level)
    switch = run.settings.switch if run.settings.switch is not None else run.settings.rudder
    reversals: list[float] = []
    if run.test == "turning":
        found = of_turning(path, part.orders[0], part.circle, notes)
    elif run.test == "zigzag":
        found, reversals = of_zigzag(path, part.orders, abs(switch), notes)
    else:
        found = of_stopping(path, part.orders[0], notes)
    if part.heel is not None:
        heel = part.heel
        found.add("heel_max_deg", math.degrees(heel.largest), math.degrees(heel.largest_std))
        found.add("heel_steady_deg", math.degrees(heel.steady), math.degrees(heel.steady_std))
        notes += [heel.words] if heel.words else []
    metrics, std = found.frozen()
    wind = mean_wind(record, path.half)
    unknown = np.full(len(record.t), math.nan)
    delta, n, phi, p = (record.others.get(name, unknown) for name in ("delta", "n", "phi", "p"))
    u, v, r = path.motion(phi)
    around = trial_conditions(
        campaign, speed=approach.speed, wind=None if wind is None else wind.speed, current=current
    )
    ahead, engine = _engine(part, found.values.get("time_to_stop", math.nan))
    return Trial(
        run=run.id,
        manoeuvre=run.test,
        name=ship.name,
        L=ship.L,
        speed=approach.speed,
        Fn=ship.froude(approach.speed, campaign.water.g),
        speed_std=approach.speed_std,
        heading_deg=math.degrees(approach.heading) % 360.0,
        rudder_deg=level,
        order=part.orders[0].t,
        orders=tuple(one.t - part.orders[0].t for one in part.orders),
        metrics=metrics,
        std=std,
        scale=f"as measured, L = {ship.L:.4g} m",
        settings=_settings(run, level, switch),
        reversals=tuple(reversals),
        rudder_rate_deg=_rudder_rate(part.orders) if run.kind_of_test.turns_rudder else math.nan,
        verdicts=verdicts_of(
            run.test,
            metrics,
            std,
            L=ship.L,
            speed=approach.speed,
            rudder_deg=level,
            switch_deg=math.degrees(abs(switch)),
            conditions=said(around),
            full_astern=engine,
        ),
        conditions=((*around, Condition.of_rudder(level)) if run.test == "turning" else around),
        revolutions=ahead,
        current=current,
        equal_headings=part.drift,
        turned_deg=part.turned_deg,
        wind=wind,
        noise=noise,
        notes=tuple(notes),
        t=path.t,
        x=path.x,
        y=path.y,
        psi=path.psi,
        u=u,
        v=v,
        r=r,
        p=p,
        phi=phi,
        delta=delta,
        n=n,
        x_ground=path.x_ground,
        y_ground=path.y_ground,
    )


def _settings(run: Run, level: float, switch: float) -> Mapping[str, float]:
    """Settings of the manoeuvre by the names that `simulate` has for them."""
    kind = run.kind_of_test
    found = {"rudder_deg": level} if kind.turns_rudder else {}
    return found | ({"switch_deg": abs(math.degrees(switch))} if kind.switches else {})
