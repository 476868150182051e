"""Records that were cut off at a limit, and cycles and runs that differ from their sisters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.checks.expected import prime_unit
from pmmkit.checks.finding import Array, Check, CheckFinding, figure

if TYPE_CHECKING:
    from pmmkit.checks.summary import Summary
    from pmmkit.runs.run import Campaign

FLAT_SAMPLES: Final = 5
FLAT_SHARE: Final = 0.01
FLAT_DENSITY: Final = 6.0
CYCLE_SHARE: Final = 0.03
CYCLE_SIGMAS: Final = 5.0
SISTER_SIGMAS: Final = 5.0
SISTER_SHARE: Final = 0.5


def flat_facts(values: Array) -> Mapping[str, float]:
    """How much of a channel lies flat at its extreme value.

    Parameters
    ----------
    values : array (n,)
        One channel.

    Returns
    -------
    mapping
        ``share`` of the samples in flat stretches of at least 5 samples at the largest or the
        smallest value, ``level`` (that value), ``stretches`` (how many). All zero where the
        extreme is not markedly more frequent than the level next to it, as in a record that is
        merely written with few digits.

    Examples
    --------
    >>> wave = 10 * np.sin(np.linspace(0, 20, 2001))
    >>> flat_facts(wave)["share"], round(flat_facts(np.clip(wave, -8, 8))["share"], 2)
    (0.0, 0.4)
    """
    finite = values[np.isfinite(values)]
    found = {"share": 0.0, "level": 0.0, "stretches": 0.0}
    if len(finite) < 10 * FLAT_SAMPLES or finite.max() == finite.min():
        return found
    share, stretches, level = 0.0, 0, 0.0
    for extreme in (finite.max(), finite.min()):
        at = finite == extreme
        count = np.count_nonzero(at)
        rest = finite[~at]
        next_level = rest.max() if extreme == finite.max() else rest.min()
        if count < FLAT_DENSITY * np.count_nonzero(rest == next_level):
            continue
        edges = np.flatnonzero(np.diff(np.concatenate(([0], at.astype(np.int8), [0]))))
        lengths = edges[1::2] - edges[::2]
        long = lengths >= FLAT_SAMPLES
        if long.any():
            share += float(lengths[long].sum()) / len(finite)
            stretches += int(long.sum())
            level = float(extreme)
    return {"share": share, "level": level, "stretches": float(stretches)}


def examine_saturation(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Forces that stand still at their extreme: a gauge or an amplifier at its end."""
    for item in summaries:
        for channel in ("X", "Y", "N", "K"):
            share = item.facts.get(f"{channel}_flat_share", 0.0)
            stretches = item.facts.get(f"{channel}_flat_stretches", 0.0)
            if share < FLAT_SHARE or stretches < 2:
                continue
            level = item.facts[f"{channel}_flat_level"]
            yield CheckFinding(
                check="saturation",
                severity="error" if share > 2 * FLAT_SHARE else "warning",
                message=f"{channel} stands flat at its extreme value {figure(level, 4)} in "
                f"{stretches:.0f} stretches, {100 * share:.1f} % of the samples "
                f"(none would be expected): it was cut off there.",
                runs=(item.run.id,),
                remedy='Leave the run out (action = "exclude"), or the cycles concerned '
                '(action = "trim"); set the range of the gauge wider.',
                numbers={"share": share, "level": level, "stretches": stretches},
            )


