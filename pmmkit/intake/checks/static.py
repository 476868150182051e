"""Steady runs: how unlike the two sides are, and forces that swing with the model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.finding import Check, CheckFinding, figure, name_runs
from pmmkit.numerics import Array
from pmmkit.presentation import counted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

Facts = dict[str, float]
ASYMMETRIC: Final = 0.03
HYSTERESIS: Final = 0.05


def examine_sides(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Static drift to port against static drift to starboard, and repeated settings.

    Y and N should be odd in the drift angle and X even. What is not is compared with the largest
    force of the series: above 3 % it is told. Runs at the same settings that differ by more than
    5 % of the largest force are told as well (hysteresis, or a run gone wrong).
    """
    series: dict[tuple[float, float, float | None], list[Summary]] = {}
    for item in summaries:
        settings = item.run.settings
        towed = item.run.kind_of_test.measures_resistance
        if item.run.kind_of_test.upright and not towed and not settings.heel:
            key = (round(settings.speed, 3), round(settings.rudder, 4), settings.propeller_rps)
            series.setdefault(key, []).append(item)
    for group in series.values():
        yield from _mirrored(group)
    yield from _repeated([*series.values()])


def _mirrored(group: Sequence[Summary]) -> Iterator[CheckFinding]:
    sides = {round(math.degrees(item.run.settings.drift), 2): item for item in group}
    pairs = [(sides[drift], sides[-drift]) for drift in sides if drift > 0 and -drift in sides]
    if not pairs or abs(group[0].run.settings.rudder) > math.radians(0.3):
        return
    words, numbers = [], {}
    for channel, parity in (("X", -1), ("Y", 1), ("N", 1)):
        left = np.array([[one.mean(channel), other.mean(channel)] for one, other in pairs])
        largest = max(abs(item.mean(channel)) for item in group)
        if not np.all(np.isfinite(left)) or not largest:
            continue
        share = float(np.median(left[:, 0] + parity * left[:, 1])) / 2 / largest
        if abs(share) > ASYMMETRIC:
            words.append(f"{channel} by {100 * share:+.1f} %")
            numbers[channel] = share
    if words:
        yield CheckFinding(
            check="sides",
            severity="info",
            message=f"Drift to both sides differs over {len(pairs)} pairs of runs, in parts of the "
            f"largest force: {', '.join(words)} (0 for a symmetric hull and mount).",
            runs=tuple(item.run.id for pair in pairs for item in pair),
            remedy="Keep the zero offsets (Y0, N0) in the fit; a propeller or a turned model "
            "explains much of it.",
            numbers=numbers,
        )


def _repeated(series: Sequence[Sequence[Summary]]) -> Iterator[CheckFinding]:
    """All settings that were run again, in one sentence."""
    differ: dict[str, list[tuple[float, float, list[Summary]]]] = {}
    again = 0
    for group in series:
        same: dict[float, list[Summary]] = {}
        for item in group:
            same.setdefault(round(item.run.settings.drift, 5), []).append(item)
        for repeats in (own for own in same.values() if len(own) > 1):
            again += 1
            for channel in ("X", "Y", "N"):
                largest = max(abs(item.mean(channel)) for item in group)
                values = np.array([item.mean(channel) for item in repeats])
                if not largest or not np.all(np.isfinite(values)):
                    continue
                apart = float(np.ptp(values))
                if apart > HYSTERESIS * largest:
                    differ.setdefault(channel, []).append((apart / largest, apart, repeats))
    if not differ:
        return
    worst = {name: max(found, key=lambda item: item[0]) for name, found in differ.items()}
    words = [
        f"{channel} in {len(differ[channel])} of {again} by up to {100 * share:.0f} % of the "
        f"largest of its series ({figure(apart)} in {counted(len(repeats), 'run')} like "
        f"{repeats[0].run.id})"
        for channel, (share, apart, repeats) in worst.items()
    ]
    runs = [x.run.id for found in differ.values() for _, _, repeats in found for x in repeats]
    yield CheckFinding(
        check="sides",
        severity="info",
        message=f"Runs at the same settings differ: {', '.join(words)}.",
        runs=tuple(dict.fromkeys(runs)),
        remedy="Look for hysteresis, waiting time between runs, or a wrong setting.",
        numbers={channel: share for channel, (share, _, _) in worst.items()},
    )


