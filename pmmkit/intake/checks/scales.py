"""Means of oscillating runs against static runs; forces off by a round factor, speeds by any."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.expected import expected, resistance_estimate, round_factor
from pmmkit.intake.checks.finding import Check, CheckFinding, figure
from pmmkit.intake.checks.signs import Slope, drift_slope
from pmmkit.numerics import Array

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign, Settings
    from pmmkit.intake.checks.finding import Summary

MEAN_LIMIT: Final = 2.5
ONE_FACTOR: Final = 1.15
FORCE_RANGE: Final = (0.3, 3.0)
RESISTANCE_RANGE: Final = (0.4, 5.0)
HARMONIC_SHARE: Final = 1.5
MEAN_CHANNELS: Final = ("T", "Y", "N", "X")


def examine_means(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Means of oscillating runs against static runs with the same speed, drift and propeller.

    The mean of an oscillating run holds a little more than the static force (½ Yvrr v r² and the
    like), so a factor above 2.5 either way is needed before anything is said, and the run of the
    smallest yaw rate at each drift angle is the one compared. Runs whose means are already dropped
    are passed over.
    """
    static = [
        item
        for item in summaries
        if item.run.kind_of_test.upright and not item.run.kind_of_test.measures_resistance
    ]
    used = [item for item in summaries if item.run.dynamic and item.run.use_means]
    ratios: dict[str, dict[str, list[tuple[Summary, float]]]] = {}
    for item in _gentlest(used):
        for channel in MEAN_CHANNELS:
            still = _static_value(static, item, channel)
            found = item.mean(channel)
            if _comparable(channel, item, still, found):
                ratios.setdefault(channel, {}).setdefault(item.run.test, []).append(
                    (item, still / found)
                )
    off = {
        channel: pairs
        for channel, tests in ratios.items()
        if _outside(pairs := [pair for group in tests.values() for pair in group])
    }
    everything = np.array([abs(ratio) for pairs in off.values() for _, ratio in pairs])
    for channel, pairs in off.items():
        parts, numbers = [], {}
        for test, group in ratios[channel].items():
            values = np.array([ratio for _, ratio in group])
            middle = float(np.median(values))
            numbers[f"{channel}_{test}"] = middle
            spread = (
                f" ({figure(float(values.min()))} to {figure(float(values.max()))})"
                if len(values) > 1
                else ""
            )
            parts.append(f"{figure(middle)} in {test}{spread}")
        one = float(everything.max() / everything.min()) < ONE_FACTOR
        verdict = (
            f" It is one factor, {figure(float(np.median(everything)))}"
            + (f", near {near}" if (near := round_factor(float(np.median(everything)))) else "")
            + "."
            if one
            else f" Over channels and tests the factor runs from {figure(float(everything.min()))} "
            f"to {figure(float(everything.max()))}: it is not one constant."
        )
        yield CheckFinding(
            check="means",
            severity="error",
            message=f"The static {channel} is {', '.join(parts)} times the mean of {channel} in "
            f"the oscillating runs at the same speed, drift and propeller (1 to 2 expected)."
            f"{verdict}",
            runs=tuple(item.run.id for item, _ in pairs),
            remedy='Give the means their factor (action = "scale").'
            if one
            else 'Leave the means of these runs out (action = "drop means"); their harmonics are '
            "judged on their own.",
            numbers=numbers,
        )


def _gentlest(items: Sequence[Summary]) -> Sequence[Summary]:
    """Of each test, speed and drift the run with the smallest motion."""
    best: dict[tuple[str, float, float], tuple[float, Summary]] = {}
    for item in items:
        settings = item.run.settings
        motion = item.c("v" if item.run.kind_of_test.pure == "v" else "r", 1)
        key = (item.run.test, round(settings.speed, 2), round(settings.drift, 4))
        if math.isfinite(motion) and (key not in best or abs(motion) < best[key][0]):
            best[key] = (abs(motion), item)
    return [item for _, item in best.values()]


def _comparable(channel: str, item: Summary, still: float, found: float) -> bool:
    if not (math.isfinite(still) and math.isfinite(found)) or found == 0:
        return False
    if channel in ("Y", "N"):
        return abs(item.run.settings.drift) > math.radians(1.5)
    if channel == "X":
        kind = item.run.kind_of_test
        return abs(still) > HARMONIC_SHARE * item.level("X") and not (kind.yaws and kind.drifts)
    return True


def _outside(pairs: Sequence[tuple[Summary, float]]) -> bool:
    values = np.array([ratio for _, ratio in pairs])
    middle = float(np.median(values))
    return middle < 1 / MEAN_LIMIT or middle > MEAN_LIMIT


