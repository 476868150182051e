"""A reduction as a page: everything that was found, in one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from pmmkit.files import write_text
from pmmkit.models import ReferenceTable
from pmmkit.presentation import Picture, Section, counted, percent
from pmmkit.reduction import Reduction
from pmmkit.views.pages.derivatives import derivatives_page
from pmmkit.views.pages.page_file import page_file, state_of
from pmmkit.views.pages.page_room import Answers
from pmmkit.views.pages.sections import PageSection, told_page
from pmmkit.views.pages.turning import track_page
from pmmkit.views.report import pictures, sections, tables
from pmmkit.views.report.checked import checked_section
from pmmkit.views.report.loop import Loop, loop_answers
from pmmkit.views.report.turning import Turns, changes, turning_section


def write_report(
    reduction: Reduction,
    path: str | Path,
    *,
    reference: ReferenceTable | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> Path:
    """Write the report of a reduction as one HTML file: style and figures inside, nothing loaded.

    Parameters
    ----------
    reduction : Reduction
        As `reduce_campaign` gives it.
    path : path
        File to write, all or nothing.
    reference : ReferenceTable, optional
        Values of a source to stand beside ours.
    turns : Turns, optional
        Turning circles with the model that was found.
    loop : Loop, optional
        What a simpler model of the same runs lacks.

    Returns
    -------
    Path
        The file.
    """
    target = Path(path)
    write_text(target, report_html(reduction, reference=reference, turns=turns, loop=loop))
    return target


def report_html(
    reduction: Reduction,
    *,
    reference: ReferenceTable | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> str:
    """The report as text (see `write_report`)."""
    places = report_places(reduction, reference=reference, turns=turns)
    return page_file(report_answers(reduction, places, reference=reference, turns=turns, loop=loop))


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
        moved = changes(turns.tracks)
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
