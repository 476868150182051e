"""What is missing: candidates with their evidence, what each takes away, and what hides."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

import numpy as np

from pmmkit.diagnosis.captive.adequacy import blocks_of
from pmmkit.diagnosis.captive.held_out import held_out
from pmmkit.diagnosis.captive.least_squares import Stack, sizes_of, solved, stacked
from pmmkit.diagnosis.captive.system import Block, System
from pmmkit.diagnosis.captive.verdict import taken_as_given
from pmmkit.diagnosis.evidence import Entry, Visible
from pmmkit.diagnosis.findings import Diagnosis, Finding
from pmmkit.effects.catalogue import catalogue, is_fault
from pmmkit.loop import Session
from pmmkit.loop.captive import CaptiveTests
from pmmkit.loop.records import FreeRecords
from pmmkit.numerics import Array
from pmmkit.workbench.pages.candidate import candidate_page, coefficients_page
from pmmkit.workbench.pages.numbers import short
from pmmkit.workbench.pages.record_overlays import record_effects

SHOWN: Final = 10
"""Candidates beside those that are named."""

Overlay = dict[str, dict[str, list[float]]]
"""Change of the model by run and channel, harmonic by harmonic [N, N m]."""


def missing_page(
    session: Session[Diagnosis],
    found: Diagnosis,
    heard: Callable[[float, str], None] = lambda _done, _: None,
    *,
    overlays: bool = True,
) -> dict[str, Any]:
    """A diagnosis with what each candidate would do, before anything is added.

    Parameters
    ----------
    session : Session[Diagnosis]
        The tests and what was added.
    found : Diagnosis
        Of this session.
    heard : callable
        Is told the share that is done, and of which candidate.
    overlays : bool
        Whether a page follows that draws candidates over runs; without, candidates of records have
        no share either, which is told by their paths.

    Returns
    -------
    dict
        ``verdict``, ``sentence``, ``remarks``, ``candidates`` (the best first), ``sets`` (the named
        set and its rivals), ``hidden``, ``covered`` (size that could hide of each, the smallest
        first), ``overlays`` by effect, of records also ``base``: their paths without any;
        ``unasked``: effects of one's own that take no part, and why.
    """
    own = {item.name: item for item in session.evidence.own}
    named = {name for names, _ in found.group for name in names}
    findings = {item.effect: item for item in found.findings}
    visible = {item.name: item for item in found.covered}
    fitted = _fitted(session)
    singles = [item for item in found.entries if len(item.names) == 1 and _known(item)]
    chosen = [
        entry
        for number, entry in enumerate(singles)
        if number < SHOWN or entry.names[0] in {*named, *findings, *own, *fitted}
    ]
    shares, changes, base = _effects_of(session, chosen, heard, overlays=overlays)
    entries = {**catalogue(), **own}
    candidates = []
    for entry in chosen:
        name = entry.names[0]
        finding, seen = findings.get(name), visible.get(name)
        effect = entries.get(name)
        candidates.append(
            candidate_page(
                name,
                effect,
                log_odds=finding.log_odds if finding else entry.log_evidence,
                named=finding is not None,
                kind="fault" if is_fault(name) else "physics",
                family=seen.family if seen else "",
                share=shares.get(name),
                lost=name not in shares,
                rivals=list(finding.rivals) if finding else _mimics(seen),
                test=finding.separating_test if finding else (effect.check if effect else ""),
                coefficients=_coefficients(finding),
                shown=seen.shown if seen else True,
                why=seen.why if seen else "",
            )
        )
    candidates.sort(key=lambda x: (not x["named"], x["effect"] not in fitted, -x["log_odds"]))
    return {
        "verdict": found.verdict,
        "sentence": found.sentence,
        "answer": found.answer,
        "remarks": found.remarks(),
        "floor": found.floor,
        "candidates": candidates,
        "sets": [
            {"effects": list(names), "odds": short(against)} for names, against in found.group
        ],
        "suspected": [{"effect": x.effect, "run": x.run} for x in found.suspected],
        "hidden": [
            {"effect": item.name, "why": item.why, "size": short(item.hides)}
            for item in found.not_testable
        ],
        "covered": [
            {"effect": item.name, "size": short(item.hides), "shown": item.shown}
            for item in sorted(found.covered, key=_hidden)
        ],
        "overlays": changes,
        "base": base,
        "unasked": _unasked(session, visible),
    }


def _hidden(seen: Visible) -> float:
    return seen.hides if np.isfinite(seen.hides) else np.inf


def _unasked(session: Session[Diagnosis], visible: Mapping[str, Visible]) -> list[dict[str, str]]:
    """Effects of one's own that take no part, and why."""
    evidence = session.evidence
    absent = [item for item in evidence.own if item.name not in evidence.kinds]
    if isinstance(evidence, FreeRecords):
        return [{"effect": x.name, "why": evidence.why_not_asked(x)} for x in absent]
    return [{"effect": x.name, "why": visible[x.name].why} for x in absent]