def _static_value(static: Sequence[Summary], item: Summary, channel: str) -> float:
    """Static force at the settings of a run, between the nearest drift angles; nan without."""
    own = item.run.settings
    near = [
        (other.run.settings.drift, other.mean(channel))
        for other in static
        if _alike(other.run.settings, own) and math.isfinite(other.mean(channel))
    ]
    if not near:
        return math.nan
    table = np.array(sorted(near))
    drifts, first = np.unique(table[:, 0].round(6), return_index=True)
    forces = table[first, 1]
    if not drifts[0] - 0.01 <= own.drift <= drifts[-1] + 0.01:
        return math.nan
    gap = np.abs(drifts - own.drift).min()
    if gap > math.radians(4):
        return math.nan
    return float(np.interp(own.drift, drifts, forces))


def _alike(one: Settings, other: Settings) -> bool:
    same_speed = abs(one.speed - other.speed) <= 0.02 * other.speed
    same_rudder = abs(one.rudder - other.rudder) <= math.radians(0.5)
    a, b = one.propeller_rps, other.propeller_rps
    same_propeller = a is None or b is None or abs(a - b) <= 0.02 * max(abs(a), abs(b), 0.1)
    return same_speed and same_rudder and same_propeller


def examine_sizes(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Forces against rough estimates: Y and N over drift, resistance; speeds and angles as well.

    Clarke's formula gives Yv and Nv within some 30 %, the friction line the resistance within a
    factor of two; a force outside a third to three times the estimate is said to be off, with the
    round factor that is nearest.
    """
    guess = expected(campaign)
    slopes = {name: drift_slope(campaign, summaries, name) for name in ("Y", "N")}
    for name, slope, estimate in (("Y", slopes["Y"], -guess.Yv), ("N", slopes["N"], -guess.Nv)):
        if slope is not None and slope.sign:
            yield from _size(campaign, name, slope, estimate)
    yield from _resistance(campaign, summaries, guess.wetted)
    yield from _speeds(campaign, summaries)


def _size(campaign: Campaign, name: str, slope: Slope, estimate: float) -> Iterator[CheckFinding]:
    ratio = abs(slope.value) / estimate
    if FORCE_RANGE[0] < ratio < FORCE_RANGE[1]:
        return
    near = round_factor(ratio, campaign.ship, spread=1.6)
    yield CheckFinding(
        check="units",
        severity="error",
        message=f"{name}' over the drift angle is {slope}; a hull of this shape has about "
        f"{figure(estimate)} (Clarke, Gedling and Hine 1983), so it is {figure(ratio)} times too "
        f"{'large' if ratio > 1 else 'small'}"
        + (f", near {near}." if near else ", which no round factor explains."),
        runs=slope.runs,
        remedy="State the unit of the column ([columns]), the non-dimensional system ([source] "
        "nondimensional) or the unit of the drift angle.",
        numbers={"slope": slope.value, "expected": estimate, "ratio": ratio},
    )


def _resistance(
    campaign: Campaign, summaries: Sequence[Summary], wetted: float
) -> Iterator[CheckFinding]:
    towed = [
        item
        for item in summaries
        if item.run.kind_of_test.measures_resistance
        or (item.run.kind_of_test.upright and item.run.settings.propeller_rps == 0)
    ]
    towed = [
        item
        for item in towed
        if abs(item.run.settings.drift) < math.radians(0.5)
        and abs(item.run.settings.rudder) < math.radians(0.5)
        and math.isfinite(item.mean("X"))
        and campaign.ship.froude(item.run.settings.speed, campaign.water.g) < 0.3
    ]
    if not towed:
        return
    ratios: Array = np.array(
        [
            abs(item.mean("X"))
            / resistance_estimate(campaign.ship, campaign.water, item.run.settings.speed, wetted)
            for item in towed
        ]
    )
    middle = float(np.median(ratios))
    if middle and not RESISTANCE_RANGE[0] < middle < RESISTANCE_RANGE[1]:
        near = round_factor(middle, campaign.ship, spread=1.6)
        yield CheckFinding(
            check="units",
            severity="warning",
            message=f"The resistance in {len(towed)} runs is {figure(middle)} times 1.2 of the "
            f"friction line (0.7 to 2.5 would be usual at low Froude number)"
            + (f", near {near}." if near else "."),
            runs=tuple(item.run.id for item in towed),
            remedy="State the unit of X, and whether friction was deducted.",
            numbers={"ratio": middle},
        )


MODEL_SPEED: Final = 4.5
"""What a carriage tows a merchant hull at, at most [m/s]: Fn 0.5 of a model of 8 m."""
CREEPING: Final = 0.04
"""Froude number below which no programme has all its speeds: in harbours they are 0.04 to 0.08; a
model's speeds over her ship's length are a sixth of what they should be at 1:36."""
USUAL: Final = 0.15
"""Froude number of a tanker's or container ship's tests, between approach and service speed."""


def _speeds_of_a_model(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """The length of the ship beside the speeds of her model."""
    L, g = campaign.ship.L, campaign.water.g
    speed = max((item.run.settings.speed for item in summaries), default=0.0)
    froude = campaign.ship.froude(speed, g)
    if not (L > campaign.ship.LONGEST_MODEL and 0 < speed < MODEL_SPEED and froude < CREEPING):
        return
    length = (speed / USUAL) ** 2 / g
    yield CheckFinding(
        check="units",
        severity="warning",
        message=f"The fastest run has {figure(speed)} m/s, Fn {froude:.3f} of a ship of "
        f"{figure(L)} m: are these speeds of a model beside the length of the ship? At Fn "
        f"{USUAL:g} it would be a model of {figure(length, 2)} m.",
        remedy="Give the particulars of the model under [ship]: L, B, d, mass, Izz.",
        numbers={"froude": froude, "speed": speed},
    )


def _speeds(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    fast = [
        item
        for item in summaries
        if campaign.ship.froude(item.run.settings.speed, campaign.water.g) > 0.55
    ]
    if fast:
        speed = max(item.run.settings.speed for item in fast)
        froude = campaign.ship.froude(speed, campaign.water.g)
        yield CheckFinding(
            check="units",
            severity="warning",
            message=f"{len(fast)} runs have Froude numbers up to {froude:.2f} (speed "
            f"{figure(speed)} m/s); a merchant hull stays below 0.4. In knots it would be "
            f"{froude * 1852 / 3600:.2f}.",
            runs=tuple(item.run.id for item in fast),
            remedy="State the speed in m/s, or L in metres.",
            numbers={"froude": froude, "speed": speed},
        )
    yield from _speeds_of_a_model(campaign, summaries)
    drifts = [
        abs(item.run.settings.drift)
        for item in summaries
        if item.run.test == "static_drift" and item.run.settings.drift
    ]
    if len(drifts) >= 3 and max(drifts) < math.radians(1.0):
        yield CheckFinding(
            check="units",
            severity="warning",
            message=f"The largest of {len(drifts)} drift angles is "
            f"{math.degrees(max(drifts)):.3f}°; read as radians it would be "
            f"{math.degrees(math.degrees(max(drifts))):.1f}°.",
            remedy="Give drift_deg in degrees.",
            numbers={"drift_deg": math.degrees(max(drifts))},
        )


FAR: Final = 8.0
"""Times by which a speed is far from the middle one: below ten, so that a slip of the decimal point
is told, and above 3.3, the farthest of the programmes at hand (KCS in shallow water)."""
FEW: Final = 0.1
"""Share of runs that are few: a series at another speed has more."""


def examine_speeds(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """A few captive runs at a speed that is far from all others: it makes a Froude number of its
    own, and divides forces by its square."""
    moving = [item for item in summaries if item.run.settings.speed > 0.0]
    if campaign.kind != "captive" or not moving:
        return
    speeds = np.array([item.run.settings.speed for item in moving])
    middle = float(np.median(speeds))
    away = np.abs(np.log(speeds / middle))
    far = [item for item, own in zip(moving, away, strict=True) if own > math.log(FAR)]
    if not 0 < len(far) <= FEW * len(moving):
        return
    first = far[0].run
    yield CheckFinding(
        check="speeds",
        severity="warning",
        message=f"The speed of {len(far)} of {len(moving)} runs is far from that of the others: "
        f"{figure(first.settings.speed)} m/s in {first.id}, where {figure(middle)} m/s is usual.",
        runs=tuple(item.run.id for item in far),
        remedy="Correct the speed, or state a correction of it with its reason. If it is right, "
        "reduce these runs by themselves.",
        numbers={"speed": first.settings.speed, "usual": middle},
    )


CHECKS = (
    Check("means", "means of oscillating runs against static runs", examine_means),
    Check(
        "units",
        "forces, speeds and angles off by a round factor",
        examine_sizes,
        by_particulars=True,
    ),
    Check("speeds", "speeds of a few runs far from those of all others", examine_speeds),
)
