"""Free-running records: standing samples, jumps, stops, the rudder's order, approach, yaw rate."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Attitude, Fixes
from pmmkit.intake.checks.finding import Check, CheckFinding, Severity, figure
from pmmkit.intake.checks.track import rate_facts
from pmmkit.numerics import Array, stretches, unwrapped

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.campaigns import Campaign, Run
    from pmmkit.intake.checks.finding import Summary

ENOUGH: Final = 50
HELD_SHARE: Final = 0.002
CATCHES_UP: Final = 0.5
TURNED: Final = math.pi
SHORT: Final = 0.005
ORDER_STEP: Final = math.radians(5.0)
ORDER_RATE: Final = math.radians(650.0)
GROWTH: Final = 0.05
SPEED: Final = 0.10
SWITCH: Final = math.radians(1.5)
SWITCH_SHARE: Final = 0.08
SWAY_SIGMAS: Final = 5.0
RUDDER_ZERO: Final = math.radians(2.0)
"""By which the zero of a rudder gauge may be off before it is called another angle."""
_DROPPED: Final = re.compile(r"(\d+) of (\d+) rows without a value left out")
_BEFORE: Final = 2


def record_facts(run: Run, campaign: Campaign, data: xr.Dataset, t: Array) -> Mapping[str, float]:
    """Facts of a free-running record beside those of `pmmkit.intake.checks.track.free_facts`.

    t [s].
    """
    facts: dict[str, float] = dict(_dropped(data))
    column = {
        name: np.asarray(data[name].values, float)
        for name in ("x", "y", "psi", "phi", "u", "v", "r", "xdot", "ydot", "delta", "n")
        if name in data
    }
    if not {"x", "y", "psi"} <= set(column):
        return facts
    good = np.logical_and.reduce([np.isfinite(part) for part in column.values()])
    if np.count_nonzero(good) < ENOUGH:
        return facts
    t = t[good]
    column = {name: part[good] for name, part in column.items()}
    column["psi"] = unwrapped(column["psi"])
    fixes = Fixes(t=t, x=column["x"], y=column["y"], psi=column["psi"], speed=run.settings.speed)
    facts |= _held(fixes)
    jumps = fixes.position_jumps()
    facts |= {"jumps": float(len(jumps)), "jump": max((jump.size for jump in jumps), default=0.0)}
    facts |= _yaw(fixes, column)
    facts |= _sway(t, column)
    if "n" in column:
        stop = fixes.stop_at_end(column["n"])
        facts["stopped"] = float(t[-1] - t[stop]) if stop < len(t) else 0.0
    if "delta" in column:
        facts |= _order(t, column["delta"])
        facts |= _manoeuvre(run, campaign.ship.L, t, column)
    return facts


def _dropped(data: xr.Dataset) -> Mapping[str, float]:
    for note in json.loads(data.attrs.get("conversions", "[]")):
        found = _DROPPED.match(note)
        if found:
            return {"dropped": float(found[1]), "rows": float(found[2])}
    return {}


def _held(fixes: Fixes) -> Mapping[str, float]:
    """Repeated positions after which the ship catches up with what it sailed meanwhile."""
    t, x, y = fixes.t, fixes.x, fixes.y
    places = np.flatnonzero(fixes.fresh)
    if len(places) < ENOUGH or len(places) == len(t):
        return {"held": 0.0, "held_time": 0.0}
    way = np.hypot(np.diff(x[places]), np.diff(y[places]))
    count = np.diff(places) - 1
    single = float(np.median(way[count == 0])) if np.any(count == 0) else 0.0
    real = (count > 0) & (way > (1 + CATCHES_UP * count) * single)
    share = float(count[real].sum()) / len(t)
    longest = float((t[places[1:] - 1] - t[places[:-1]])[real].max(initial=0.0))
    return {"held": share, "held_time": longest}


def _yaw(fixes: Fixes, column: Mapping[str, Array]) -> Mapping[str, float]:
    t, jumps = fixes.t, fixes.heading_jumps()
    sizes = [jump.size for jump in jumps]
    facts = {"turn_jumps": float(len(jumps)), "turn_jump": max(sizes, default=0.0)}
    if "r" not in column:
        return facts
    smooth = fixes.smooth_heading(jumps)
    if jumps:
        facts |= {f"r_{name}": value for name, value in rate_facts(t, smooth, column["r"]).items()}
    turned = float(smooth[-1] - smooth[0])
    if abs(turned) > TURNED:
        facts["turned"] = turned
        facts["yaw_share"] = _yaw_share(t, column["r"], column.get("phi"), turned)
        facts["yaw_time"] = float(t[-1] - t[0])
    return facts


def _yaw_share(t: Array, r: Array, phi: Array | None, turned: float) -> float:
    """Integral of the yaw rate over the change of heading.

    A ship that heels turns by ψ̇ = r cos φ + q sin φ. Without its pitch rate q the share lies
    between that of r cos φ and that of r/cos φ, which is a gyroscope's in a steady heel; the
    nearest of them to 1 counts.
    """

    def share(rate: Array) -> float:
        return float(np.sum(0.5 * (rate[1:] + rate[:-1]) * np.diff(t))) / turned

    if phi is None:
        return share(r)
    low, high = sorted((share(r * np.cos(phi)), share(r / np.cos(phi))))
    return min(max(1.0, low), high)


def _sway(t: Array, column: Mapping[str, Array]) -> Mapping[str, float]:
    """Slope of v minus the sway from positions over r, where it is beyond its scatter."""
    if not {"u", "v", "r"} <= set(column):
        return {}
    x, y, psi, u, v, r = (column[name] for name in ("x", "y", "psi", "u", "v", "r"))
    half = max(1, round(0.5 / float(np.median(np.diff(t)))))
    if len(t) < 20 * half:
        return {}
    middle = slice(half, -half)
    span = t[2 * half :] - t[: -2 * half]
    north, east = ((part[2 * half :] - part[: -2 * half]) / span for part in (x, y))
    phi = column["phi"][middle] if "phi" in column else 0.0
    _, across = Attitude(psi=psi[middle], phi=phi).in_ship_axes(north, east)
    miss, rate = v[middle] - across, r[middle]
    if float(np.ptp(rate)) == 0:
        return {}
    kept = np.ones(len(miss), dtype=bool)
    slope = std = 0.0
    for _ in range(3):
        basis = np.stack([rate[kept], np.ones(np.count_nonzero(kept))], axis=1)
        inverse = np.linalg.pinv(basis.T @ basis)
        slope, offset = inverse @ (basis.T @ miss[kept])
        rest = miss - slope * rate - offset
        kept = np.abs(rest) <= 4 * 1.4826 * np.median(np.abs(rest)) + 1e-12
        std = math.sqrt(float(np.mean(rest[kept] ** 2)) * float(inverse[0, 0]) * 4 * half)
    gain = float(slope * np.std(rate))
    if abs(slope) < SWAY_SIGMAS * std or abs(gain) < 0.02 * float(np.std(np.hypot(u, v)) + 1e-12):
        return {}
    power = float(np.sum((rate * u[middle])[kept] ** 2))
    return {
        "false_sway": float(slope),
        "false_time": float(np.sum((rate * u[middle] * miss)[kept])) / power if power else 0.0,
    }


def _order(t: Array, delta: Array) -> Mapping[str, float]:
    step = np.abs(np.diff(delta))
    place = int(np.argmax(step))
    return {
        "order_step": float(step[place]),
        "order_rate": float(step[place] / (t[place + 1] - t[place])),
    }


def _manoeuvre(
    run: Run, length: float, t: Array, column: Mapping[str, Array]
) -> Mapping[str, float]:
    """Approach speed, its growth per ship length, and headings at which a zigzag switches."""
    delta, nominal = column["delta"], run.settings.rudder
    if not run.kind_of_test.turns_rudder or nominal == 0:
        return {}
    zero = _rudder_zero(delta) if run.kind_of_test.switches else 0.0
    near = np.abs(delta - zero - nominal) < max(0.1 * abs(nominal), math.radians(1.0))
    if not near.any():
        return {"order_missing": float(delta[int(np.argmax(np.abs(delta)))])}
    passage = length / run.settings.speed
    first = _laid(t, near, 0.25 * passage)
    # A rudder that moves at its rate was ordered when it set out.
    while first and (delta[first] - delta[first - 1]) * nominal > 0:
        first -= 1
    facts: dict[str, float] = {}
    speed = _speed(t, column)
    window = (t >= t[first] - passage) & (t <= t[first])
    few = slice(max(0, first - 20), first + 1)
    facts["approach"] = float(np.median(speed[few]))
    if t[first] - t[0] > 0.5 * passage and np.count_nonzero(window) > 10:
        slope, mean = np.polyfit(t[window] - t[window].mean(), speed[window], 1)
        facts["growth"] = float(slope * length / mean**2) if mean > 0 else 0.0
    if run.kind_of_test.switches and run.settings.switch:
        facts |= _switches(t[first:], delta[first:], column["psi"][first:], nominal, passage)
    return facts


def _rudder_zero(delta: Array) -> float:
    """The middle of a rudder that was laid to both sides, if it is small enough to be its zero."""
    low, high = np.quantile(delta, (0.05, 0.95))
    middle = float(0.5 * (low + high))
    return middle if abs(middle) < min(RUDDER_ZERO, 0.25 * float(high - low)) else 0.0


def _speed(t: Array, column: Mapping[str, Array]) -> Array:
    for pair in (("u", "v"), ("xdot", "ydot")):
        if set(pair) <= set(column):
            return np.hypot(column[pair[0]], column[pair[1]])
    return np.hypot(np.gradient(column["x"], t), np.gradient(column["y"], t))


def _laid(t: Array, near: NDArray[np.bool_], seconds: float) -> int:
    """Where the rudder first comes to its angle and stays there for a while."""
    starts, stops = stretches(near)
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        if t[stop - 1] - t[start] > seconds:
            return int(start)
    return int(starts[0])


def _switches(
    t: Array, delta: Array, psi: Array, nominal: float, passage: float
) -> Mapping[str, float]:
    """Half the distance and the middle of the headings at which the rudder is turned over.

    ``switch_late`` is what the heading goes on in a tenth of the time of a ship length: so much
    later the rudder may answer.
    """
    side = np.where(np.abs(delta) > 0.85 * abs(nominal), np.sign(delta), 0)
    held = np.flatnonzero(side)
    groups = np.split(held, np.flatnonzero(np.diff(side[held]) != 0) + 1)
    last = []
    for group in groups[:-1]:
        size = np.abs(delta[group])
        full = size > float(np.median(size)) - math.radians(0.5)
        last.append(int(group[np.flatnonzero(full)[-1]]))
    if len(last) < _BEFORE:
        return {}
    headings, rates = psi[last], np.gradient(psi, t)[last]
    return {
        "switch": float(np.mean(np.abs(np.diff(headings)))) / 2,
        "switch_offset": float(np.mean(headings[1:] + headings[:-1])) / 2,
        "switch_late": 0.1 * passage * float(np.mean(np.abs(rates))),
    }


def examine_samples(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Rows without values, and positions that stand while the ship moves."""
    yield from _told(
        summaries,
        lambda item: item.facts.get("dropped", 0.0),
        "standing samples",
        "info",
        lambda item: (
            f"Rows without a value are left out: {item.facts['dropped']:.0f} of "
            f"{item.facts['rows']:.0f} in {item.run.id}"
        ),
        'Nothing, if the record is complete without them (missing = "drop" says so).',
        ("dropped", "rows"),
    )
    yield from _told(
        summaries,
        lambda item: item.facts["held_time"] if item.facts.get("held", 0) > HELD_SHARE else 0.0,
        "standing samples",
        "warning",
        lambda item: (
            f"The position stands still while the ship moves, and then catches up: for up to "
            f"{figure(item.facts['held_time'], 2)} s in {item.run.id}, "
            f"{100 * item.facts['held']:.1f} % of its samples"
        ),
        "Use positions only where they are fresh: identify leaves the others out.",
        ("held", "held_time"),
    )


