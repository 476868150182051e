"""What forces of any hull have in common: the signs that physics asks of them.

The checks refuse a campaign whose signs are against them; a draft of a campaign file is given the
axes and signs that agree with them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from pmmkit.intake.checks.expected import prime_unit
from pmmkit.intake.checks.inertia import inertia_ratio
from pmmkit.intake.checks.signs import (
    DRIFT_LIMIT,
    SIGMAS,
    Slope,
    damping,
    drift_slope,
    rudder_slope,
)
from pmmkit.numerics import Array
from pmmkit.presentation import counted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

Motion = Literal["ahead", "drift", "rudder", "sway", "yaw"]
"""What a force answers to; ``ahead`` has no sign of its own."""

AHEAD: Final = 0.015
"""Least X straight ahead over the slope of Y with drift, per radian: 0.04 to 0.1 for bare hulls
(S175, KCS, KVLCC2, Mariner of the ship library); a propeller at the point of self-propulsion leaves
less."""
WITHOUT_INERTIA: Final = 0.05
WITH_INERTIA: Final = 0.2
"""Y over r u in yaw, over Y over the acceleration in sway: Yr/Yv̇ is -0.26 to -0.40 (KCS, KVLCC2,
Mariner, S175 of the ship library), (Yr - m)/(Yv̇ - m) is 0.32 to 0.45 for the same ships."""
ALONG_HULL: Final = -0.5
ALONG_TANK: Final = -0.95
"""Growth of X with the square of drift over the slope of Y: (Xvv - Xuu)/|Yv| is -0.06 to -0.30 for
KVLCC2, KCS and S175, -0.68 for the Mariner; along the tank it is 1 less, by the drag of Y."""

SHARE: Final = 0.01
"""Doubt of a slope: this share of the largest force over the range of the angle, which gauges and
rounding leave, whatever the scatter of a few runs says."""
PHASE: Final = 0.02
"""Doubt of a part of a harmonic: this share of its size, a phase that is wrong by one degree."""


@dataclass(frozen=True, kw_only=True)
class AskedSign:
    """One sign that physics asks, and what the runs say of it.

    `motion`: what it answers to. `words`: the quantity in words. `value, std`: it and its
    standard error, prime system where it is a slope of non-dimensional forces. `right`: sign
    that it should have. `runs`: the runs behind it.
    """

    channel: str
    motion: Motion
    words: str
    value: float
    std: float
    right: int
    runs: tuple[str, ...]

    @property
    def verdict(self) -> int:
        """1 as it should be, -1 against physics, 0 not certain by 3 standard errors."""
        if not abs(self.value) > SIGMAS * self.std:
            return 0
        return 1 if self.value * self.right > 0 else -1

    def __str__(self) -> str:
        """Without the number: a draft has it over a ship and a speed that nobody stated."""
        word = {1: "as it should be", -1: "against physics", 0: "not certain"}[self.verdict]
        return f"{self.words} is {word} ({counted(len(self.runs), 'run')})"


def asked_signs(campaign: Campaign, summaries: Sequence[Summary]) -> tuple[AskedSign, ...]:
    """The signs that physics asks of captive tests, of which the runs say something.

    With x forward, y to starboard, z down and beta = atan2(-v, u): Y and N rise with drift, Y falls
    and N rises with the rudder, sway and yaw are damped and their inertia is positive, a hull is
    held back.
    """
    return (
        *_slopes(campaign, summaries),
        *_damped(campaign, summaries),
        *_inertia(summaries),
        *_ahead(campaign, summaries),
    )


def inertia_inside(summaries: Sequence[Summary]) -> tuple[bool, float] | None:
    """Whether the model's inertia is in Y, told without knowing it; and the ratio that says so.

    In tests that only yaw the inertia adds -m to Y over r u, which is small and of the other sign
    without it; tests that only sway give its measure. Motions and Y must have their right signs.
    """
    swayed, turned = inertia_ratio("Y", summaries), inertia_ratio("Yr", summaries)
    if swayed is None or turned is None or not abs(swayed.slope) > SIGMAS * swayed.error:
        return None
    ratio = turned.slope / swayed.slope
    noise = SIGMAS * np.nan_to_num(turned.error) / abs(swayed.slope)
    if ratio - noise > WITH_INERTIA:
        return True, ratio
    return (False, ratio) if ratio + noise < WITHOUT_INERTIA else None


def along_tank(campaign: Campaign, summaries: Sequence[Summary]) -> tuple[bool, float] | None:
    """Whether forces of drift stay along the tank while the hull is turned in it; and the ratio.

    Along the tank X holds the drag of the side force, -Y sin(beta), which the hull itself hardly
    has. X must have its right sign.
    """
    slope = drift_slope(campaign, summaries, "Y")
    found = _drifting(summaries)
    if slope is None or not slope.sign or len(found) < 4:
        return None
    beta = np.array([item.run.settings.drift for item in found])
    forces = np.array([item.mean("X") / _pressure(campaign, item) for item in found])
    if len(set(np.round(beta**2, 6))) < 3 or np.max(np.abs(beta)) < math.radians(5):
        return None
    ratio = float(np.polyfit(beta**2, forces, 1)[0]) / abs(slope.value)
    if ratio < ALONG_TANK:
        return True, ratio
    return (False, ratio) if ratio > ALONG_HULL else None


def _drifting(summaries: Sequence[Summary]) -> list[Summary]:
    return [
        item
        for item in summaries
        if item.run.kind_of_test.upright
        and abs(item.run.settings.rudder) < math.radians(0.3)
        and abs(item.run.settings.drift) <= DRIFT_LIMIT
        and math.isfinite(item.mean("X"))
    ]


def _pressure(campaign: Campaign, item: Summary) -> float:
    return 0.5 * campaign.water.rho * campaign.ship.L**2 * item.run.settings.speed**2


def _slopes(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[AskedSign]:
    for motion, words, slope_of, right in (
        ("drift", "the drift angle", drift_slope, {"Y": 1, "N": 1}),
        ("rudder", "the rudder angle", rudder_slope, {"Y": -1, "N": 1}),
    ):
        for channel, sign in right.items():
            slope = slope_of(campaign, summaries, channel)
            if slope is not None:
                doubt = _doubt_of_slope(campaign, summaries, channel, motion, slope)
                yield AskedSign(
                    channel=channel,
                    motion=motion,  # type: ignore[arg-type]
                    words=f"{channel}' over {words}",
                    value=slope.value,
                    std=max(slope.std, doubt),
                    right=sign,
                    runs=slope.runs,
                )


def _named(summaries: Sequence[Summary], runs: Sequence[str]) -> list[Summary]:
    found = {item.run.id: item for item in summaries}
    return [found[run] for run in runs]


def _doubt_of_slope(
    campaign: Campaign, summaries: Sequence[Summary], channel: str, angle: str, slope: Slope
) -> float:
    """Standard error of a slope by the noise of the means, and by what gauges and zeros leave.

    A force without angle that is larger than what the angle makes of it is no answer of a hull.
    """
    items = _named(summaries, slope.runs)
    unit = [prime_unit(campaign, channel, item.run.settings.speed) for item in items]
    if items[0].run.kind_of_test.swings_rudder:
        doubts = [_doubt_of_harmonic(item, channel) for item in items]
        sizes = [item.run.settings.rudder_amplitude or math.inf for item in items]
        return float(np.median(np.array(doubts) / unit / sizes))
    noise = np.array([item.harmonic_noise.get(channel, 0.0) for item in items]) / unit
    largest = float(np.max(np.abs([item.mean(channel) for item in items] / np.array(unit))))
    angles = np.array([float(getattr(item.run.settings, angle)) for item in items])
    centred = angles - angles.mean()
    by_noise = float(np.sqrt(np.sum((noise * centred) ** 2)) / np.sum(centred**2))
    left = max(SHARE * largest, abs(slope.intercept) / 2)
    return max(by_noise, left / float(np.ptp(angles)))


def _doubt_of_harmonic(item: Summary, channel: str) -> float:
    """Standard error of a part of the first harmonic of a force."""
    size = float(np.hypot(item.c(channel, 1), item.s(channel, 1)))
    return max(item.harmonic_noise.get(channel, 0.0), PHASE * size)


def _damped(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[AskedSign]:
    for found in damping(campaign, summaries):
        items = _named(summaries, found.runs)
        scale = [
            prime_unit(campaign, found.motion, item.run.settings.speed)
            / prime_unit(campaign, found.channel, item.run.settings.speed)
            / abs(item.c(found.motion, 1))
            for item in items
        ]
        doubts = [
            one * _doubt_of_harmonic(item, found.channel)
            for one, item in zip(scale, items, strict=True)
        ]
        yield AskedSign(
            channel=found.channel,
            motion="sway" if found.motion == "v" else "yaw",
            words=f"{found.derivative}' of {found.tests}",
            value=found.value,
            std=max(found.std, float(np.median(doubts))),
            right=-1,
            runs=found.runs,
        )


def _inertia(summaries: Sequence[Summary]) -> Iterator[AskedSign]:
    for key, motion, words in (
        ("Y", "sway", "Y over the sway acceleration"),
        ("N", "yaw", "N over the yaw acceleration"),
    ):
        ratio = inertia_ratio(key, summaries)
        if ratio is not None:
            accelerated = "vdot" if motion == "sway" else "rdot"
            doubts = [
                _doubt_of_harmonic(item, key) / abs(item.s(accelerated, 1))
                for item in _named(summaries, ratio.runs)
            ]
            yield AskedSign(
                channel=key,
                motion=motion,  # type: ignore[arg-type]
                words=words,
                value=ratio.slope,
                std=float(np.nanmax([ratio.error, np.median(doubts)])),
                right=-1,
                runs=ratio.runs,
            )


def _ahead(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[AskedSign]:
    """X of straight runs of which no propeller is known, where it is large enough to be drag."""
    straight = [
        item
        for item in summaries
        if item.run.kind_of_test.upright
        and not item.run.settings.propeller_rps
        and abs(item.run.settings.drift) < math.radians(5)
        and abs(item.run.settings.rudder) < math.radians(5)
        and math.isfinite(item.mean("X"))
    ]
    if not straight:
        return
    side = drift_slope(campaign, summaries, "Y")
    values: Array = np.array([item.mean("X") / _pressure(campaign, item) for item in straight])
    value = float(np.median(values))
    alike = bool(np.all(np.sign(values) == np.sign(value)))
    noise = max(item.harmonic_noise.get("X", 0.0) / _pressure(campaign, item) for item in straight)
    large = side is not None and abs(value) > max(AHEAD * abs(side.value), 2 * SIGMAS * noise)
    yield AskedSign(
        channel="X",
        motion="ahead",
        words="X' straight ahead",
        value=value,
        std=abs(value) / (2 * SIGMAS) if alike and large else abs(value),
        right=-1,
        runs=tuple(item.run.id for item in straight),
    )
