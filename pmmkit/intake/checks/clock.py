"""Time stamps: increasing, even, and written with enough digits."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.finding import Check, CheckFinding, Severity, figure
from pmmkit.numerics import Array

if TYPE_CHECKING:
    from pmmkit.base import Problem
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

RESOLUTIONS: Final = (3600.0, 60.0, 10.0, 5.0, 1.0, 0.5, 0.1, 0.05, 0.02, 0.01, 0.005, 0.001)
HEAD: Final = 64
"""First times, which tell most resolutions that are not those of the record."""
GAP: Final = 5.0
COARSE: Final = 0.05
UNEVEN: Final = 0.05
MOSTLY: Final = 0.9
_ROUNDED: Final[tuple[tuple[bool, Severity, str], ...]] = (
    (True, "error", "Time stamps repeat, and no even clock agrees with them"),
    (False, "warning", "Time stamps are rounded"),
)
"""Whether they repeat. `Run.data` has put even clocks in place of stamps that tell one."""


def clock_facts(t: Array) -> Mapping[str, float]:
    """Numbers that describe a column of times.

    t [s]; mapping [s].

    Examples
    --------
    >>> facts = clock_facts(np.round(np.arange(0, 20, 0.3)))
    >>> facts["resolution"], facts["repeats"] > 0
    (1.0, True)
    """
    finite = t[np.isfinite(t)]
    facts = {"samples": float(len(t)), "missing": float(len(t) - len(finite))}
    if len(finite) < 3:
        return facts
    steps = np.diff(finite)
    forward = steps[steps > 0]
    typical = float(np.median(forward)) if len(forward) else 0.0
    mean = abs(float(finite[-1] - finite[0])) / (len(finite) - 1)
    rough = np.abs(finite).max() * 1e-12 + 1e-9
    multiples = (
        unit
        for unit in RESOLUTIONS
        if _are_multiples(finite[:HEAD], unit, rough) and _are_multiples(finite, unit, rough)
    )
    even = float(np.mean(np.abs(steps - typical) <= 0.01 * typical))
    return facts | {
        "step": mean,
        "usual_step": typical,
        "backwards": float(np.count_nonzero(steps < 0)),
        "repeats": float(np.count_nonzero(steps == 0)),
        "gaps": float(np.count_nonzero(steps > GAP * typical)) if typical else 0.0,
        "gap": float(steps.max()),
        "lost": _lost(steps / typical) if typical and even >= MOSTLY else 0.0,
        "unevenness": float(steps.std() / mean) if mean else 0.0,
        "even": even,
        "resolution": next(multiples, 0.0),
    }


def _lost(times: Array) -> float:
    """Rows that an even clock lacks: steps that are two to five times the others, whole ones."""
    whole = np.rint(times)
    short = (whole >= 2) & (whole <= GAP) & (np.abs(times - whole) < 0.05)
    return float(np.sum(whole[short] - 1))


def _are_multiples(times: Array, unit: float, rough: float) -> bool:
    return bool(np.all(np.abs(times - np.rint(times / unit) * unit) < rough))


def examine_clock(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Records whose times no reduction takes; times with gaps, or rounded, or uneven."""
    timed = [item for item in summaries if item.run.kind == "history"]
    for item in timed:
        if item.refused and not _is_rounded(item):
            yield CheckFinding(
                check="time stamps",
                severity="error",
                message=_sentence(item.refused),
                runs=(item.run.id,),
                remedy=item.refused.advice("command") or "",
                numbers=item.facts,
            )
    sound = [item for item in timed if not item.refused]
    yield from _together(
        [item for item in sound if item.facts.get("gaps", 0) and not item.facts.get("backwards")],
        lambda item: (
            f"{item.facts['gaps']:.0f} gaps in {item.run.id}, the longest "
            f"{figure(item.facts['gap'])} s where the mean step is {figure(item.facts['step'])} s"
        ),
        "Time stamps have gaps",
        "Harmonics and means are taken on the times as they stand; leave out what lies about a "
        'gap with a correction (action = "trim") if samples were lost.',
    )
    yield from _together(
        [item for item in sound if item.facts.get("lost")],
        lambda item: (
            f"{item.facts['lost']:.0f} in {item.run.id}, which else has one each "
            f"{figure(item.facts['usual_step'])} s"
        ),
        "Rows of even records are missing",
        "Nothing, if the times are true: means and harmonics are taken on them. If the times were "
        "counted after rows were lost, the phase of what follows is off.",
        severity="info",
    )
    rounded = [item for item in timed if _is_rounded(item)]
    for repeats, severity, title in _ROUNDED:
        yield from _together(
            [item for item in rounded if (item.facts["repeats"] > 0) is repeats],
            lambda item: (
                f"{item.run.id} has steps of {figure(item.facts['step'])} s on average, "
                f"written to {figure(item.facts['resolution'])} s"
            ),
            title,
            "Write the times with more digits, or as sample number times the sampling interval.",
            severity=severity,
        )
    done = {id(item) for item in rounded}
    yield from _together(
        [
            item
            for item in sound
            if item.facts.get("unevenness", 0) > UNEVEN
            and not item.facts.get("gaps")
            and not item.facts.get("lost")
            and not item.facts.get("backwards")
            and id(item) not in done
        ],
        lambda item: (
            f"in {item.run.id} the steps scatter by "
            f"{100 * item.facts['unevenness']:.0f} % about {figure(item.facts['step'])} s"
        ),
        "Steps of time are uneven",
        "Nothing, if the times are true: uneven sampling is allowed.",
        severity="info",
    )


def _sentence(problem: Problem) -> str:
    """What a problem says, with its row."""
    message = problem.message[:1].upper() + problem.message[1:]
    return f"Row {problem.row}: {message}" if problem.row else message


def _is_rounded(item: Summary) -> bool:
    facts = item.facts
    step, resolution = facts.get("step", 0.0), facts.get("resolution", 0.0)
    uneven = facts.get("even", 1.0) < MOSTLY
    return bool(step and uneven and resolution > COARSE * step and not facts.get("backwards"))


def _together(
    items: Sequence[Summary],
    say: Callable[[Summary], str],
    title: str,
    remedy: str,
    severity: Severity = "warning",
) -> Iterator[CheckFinding]:
    """One finding for all runs of which the same is to be said; the first is quoted."""
    if items:
        worst = max(items, key=lambda item: item.facts["unevenness"])
        share = f" in {len(items)} runs" if len(items) > 1 else ""
        yield CheckFinding(
            check="time stamps",
            severity=severity,
            message=f"{title}{share}: {say(worst)}.",
            runs=tuple(item.run.id for item in items),
            remedy=remedy,
            numbers=dict(worst.facts),
        )


CHECKS = (
    Check("time stamps", "times that run backwards, repeat, jump or are rounded", examine_clock),
)
