"""What is missing: candidates with their evidence, what each takes away, and what hides."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Final

from pmmkit.diagnosis import REMOVES, Diagnosis, Fall, Session, Together
from pmmkit.effects import CATALOGUE, Effect, is_fault
from pmmkit.models import Step, odds
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE
from pmmkit.views.pages.numbers import short
from pmmkit.views.pages.records import MOTIONS

# How the error of what is left out falls with each step.


def fall_page(fall: Fall) -> dict[str, Any]:
    """The waterfall: a row per step."""
    if len(fall.campaigns) > 1:
        return {
            "campaigns": [
                {**fall_page(fall.only(name)), "title": name, "steps": _steps(fall, name)}
                for name in fall.campaigns
            ]
        }
    return {
        "unit": fall.unit,
        "of": fall.of,
        "how": fall.how,
        "remarks": list(fall.remarks()),
        "useless": list(fall.useless),
        "steps": _steps(fall, fall.campaigns[0]),
    }


def _steps(fall: Fall, name: str) -> list[dict[str, Any]]:
    """The errors of one campaign after each step."""
    of, units = fall.told[name].of, fall.units(name)
    errors = {x: fall.errors(x, name) for x in fall.quantities(name)}
    levels = fall.levels(of, name)
    return [
        {
            "step": step,
            "error": short(errors[of][place]),
            "level": short(levels[place]),
            "channels": {
                x: {"error": short(own[place]), "unit": units[x]}
                for x, own in errors.items()
                if units[x] != "%"
            },
        }
        for place, step in enumerate(fall.steps)
    ]


# What each candidate alone would do to the tests, before anything is added.


NUMBERS: Final = 120_000
"""Of all paths together, where a page holds one campaign: it stays small enough for one file."""


def drawn_over(
    evidence: Any,
    steps: Sequence[Step],
    chosen: Sequence[Any],
    heard: Callable[[float, str], None],
    *,
    numbers: int = NUMBERS,
) -> dict[str, dict[str, Any]]:
    """What each candidate would do, alone beside the base as it stands."""
    shares, overlays, base = evidence.alone(
        steps, chosen, lambda number, name: heard(number / len(chosen), name), numbers=numbers
    )
    return {
        "shares": {
            name: {
                "all": short(own["all"]),
                "noise": short(own["noise"]),
                "channels": {
                    key: short(x) for key, x in own.items() if key not in ("all", "noise")
                },
            }
            for name, own in shares.items()
        },
        "overlays": {
            name: {
                run: {key: values for key, values in _on_screen(own).items() if key != "t"}
                for run, own in runs.items()
            }
            for name, runs in overlays.items()
        },
        "base": {run: _on_screen(own) for run, own in base.items()},
    }


def _on_screen(columns: Mapping[str, Array]) -> dict[str, list[float]]:
    """Forces as they are, motions in the units of the screen; paths have their times."""
    return {
        name: short(MOTIONS[name][1] * values if name in MOTIONS else values)
        for name, values in columns.items()
    }


# One candidate of what may be missing, as the page reads it.


def candidate_page(
    name: str, effect: Effect | None, *, log_odds: float, named: bool, kind: str, **more: Any
) -> dict[str, Any]:
    """A candidate before it is ranked; `log_odds` are those that a step keeps."""
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
        "named": named,
        **told,
        **more,
    }


def _ranked(
    candidates: Sequence[Mapping[str, Any]],
    found: Diagnosis | Together,
    drawn: Sequence[Mapping[str, Any]],
    own: Collection[str],
    fitted: Collection[str] = (),
) -> list[dict[str, Any]]:
    """Candidates with their evidence in words, those first that take the largest share of the
    held-out misfit of a campaign away, and those last that do not help, with the reason: of
    these only a person's own effects are offered. What was fitted stands before what a linear
    problem promises."""
    ranked = []
    for item in candidates:
        told = [x["shares"].get(item["effect"], {"all": None})["all"] for x in drawn]
        shares = [share for share in told if share is not None]
        most = max(shares, default=math.nan)
        asked = found.diagnoses[item["campaign"]] if item["campaign"] else found  # type: ignore[union-attr]
        words = asked.weight(item["effect"], math.nan if item["named"] else most)
        useless = words == "does not help"
        weighed = asked.log_odds_of(item["effect"])
        why = _why_not(item["effect"], most, weighed, found.best) if useless else ""
        offered = not useless or item["effect"] in own
        share = math.inf if math.isnan(most) else -most
        place = (useless, item["effect"] not in fitted, share, -item["log_odds"])
        said = {"evidence": odds(weighed), "weight": words, "reason": why, "offered": offered}
        ranked.append((place, {**item, **said}))
    return [item for _, item in sorted(ranked, key=lambda pair: pair[0])]


def _why_not(effect: str, share: float, log_odds: float, best: Sequence[str]) -> str:
    """Why a candidate does not help."""
    if share < REMOVES:
        return "It takes nothing of the held-out misfit away."
    if best and effect not in best:
        return f"The tests need no more than {' and '.join(best)}."
    if log_odds < 0.0:
        return f"The tests speak against it: {odds(-log_odds)}."
    return "Another effect explains more."


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
    formula = None if found.formula is None else found.formula.with_titles(CATALOGUE.titles)
    found = replace(found, formula=formula)
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
    candidates = _ranked(candidates, found, [drawn], own, fitted)
    return {
        "verdict": found.verdict,
        "sentence": found.sentence,
        "answer": found.answer,
        "remarks": found.remarks(),
        "formula": _formula(found),
        "floor": found.floor,
        "candidates": candidates,
        "sets": [
            {"effects": list(names), "odds": short(against)} for names, against in found.group
        ],
        "suspected": [
            {"effect": x.effect, "run": x.run, "agrees": x.agrees} for x in found.suspected
        ],
        "hidden": [
            {"effect": item.name, "why": item.why, "size": short(item.hides)}
            for item in found.not_testable
        ],
        "untold": [str(item) for item in found.untold],
        "covered": [
            {"effect": item.name, "size": short(item.hides), "shown": item.shown}
            for item in sorted(found.covered, key=lambda x: x.hides)
        ],
        "overlays": drawn["overlays"],
        "base": drawn["base"],
        "unasked": _unasked(session, found),
    }


def _formula(found: Diagnosis) -> dict[str, Any] | None:
    """What fits where no effect explains, in words, and its terms as effects of one's own."""
    if found.formula is None or not found.formula.terms:
        return None
    effects = [{"name": x.name, "text": x.text} for x in found.formula.effects]
    return {"remarks": found.formula.remarks(), "effects": effects}


