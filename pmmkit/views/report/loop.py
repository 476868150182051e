"""A diagnosis as a page: verdict, candidates, what hides, how the error falls, records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pmmkit.base import DataError
from pmmkit.diagnosis import Diagnosis, Fall, Session
from pmmkit.intake import CheckFinding
from pmmkit.models import Step
from pmmkit.presentation import Section, counted
from pmmkit.views.figures.captions import drawn
from pmmkit.views.pages.missing import fall_page, missing_page
from pmmkit.views.pages.page_file import Answers, state_of
from pmmkit.views.pages.sections import told_page
from pmmkit.views.report.sections import checked_section


@dataclass(frozen=True, kw_only=True, eq=False)
class Loop:
    """A diagnosis and what adding its effects does.

    Parameters
    ----------
    base : str
        The model in words.
    session : Session[Diagnosis]
        The base and its tests.
    diagnosis : Diagnosis
        Of the base.
    fall : Fall
        Of the base and of each effect that was named.
    end : Diagnosis or None
        Of the base with all of them, where the loop went on.
    """

    base: str
    session: Session[Diagnosis]
    diagnosis: Diagnosis
    fall: Fall
    end: Diagnosis | None = None

    @classmethod
    def of(cls, session: Session[Diagnosis], base: str, *, rounds: int = 1) -> Loop:
        """Diagnose, add what is named step by step, what explains most first, and go on.

        rounds: diagnoses at most whose effects are added.
        """
        begun, first = session, session.diagnose()
        found = first
        for _ in range(rounds):
            for item in found.proposed:
                session = session.add(item)
            if rounds == 1 or not found.proposed:
                break
            found = session.diagnose()
        return cls(
            base=base,
            session=begun,
            diagnosis=first,
            fall=session.fall(),
            end=None if found is first else found,
        )


def diagnosis_answers(
    loop: Loop, *, title: str, runs: int, findings: Sequence[CheckFinding] = ()
) -> Answers:
    """What the page of a diagnosis of captive tests holds: so many runs, findings of the checks."""
    found = loop.diagnosis
    shown = sum(item.shown for item in found.covered)
    facts = {
        "effects these runs can show": f"{shown} of {len(found.covered)}",
        "of the rms force does not matter": f"{100 * found.floor:g} %",
    }
    return {
        "state": state_of(
            title=title or "Captive tests", kind="captive", runs=runs, model=loop.base
        ),
        "told data": told_page(after=[checked_section(findings)]),
        **loop_answers(loop, facts=facts),
    }


def loop_answers(
    loop: Loop, *, facts: Mapping[str, str], sections: Sequence[Section] = ()
) -> Answers:
    """What the page holds of a diagnosis."""
    found = loop.diagnosis
    missing = missing_page(found, loop.session, overlays=False)
    place = told_page(
        facts={"answer": found.answer if found.best else found.verdict, **facts},
        before=_asked_again(loop),
        after=sections,
        folded=[*found.sections(), *_fall(loop.fall)],
    )
    return {
        "missing": {**missing, "since": 0},
        "fall": fall_page(loop.fall) if len(loop.fall.steps) > 1 else None,
        "told missing": place,
    }


def _fall(fall: Fall) -> list[Section]:
    """The errors after each step in numbers, by kind of test too."""
    if len(fall.steps) < 2:
        return []
    table = [fall.table()]
    said = fall.remarks()
    return [Section(title="Errors by step", paragraphs=[fall.how], points=said, tables=table)]


def _asked_again(loop: Loop) -> list[Section]:
    """What was asked, and the verdict on the last step, where the loop went on."""
    if loop.end is None:
        return []
    about = "" if loop.end.verdict == "noise" else f" {loop.end.answer}."
    first = f"Asked of {loop.base}: {loop.diagnosis.sentence}"
    last = f"Asked again after the last step: {loop.end.sentence}{about}"
    return [Section(paragraphs=[first, last])]


# A diagnosis of free-running records as a page: verdict, errors, records before and after.


def records_answers(
    found: Diagnosis,
    *,
    session: Session[Diagnosis],
    title: str = "",
    findings: Sequence[CheckFinding] = (),
) -> Answers:
    """What the page of a diagnosis of free-running records holds.

    session: that said it; what it worked out is used again. title: of the tests, that of the
    campaign by default. findings: of the checks.
    """
    evidence: Any = session.evidence
    if found.model is None:
        raise DataError("This session is one of captive tests: it is told by a `Loop`.")
    after = session
    for item in found.findings:
        after = after.add(item)
    loop = Loop(base=evidence.base, session=session, diagnosis=found, fall=after.fall())
    shown = sum(item.shown for item in found.covered)
    headings = loop.fall.errors("heading")
    ends = dict.fromkeys(f"{x:.2g}" for x in (headings[0], headings[-1]))
    facts = {
        "effects these records can show": f"{shown} of {len(found.covered)}",
        "heading of records left out, rms error": f"{' → '.join(ends)}°",
    }
    return {
        "state": state_of(
            title=title or evidence.title or "Free-running records",
            kind="free-running",
            runs=len(evidence.system.records),
            model=loop.base,
        ),
        "told data": told_page(after=[checked_section(findings)]),
        **loop_answers(
            loop, facts=facts, sections=[_sailed(evidence, after.steps), _errors(found)]
        ),
    }


def _sailed(evidence: Any, steps: Sequence[Step]) -> Section:
    """Records left out, measured and sailed before and after."""
    records = evidence.sailed(steps)
    return Section(
        title="Records before and after",
        paragraphs=[
            f"{counted(len(records), 'record').capitalize()} that the base misses most, each left "
            "out of the fit. The model sails with the measured inputs through windows, from a "
            "start that the sensors tell for each window; lines break where a window begins. "
            "Bands are 95 % intervals: of the values by the other records, of the forces that "
            "nothing explains, and of the start."
        ],
        figures=[
            drawn(
                evidence.plot(records),
                "Track, heading, how far the heading is off, and yaw rate of records left out.",
            )
        ],
    )


def _errors(found: Diagnosis) -> Section:
    """All errors over windows, and how they came about."""
    return Section(
        title="Errors over windows with the measured rudder",
        paragraphs=[
            "Root mean square; the noise of the sensors is taken off where records are left out."
        ],
        tables=[found.error_table()],
        points=list(found.notes),
    )
