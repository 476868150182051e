"""What is missing: candidates with their evidence, what each takes away, and what hides."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

from pmmkit.diagnosis import Diagnosis, Session
from pmmkit.effects import CATALOGUE, Effect, is_fault
from pmmkit.models import odds
from pmmkit.presentation import WIDE
from pmmkit.views.pages.drawn import NUMBERS, drawn_over
from pmmkit.views.pages.numbers import short

# One candidate of what may be missing, as the page reads it.


def candidate_page(
    name: str, effect: Effect | None, *, log_odds: float, named: bool, kind: str, **more: Any
) -> dict[str, Any]:
    """A candidate."""
    told: dict[str, Any] = {
        "family": effect.family if effect else "",
        "campaign": "",
        "votes": [],
        "said": "",
        "share": None,
        "lost": False,
        "rivals": [],
        "test": effect.check if effect else "",
        "coefficients": [],
        "shown": True,
        "why": "",
    }
    return {
        "effect": name,
        "kind": kind,
        "summary": (effect.summary or effect.text) if effect else "",
        "log_odds": short(log_odds),
        "evidence": odds(log_odds),
        "named": named,
        **told,
        **more,
    }


def coefficients_page(
    names: Sequence[str], values: Sequence[float], stds: Sequence[float], typical: Sequence[float]
) -> list[dict[str, Any]]:
    """Coefficients with half of their 95 % intervals and usual sizes."""
    rows = zip(names, values, stds, typical, strict=True)
    return [
        {"name": name, "value": short(value), "half": short(WIDE * std), "typical": short(usual)}
        for name, value, std, usual in rows
    ]


SHOWN: Final = 10
"""Candidates beside those that are named."""


def missing_page(
    found: Diagnosis,
    session: Session[Diagnosis],
    heard: Callable[[float, str], None] = lambda _done, _: None,
    *,
    overlays: bool = True,
) -> dict[str, Any]:
    """A diagnosis with what each candidate would do, before anything is added."""
    own = {item.name: item for item in session.evidence.own}
    named = {name for names, _ in found.group for name in names}
    findings = {item.effect: item for item in found.findings}
    visible = {item.name: item for item in found.covered}
    evidence: Any = session.evidence  # of one campaign
    fitted = evidence.fitted(session.steps)
    singles = [
        item for item in found.entries if len(item.names) == 1 and math.isfinite(item.log_evidence)
    ]
    chosen = [
        entry
        for number, entry in enumerate(singles)
        if number < SHOWN or entry.names[0] in {*named, *findings, *own, *fitted}
    ]
    drawn = drawn_over(evidence, session.steps, chosen, heard, numbers=NUMBERS if overlays else 0)
    entries = {**CATALOGUE, **own}
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
                share=drawn["shares"].get(name),
                lost=name not in drawn["shares"],
                rivals=list(finding.rivals if finding else seen.mimics if seen else ()),
                test=finding.separating_test if finding else (effect.check if effect else ""),
                coefficients=coefficients_page(
                    list(finding.coefficients),
                    *(
                        [numbers[x] for x in finding.coefficients]
                        for numbers in (finding.coefficients, finding.std, finding.typical)
                    ),
                )
                if finding
                else [],
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
            for item in sorted(found.covered, key=lambda x: x.hides)
        ],
        "overlays": drawn["overlays"],
        "base": drawn["base"],
        "unasked": _unasked(session, found),
    }


def _unasked(session: Session[Diagnosis], found: Diagnosis) -> list[dict[str, str]]:
    """Effects of one's own that take no part, and why."""
    evidence: Any = session.evidence
    absent = [item for item in evidence.own if item.name not in evidence.kinds]
    return [{"effect": x.name, "why": evidence.why_not_asked(x, found.covered)} for x in absent]