SWINGS: Final = ("sinkage", "trim", "phi")
"""Channels in which a model that is free follows waves."""
SHARE: Final = 0.5
"""Least part of the square of a response, and of a force, that lies at the one frequency."""
LARGE: Final = 0.5
"""Amplitude over the mean from which a swinging force is told: of the DTC (benchmark of 2019) it is
1.2 in waves as high as half the draught, and its three runs in calm water are silent."""


def wave_facts(t: Array, force: Array, moved: Iterable[Array]) -> Facts:
    """Period of a swing that a free model and X share in a steady window, and its size."""
    if len(t) < 64:
        return {}
    clock = np.linspace(t[0], t[-1], len(t))
    window = np.hanning(len(t))

    def power(values: Array) -> Array:
        even = np.interp(clock, t, values)
        found: Array = np.abs(np.fft.rfft((even - even.mean()) * window)) ** 2
        return found / max(float(found.sum()), 1e-300)

    spectrum = power(force)
    peak = int(np.argmax(spectrum))
    near = slice(max(peak - 2, 0), peak + 3)
    own = float(spectrum[near].sum())
    size = math.sqrt(2.0 * own) * float(force.std())
    if peak <= 3 or own <= SHARE or size <= LARGE * abs(float(force.mean())):
        return {}
    if not any(power(values)[near].sum() > SHARE for values in moved if np.ptp(values) > 0):
        return {}
    return {"X_swing": size, "X_swing_period": float(np.ptp(t)) / peak}


def examine_waves(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Steady runs in which a force swings with heave, pitch or roll, by more than half its mean.

    A model that is towed through waves has a mean force which holds their drift, and is no
    resistance in calm water.
    """
    swung = [item for item in summaries if "X_swing" in item.facts]
    if not swung:
        return
    worst = max(swung, key=lambda item: item.facts["X_swing"] / max(abs(item.mean("X")), 1e-12))
    size, period = worst.facts["X_swing"], worst.facts["X_swing_period"]
    yield CheckFinding(
        check="waves",
        severity="warning",
        message=f"The model heaves, pitches or rolls, and X swings with it: in {worst.run.id} by "
        f"{figure(size)} N to each side of its mean, {figure(worst.mean('X'))} N, every "
        f"{period:.3g} s. A "
        "model in waves does so; its mean force holds what the waves add.",
        runs=tuple(item.run.id for item in swung),
        remedy="Leave runs in waves out of derivatives of calm water, or compare a model with "
        "waves with them.",
        numbers={"swing": size, "period": period},
    )


def examine_steady(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Steady runs whose forces still change at their end, or jump about: of such a record the last
    part counts, whatever it is."""
    lost = [item for item in summaries if "unsteady_from" in item.facts]
    if not lost:
        return
    ids, begin = tuple(item.run.id for item in lost), lost[0].facts["unsteady_from"]
    yield CheckFinding(
        check="steady",
        severity="warning",
        message=f"Nothing steady was found in {name_runs(ids)}: the forces still change at the "
        f"end. What comes after {figure(begin)} s of {ids[0]} counts.",
        runs=ids,
        remedy='Look at the record. State what counts with a correction (action = "window"), or '
        "leave the run out.",
        numbers={"from": begin},
    )


CHECKS = (
    Check("steady", "steady runs whose forces change to the end", examine_steady),
    Check("waves", "steady forces that swing with heave, pitch or roll", examine_waves),
    Check("sides", "drift to port against starboard, and repeats that differ", examine_sides),
)
