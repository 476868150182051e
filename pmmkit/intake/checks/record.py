"""Records that were cut off at a limit, and cycles and runs that differ from their sisters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.intake.checks.expected import prime_unit
from pmmkit.intake.checks.finding import Check, CheckFinding, Summary, figure, name_runs
from pmmkit.numerics import Array, stretches
from pmmkit.presentation import counted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign

Cycles = NDArray[np.complex128]

SPIKE: Final = 12.0
"""Usual misses of neighbours by which a sample is a spike. At 12 none of 2,000 records of white,
red, uneven, coarsely rounded and Laplacian noise and of waves has one, and two of 200 of Student's
t of five degrees; of spikes of 20 standard deviations of the noise 9 in 10 are seen, of 15 a tenth.
"""
USUAL: Final = 0.95
"""Share of misses that are usual: a spike makes three, and up to one sample in a hundred is seen.
At .98 two in 200 rows hid each other; at .9 a sixth of records with short bursts has spikes."""
_USUAL_DEVIATION: Final = 1.96
"""Standard deviations that hold the usual share of normal misses."""
ABOUT: Final = 5
"""Samples on each side whose median judges: up to five that jump together are seen."""
FLAT_SHARE: Final = 0.01
FLAT_DENSITY: Final = 6.0
CYCLE_SHARE: Final = 0.03
CYCLE_SIGMAS: Final = 6.5
FEW: Final = 2.5
SISTER_SIGMAS: Final = 5.0
SISTER_SHARE: Final = 0.5


def flat_facts(values: Array) -> Mapping[str, float]:
    """How much of a channel lies flat at its extreme value.

    Examples
    --------
    >>> wave = 10 * np.sin(np.linspace(0, 20, 2001))
    >>> flat_facts(wave)["share"], round(flat_facts(np.clip(wave, -8, 8))["share"], 2)
    (0.0, 0.4)
    """
    finite = values[np.isfinite(values)]
    found = {"share": 0.0, "level": 0.0, "stretches": 0.0}
    if len(finite) < 10 * Summary.FLAT_SAMPLES or finite.max() == finite.min():
        return found
    share, pieces, level = 0.0, 0, 0.0
    for extreme in (finite.max(), finite.min()):
        at = finite == extreme
        count = np.count_nonzero(at)
        rest = finite[~at]
        next_level = rest.max() if extreme == finite.max() else rest.min()
        if count < FLAT_DENSITY * np.count_nonzero(rest == next_level):
            continue
        starts, stops = stretches(at)
        lengths = stops - starts
        long = lengths >= Summary.FLAT_SAMPLES
        if long.any():
            share += float(lengths[long].sum()) / len(finite)
            pieces += int(long.sum())
            level = float(extreme)
    return {"share": share, "level": level, "stretches": float(pieces)}


def spike_facts(values: Array, counts: slice = slice(None)) -> Mapping[str, float]:
    """How many samples of a channel jump away and come back, the largest, and by how much they move
    the mean of what counts (after Hampel 1974: medians judge, so that spikes do not judge
    themselves).

    A sample is one that misses the middle of its neighbours by `SPIKE` times the usual miss, and
    the median of the samples about it by as much. Waves and steps miss neither.

    Examples
    --------
    >>> wave = np.sin(np.linspace(0, 60, 3000))
    >>> wave[[700, 701, 2000]] += 5.0
    >>> facts = spike_facts(wave)
    >>> facts["spikes"], round(facts["spike"], 2)
    (3.0, 5.0)
    """
    places, away = _spikes(values)
    if not places.size:
        return {}
    return {
        "spikes": float(places.size),
        "spike": float(np.max(np.abs(away))),
        "spike_shift": abs(float(np.mean(_at(places, away, len(values))[counts]))),
    }


def without_spikes(values: Array) -> Array:
    """Values (n,) with the median of those about it in the place of each spike."""
    places, away = _spikes(values)
    return values - _at(places, away, len(values))


def _at(places: NDArray[np.intp], away: Array, size: int) -> Array:
    """What stands at some places of a record (size,), and zero elsewhere."""
    found = np.zeros(size)
    found[places] = away
    return found


def _spikes(values: Array) -> tuple[NDArray[np.intp], Array]:
    """Places of the spikes of a channel, and how far each is from the median about it."""
    if len(values) < 4 * ABOUT:
        return np.zeros(0, np.intp), np.zeros(0)
    miss = np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))
    middle, most = np.quantile(miss, [0.5, USUAL])
    limit = SPIKE * max(1.4826 * middle, most / _USUAL_DEVIATION)
    suspects = np.flatnonzero(miss > limit) + 1 if limit > 0 else np.zeros(0, np.intp)
    suspects = np.unique(
        np.clip(suspects[:, None] + np.arange(-1, 2), ABOUT, len(values) - 1 - ABOUT)
    )
    away = np.zeros(0)
    if suspects.size:
        around = values[suspects[:, None] + np.arange(-ABOUT, ABOUT + 1)]
        away = values[suspects] - np.median(around, axis=1)
        largest = float(np.max(np.abs(away)))
        jumped = np.abs(away) > max(limit, 0.2 * largest)  # neighbours of a spike are none
        suspects, away = suspects[jumped], away[jumped]
    return suspects, away


def examine_spikes(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Single samples of a force that jump away and come back: glitches of an amplifier or a log."""
    for channel in ("X", "Y", "N", "K"):
        torn = [item for item in summaries if item.facts.get(f"{channel}_spikes")]
        if not torn:
            continue
        worst = max(torn, key=lambda item: item.facts[f"{channel}_spike_shift"])
        facts = worst.facts
        ids = tuple(item.run.id for item in torn)
        shift, noise = facts[f"{channel}_spike_shift"], worst.harmonic_noise.get(channel, 0.0)
        yield CheckFinding(
            check="spikes",
            severity="warning" if shift > noise else "info",
            message=f"{channel} jumps away and comes back in {name_runs(ids)}: "
            f"{counted(int(facts[f'{channel}_spikes']), 'sample')} in {worst.run.id}, the largest "
            f"by {figure(facts[f'{channel}_spike'])}. "
            + (
                f"The mean moves by {figure(shift)}, where its noise is {figure(noise)}."
                if shift
                else "What counts of the record holds none of them, and may be short for them."
            ),
            runs=ids,
            remedy="Look at the record. Trim it to a part without them, or mend it at its source.",
            numbers={"spikes": facts[f"{channel}_spikes"], "shift": shift, "noise": noise},
            channels=(channel,),
        )


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
                channels=(channel,),
            )


