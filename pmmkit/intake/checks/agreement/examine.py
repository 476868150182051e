"""Runs held against one another and against what hulls usually have, with the cause by name."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.agreement.asking import (
    STRANGE,
    Answer,
    Suspected,
    of_all,
    of_one,
    suspects,
)
from pmmkit.intake.checks.agreement.groups import groups_apart
from pmmkit.intake.checks.agreement.posterior import Agreement, agreement
from pmmkit.intake.checks.agreement.rows import CHANNELS, MAIN, groups_of
from pmmkit.intake.checks.expected import is_shallow
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, name_runs
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

NAMED: Final = 9.0
"""Logarithm of the evidence from which a cause is named."""
SURE: Final = 20.0
"""And from which a slip is an error."""
RIVAL: Final = 2.5
"""Causes whose evidence comes as near as this are named beside it."""
EXPLAINED: Final = 4.0
"""Squared misfit over its expected value that a cause may leave."""
ODD: Final = 5.0
"""Squared misfit beyond chance from which a run is asked what is wrong; from which it is told of
without a cause, `FAR`."""
UNEXPLAINED: Final = 0.03
FAR: Final = 18.0
"""A run that no cause explains is told of if it misses by this share of a channel's usual size."""
SCATTER: Final = 1.2
"""Scatter between runs beyond the usual (variance) from which a common cause is sought."""
UNUSUAL: Final = 1.3
"""Standard deviations by which a derivative is unlike those of hulls: a cause is sought; told."""
LOPSIDED: Final = 0.5
"""Asymmetry of the mass matrix, over the usual, from which a cause is sought."""
FEW: Final = 2
"""Runs at odds up to which it is the runs that are looked at; more may have a common cause."""
MOST: Final = 4
"""Runs that are looked at one by one."""


