"""Channels that are dead, frozen or stuck, that step or creep, and records without noise."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.finding import Check, CheckFinding, Severity, figure
from pmmkit.numerics import Array, stretches
from pmmkit.signals import design_matrix

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

CHANNELS: Final = ("X", "Y", "N", "K")
HOLD: Final = 5
"""Samples of one value that are a hold."""
FROZEN: Final = 0.08
STUCK: Final = 0.04
RELEASE: Final = 3.0
"""A gauge that sticks comes free with a jump of so many times the finest step."""
BLOCKS: Final = 24
"""Means per cycle (twice as many of a steady record) in which steps and creep are sought."""
CERTAIN: Final = 80.0
"""Squared size of a step or a creep over its standard error."""
SIZE: Final = 0.06
"""And its share of the channel's usual size."""
QUIET: Final = 0.05
ROUNDING: Final = 1e-9


def hold_facts(values: Array) -> Mapping[str, float]:
    """How a channel stands still.

    Examples
    --------
    >>> wave = np.sin(np.linspace(0, 20, 2001))
    >>> held = np.where(np.arange(2001) < 1500, wave, wave[1500])
    >>> hold_facts(wave)["frozen"], round(hold_facts(held)["frozen"], 2)
    (0.0, 0.25)
    """
    x = values[np.isfinite(values)]
    found = {"constant": 0.0, "frozen": 0.0, "stuck": 0.0}
    if len(x) < 10 * HOLD:
        return found
    if np.ptp(x) <= ROUNDING * np.abs(x).max():
        return found | {"constant": 1.0}
    steps = np.abs(np.diff(x))
    same = steps == 0
    if not same.any():
        return found
    starts, stops = stretches(same)
    lengths = stops - starts + 1
    long = lengths >= HOLD
    loose = np.count_nonzero(same) - int((lengths[long] - 1).sum())
    usual = loose / max(len(same) - int((lengths[long] - 1).sum()), 1)
    natural = HOLD + math.log(len(x)) / math.log(1 / min(max(usual, 1e-3), 0.98))
    longest = int(lengths.max())
    if longest > max(2 * natural, FROZEN * len(x)):
        found["frozen"] = longest / len(x)
    quantum = float(steps[steps > 0].min())
    ends = starts + lengths - 1
    inner = long & (ends < len(steps))
    level = x[starts]
    inner &= (level < x.max()) & (level > x.min())
    release = steps[np.minimum(ends, len(steps) - 1)]
    sticks = inner & (release > RELEASE * quantum)
    if np.count_nonzero(sticks) >= 3 and usual < 0.2:
        found["stuck"] = float(lengths[sticks].sum()) / len(x)
    return found