def _unasked(session: Session[Diagnosis], found: Diagnosis) -> list[dict[str, str]]:
    """Effects of one's own that take no part, and why."""
    evidence: Any = session.evidence
    absent = [item for item in evidence.own if item.name not in evidence.kinds]
    return [{"effect": x.name, "why": evidence.why_not_asked(x, found.covered)} for x in absent]


# What is missing, as several campaigns say together.


def joint_page(
    found: Together,
    session: Session[Together],
    heard: Callable[[float, str], None] = lambda _done, _: None,
) -> dict[str, Any]:
    """A diagnosis of several campaigns, with what each candidate would do to each of them."""
    own = {item.name: item for item in session.evidence.own}
    entries = {**CATALOGUE, **own}
    named = [item for item in found.singles if item.names[0] in found.best]
    others = [item for item in found.singles if item.names[0] not in found.best][:SHOWN]
    sentences = {item.effect: item.sentence for item in found.belongs}
    ship = [
        _candidate(
            item.names[0],
            entries,
            found,
            # Nothing of a campaign that cannot be asked for it.
            [_vote(name, ballot.log_evidence) for name, ballot in item.ballots.items()],
            sentences,
        )
        for item in (*named, *others)
    ]
    faults = [
        _fault(name, fault, entries, found)
        for name in found.names
        for fault in found.faults_of(name)
    ]
    candidates = [item for item in (*ship, *faults) if item["named"]]
    candidates += [item for item in ship if not item["named"]]
    drawn = _drawn(session, found, candidates, heard)
    return {
        "verdict": found.verdict,
        "sentence": found.sentence,
        "answer": found.answer,
        "remarks": [*found.flags, *sentences.values(), *found.notes],
        "formula": None,
        "floor": session.evidence.floor,
        "candidates": _ranked(candidates, found, drawn, own),
        "sets": [{"effects": list(names), "odds": short(x)} for names, x in found.group],
        "suspected": [],
        "hidden": [{"effect": x.name, "why": x.why, "size": short(x.hides)} for x in found.hidden],
        "untold": [],
        "covered": [],
        "overlays": {},
        "base": {},
        "drawn": drawn,
        "unasked": [
            {"effect": name, "why": ""} for name in own if name not in session.evidence.kinds
        ],
    }


def _drawn(
    session: Session[Together],
    found: Together,
    candidates: Sequence[Mapping[str, Any]],
    heard: Callable[[float, str], None],
) -> list[dict[str, Any]]:
    """What candidates would do to each campaign; nothing of those that it is not asked for."""
    evidence: Any = session.evidence  # of several campaigns
    tables = []
    for number, (name, (item, asked)) in enumerate(evidence.each(session.steps).items()):
        singles = {x.names: x for x in found.diagnoses[name].entries}
        names = [x["effect"] for x in candidates if x["campaign"] in ("", name)]
        chosen = [singles[own,] for own in names if (own,) in singles]
        tables.append(
            drawn_over(
                item,
                asked,
                [x for x in chosen if math.isfinite(x.log_evidence)],
                partial(_told, heard, number, len(found.names)),
                numbers=NUMBERS // len(found.names),
            )
        )
    return tables


def _told(
    heard: Callable[[float, str], None], number: int, count: int, done: float, effect: str
) -> None:
    heard((number + done) / count, effect)


def _candidate(
    name: str,
    entries: Mapping[str, Effect],
    found: Together,
    votes: list[dict[str, Any]],
    sentences: Mapping[str, str],
) -> dict[str, Any]:
    """An effect of the ship, beside the others of the best set if it is one of them."""
    single = next(item for item in found.singles if item.names == (name,))
    measured = next((item for item in found.belongs if item.effect == name), None)
    third = measured.thirds[0] if measured and measured.thirds else None
    return candidate_page(
        name,
        entries.get(name),
        log_odds=found.added.get(name, single.log_evidence),
        named=name in found.best,
        kind="physics",
        votes=votes,
        rivals=[" + ".join(names) for names in found.rivals_of(name)],
        coefficients=coefficients_page(
            measured.coefficients, third.values.tolist(), third.std.tolist(), measured.usual
        )
        if measured and third
        else [],
        said=sentences.get(name, ""),
    )


def _fault(
    campaign: str, name: str, entries: Mapping[str, Effect], found: Together
) -> dict[str, Any]:
    """A fault of one campaign, as it alone says it."""
    own = next((x for x in found.diagnoses[campaign].findings if x.effect == name), None)
    size = own.log_odds if own else 0.0
    return candidate_page(
        name,
        entries.get(name),
        log_odds=size,
        named=True,
        kind="fault",
        campaign=campaign,
        votes=[_vote(campaign, size)],
    )


def _vote(campaign: str, log_odds: float) -> dict[str, Any]:
    return {"campaign": campaign, "log_odds": short(log_odds), "evidence": odds(log_odds)}
