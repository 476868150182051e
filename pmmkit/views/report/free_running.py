"""A diagnosis of free-running records as a page: verdict, errors, records before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pmmkit.base import DataError
from pmmkit.diagnosis import Diagnosis, Session
from pmmkit.intake import CheckFinding
from pmmkit.models import Step
from pmmkit.presentation import Section, counted
from pmmkit.views.pages.page_file import state_of
from pmmkit.views.pages.page_room import Answers
from pmmkit.views.pages.sections import PageSection, told_page
from pmmkit.views.report.checked import checked_section
from pmmkit.views.report.drawn import drawn
from pmmkit.views.report.loop import Loop, loop_answers


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
        "told data": told_page(PageSection(after=[checked_section(findings)])),
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
