"""A diagnosis as a page: verdict, candidates, what hides, and how the error falls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pmmkit.diagnosis import Diagnosis, Fall, Session
from pmmkit.intake import CheckFinding
from pmmkit.presentation import Section
from pmmkit.views.pages.fall import fall_page
from pmmkit.views.pages.missing import missing_page
from pmmkit.views.pages.page_file import state_of
from pmmkit.views.pages.page_room import Answers
from pmmkit.views.pages.sections import PageSection, told_page
from pmmkit.views.report.checked import checked_section


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
        "told data": told_page(PageSection(after=[checked_section(findings)])),
        **loop_answers(loop, facts=facts),
    }


def loop_answers(
    loop: Loop, *, facts: Mapping[str, str], sections: Sequence[Section] = ()
) -> Answers:
    """What the page holds of a diagnosis."""
    found = loop.diagnosis
    missing = missing_page(found, loop.session, overlays=False)
    place = PageSection(
        facts={"answer": found.answer if found.best else found.verdict, **facts},
        before=_asked_again(loop),
        after=sections,
        folded=[*found.sections(), *_fall(loop.fall)],
    )
    return {
        "missing": {**missing, "since": 0},
        "fall": fall_page(loop.fall) if len(loop.fall.steps) > 1 else None,
        "told missing": told_page(place),
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
