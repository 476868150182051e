"""Signs against physics: drift, rudder, yaw, resistance."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns import Frame
from pmmkit.intake.checks.expected import expected, prime_unit
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, straight_line
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

SIGMAS: Final = 3.0
DRIFT_LIMIT: Final = math.radians(16)
RUDDER_LIMIT: Final = math.radians(25)


@dataclass(frozen=True)
class Slope:
    """A slope of a non-dimensional force over an angle, with the runs behind it."""

    value: float
    std: float
    intercept: float
    runs: tuple[str, ...]

    @property
    def sign(self) -> int:
        """Sign where it is certain by 3 standard errors, else 0."""
        return int(math.copysign(1, self.value)) if abs(self.value) > SIGMAS * self.std else 0

    def __str__(self) -> str:
        return f"{figure(self.value)} ± {figure(WIDE * self.std, 2)} per radian"


def axis_facts(data: xr.Dataset) -> Mapping[str, float]:
    """Whether the side force changed its sign when it was brought to our axes."""
    notes = json.loads(data.attrs.get("conversions", "[]"))
    told = [note.split(":")[1] for note in notes if note.startswith(Frame.TURNED)]
    turned = any("Y" in names.replace(",", " ").split() for names in told)
    return {"sway_axis_turned": 1.0} if turned else {}


def drift_slope(campaign: Campaign, summaries: Sequence[Summary], channel: str) -> Slope | None:
    """Slope of a static force over the drift angle, prime system, up to 16°, rudder amidships."""
    return static_slope(campaign, summaries, channel, "drift", DRIFT_LIMIT)


def rudder_slope(campaign: Campaign, summaries: Sequence[Summary], channel: str) -> Slope | None:
    """Slope of a static force over the rudder angle, prime system, up to 25°, without drift.

    Revolutions and speeds are kept apart: the speed with most runs counts. Without steady tests
    that of rudders that swing: the force in phase with the rudder over its amplitude.
    """
    steady = static_slope(campaign, summaries, channel, "rudder", RUDDER_LIMIT)
    return steady or _swung_slope(campaign, summaries, channel)


def _swung_slope(campaign: Campaign, summaries: Sequence[Summary], channel: str) -> Slope | None:
    found = {
        item.run.id: item.s(channel, 1)
        / prime_unit(campaign, channel, item.run.settings.speed)
        / item.run.settings.rudder_amplitude
        for item in summaries
        if item.run.test == "harmonic_rudder"
        and item.run.settings.rudder_amplitude
        and math.isfinite(item.s(channel, 1))
    }
    if not found:
        return None
    slopes = np.array(list(found.values()))
    value = float(np.median(slopes))
    std = (
        float(slopes.std(ddof=1) / math.sqrt(len(slopes))) if len(slopes) > 1 else 0.25 * abs(value)
    )
    return Slope(value, std, 0.0, tuple(found))


def static_slope(
    campaign: Campaign, summaries: Sequence[Summary], channel: str, angle: str, limit: float
) -> Slope | None:
    """Slope of a force over one angle with the other at zero; None without three angles."""
    other = "rudder" if angle == "drift" else "drift"
    speeds: dict[float, list[Summary]] = {}
    for item in summaries:
        settings = item.run.settings
        if (
            item.run.kind_of_test.upright
            and abs(getattr(settings, other)) < math.radians(0.3)
            and abs(getattr(settings, angle)) <= limit
            and math.isfinite(item.mean(channel))
        ):
            speeds.setdefault(round(settings.speed, 3), []).append(item)
    if not speeds:
        return None
    group = max(speeds.values(), key=lambda items: len({_angle(item, angle) for item in items}))
    if len({_angle(item, angle) for item in group}) < 2:
        return None
    angles: Array = np.array([_angle(item, angle) for item in group])
    forces: Array = np.array(
        [
            item.mean(channel) / prime_unit(campaign, channel, item.run.settings.speed)
            for item in group
        ]
    )
    slope, intercept, std = straight_line(angles, forces)
    if not math.isfinite(std):
        std = 0.25 * abs(slope)
    return Slope(slope, std, intercept, tuple(item.run.id for item in group))


def _angle(item: Summary, angle: str) -> float:
    return round(float(getattr(item.run.settings, angle)), 9)


def examine_signs(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Signs of drift, rudder, yaw damping and resistance.

    With x forward, y to starboard, z down and beta = atan2(-v, u): a positive drift angle pushes
    the hull to starboard and turns its bow away from the flow, so Y and N rise with beta; a
    positive rudder turns the ship to starboard, so Y falls and N rises with delta; yaw is damped;
    a hull without propeller is held back.
    """
    yield from _drift(campaign, summaries)
    yield from _rudder(campaign, summaries)
    yield from _oscillation(campaign, summaries)
    yield from _resistance(summaries)
    yield from _free(summaries)