def examine_stops(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Propellers that stand until the end of a record where they should not."""
    yield from _told(
        [item for item in summaries if not item.run.kind_of_test.propeller_stops],
        lambda item: item.facts.get("stopped", 0.0),
        "stop at the end",
        "warning",
        lambda item: (
            f"The propeller stands for the last {figure(item.facts['stopped'])} s of {item.run.id}"
        ),
        'Cut it: a correction with action = "trim" in the campaign file.',
        ("stopped",),
    )


MUCH_LESS: Final = 0.25
"""Share of the squares a gain leaves that a zero may leave to be named: turns to one side of about
one length tell them not apart."""


def examine_headings(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Headings that jump, and yaw rates whose integral is not the change of heading."""
    yield from _told(
        summaries,
        lambda item: item.facts.get("turn_jump", 0.0),
        "headings",
        "warning",
        lambda item: (
            f"The heading jumps: by {math.degrees(item.facts['turn_jump']):.1f}° in one sample "
            f"beyond what the yaw rate explains in {item.run.id} "
            f"({item.facts['turn_jumps']:.0f} in all)"
        ),
        "Use the segments between the jumps, or trim the record there.",
        ("turn_jump", "turn_jumps"),
    )
    turned = [item for item in summaries if "yaw_share" in item.facts]
    off = [item for item in turned if SHORT < abs(item.facts["yaw_share"] - 1) <= 0.1]
    if off:
        shares: Array = np.array([item.facts["yaw_share"] for item in off])
        middle = float(np.median(shares))
        worst = max(off, key=lambda item: abs(item.facts["yaw_share"] - 1))
        degrees = math.degrees(worst.facts["turned"])
        missing = 100 * np.abs(1 - shares)
        low, high = float(missing.min()), float(missing.max())
        zero = math.degrees(_zero_of_rate(off))
        more = {len(shares): "more than", 0: "short of"}
        which = more.get(int(np.count_nonzero(shares > 1)), "not")
        remedy = (
            f'Shift r by {-zero:.3g} deg/s (a correction with action = "shift"), or take it from '
            "psi: to both sides it misses by the same in a second, as a gyroscope with a zero."
            if zero
            else f'Scale r by {1 / middle:.4f} (a correction with action = "scale"), or take it '
            "from psi; a compass does not lose turns, a gyroscope may have a wrong gain."
        )
        yield CheckFinding(
            check="headings",
            severity="warning",
            message=f"The integral of r is {which} the change of heading in {len(off)} of "
            f"{len(turned)} records that turn by more than 180°, by {low:.1f} to {high:.1f} %: "
            f"{degrees * worst.facts['yaw_share']:.1f}° for {degrees:.1f}° in {worst.run.id}.",
            runs=tuple(item.run.id for item in off),
            remedy=remedy,
            numbers={
                "share": middle,
                "low": float(shares.min()),
                "high": float(shares.max()),
                **({"zero_deg_s": zero} if zero else {}),
            },
        )


def _zero_of_rate(items: Sequence[Summary]) -> float:
    """Zero of the yaw rate [rad/s] that explains what its integral misses better than a gain does;
    0 where it does not."""
    turned, share, time = (
        np.array([item.facts[name] for item in items])
        for name in ("turned", "yaw_share", "yaw_time")
    )
    missed = (share - 1.0) * turned
    zero, gain = (float(missed @ part) / float(part @ part) for part in (time, turned))
    left = [float(np.sum((missed - x * part) ** 2)) for x, part in ((zero, time), (gain, turned))]
    return zero if len(items) > 1 and left[0] < MUCH_LESS * left[1] else 0.0


def examine_sway(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Sway columns that hold a part of the surge because they are late."""
    items = [item for item in summaries if "false_sway" in item.facts]
    if items:
        slopes: Array = np.array([item.facts["false_sway"] for item in items])
        times: Array = np.array([item.facts["false_time"] for item in items])
        yield CheckFinding(
            check="false sway",
            severity="warning",
            message=f"v holds a false sway in {len(items)} of {len(summaries)} runs: it differs "
            f"from the sway of the positions by {figure(float(np.median(slopes)), 2)} m times r "
            f"({figure(float(slopes.min()), 2)} to {figure(float(slopes.max()), 2)} m), "
            f"{figure(float(np.median(times)), 2)} s times u r. So do velocities that are late "
            f"and turned with the present heading.",
            runs=tuple(item.run.id for item in items),
            remedy="Turn u and v back with the heading, shift them, and turn them again; or take "
            "the velocities from the positions.",
            numbers={"slope": float(np.median(slopes)), "time": float(np.median(times))},
        )


def examine_rudder(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Rudder columns that step as no rudder does: they hold the order, not the angle."""
    stated = campaign.rudder.get("rate_deg_s")

    def limit(item: Summary) -> float:
        if isinstance(stated, (int, float)) and stated > 0:
            return 2 * math.radians(float(stated))
        return ORDER_RATE * item.run.settings.speed / campaign.ship.L

    yield from _told(
        summaries,
        lambda item: (
            item.facts["order_step"]
            if item.facts.get("order_step", 0.0) > ORDER_STEP
            and item.facts["order_rate"] > limit(item)
            else 0.0
        ),
        "rudder order",
        "warning",
        lambda item: (
            f"The rudder column is the order, not the angle: it steps "
            f"{math.degrees(item.facts['order_step']):.1f}° in one sample of {item.run.id}, "
            f"{figure(math.degrees(item.facts['order_rate']))}°/s"
            + (f" where {float(stated):g}°/s is stated" if stated else "")
        ),
        "Let the model's rudder follow the order at its rate; do not feed the column as an angle.",
        ("order_step", "order_rate"),
    )


def examine_manoeuvres(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Approach, rudder and headings of turns and zigzags against what they were set to."""
    for item in summaries:
        facts, settings = item.facts, item.run.settings
        if "order_missing" in facts:
            yield CheckFinding(
                check="settings",
                severity="error",
                message=f"The rudder never comes near the {math.degrees(settings.rudder):.1f}° "
                f"that the campaign file states (positive to starboard); its largest angle is "
                f"{math.degrees(facts['order_missing']):.1f}°.",
                runs=(item.run.id,),
                remedy="Correct rudder_deg, rudder_positive or the unit of delta.",
                numbers={"delta": facts["order_missing"], "stated": settings.rudder},
            )
    yield from _told(
        summaries,
        lambda item: _off_share(item.facts.get("approach", math.nan), item.run.settings.speed),
        "settings",
        "warning",
        lambda item: (
            f"The speed when the rudder is laid is not the one stated: "
            f"{figure(item.facts['approach'])} m/s in {item.run.id}, stated "
            f"{figure(item.run.settings.speed)} m/s"
        ),
        "Correct speed, or the scale of the record.",
        ("approach",),
    )
    yield from _told(
        summaries,
        lambda item: max(0.0, abs(item.facts.get("growth", 0.0)) - GROWTH),
        "approach",
        "warning",
        lambda item: (
            f"The approach is not steady: the speed changes by "
            f"{100 * item.facts['growth']:.0f} % over the last ship length before the rudder in "
            f"{item.run.id}"
        ),
        "Start a simulation of it from the recorded state, and do not divide by the approach "
        "speed as if it were the speed of the revolutions.",
        ("growth", "approach"),
    )
    yield from _told(
        summaries,
        _off_switch,
        "settings",
        "warning",
        lambda item: (
            f"The rudder is turned over at other headings than stated: half their distance is "
            f"{math.degrees(item.facts['switch']):.1f}° about "
            f"{math.degrees(item.facts['switch_offset']):+.1f}° in {item.run.id}, stated "
            f"{math.degrees(abs(item.run.settings.switch or 0.0)):.1f}°"
        ),
        "Correct switch_deg, or look for jumps of the heading.",
        ("switch", "switch_offset"),
    )


def _off_share(found: float, stated: float) -> float:
    off = abs(found / stated - 1)
    return off if off > SPEED else 0.0


def _off_switch(item: Summary) -> float:
    stated = abs(item.run.settings.switch or 0.0)
    off = item.facts.get("switch", stated) - stated
    if off > 0:
        off = max(0.0, off - item.facts["switch_late"])
    return abs(off) if abs(off) > max(SWITCH, SWITCH_SHARE * stated) else 0.0


def _told(
    summaries: Sequence[Summary],
    size: Callable[[Summary], float],
    check: str,
    severity: Severity,
    say: Callable[[Summary], str],
    remedy: str,
    numbers: Sequence[str],
) -> Iterator[CheckFinding]:
    """One finding for all runs in which something has a size; the largest is quoted."""
    found = [(item, size(item)) for item in summaries]
    found = [(item, value) for item, value in found if value > 0]
    if found:
        worst = max(found, key=lambda pair: pair[1])[0]
        ids = tuple(item.run.id for item, _ in found)
        more = f". So in {len(ids)} of {len(summaries)} runs, here most"
        yield CheckFinding(
            check=check,
            severity=severity,
            message=say(worst) + (more if len(ids) > 1 else "") + ".",
            runs=ids,
            remedy=remedy,
            numbers={name: worst.facts[name] for name in numbers},
        )


CHECKS = (
    Check(
        "standing samples",
        "positions that stand and then catch up; rows without a value",
        examine_samples,
    ),
    Check(
        "stop at the end",
        "propellers that stand at the end of a free-running record",
        examine_stops,
    ),
    Check("headings", "headings that jump; the integral of r against psi", examine_headings),
    Check("false sway", "sway columns that hold a part of the surge, times r", examine_sway),
    Check("rudder order", "rudder columns that step as no rudder does", examine_rudder),
    Check("approach", "approach, rudder and switches of turns and zigzags", examine_manoeuvres),
)