def examine_cycles(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """First harmonics that change from cycle to cycle beyond their noise, or that drift.

    The first cycle is left out: it holds the start. A cycle is conspicuous when its first harmonic
    lies more than 3 % of the amplitude and more than 5 standard errors (of one cycle) from the
    median of the others.
    """
    for item in summaries:
        for channel, cycles in item.cycles.items():
            kept = cycles[1:] if len(cycles) > 3 else cycles
            if len(kept) < 3:
                continue
            first = kept[:, 1] + 1j * kept[:, 2]
            middle = complex(np.median(first.real), np.median(first.imag))
            away = np.abs(first - middle)
            limit = max(
                CYCLE_SHARE * abs(middle),
                CYCLE_SIGMAS * item.cycle_noise.get(channel, 0.0),
                CYCLE_SHARE * item.level(channel),
            )
            worst = int(np.argmax(away))
            if away[worst] <= limit:
                continue
            steps = np.diff(np.abs(first))
            trend = bool(len(first) > 3 and (np.all(steps > 0) or np.all(steps < 0)))
            yield CheckFinding(
                check="cycles",
                severity="warning",
                message=f"The first harmonic of {channel} differs between cycles: cycle "
                f"{len(cycles) - len(kept) + worst + 1} of {len(cycles)} lies "
                f"{figure(away[worst])} from the median cycle of {figure(abs(middle))}, "
                f"{100 * away[worst] / abs(middle):.0f} %, where at most {figure(limit)} is noise."
                + (" It grows or falls all the way: a trend." if trend else ""),
                runs=(item.run.id,),
                remedy="Look at the record; take cycles that agree (cycles = …), or trim it.",
                numbers={
                    "deviation": float(away[worst]),
                    "amplitude": abs(middle),
                    "limit": limit,
                    "cycle": float(len(cycles) - len(kept) + worst + 1),
                },
            )


_SISTERS: Final = (
    ("pure_sway", "Y", "s", "vdot"), ("pure_sway", "Y", "c", "v"),
    ("pure_sway", "N", "c", "v"),
    ("pure_yaw", "Y", "s", "rdot"), ("pure_yaw", "Y", "c", "r"),
    ("pure_yaw", "N", "s", "rdot"), ("pure_yaw", "N", "c", "r"),
)  # fmt: skip


def examine_sisters(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Oscillating runs whose force over motion differs from that of all other runs of the series.

    For each run the ratio that the others agree on (their median) predicts its first harmonic;
    conspicuous is a run that misses by half of the prediction and by 5 times the typical miss.
    """
    for test, channel, phase, motion in _SISTERS:
        groups: dict[float, list[Summary]] = {}
        for item in summaries:
            if item.run.test == test and abs(item.run.settings.drift) < math.radians(0.2):
                groups.setdefault(round(item.run.settings.speed, 2), []).append(item)
        for group in groups.values():
            if len(group) >= 4:
                yield from _odd_one(campaign, group, channel, phase, motion)


def _odd_one(
    campaign: Campaign, group: Sequence[Summary], channel: str, phase: str, motion: str
) -> Iterator[CheckFinding]:
    speed = group[0].run.settings.speed
    unit = prime_unit(campaign, channel, speed) / prime_unit(campaign, motion, speed)
    take = np.array([[_part(item, motion, phase), _part(item, channel, phase)] for item in group])
    moved, force = take[:, 0], take[:, 1]
    if not np.all(np.isfinite(take)) or np.any(moved == 0):
        return
    ratio = force / moved
    for place, item in enumerate(group):
        others = np.arange(len(group)) != place
        usual = float(np.median(ratio[others]))
        misses = np.abs(force[others] - usual * moved[others])
        typical = max(float(np.median(misses)), item.harmonic_noise.get(channel, 0.0))
        miss = abs(force[place] - usual * moved[place])
        if miss > SISTER_SIGMAS * typical and miss > SISTER_SHARE * abs(usual * moved[place]):
            low, high = float(ratio[others].min() / unit), float(ratio[others].max() / unit)
            part = "displacement" if phase == "s" else "velocity"
            yield CheckFinding(
                check="sister runs",
                severity="warning",
                message=f"{channel} in phase with the {part} over {_dotted(motion)} is "
                f"{figure(float(ratio[place] / unit))} in the prime system; the other "
                f"{len(group) - 1} runs of the series lie between {figure(low)} and "
                f"{figure(high)}.",
                runs=(item.run.id,),
                remedy="Compare the derivatives with and without this run; exclude it if its "
                "record is at fault.",
                numbers={
                    "ratio": float(ratio[place] / unit),
                    "median": usual / unit,
                    "low": low,
                    "high": high,
                    "miss": float(miss),
                    "typical": typical,
                },
            )


def _part(item: Summary, name: str, phase: str) -> float:
    return item.s(name, 1) if phase == "s" else item.c(name, 1)


def _dotted(motion: str) -> str:
    return {"vdot": "v̇", "rdot": "ṙ"}.get(motion, motion)


CHECKS = (
    Check("saturation", "forces that stand flat at their extreme value", examine_saturation),
    Check("cycles", "first harmonics that change from cycle to cycle", examine_cycles),
    Check("sister runs", "runs out of line with the series they belong to", examine_sisters),
)