def _drift(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    slopes = {name: drift_slope(campaign, summaries, name) for name in ("Y", "N")}
    wrong = [name for name, slope in slopes.items() if slope is not None and slope.sign < 0]
    if not wrong:
        return
    turned = any(item.facts.get("sway_axis_turned") for item in summaries)
    if len(wrong) == 2 and turned:
        remedy = (
            'The campaign file turns the sway axis, and with it Y and N: take y = "-y" (or '
            'z = "-z") under [axes] away if the forces are in our axes already; where they are '
            "not, turn drift_positive: without it drift angles go with [axes], with it they say "
            "where the bow is."
        )
    elif len(wrong) == 2:
        remedy = 'Write drift_positive = "port-bow": turning the sign of drift mends both.'
    elif slopes["Y" if wrong == ["N"] else "N"] is None:
        remedy = 'Write drift_positive = "port-bow", or turn the axis of this channel.'
    else:
        other = "N" if wrong == ["Y"] else "Y"
        remedy = (
            f'Turn the sign of {wrong[0]} alone (a correction with action = "flip"): '
            f"{other} has the right sign, so the sign of drift is not to blame."
        )
    for name in wrong:
        slope = slopes[name]
        assert slope is not None
        meaning = (
            "Yv would be positive" if name == "Y" else "the bow would turn into the flow (Munk)"
        )
        yield CheckFinding(
            check="signs",
            severity="error",
            message=f"{name}' over the drift angle is {slope}; it should be positive for "
            f"beta = atan2(-v, u), as {meaning} otherwise.",
            runs=slope.runs,
            remedy=remedy,
            numbers={"slope": slope.value, "std": slope.std},
        )


def _rudder(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    slopes = {name: rudder_slope(campaign, summaries, name) for name in ("Y", "N")}
    if campaign.kind != "captive" or all(slope is None for slope in slopes.values()):
        return
    right = {"Y": -1, "N": 1}
    wrong = [
        name for name, slope in slopes.items() if slope is not None and slope.sign == -right[name]
    ]
    both = len(wrong) == sum(slope is not None for slope in slopes.values())
    for name in wrong:
        slope = slopes[name]
        assert slope is not None
        if both:
            remedy = (
                'Write rudder_positive = "port" (or take it away if it is there): turning the sign '
                "of the rudder mends both Y and N."
            )
        elif name == "Y" and slope.value > 0.5 * abs(expected(campaign).Yv):
            remedy = (
                "A hull answers to drift like this, N rising with Y: the column called rudder "
                "angle may be the drift angle."
            )
        else:
            remedy = f'Turn the sign of {name} alone (a correction with action = "flip").'
        yield CheckFinding(
            check="signs",
            severity="error",
            message=f"{name}' over the rudder angle is {slope}; it should be "
            f"{'negative' if name == 'Y' else 'positive'} for a rudder that turns the ship to "
            f"starboard when positive.",
            runs=slope.runs,
            remedy=remedy,
            numbers={"slope": slope.value, "std": slope.std},
        )


@dataclass(frozen=True)
class Damping:
    """A derivative of an oscillating test from the force in phase with the velocity.

    `derivative, channel, motion`: its name, the force and the velocity. `values`: the ratio of
    each run, prime system. `tests`: their kinds of test.
    """

    derivative: str
    channel: str
    motion: str
    values: Array
    runs: tuple[str, ...]
    tests: str

    @property
    def value(self) -> float:
        """Median of the runs."""
        return float(np.median(self.values))

    @property
    def std(self) -> float:
        """Standard error from the scatter of the runs; 0 of a single one."""
        return float(self.values.std() / math.sqrt(len(self.values)))


_DAMPING: Final = (("v", "Y", "v", "Yv"), ("v", "N", "v", "Nv"), ("r", "N", "r", "Nr"))


def damping(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[Damping]:
    """Yv and Nv of tests that only sway, Nr of tests that only yaw, where runs say them."""
    for pure, channel, motion, derivative in _DAMPING:
        pures = [item for item in summaries if item.run.kind_of_test.pure == pure]
        ratios = {
            item.run.id: item.c(channel, 1)
            / item.c(motion, 1)
            / prime_unit(campaign, channel, item.run.settings.speed)
            * prime_unit(campaign, motion, item.run.settings.speed)
            for item in pures
            if item.c(motion, 1) and math.isfinite(item.c(channel, 1))
        }
        if ratios:
            tests = ", ".join(dict.fromkeys(item.run.test for item in pures))
            values = np.array(list(ratios.values()))
            yield Damping(derivative, channel, motion, values, tuple(ratios), tests)


def _oscillation(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    for found in damping(campaign, summaries):
        if found.value > SIGMAS * found.std:
            meaning = {
                "Yv": "it would drive the sway on",
                "Nv": "the bow would turn into the flow (Munk)",
                "Nr": "it would drive the turn on",
            }[found.derivative]
            yield CheckFinding(
                check="signs",
                severity="error",
                message=f"{found.derivative}' from {len(found.values)} runs of {found.tests} is "
                f"{figure(found.value)} ({found.channel} in phase with the velocity); it should be "
                f"negative, {meaning} otherwise.",
                runs=found.runs,
                remedy="Look at the sign of the channel, of the motion, and at in_phase_with: "
                "the parts in phase and out of phase may be exchanged.",
                numbers={"derivative": found.value, "std": found.std},
            )


def _resistance(summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    towed = [
        item
        for item in summaries
        if (
            item.run.kind_of_test.measures_resistance
            or (item.run.kind_of_test.upright and item.run.settings.propeller_rps == 0)
        )
        and abs(item.run.settings.drift) < math.radians(5)
        and math.isfinite(item.mean("X"))
    ]
    pushed = [item for item in towed if item.mean("X") > 0]
    if towed and len(pushed) > len(towed) / 2:
        largest = max(pushed, key=lambda item: item.mean("X"))
        yield CheckFinding(
            check="signs",
            severity="error",
            message=f"X is positive in {len(pushed)} of {len(towed)} runs without propeller, "
            f"{figure(largest.mean('X'))} N at {figure(largest.run.settings.speed)} m/s; a hull "
            f"that is towed is held back, X should be negative.",
            runs=tuple(item.run.id for item in pushed),
            remedy='Write x = "-x" under [axes], or X = { column = …, factor = -1 } where the '
            "column holds the resistance.",
            numbers={"X": largest.mean("X"), "runs": float(len(pushed))},
        )


def _free(summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    turns = [item for item in summaries if "yaw_per_rudder" in item.facts]
    wrong = [item for item in turns if item.facts["yaw_per_rudder"] < 0]
    if turns and len(wrong) > len(turns) / 2:
        item = wrong[0]
        yield CheckFinding(
            check="signs",
            severity="error",
            message=f"In {len(wrong)} of {len(turns)} free-running tests the yaw rate follows the "
            f"rudder with the opposite sign (in {item.run.id} by "
            f"{figure(item.facts['yaw_per_rudder'])} 1/s); a positive rudder should turn the ship "
            f"to starboard.",
            runs=tuple(item.run.id for item in wrong),
            remedy='Write rudder_positive = "port" (or take it away if it is there), or turn the '
            "sign of psi and r.",
            numbers={"yaw_per_rudder": item.facts["yaw_per_rudder"]},
        )


CHECKS = (
    Check("signs", "drift, rudder, yaw damping and resistance against physics", examine_signs),
)