def change_facts(t: Array, values: Array, theta: Array | None) -> tuple[Mapping[str, float], ...]:
    """Steps and creep of channels, beside their mean and their harmonics.

    t [s]; values (c, n).

    Examples
    --------
    >>> t = np.linspace(0, 60, 600)
    >>> noise = np.random.default_rng(0).normal(size=600)
    >>> found, = change_facts(t, (noise + 5.0 * (t > 30))[None], None)
    >>> round(found["step"]), round(found["step_at"] / 10), found["step_f"] > found["creep_f"]
    (5, 3, True)
    """
    cycles = 2.0 if theta is None else (theta[-1] - theta[0]) / (2 * math.pi)
    count = int(min(BLOCKS * max(round(cycles), 2), len(t) // 2, 480))
    if count < 24:
        return tuple({} for _ in values)
    edges = np.linspace(0, len(t), count + 1).astype(int)
    width = np.diff(edges)
    means = np.add.reduceat(values, edges[:-1], axis=1) / width
    time = np.add.reduceat(t, edges[:-1]) / width
    if theta is None:
        basis = np.ones((count, 1))
    else:
        basis = design_matrix(np.add.reduceat(theta, edges[:-1]) / width, 5)
    frame = np.linalg.qr(basis)[0]
    places = np.arange(count // 12, count - count // 12, max(1, count // 48))
    shapes = np.stack(
        [(time - time[0]) / (time[-1] - time[0]), *(np.arange(count) >= k for k in places)], axis=1
    ).astype(float)
    shapes = shapes - frame @ (frame.T @ shapes)
    rest = means - (means @ frame) @ frame.T
    power = np.sum(shapes**2, axis=0)
    sizes = rest @ shapes / power
    gained = sizes**2 * power
    total = np.sum(rest**2, axis=1)
    free = count - basis.shape[1] - 1
    out = []
    for row in range(len(values)):
        best = 1 + int(np.argmax(gained[row, 1:]))
        left = rest[row] - sizes[row, best] * shapes[:, best]
        own = float(left @ left)
        alike = float(np.clip(left[1:] @ left[:-1] / own, 0.0, 0.9)) if own > 0 else 0.0
        wide = (1 + alike) / (1 - alike)
        out.append(
            {
                "creep": float(sizes[row, 0]),
                "creep_f": _over(gained[row, 0], total[row] - gained[row, 0], free, wide),
                "step": float(sizes[row, best]),
                "step_at": float(t[edges[places[best - 1]]]),
                "step_f": _over(gained[row, best], own, free, wide),
            }
        )
    return tuple(out)


def _over(gained: float, left: float, free: int, wide: float) -> float:
    return float(gained / max(left / free * wide, 1e-300))


@dataclass(frozen=True)
class _Fault:
    """What a channel of a run has, by how much."""

    fact: str
    words: str
    remedy: str
    severity: Severity


_FAULTS: Final = (
    _Fault(
        "constant",
        "is dead: it shows one value throughout",
        'Leave the channel out (action = "drop") or the run (action = "exclude").',
        "error",
    ),
    _Fault(
        "frozen",
        "is frozen: it holds its value for {:.0f} % of the record",
        'Leave the run out (action = "exclude"), or that part of it (action = "trim").',
        "error",
    ),
    _Fault(
        "stuck",
        "sticks: it holds its value again and again, for {:.0f} % of the record",
        'Leave the run out (action = "exclude"); look at the gauge and its amplifier.',
        "error",
    ),
)


def examine_gauges(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Force channels that stand still, step or creep within a record.

    A constant is told where the motion oscillates, or where the channel varies in other runs
    (a solver without noise is constant in all steady runs). A step or a creep counts above 6 %
    of the usual size of the channel at that speed and nine standard errors.
    """
    histories = [item for item in summaries if item.run.kind == "history"]
    # A solver that has converged in a steady run holds its value, to the digits that it prints.
    solver = campaign.computed
    for channel in CHANNELS:
        varies = any(
            item.facts.get(f"{channel}_constant") == 0.0
            for item in histories
            if not item.run.dynamic
        )
        for fault in _FAULTS:
            hit = [
                item
                for item in histories
                if item.facts.get(f"{channel}_{fault.fact}", 0.0) > _least(fault.fact)
                and (fault.fact != "constant" or item.run.dynamic or varies)
                and not (fault.fact == "constant" and _rightly_zero(channel, item))
                and not (solver and not item.run.dynamic)
            ]
            yield from _told(channel, fault, hit, len(histories))
        yield from _changes(channel, histories)
        if not solver:
            yield from _quiet(channel, histories)


def _rightly_zero(channel: str, item: Summary) -> bool:
    """No side force, yaw or roll moment of a hull straight ahead, as a solver without noise has it.

    What is constant there at another value is at odds with the other runs.
    """
    settings = item.run.settings
    ahead = not (item.run.dynamic or settings.drift or settings.rudder or settings.heel)
    turns = settings.yaw_rate or settings.radius
    return channel != "X" and ahead and not turns


def _least(fact: str) -> float:
    return {"frozen": FROZEN, "stuck": STUCK}.get(fact, 0.0)


def _told(
    channel: str, fault: _Fault, hit: Sequence[Summary], total: int
) -> Iterator[CheckFinding]:
    if hit:
        name = f"{channel}_{fault.fact}"
        worst = max(hit, key=lambda item: item.facts[name])
        many = f", in {len(hit)} of {total} runs" if len(hit) > 1 else ""
        yield CheckFinding(
            check="gauges",
            severity=fault.severity,
            message=f"{channel} {fault.words.format(100 * worst.facts[name])} "
            f"({worst.run.id}){many}.",
            runs=tuple(item.run.id for item in hit),
            remedy=fault.remedy,
            numbers={fault.fact: worst.facts[name], "runs": float(len(hit))},
            channels=(channel,),
        )


def _changes(channel: str, items: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Steps and creep that are certain and large, the worst run quoted."""
    hit: dict[str, list[tuple[Summary, float]]] = {"step": [], "creep": []}
    levels = _levels(channel, items)
    for item, level in zip(items, levels, strict=True):
        facts = item.facts
        if f"{channel}_step_f" not in facts or not level:
            continue
        kind = "step" if facts[f"{channel}_step_f"] > 1.2 * facts[f"{channel}_creep_f"] else "creep"
        share = abs(facts[f"{channel}_{kind}"]) / level
        if facts[f"{channel}_{kind}_f"] > CERTAIN and share > SIZE:
            hit[kind].append((item, share))
    for kind, found in hit.items():
        if not found:
            continue
        worst, share = max(found, key=lambda pair: pair[1])
        size = worst.facts[f"{channel}_{kind}"]
        what = (
            f"steps by {figure(size)} at t = {figure(worst.facts[f'{channel}_step_at'])} s: its "
            f"zero jumped"
            if kind == "step"
            else f"drifts by {figure(size)} over the record: its zero creeps"
        )
        many = f"; so in {len(found)} of {len(items)} runs" if len(found) > 1 else ""
        yield CheckFinding(
            check="gauges",
            severity="warning",
            message=f"{channel} {what}, {100 * share:.0f} % of its usual size, in "
            f"{worst.run.id}{many}.",
            runs=tuple(item.run.id for item, _ in found),
            remedy='Leave out what lies before or after it (action = "trim"), or the run; zero '
            "records before and after tell the drift of a gauge.",
            numbers={kind: size, "share": share, "runs": float(len(found))},
            channels=(channel,),
        )


def _levels(channel: str, items: Sequence[Summary]) -> list[float]:
    """Usual size of a channel at the speed of each run."""
    sizes = np.array([max(abs(item.mean(channel)), item.level(channel)) for item in items])
    speeds = np.array([item.run.settings.speed for item in items])
    found = []
    for speed in speeds:
        own = sizes[(np.abs(speeds / speed - 1) < 0.02) & np.isfinite(sizes)]
        found.append(float(np.quantile(own, 0.75)) if len(own) else 0.0)
    return found


def _quiet(channel: str, items: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Records with far less noise than those of the other steady, or oscillating, runs."""
    for dynamic in (False, True):
        pairs = [
            (item, size)
            for item in items
            if item.run.dynamic == dynamic
            and not item.facts.get(f"{channel}_constant")
            and (size := _noise(channel, item)) > 0
        ]
        own, noise = [item for item, _ in pairs], np.array([size for _, size in pairs])
        if len(own) < 3:
            continue
        usual = float(np.median(noise))
        hit = [item for item, size in zip(own, noise, strict=True) if size < QUIET * usual]
        if hit and len(hit) <= len(own) / 3:
            worst = own[int(np.argmin(noise))]
            least = float(noise.min())
            yield CheckFinding(
                check="gauges",
                severity="warning",
                message=f"{channel} has {usual / least:.0f} times less "
                f"noise in {worst.run.id} than in the other runs: its record was smoothed, or was "
                f"not measured.",
                runs=tuple(item.run.id for item in hit),
                remedy="Take the record as it was sampled; a run without noise counts too much.",
                numbers={"noise": least, "usual": usual},
            )


def _noise(channel: str, item: Summary) -> float:
    """Noise of a record: about its harmonics, or from sample to sample where it is steady."""
    if item.run.dynamic:
        return item.cycle_noise.get(channel, 0.0)
    return item.facts.get(f"{channel}_noise", 0.0)


CHECKS = (
    Check(
        "gauges",
        "forces that are dead, frozen or stuck, that step or creep, or have no noise",
        examine_gauges,
    ),
)