def _fitted(session: Session[Diagnosis]) -> set[str]:
    """Effects that a contest of records has fitted through the equations: they stand before those
    of which the linear problem promises more, which the equations may not keep."""
    evidence = session.evidence
    if not isinstance(evidence, FreeRecords):
        return set()
    return {name for item in evidence.contest(session.given).settled for name in item.names}


def _known(entry: Entry) -> bool:
    return bool(np.isfinite(entry.log_evidence))


def _mimics(seen: Any) -> list[str]:
    return [] if seen is None else list(seen.mimics)


def _coefficients(finding: Finding | None) -> list[dict[str, Any]]:
    if finding is None:
        return []
    names = list(finding.coefficients)
    return coefficients_page(
        names,
        *(
            [told[name] for name in names]
            for told in (finding.coefficients, finding.std, finding.typical)
        ),
    )


def _effects_of(
    session: Session[Diagnosis],
    chosen: Sequence[Entry],
    heard: Callable[[float, str], None],
    *,
    overlays: bool,
) -> tuple[dict[str, dict[str, Any]], Mapping[str, Any], Mapping[str, Any]]:
    """By effect the share of the held-out mean square error that it takes away, and the change of
    the model; of records the paths, and those of the base."""
    evidence, names = session.evidence, [entry.names[0] for entry in chosen]

    def told(number: int, name: str) -> None:
        heard(number / len(names), name)

    if isinstance(evidence, FreeRecords):
        if not overlays:
            return {}, {}, {}
        return record_effects(evidence.contest(session.given), names, told)
    assert isinstance(evidence, CaptiveTests)
    found = _captive_effects(evidence.system, session.given, chosen, told, overlays=overlays)
    return (*found, {})


def _captive_effects(
    system: System,
    given: Sequence[str],
    chosen: Sequence[Entry],
    heard: Callable[[int, str], None],
    *,
    overlays: bool,
) -> tuple[dict[str, dict[str, Any]], dict[str, Overlay]]:
    known = taken_as_given(system, given)
    base = held_out(system, known.blocks, with_level=False)
    before = base.of_channel()
    each = [tuple(blocks_of(known.system, entry)) for entry in chosen]
    shares = {}
    for number, (entry, own) in enumerate(zip(chosen, each, strict=True)):
        heard(number, entry.names[0])
        errors = held_out(system, (*known.blocks, *own), with_level=False)
        after = errors.of_channel()
        shares[entry.names[0]] = {
            "all": short(1.0 - (errors.share() / base.share()) ** 2),
            "channels": {name: short(1.0 - (after[name] / before[name]) ** 2) for name in after},
        }
    if not overlays:
        return shares, {}
    # One stack for all: the features of the smooth floor cost most, and are the same for each.
    whole = _Whole.of(system, known.blocks, each)
    without = whole.forces()
    return shares, {
        entry.names[0]: _change(system, without, whole.forces(number))
        for number, entry in enumerate(chosen)
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class _Whole:
    """Base, what is known and all candidates in one stack, and the columns of each candidate."""

    stack: Stack
    known: int
    columns: tuple[slice, ...]

    @classmethod
    def of(
        cls, system: System, known: Sequence[Block], each: Sequence[tuple[Block, ...]]
    ) -> _Whole:
        stack = stacked(
            system, [*known, *(block for own in each for block in own)], floor=system.floor
        )
        first = stack.begin + sum(len(sizes_of(block)) for block in known)
        ends = np.cumsum([first, *(sum(len(sizes_of(block)) for block in own) for own in each)])
        columns = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        return cls(stack=stack, known=first, columns=columns)

    def forces(self, number: int | None = None) -> Mapping[str, Array]:
        """Forces of all rows by channel [N, N m], as the model predicts them that `add` of a
        candidate, or of none, would give."""
        stack = self.stack
        given = range(self.known)
        more = () if number is None else range(stack.plain.shape[1])[self.columns[number]]
        floor = range(len(stack.names), stack.white.shape[1])
        kept = np.array([*given, *more, *floor])
        effects = kept[stack.begin : -1] - stack.begin
        one = replace(stack, white=stack.white[:, kept], centre=stack.centre[effects])
        own = kept[: len(given) + len(more)]
        fitted = stack.plain[:, own] @ solved(one).solution[: len(own)]
        return {name: fitted[rows] for name, rows in stack.places.items()}


def _change(system: System, before: Mapping[str, Array], after: Mapping[str, Array]) -> Overlay:
    found: Overlay = {}
    for channel in system.channels:
        moved = after[channel.name] - before[channel.name]
        for i, rows in zip(channel.views, channel.rows, strict=True):
            view = system.views[i]
            if not view.early:
                found.setdefault(view.run.id, {})[channel.name] = short(moved[rows])
    return found