@dataclass(frozen=True)
class _Odd:
    """A run of which one cycle, or the trend over the cycles, is beyond the noise."""

    item: Summary
    away: float
    amplitude: float
    limit: float
    cycle: int
    total: int
    trend: bool


def examine_cycles(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """First harmonics that change from cycle to cycle beyond their noise, or that drift.

    The first cycle is left out: it holds the start. A cycle is conspicuous when its first harmonic
    lies more than 3 % of the amplitude and more than 6.5 times the noise of one cycle from the
    median cycle; a straight line through the cycles when it changes by as much. The noise is the
    usual scatter over the cycles of all runs at that speed; with fewer than four runs it is 2.5
    times the scatter of the cycles but the worst, as few cycles tell it badly.
    """
    for channel in ("X", "Y", "N", "K"):
        items = [item for item in summaries if len(_kept(item, channel)) >= 3]
        speeds = np.array([item.run.settings.speed for item in items])
        scatters = np.array([_scatter(_kept(item, channel)) for item in items])
        odd = []
        for item, speed in zip(items, speeds, strict=True):
            series = scatters[np.abs(speeds / speed - 1) < 0.02]
            found = _odd_cycle(item, channel, _noise(item, series, channel))
            odd += [found] if found is not None else []
        if not odd:
            continue
        worst = max(odd, key=lambda found: found.away / found.limit)
        what = (
            f"changes steadily by {figure(worst.away)} over the cycles of {worst.item.run.id}, "
            f"a trend"
            if worst.trend
            else f"differs between cycles: cycle {worst.cycle} of {worst.total} in "
            f"{worst.item.run.id} lies {figure(worst.away)} from the median cycle"
        )
        yield CheckFinding(
            check="cycles",
            severity="warning",
            message=f"The first harmonic of {channel} {what}, "
            f"{100 * worst.away / worst.amplitude:.0f} % of its {figure(worst.amplitude)}, where "
            f"at most {figure(worst.limit)} is noise"
            + (f"; so in {len(odd)} of {len(items)} runs." if len(odd) > 1 else "."),
            runs=tuple(found.item.run.id for found in odd),
            remedy="Look at the record; take cycles that agree (cycles = …), or trim it.",
            numbers={
                "deviation": worst.away,
                "amplitude": worst.amplitude,
                "limit": worst.limit,
                "cycle": float(worst.cycle),
            },
        )


def _kept(item: Summary, channel: str) -> Cycles:
    """First harmonics of the cycles as complex numbers, without the cycle of the start."""
    cycles = item.cycles.get(channel)
    if cycles is None:
        return np.zeros(0, complex)
    kept = cycles[1:] if len(cycles) > 3 else cycles
    return kept[:, 1] + 1j * kept[:, 2]


def _scatter(first: Cycles) -> float:
    """Standard deviation of each of the two parts over the cycles."""
    away = first - first.mean()
    return math.sqrt(float(np.sum(np.abs(away) ** 2)) / 2 / (len(first) - 1))


def _noise(item: Summary, series: NDArray[np.float64], channel: str) -> float:
    """Noise of one cycle, from the scatter over the cycles of all runs at that speed."""
    own = item.cycle_noise.get(channel, 0.0)
    if len(series) >= 4:
        return max(own, float(np.median(series)))
    first = _kept(item, channel)
    worst = int(np.argmax(np.abs(first - _middle(first))))
    line = _line(first)[1] if len(first) > 3 else math.inf
    return max(own, FEW * min(_scatter(np.delete(first, worst)), line))


def _middle(first: Cycles) -> complex:
    return complex(np.median(first.real), np.median(first.imag))


def _line(first: Cycles) -> tuple[float, float]:
    """Change from the first to the last cycle on a straight line, and what scatters about it."""
    number = np.arange(len(first)) - (len(first) - 1) / 2
    slope = np.sum(number * first) / np.sum(number**2)
    rest = first - first.mean() - slope * number
    free = 2 * max(len(first) - 2, 1)
    return float(abs(slope)) * (len(first) - 1), math.sqrt(float(np.sum(np.abs(rest) ** 2)) / free)


def _odd_cycle(item: Summary, channel: str, noise: float) -> _Odd | None:
    first = _kept(item, channel)
    middle = _middle(first)
    amplitude = max(abs(middle), item.level(channel))
    limit = max(CYCLE_SHARE * amplitude, CYCLE_SIGMAS * noise)
    total = len(item.cycles[channel])
    away = np.abs(first - middle)
    worst = int(np.argmax(away))
    change, rest = _line(first)
    if len(first) > 3 and change > limit and change > CYCLE_SIGMAS * rest:
        return _Odd(item, change, amplitude, limit, total, total, True)
    if away[worst] > limit:
        cycle = total - len(first) + worst + 1
        return _Odd(item, float(away[worst]), amplitude, limit, cycle, total, False)
    return None


_SISTERS: Final = (
    ("v", "Y", "s", "vdot"),
    ("v", "Y", "c", "v"),
    ("v", "N", "c", "v"),
    ("r", "Y", "s", "rdot"),
    ("r", "Y", "c", "r"),
    ("r", "N", "s", "rdot"),
    ("r", "N", "c", "r"),
)


def examine_sisters(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Oscillating runs whose force over motion differs from that of all other runs of the series.

    For each run the ratio that the others agree on (their median) predicts its first harmonic;
    conspicuous is a run that misses by half of the prediction and by 5 times the typical miss.
    """
    for pure, channel, phase, motion in _SISTERS:
        groups: dict[float, list[Summary]] = {}
        for item in summaries:
            if item.run.kind_of_test.pure == pure and abs(item.run.settings.drift) < math.radians(
                0.2
            ):
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


SATURATION = (
    Check("saturation", "forces that stand flat at their extreme value", examine_saturation),
)
CHECKS = (
    *SATURATION,
    Check("spikes", "single samples that jump away and come back", examine_spikes),
    Check("cycles", "first harmonics that change from cycle to cycle", examine_cycles),
    Check("sister runs", "runs out of line with the series they belong to", examine_sisters),
)
