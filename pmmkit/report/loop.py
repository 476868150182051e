"""Diagnosis in a report: verdict, evidence, coverage, and how the error falls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.channels import CHANNEL_UNITS
from pmmkit.diagnosis.findings import Diagnosis, Finding
from pmmkit.figures.diagnosis import coverage, error_fall, evidence
from pmmkit.files import write_text
from pmmkit.loop.session import ErrorFall, Session
from pmmkit.plotting.style import svg
from pmmkit.presentation import Cell, Grid, Group, Picture, Section, counted, number
from pmmkit.report.page import page
from pmmkit.version import __version__

WIDE: Final = 1.96
VERDICTS: Final = {
    "noise": "Nothing is missing that these runs could show.",
    "missing_effect": "An effect is missing.",
    "unexplained": "Something is missing, and it is not in the catalogue.",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Loop:
    """A diagnosis and what adding its effects does.

    Parameters
    ----------
    base : str
        The model in words.
    diagnosis : Diagnosis
        Of the base.
    fall : ErrorFall
        Of the base and of each effect that was named.
    end : Diagnosis or None
        Of the base with all of them, where the loop went on.
    """

    base: str
    diagnosis: Diagnosis
    fall: ErrorFall
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
        {"value": " + ".join(found.best) or found.verdict, "label": "answer"},
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
            paragraphs=[f"Asked of {loop.base}: {VERDICTS[found.verdict]}", *_together(found)],
            tables=[_findings(found.findings)] if found.findings else [],
            figures=[
                Picture(
                    svg=svg(evidence(found)),
                    caption="ln evidence of the best effects and sets against no effect; the price "
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
                Picture(
                    svg=svg(coverage(found)),
                    caption="Size that could hide from these runs, over the usual size of each "
                    "effect.",
                )
            ],
        ),
    ]


def _together(found: Diagnosis) -> list[str]:
    said = []
    if found.findings:
        said.append(f"Family: {', '.join(found.families)}.")
    if len(found.group) > 1:
        others = "; ".join(" and ".join(names) for names, _ in found.group[1:])
        said.append(f"These runs cannot tell it from: {others}.")
    if "not_the_whole_story" in found.flags:
        said.append(
            "It is not the whole story: something is left that no named effect explains. Take it "
            "as the nearest relative."
        )
    return said


def _findings(findings: Sequence[Finding]) -> Grid:
    groups = []
    for item in findings:
        rows: list[list[Cell]] = [
            [
                name,
                number(value, 3),
                f"± {number(WIDE * item.std[name], 2)}",
                number(item.typical[name], 2),
            ]
            for name, value in item.coefficients.items()
        ]
        if item.parameter:
            rows.append([item.parameter, number(item.value, 3), "", ""])
        groups.append(Group(rows=rows, title=f"{item.effect}: {item.summary} {_said(item)}"))
    return Grid(head=["coefficient", "value", "95 %", "usual size"], groups=groups, texts=(0,))


def _said(item: Finding) -> str:
    said = f"Evidence {item.evidence}."
    if math.isfinite(item.error_before):
        said += (
            f" Error of left-out conditions {100 * item.error_before:.2f} % to "
            f"{100 * item.error_after:.2f} %."
        )
    if item.separating_test:
        said += f" To be sure: {item.separating_test}."
    return said


def _fall(loop: Loop) -> Section:
    fall = loop.fall
    rows: list[list[Cell]] = []
    tests = list(dict.fromkeys(fall.errors[0].tests))
    channels = fall.errors[0].channels
    for name, item in zip(fall.steps, fall.errors, strict=True):
        own = item.of_channel()
        rows.append(
            [
                name,
                number(100 * item.share(), 3),
                *(number(own[x], 3) for x in channels),
                *(number(100 * item.share(test), 3) for test in tests),
            ]
        )
    units = [f"{name} [{CHANNEL_UNITS[name]}]" for name in channels]
    head = ["after", "all [%]", *units, *(f"{kind_of(name).title} [%]" for name in tests)]
    points = [f"{name} does not lower the error of left-out conditions." for name in fall.useless]
    if loop.end is not None:
        points.append(f"Asked again after the last step: {VERDICTS[loop.end.verdict]}")
    return Section(
        title="How the error falls",
        paragraphs=[
            "Each condition was left out of the fit in turn, with its repeats, and predicted from "
            "all others: root mean square of the error, in newtons and in per cent of the "
            "channel's rms force."
        ],
        points=points,
        tables=[Grid(head=head, groups=[Group(rows=rows)], texts=(0,))],
        figures=[
            Picture(
                svg=svg(error_fall(fall)),
                caption=f"Error after {counted(len(fall.steps) - 1, 'step')}.",
            )
        ],
    )
