"""Results as pages, each one HTML file that needs nothing else; a reduction with all of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import singledispatch
from pathlib import Path
from typing import Any

from pmmkit.diagnosis import Diagnosis
from pmmkit.files import write_text
from pmmkit.models import ReferenceTable
from pmmkit.presentation import Picture, Section, counted, percent
from pmmkit.reduction import Reduction
from pmmkit.seakeeping import Rao
from pmmkit.validation import Comparison
from pmmkit.views.pages.derivatives import derivatives_page
from pmmkit.views.pages.page_file import page_file, state_of
from pmmkit.views.pages.page_room import Answers
from pmmkit.views.pages.sections import PageSection, told_page
from pmmkit.views.pages.turning import track_page
from pmmkit.views.report import pictures, sections, tables
from pmmkit.views.report.captive.document import Document
from pmmkit.views.report.captive.html import write_document
from pmmkit.views.report.checked import checked_section
from pmmkit.views.report.comparison import comparison_answers
from pmmkit.views.report.free_running import records_answers
from pmmkit.views.report.loop import Loop, diagnosis_answers, loop_answers
from pmmkit.views.report.seakeeping import seakeeping_answers
from pmmkit.views.report.turning import Turns, turning_section


def write_report(result: Any, path: str | Path, **about: Any) -> Path:
    """Write the report of a result as one HTML file: style and figures inside, nothing loaded.

    Parameters
    ----------
    result : Reduction, Comparison, Loop, Diagnosis, Rao or Document
        What is told: derivatives, a model beside tests, a diagnosis of captive tests or of
        records, a ship in waves, or a test report.
    path : path
        File to write, all or nothing; of a test report also ``.docx``, for Word.
    **about
        Of a reduction ``reference`` (values of a source to stand beside ours), ``turns``
        (`Turns` with the model that was found) and ``loop`` (what a simpler model of the same
        runs lacks). Of a comparison and of both diagnoses ``findings`` of the checks; of these
        ``title``, of captive tests ``runs`` (how many), of records the ``session`` that was asked.
        Of a ship in waves ``added``, ``responses``, ``operability``, and what ``more`` is told
        and by ``figures`` drawn. Of a test report the ``template`` for Word that is filled.

    Returns
    -------
    Path
        The file.
    """
    target = Path(path)
    if isinstance(result, Document):
        write_document(result, target, **about)
    else:
        write_text(target, page_file(answers_of(result, **about)))
    return target


def reduction_answers(
    reduction: Reduction,
    *,
    reference: ReferenceTable | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> Answers:
    """What the page of a reduction holds."""
    places = report_places(reduction, reference=reference, turns=turns)
    return report_answers(reduction, places, reference=reference, turns=turns, loop=loop)


@singledispatch
def answers_of(result: Any, **about: Any) -> Answers:
    """What the page of a result holds."""
    del about
    raise TypeError(f"{type(result).__name__} has no page.")


answers_of.register(Comparison, comparison_answers)
answers_of.register(Diagnosis, records_answers)
answers_of.register(Loop, diagnosis_answers)
answers_of.register(Rao, seakeeping_answers)
answers_of.register(Reduction, reduction_answers)


def report_places(
    reduction: Reduction, *, reference: ReferenceTable | None = None, turns: Turns | None = None
) -> dict[str, PageSection]:
    """What is told of a reduction by place, figures drawn (see `write_report`)."""
    beside = reference or ReferenceTable.published(reduction.table)
    told = {
        "data": PageSection(
            facts=_facts(reduction),
            after=[
                sections.done(reduction),
                checked_section(reduction.findings, list(pictures.of_findings(reduction))),
                Section(title="Runs", tables=[tables.settings(reduction)]),
                sections.provenance(reduction, reference),
            ],
        ),
        "derivatives": PageSection(
            before=[
                Section(
                    title="At a glance",
                    paragraphs=[str(reduction.verdict), *_headline(reduction, turns)],
                    points=reduction.verdict.reasons,
                )
            ],
            after=[
                *sections.remarks(reduction),
                *_pictures(
                    "Over the Froude number, and together",
                    pictures.of_derivatives(reduction.table, reference),
                ),
                *_pictures("Forces and what was fitted", pictures.of_forces(reduction)),
                sections.influence(reduction),
                sections.comparison(reduction, beside),
            ],
        ),
    }
    return told | ({"ship": PageSection(after=[turning_section(turns)])} if turns else {})


def report_answers(
    reduction: Reduction,
    places: Mapping[str, PageSection],
    *,
    reference: ReferenceTable | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> Answers:
    """What the page of a reduction holds."""
    answers: Answers = {
        "state": state_of(
            title=reduction.campaign.title or "Captive tests",
            kind="captive",
            runs=len(reduction.runs),
            model="",
        ),
        "derivatives": derivatives_page(reduction, reference),
        **{f"told {name}": told_page(place) for name, place in places.items()},
    }
    if turns:
        answers["turns"] = {"before": track_page(turns.tracks[len(turns.tracks) // 2])}
    return answers | (loop_answers(loop, facts={}) if loop else {})


def _facts(reduction: Reduction) -> dict[str, str]:
    campaign, table = reduction.campaign, reduction.table
    warnings = [item for item in reduction.findings if item.severity == "warning"]
    return {
        "runs used": str(len(reduction.runs)),
        "runs left out, with reasons": str(len(campaign.excluded)),
        "Froude numbers": "all" if table.pooled else _span([f"{x:.3f}" for x in table.Fn]),
        "structure": str(table.provenance.get("structure", "custom")),
        "warnings of the checks": str(len(warnings)),
    }


def _span(texts: list[str]) -> str:
    return ", ".join(texts) if len(texts) < 4 else f"{texts[0]} … {texts[-1]}"


def _headline(reduction: Reduction, turns: Turns | None) -> list[str]:
    said = []
    if turns and len(turns.tracks) > 1:
        moved = turns.changes
        low, high = sorted(track.Fn for track in turns.tracks)[:: len(turns.tracks) - 1]
        said.append(
            f"From Fn {low:.3f} to {high:.3f} a turn with {abs(turns.tracks[0].rudder_deg):g}° of "
            f"rudder changes: steady radius {percent(moved['steady_diameter_L'])}, tactical "
            f"diameter {percent(moved['tactical_diameter_L'])}, transfer "
            f"{percent(moved['transfer_L'])}, advance {percent(moved['advance_L'])}."
        )
    if reduction.propulsion is not None:
        found = reduction.propulsion
        said.append(
            f"Thrust deduction t = {found.thrust_deduction:.3f} from "
            f"{counted(len(found.runs), 'straight run')}."
        )
    return said


def _pictures(title: str, figures: Iterable[Picture]) -> list[Section]:
    found = list(figures)
    return [Section(title=title, figures=found)] if found else []
