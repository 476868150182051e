"""Diagnosis in a report: verdict, evidence, coverage, and how the error falls."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.files import write_text
from pmmkit.loop import Session
from pmmkit.loop.evidence import Fall
from pmmkit.presentation import Section, counted
from pmmkit.report.drawn import drawn
from pmmkit.report.page import page
from pmmkit.version import __version__


@dataclass(frozen=True, kw_only=True, eq=False)
class Loop:
    """A diagnosis and what adding its effects does.

    Parameters
    ----------
    base : str
        The model in words.
    diagnosis : Diagnosis
        Of the base.
    fall : Fall
        Of the base and of each effect that was named.
    end : Diagnosis or None
        Of the base with all of them, where the loop went on.
    """

    base: str
    diagnosis: Diagnosis
    fall: Fall
    end: Diagnosis | None = None


def loop_of(session: Session, base: str, *, rounds: int = 1) -> Loop:
    """Diagnose a session, add what is named step by step, what explains most first, and go on.

    Parameters
    ----------
    session : Session
        A model and its tests.
    base : str
        The model in words.
    rounds : int
        Diagnoses at most whose effects are added.
    """
    first = found = session.diagnose()
    for _ in range(rounds):
        for item in found.findings:
            session = session.add(item)
        if rounds == 1 or not found.findings:
            break
        found = session.diagnose()
    return Loop(
        base=base, diagnosis=first, fall=session.fall(), end=None if found is first else found
    )


def write_diagnosis(loop: Loop, path: str | Path, *, title: str, runs: int) -> Path:
    """Write a diagnosis as one HTML file, all or nothing.

    Parameters
    ----------
    loop : Loop
        What was found.
    path : path
        File to write.
    title : str
        Of the tests.
    runs : int
        How many.
    """
    found = loop.diagnosis
    shown = sum(item.shown for item in found.covered)
    tiles = [
        {"value": str(runs), "label": "runs"},
        {"value": f"{shown} of {len(found.covered)}", "label": "effects these runs can show"},
        {"value": f"{100 * found.floor:g} %", "label": "of the rms force does not matter"},
        {"value": found.answer if found.best else found.verdict, "label": "answer"},
    ]
    target = Path(path)
    write_text(
        target,
        page(
            title or "Captive tests",
            f"What {loop.base} lacks, by pmmkit {__version__}.",
            tiles,
            loop_sections(loop),
        ),
    )
    return target


def loop_sections(loop: Loop) -> list[Section]:
    """The sections of a diagnosis.

    Parameters
    ----------
    loop : Loop
        What was found.
    """
    found = loop.diagnosis
    return [
        Section(
            title="What is missing",
            paragraphs=[f"Asked of {loop.base}: {found.sentence}", *_told(found)],
            tables=[found.table()] if found.findings else [],
            figures=[
                drawn(
                    found.plot(),
                    "ln evidence of the best effects and sets against no effect; the price "
                    "of the catalogue's size is taken off.",
                )
            ],
        ),
        *([_fall(loop)] if len(loop.fall.steps) > 1 else []),
        Section(
            title="What these runs could show",
            paragraphs=["Whatever the forces are, an effect below these sizes stays hidden."],
            points=[f"{item.name}: {item.why}." for item in found.not_testable],
            figures=[
                drawn(
                    found.plot_coverage(),
                    "Size that could hide from these runs, over the usual size of each effect.",
                )
            ],
        ),
    ]


def _told(found: Diagnosis) -> list[str]:
    """What is to be said beside the verdict."""
    rivals = "; ".join(" and ".join(names) for names, _ in found.group[1:])
    each = [f"{item.effect}: {text}" for item in found.findings for text in item.remarks()]
    return [
        *found.remarks(),
        *([f"These runs cannot tell it from: {rivals}."] if rivals else []),
        *each,
    ]


def _asked_again(end: Diagnosis) -> list[str]:
    """The verdict on the last step, and what it is about."""
    about = [f"{end.answer}."] if end.verdict != "noise" else []
    return [" ".join(["Asked again after the last step:", end.sentence, *about])]


def _fall(loop: Loop) -> Section:
    fall = loop.fall
    end = _asked_again(loop.end) if loop.end else []
    return Section(
        title="How the error falls",
        paragraphs=[fall.how],
        points=[*fall.remarks(), *end],
        tables=[fall.table()],
        figures=[drawn(fall.plot(), f"Error after {counted(len(fall.steps) - 1, 'step')}.")],
    )