def examine_agreement(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Each run against what the others of its speed predict, and all against usual hulls.

    A polynomial of third order in the motion, with the derivatives that hulls of these particulars
    usually have as its prior, is fitted to all runs of a speed. Runs that miss what the others
    predict, and campaigns whose runs contradict one another or physics, are asked what slip or
    fault would bring them to agree; it is named where the evidence is clear. Where nothing is at
    odds, groups of runs are asked whether they read otherwise than the rest.
    """
    if campaign.kind != "captive":
        return
    found = [agreement(group) for group in groups_of(campaign, summaries)]
    far = sorted(
        ((beyond, item, place) for item in found for beyond, place in _odd(item)),
        key=lambda entry: -entry[0],
    )
    odd = [(item, place) for _, item, place in far]
    single = [(item, place, of_one(item, place, suspects())) for item, place in odd[:MOST]]
    deep = not is_shallow(campaign)
    few = len(odd) <= FEW
    common: list[Answer] = []
    solved = few and all(_explain(answers) for _, _, answers in single)
    if deep and (not solved or any(_doubtful(item) for item in found)):
        common = _common(found, odd if few else [])
        if not common and few and odd and not any(_explain(answers) for _, _, answers in single):
            common = [x for x in _common(found, []) if x.gain > 2 * NAMED]
        alone = max((answers[0].gain for _, _, answers in single), default=0.0)
        if common and not few and common[0].gain < alone:
            common = []
    apart = [] if common else list(groups_apart(campaign, found, SCATTER))
    inside = {item.group.summaries[place].run.id for item, place in odd}
    if not few and any(inside.issubset(item.runs) for item in apart):
        # What is off in all runs of a group is no slip of each.
        yield from apart
        return
    said = [_of_all(common, found)] if common else []
    if few or not common:
        named = [(item, place) for item, place, answers in single if few or _explain(answers)]
        for item, place, answers in single:
            if (item, place) in named:
                said += _of_one(item, place, answers)
        said += _rest([entry for entry in odd if entry not in named])
    if deep and not common and not odd:
        said += _strange(found)
    yield from said or apart


def _common(found: Sequence[Agreement], without: Sequence[tuple[Agreement, int]]) -> list[Answer]:
    """Causes in all runs that the evidence names, some runs left out."""
    left = {(id(item), place) for item, place in without}
    kept = [
        np.array([(id(item), k) not in left for k in range(len(item.misfit))]) for item in found
    ]
    return [x for x in of_all(found, kept, suspects()) if x.gain > NAMED and x.left < EXPLAINED]


def _explain(answers: Sequence[Answer]) -> list[Answer]:
    """Causes that the evidence names and that leave little."""
    return [x for x in answers if x.gain > NAMED and x.left < EXPLAINED]


def _odd(found: Agreement) -> list[tuple[float, int]]:
    """Runs that miss what the others predict by more than chance, and by how much more."""
    return [(float(x), k) for k, x in enumerate(_beyond(found) - ODD) if x > 0]


def _beyond(found: Agreement) -> Array:
    """Squared misfit of the worst channel of each run beyond what chance makes of it, (n,)."""
    count = found.group.known.sum(axis=2)
    beyond = found.misfit * count - (count + 4 * np.sqrt(2 * count))
    return np.asarray(np.where(count > 0, beyond, -math.inf).max(axis=1))


def _doubtful(found: Agreement) -> bool:
    z = _unusual(found)
    large = max((abs(x) for x in z.values()), default=0.0)
    lopsided = _asymmetry(found) > LOPSIDED
    return bool(large > UNUSUAL or lopsided or np.any(found.excess > SCATTER))


def _unusual(found: Agreement) -> dict[str, float]:
    """By how many standard deviations each main derivative is unlike those of hulls."""
    value, covariance = found.value, np.linalg.inv(found.precision)
    usual = found.group.usual
    out = {}
    for k, name in enumerate(usual.names):
        told = float(usual.covariance[k, k] - covariance[k, k])
        if name in MAIN and told > 0.1 * usual.covariance[k, k]:
            out[name] = float(value[k] - usual.mean[k]) / math.sqrt(told)
    return out


def _asymmetry(found: Agreement) -> float:
    """Yrdot against Nvdot, equal in a mass matrix, over what hulls with way on may have."""
    names, scale = found.group.usual.names, found.group.scale
    one, other = names.index("Yrdot"), names.index("Nvdot")
    both = np.zeros(len(names))
    both[one], both[other] = scale[one], -scale[other]
    usual = float(both @ found.group.usual.covariance @ both)
    return float(abs(both @ found.value)) / math.sqrt(usual)


def _of_one(found: Agreement, place: int, answers: Sequence[Answer]) -> Iterator[CheckFinding]:
    """What is said of a single run."""
    missed = _missed(found, place)
    good = _explain(answers)
    if good:
        yield _named(found, place, good, missed)
    elif missed.max() > UNEXPLAINED and (_beyond(found)[place] > FAR or answers[0].gain > NAMED):
        yield _at_odds(found, place, missed, answers)


def _rest(odd: Sequence[tuple[Agreement, int]]) -> Iterator[CheckFinding]:
    """What is said of runs at odds that nothing explains, all together."""
    far = [
        (float(_missed(item, place).max()), item.group.summaries[place].run.id)
        for item, place in odd
        if _missed(item, place).max() > UNEXPLAINED and _beyond(item)[place] > FAR
    ]
    if far:
        share, worst = max(far)
        yield CheckFinding(
            check="agreement",
            severity="warning",
            message=f"{len(far)} runs miss what the others of their speed predict by more than "
            f"{100 * UNEXPLAINED:.0f} % of the usual size, {worst} by {100 * share:.0f} %, and no "
            f"slip or fault explains it: their forces have a form that no polynomial of third "
            f"order holds (waves, memory, separation), or several records are at fault.",
            runs=tuple(run for _, run in far),
            remedy="Compare the derivatives with and without these runs; see what the diagnosis "
            "says of them.",
            numbers={"missed": share, "runs": float(len(far))},
        )


def _missed(found: Agreement, place: int) -> Array:
    """By what share of its usual size each channel of a run misses what the others predict."""
    group = found.group.only([place])
    value, _ = found.without(place)
    rest = group.rows[0] - group.design(group.histories())[0] @ value
    return np.asarray(np.sqrt(np.nansum(rest**2, axis=1)) / found.group.level)


def _who(found: Agreement, place: int, missed: Array) -> str:
    run = found.group.summaries[place].run
    parts = [
        f"{name} by {100 * share:.0f} %"
        for name, share in zip(CHANNELS, missed, strict=True)
        if share > max(0.01, 0.2 * missed.max())
    ]
    others = len(found.misfit) - 1
    return (
        f"{run.id} is at odds with the other {others} runs at {figure(found.group.speed)} m/s: it "
        f"misses what they predict, {', '.join(parts)} of the usual size"
    )


def _named(found: Agreement, place: int, good: Sequence[Answer], missed: Array) -> CheckFinding:
    best, rivals = _rivals(good)
    run = found.group.summaries[place].run
    return CheckFinding(
        check="agreement",
        severity="error" if best.suspect.slip and best.gain > SURE else "warning",
        message=f"{_who(found, place, missed)}. It agrees if "
        f"{', or if '.join(x.words for x in (best, *rivals))}.",
        runs=(run.id,),
        remedy=_remedy(best.suspect, 'exclude the run (action = "exclude", with the reason)'),
        numbers={"value": best.value, "evidence": best.gain, "missed": float(missed.max())},
        channels=best.suspect.channels if len(best.suspect.channels) < len(CHANNELS) else (),
        cause=best.suspect.cause,
    )


def _at_odds(
    found: Agreement, place: int, missed: Array, answers: Sequence[Answer]
) -> CheckFinding:
    run = found.group.summaries[place].run
    best, rivals = _rivals([x for x in answers if x.left < EXPLAINED] or answers)
    nearest = (
        f" The nearest: {', or '.join(x.words for x in (best, *rivals))}." if best.gain > 0 else ""
    )
    return CheckFinding(
        check="agreement",
        severity="warning",
        message=f"{_who(found, place, missed)}. No single slip or fault explains it for certain."
        f"{nearest}",
        runs=(run.id,),
        remedy="Look at its record and its settings; compare the derivatives with and without it, "
        'and exclude it (action = "exclude") if it is at fault.',
        numbers={"missed": float(missed.max())},
        cause=best.suspect.cause if best.gain > 0 and not best.suspect.slip else "",
    )


def _of_all(answers: Sequence[Answer], found: Sequence[Agreement]) -> CheckFinding:
    best, rivals = _rivals(answers)
    runs = tuple(
        item.run.id
        for own in found
        for item in own.group.summaries
        if best.suspect.concerns(item.run)
    )
    return CheckFinding(
        check="agreement",
        severity="error" if best.suspect.slip and best.gain > SURE else "warning",
        message=f"Taken as stated, the runs contradict one another, or have derivatives that no "
        f"hull has. They agree if in all of them "
        f"{', or if '.join(x.words for x in (best, *rivals))}.",
        runs=runs,
        remedy=_remedy(best.suspect, ""),
        numbers={"value": best.value, "evidence": best.gain},
        channels=best.suspect.channels if len(best.suspect.channels) < len(CHANNELS) else (),
        cause=best.suspect.cause,
    )


def _rivals(answers: Sequence[Answer]) -> tuple[Answer, list[Answer]]:
    best = answers[0]
    return best, [x for x in answers[1:3] if x.gain > best.gain - RIVAL]


def _remedy(suspect: Suspected, other: str) -> str:
    check = "" if suspect.slip else suspect.effect.check
    shows = f" What would show it: {check}." if check else ""
    return f"{suspect.remedy}{f' Or {other}.' if other else ''}{shows}"


def _strange(found: Sequence[Agreement]) -> Iterator[CheckFinding]:
    """Main derivatives that no hull of these particulars has, where no cause was found."""
    told: dict[str, list[tuple[float, Agreement, float]]] = {}
    for item in found:
        for name, z in _unusual(item).items():
            if abs(z) > STRANGE:
                told.setdefault(name, []).append((abs(z), item, z))
    for name, every in told.items():
        _, item, z = max(every, key=lambda entry: entry[0])
        at = item.group.usual.names.index(name)
        size = item.group.scale[at]
        value, mean = item.value[at] * size, item.group.usual.mean[at] * size
        yield CheckFinding(
            check="agreement",
            severity="warning",
            message=f"{name}' comes to about {figure(value)} at {figure(item.group.speed)} m/s; "
            f"hulls of these particulars have {figure(mean)} ± {figure(WIDE * size, 2)} "
            f"(library ships and Clarke, Gedling and Hine 1983).",
            runs=(),
            remedy="Look at the units, signs and axes of this channel, at the inertia and at what "
            f"the runs were set to: {name_runs([x.run.id for x in item.group.summaries])}.",
            numbers={"value": float(value), "usual": float(mean), "z": z},
        )


CHECKS = (
    Check(
        "agreement",
        "each run against what the others predict, and all against usual hulls",
        examine_agreement,
    ),
)
