"""A reduction as a page: everything that was found, in one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pmmkit.checks.finding import name_runs
from pmmkit.files import write_text
from pmmkit.models.reference import Reference, published_of
from pmmkit.presentation import Grid, Group, Picture, Section, counted, percent
from pmmkit.reduction import Reduction
from pmmkit.reduction.agreement import differences
from pmmkit.reduction.methods.registry import METHODS
from pmmkit.report import pictures, tables
from pmmkit.report.checked import checked_section
from pmmkit.report.drawn import drawn
from pmmkit.report.loop import Loop, loop_answers
from pmmkit.report.turning import Turns, changes, turning_section
from pmmkit.report.words import flattened
from pmmkit.workbench.page_file import page_file, state_of
from pmmkit.workbench.page_room import Answers
from pmmkit.workbench.pages.derivatives import derivatives_page
from pmmkit.workbench.pages.sections import Place, told_page
from pmmkit.workbench.pages.turning import track_page


def write_report(
    reduction: Reduction,
    path: str | Path,
    *,
    reference: Reference | None = None,
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
    reference : Reference, optional
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
    reference: Reference | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> str:
    """The report as text (see `write_report`).

    Parameters
    ----------
    reduction, reference, turns, loop
        As for `write_report`.
    """
    places = report_places(reduction, reference=reference, turns=turns)
    return page_file(report_answers(reduction, places, reference=reference, turns=turns, loop=loop))


def report_places(
    reduction: Reduction, *, reference: Reference | None = None, turns: Turns | None = None
) -> dict[str, Place]:
    """What is told of a reduction by place, figures drawn (see `write_report`).

    Parameters
    ----------
    reduction, reference, turns
        As for `write_report`.
    """
    beside = reference or published_of(reduction.table)
    told = {
        "data": Place(
            facts=_facts(reduction),
            after=[
                _done(reduction),
                checked_section(reduction.findings, list(pictures.of_findings(reduction))),
                Section(title="Runs", tables=[tables.settings(reduction)]),
                _provenance(reduction, reference),
            ],
        ),
        "derivatives": Place(
            before=[
                Section(
                    title="At a glance",
                    paragraphs=[str(reduction.verdict), *_headline(reduction, turns)],
                    points=reduction.verdict.reasons,
                )
            ],
            after=[
                *_notes(reduction),
                *_pictures(
                    "Over the Froude number, and together",
                    pictures.of_derivatives(reduction.table, reference),
                ),
                *_pictures("Forces and what was fitted", pictures.of_forces(reduction)),
                _influence(reduction),
                _comparison(reduction, beside),
            ],
        ),
    }
    return told | ({"ship": Place(after=[turning_section(turns)])} if turns else {})


def report_answers(
    reduction: Reduction,
    places: Mapping[str, Place],
    *,
    reference: Reference | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> Answers:
    """What the page of a reduction holds.

    Parameters
    ----------
    reduction : Reduction
        What was reduced.
    places : mapping of str to Place
        From `report_places`.
    reference, turns, loop
        As for `write_report`.
    """
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


def _influence(reduction: Reduction) -> Section:
    found = reduction.influences
    scatter = reduction.solution.between.scatter
    sizes = (
        "; ".join(f"{channel}: {scatter.words(channel)}" for channel in scatter.weights)
        if scatter
        else ""
    )
    return Section(
        title="What each run does",
        paragraphs=[
            f"Scatter between runs that the intervals hold (standard deviations; offset over the "
            f"rms force of the channel): {sizes}.",
            "Each derivative with all runs less the same without one run, over half of its 95 % "
            "interval. Above 1 the interval hangs on that run.",
        ],
        figures=[
            drawn(
                found.plot(),
                "Influence of each run; empty where a run says nothing of a derivative.",
                facts=_strong(reduction),
            )
        ],
    )


def _strong(reduction: Reduction) -> list[str]:
    """Which runs move a derivative most, in a sentence."""
    found = [
        f"{item.run} moves {name} by {share:+.2g}"
        for item, name, share in reduction.influences.strong()[:3]
    ]
    return [
        f"{'; '.join(found)} half intervals." if found else "No run moves a derivative beyond 1."
    ]


def _done(reduction: Reduction) -> Section:
    campaign, origin = reduction.campaign, reduction.table.provenance
    fn = (
        "one set of derivatives over all speeds"
        if reduction.table.pooled
        else "a set of derivatives per Froude number"
    )
    cycles = origin.get("cycles")
    asked = "by a cycle-to-cycle test" if cycles is None else f"as asked: {cycles}"
    inertia = {run.run.forces for run in reduction.runs}
    inside = (
        "The inertia of the model was still inside the forces and has been removed, in X too."
        if inertia == {"balance"}
        else "The forces are stated to be those of the water alone."
        if inertia == {"hydrodynamic"}
        else "Some runs hold the inertia of the model, which has been removed there."
    )
    corrections = dict.fromkeys(
        (item.action, name_runs(item.runs), item.reason)
        for run in (*campaign.runs, *(run for run, _ in campaign.excluded))
        for item in run.corrections
    )
    grids = [tables.particulars(reduction), tables.runs(reduction)]
    if campaign.excluded:
        reasons: dict[str, list[str]] = {}
        for run, reason in campaign.excluded:
            reasons.setdefault(reason, []).append(run.id)
        rows = [[name_runs(ids, 30), reason] for reason, ids in reasons.items()]
        head = ["Runs left out", "Because"]
        grids.append(Grid(head=head, groups=[Group(rows=rows)], texts=(0, 1)))
    if corrections:
        grids.append(
            Grid(
                head=["Correction", "Runs", "Reason"],
                groups=[Group(rows=[list(item) for item in corrections])],
                texts=(1, 2),
            )
        )
    return Section(
        title="What was done",
        paragraphs=[
            f"Structure {origin.get('structure', 'custom')}, {fn}, by {_way(reduction)}. Cycles of "
            f"oscillating tests were chosen {asked}. {inside}"
        ],
        tables=grids,
    )


def _way(reduction: Reduction) -> str:
    """By which method the table was found."""
    if reduction.method == next(iter(METHODS)):
        return "one regression over all runs weighted with the noise of their records"
    return f"{reduction.estimates[reduction.method].method} ({METHODS[reduction.method].text[:-1]})"


def _notes(reduction: Reduction) -> list[Section]:
    notes = list(dict.fromkeys(reduction.notes))
    title = "What these runs tell and do not tell"
    return [Section(title=title, points=notes)] if notes else []


def _pictures(title: str, figures: Iterable[Picture]) -> list[Section]:
    found = list(figures)
    return [Section(title=title, figures=found)] if found else []


def _comparison(reduction: Reduction, beside: Reference | None) -> Section:
    several = len(reduction.estimates) > 1
    told = [item.sentence for item in differences(reduction)]
    agree = ["No method differs from the regression beyond both intervals."]
    tests = [
        f"{estimate.method}: {text}"
        for estimate in reduction.estimates.values()
        for text in (estimate.tests.words() if estimate.tests else ())
    ]
    return Section(
        title="The same derivatives by other ways",
        paragraphs=[
            "All runs together is the table above. Beside it stand the same derivatives from each "
            "family of tests alone (curve fits of static tests, amplitude series of oscillating "
            "ones), and from the harmonics of single runs: their mean and range. Where the ways "
            "disagree by more than their intervals, the structure lacks something or a test does."
        ],
        points=[*(told or agree), *tests] if several else [],
        tables=[*tables.methods(reduction, beside), *tables.shares(reduction)],
        figures=[*pictures.of_families(reduction, beside), *pictures.of_methods(reduction, beside)],
    )


def _provenance(reduction: Reduction, reference: Reference | None) -> Section:
    rows = [list(pair) for pair in flattened(reduction.table.provenance)]
    return Section(
        title="Provenance and sources",
        points=list(_sources(reduction, reference)),
        tables=[Grid(head=["What", "Value"], groups=[Group(rows=rows)], texts=(1,))],
    )


def _sources(reduction: Reduction, reference: Reference | None) -> Iterable[str]:
    structure: Any = reduction.table.provenance.get("source")
    if structure:
        yield f"Structure: {structure}."
    if reference:
        yield f"Values to compare with: {reference.name}."
    yield (
        "Uncertainty: Guide to the expression of uncertainty in measurement (JCGM 100:2008), "
        "95 % intervals."
    )
