"""What a system answers: nothing, effects with their rivals, a suspicion, something unknown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from threadpoolctl import threadpool_limits

from pmmkit.diagnosis.captive.adequacy import LEAST, blocks_of, chosen, flags, refused
from pmmkit.diagnosis.captive.chosen_anew import chosen_anew
from pmmkit.diagnosis.captive.conditioning import condition_on
from pmmkit.diagnosis.captive.coverage import coverage
from pmmkit.diagnosis.captive.evidence import gate, ranked_sets, sets_of
from pmmkit.diagnosis.captive.grid import best_blocks
from pmmkit.diagnosis.captive.held_out import HeldOut, Misfit, held_out
from pmmkit.diagnosis.captive.joint_fit import JointFit, joint_fit, refined
from pmmkit.diagnosis.captive.least_squares import labels
from pmmkit.diagnosis.captive.system import CandidateColumns, System
from pmmkit.diagnosis.evidence import RankedSet, Visible
from pmmkit.diagnosis.findings import Diagnosis, Finding, Nearest, SuspectRun, Verdict
from pmmkit.effects import BY_SPEED

CHANCE: Final = 0.01
"""A best effect that chance alone gives more often than this is no finding; nor is a set whose
errors of left-out conditions noise gives less often."""
ABOVE: Final = "errors of left-out conditions stay above noise"
RIVALS: Final = math.log(20.0)
"""Sets within these odds of the best cannot be told from it (docs/theory/evidence.md)."""


def answer(system: System, given: Sequence[str] = (), *, floor: float, seed: int = 0) -> Diagnosis:
    """Ask a system which effects the base lacks."""
    with threadpool_limits(1):
        return _answered(system, tuple(given), floor, seed)


def _answered(system: System, given: tuple[str, ...], floor: float, seed: int) -> Diagnosis:
    beside, used, known = taken_as_given(system, given)
    sets = sets_of(beside)
    entries = ranked_sets(sets)
    covered = coverage(beside)
    singles = [item for item in entries if len(item.names) == 1]
    chance = gate(beside, max(item.log_evidence for item in singles), seed=seed)
    best = chosen(system, entries, used) if chance < CHANCE else None
    blocks = blocks_of(beside, best) if best else []
    first = entries[0] if chance < CHANCE and entries[0].log_evidence > LEAST else None
    left = refused(system, sets, first, blocks, used) if first else ()
    hanging = tuple(item for item in left if item.run)
    doubts = flags(system, blocks, used, left)
    nearest: Nearest | None = None
    findings: tuple[Finding, ...] = ()
    verdict: Verdict = "unexplained" if doubts else "noise"
    if best:
        together = refined(system, [*known, *blocks])
        after = held_out(system, together)
        misfit = chosen_anew(system, entries, best, after, used).misfit
        if misfit.chance >= CHANCE or _leads_on(system, (*given, *best.names)):
            verdict = "missing_effect"
            findings = _findings(
                system, sets.added(best), together, len(known), after, covered, floor
            )
        else:
            before = held_out(system, together[: len(known)], with_level=False)
            nearest = _nearest(best, before, after, misfit)
        if misfit.chance < CHANCE:
            doubts = doubts or ("not_the_whole_story", ABOVE)
    elif hanging and not flags(system, [item.block for item in hanging], used):
        verdict, doubts = "suspected", (doubts[0], *map(str, hanging))
    elif first and not hanging:
        before = held_out(system, known, with_level=False)
        after = held_out(system, [*known, *blocks_of(beside, first)])
        nearest = _nearest(first, before, after, after.misfit)
    return Diagnosis(
        verdict=verdict,
        group=_group(entries, best) if findings and best else (),
        flags=doubts,
        findings=findings,
        chance=chance,
        covered=covered,
        entries=tuple(entries),
        floor=floor,
        base=system.base.values,
        given=given,
        suspected=tuple(
            SuspectRun(effect=item.block.candidate.name, run=item.run, log_odds=item.log_odds)
            for item in hanging
        ),
        nearest=nearest,
    )


def _leads_on(system: System, named: Sequence[str]) -> bool:
    """Whether effects that leave more than noise do so for want of others in the catalogue.

    A set holds three effects at most, and what changes with the speed is asked for once the term is
    there: where more are missing, what is found beside the set must bring the errors of left-out
    conditions down to the noise.
    """
    beside, used, known = taken_as_given(system, named)
    entries = ranked_sets(sets_of(beside))
    best = chosen(system, entries, used)
    if best is None:
        return False
    after = held_out(system, refined(system, [*known, *blocks_of(beside, best)]))
    return chosen_anew(system, entries, best, after, used).misfit.chance >= CHANCE


def _nearest(entry: RankedSet, before: HeldOut, after: HeldOut, misfit: Misfit) -> Nearest:
    return Nearest(
        effects=entry.names,
        error_before=before.share(),
        error_after=after.share(),
        error_level=after.share(kind="level"),
        channel=misfit.where,
        ratio=misfit.ratio,
    )


def _group(
    entries: Sequence[RankedSet], best: RankedSet
) -> tuple[tuple[tuple[str, ...], float], ...]:
    """Sets of no greater size within `RIVALS` of the best, which stands first."""
    rivals = [
        item
        for item in entries
        if item is not best
        and len(item.names) <= len(best.names)
        and 0.0 <= best.log_evidence - item.log_evidence < RIVALS
    ]
    return tuple(
        (item.names, math.exp(item.log_evidence - best.log_evidence)) for item in (best, *rivals)
    )


def taken_as_given(
    system: System, names: Sequence[str]
) -> tuple[System, tuple[CandidateColumns, ...], tuple[CandidateColumns, ...]]:
    """A system beside effects that the base has, one after another at their best grid points.

    Two neighbouring points stand for a value between them.
    """
    used, blocks = [], []
    for name in names:
        near = best_blocks(system, name, 2)
        system = condition_on(system, near)
        used += near
        blocks.append(near[0])
    return _askable(system, blocks), tuple(used), tuple(blocks)


def _askable(system: System, given: Sequence[CandidateColumns]) -> System:
    """Without what changes a derivative with the speed that the base does not have yet.

    Where most runs have one speed, the term and its change with the speed are one.
    """
    known = {name for names in system.base.names.values() for name in names}
    known |= {name for block in given for name in block.candidate.coefficients}
    blocks = [
        block
        for block in system.blocks
        if all(
            name.removesuffix(BY_SPEED) in known
            for name in block.candidate.coefficients
            if name.endswith(BY_SPEED)
        )
    ]
    return replace(system, blocks=tuple(blocks))


def _findings(
    system: System,
    evidence: Sequence[float],
    together: Sequence[CandidateColumns],
    given: int,
    after: HeldOut,
    covered: Sequence[Visible],
    floor: float,
) -> tuple[Finding, ...]:
    """Each effect after those that are given, with the held-out errors without and with it; the
    largest first."""
    fit = joint_fit(system, together, floor=floor)
    visible = {item.name: item for item in covered}
    findings = [
        _finding(
            block,
            fit,
            visible[block.candidate.name],
            log_odds,
            held_out(system, [item for item in together if item is not block], with_level=False),
            after,
        )
        for block, log_odds in zip(together[given:], evidence, strict=True)
    ]
    return tuple(sorted(findings, key=lambda item: -item.error_before))


def _finding(
    block: CandidateColumns,
    fit: JointFit,
    visible: Visible,
    log_odds: float,
    before: HeldOut,
    after: HeldOut,
) -> Finding:
    c = block.candidate
    values, std = coefficients_of(block, fit)
    old, new = before.of_channel(), after.of_channel()
    return Finding(
        effect=c.name,
        family=c.family,
        kind=c.kind,
        summary=c.summary,
        coefficients=dict(zip(c.coefficients, values, strict=True)),
        std=dict(zip(c.coefficients, std, strict=True)),
        typical=dict(zip(c.coefficients, c.typical, strict=True)),
        value=block.value,
        parameter=c.parameter,
        log_odds=log_odds,
        rivals=tuple(visible.mimics),
        separating_test=c.check,
        error_before=before.share(),
        error_after=after.share(),
        error_level=after.share(kind="level"),
        errors={name: (old[name], new[name]) for name in new},
        levels=after.of_channel(kind="level"),
    )


def coefficients_of(block: CandidateColumns, fit: JointFit) -> tuple[list[float], list[float]]:
    """Values and standard deviations; of a transient its rms share over runs and channels."""
    if not block.candidate.each_run:
        values, std = fit.of(labels(block.candidate))
        return values.tolist(), std.tolist()
    at = [i for i, name in enumerate(fit.names) if name.startswith(f"{block.candidate.name}: ")]
    values, std = fit.values[at], fit.std[at]
    size = float(np.sqrt(np.mean(values**2)))
    return [size], [float(np.sqrt(np.sum((values * std) ** 2)) / (len(at) * size))]
