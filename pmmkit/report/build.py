"""A report: everything that was found, in one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from pmmkit.checks.finding import name_runs
from pmmkit.checks.zeros import zeros_grid
from pmmkit.files import write_text
from pmmkit.presentation import Grid, Group, Section, counted, percent
from pmmkit.reduction import Reduction
from pmmkit.reduction.agreement import differences
from pmmkit.reduction.methods.registry import METHODS
from pmmkit.report import pictures, tables
from pmmkit.report.drawn import drawn
from pmmkit.report.loop import Loop, loop_sections
from pmmkit.report.page import page
from pmmkit.report.reference import Reference, published_of
from pmmkit.report.turning import Turns, changes, turning_section
from pmmkit.report.words import flattened
from pmmkit.version import __version__


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
    return page_of(
        reduction, report_sections(reduction, reference=reference, turns=turns, loop=loop)
    )


def report_sections(
    reduction: Reduction,
    *,
    reference: Reference | None = None,
    turns: Turns | None = None,
    loop: Loop | None = None,
) -> list[Section]:
    """What stands in the report, figures drawn (see `write_report`).

    Parameters
    ----------
    reduction, reference, turns, loop
        As for `write_report`.
    """
    sections = [
        Section(
            title="Derivatives at a glance",
            paragraphs=[str(reduction.verdict), *_headline(reduction, turns)],
            points=reduction.verdict.reasons,
            tables=[tables.headline(reduction.table, reference)],
        ),
        _done(reduction),
        _findings(reduction),
        _derivatives(reduction, reference),
        _forces(reduction),
        _influence(reduction),
        _comparison(reduction, reference or published_of(reduction.table)),
        *([turning_section(turns)] if turns else []),
        *(loop_sections(loop) if loop else []),
        _runs(reduction),
        _provenance(reduction, reference),
    ]
    return [section for section in sections if section is not None]


def page_of(reduction: Reduction, sections: Sequence[Section]) -> str:
    """The page of a report from its sections.

    Parameters
    ----------
    reduction : Reduction
        What was reduced.
    sections : sequence of Section
        From `report_sections`.
    """
    return page(
        reduction.campaign.title or "Captive tests",
        f"Captive ship-model tests reduced to hydrodynamic derivatives, by pmmkit {__version__}.",
        _tiles(reduction),
        list(sections),
    )


def _tiles(reduction: Reduction) -> list[dict[str, str]]:
    campaign, table = reduction.campaign, reduction.table
    severities = [finding.severity for finding in reduction.findings]
    warnings = severities.count("warning")
    return [
        {"value": str(len(reduction.runs)), "label": "runs used"},
        {"value": str(len(campaign.excluded)), "label": "runs left out, with reasons"},
        {
            "value": "all" if table.pooled else _span([f"{x:.3f}" for x in table.Fn]),
            "label": "Froude numbers",
        },
        {"value": str(table.provenance.get("structure", "custom")), "label": "structure"},
        {"value": str(warnings), "label": "warnings of the checks"},
    ]


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


def _findings(reduction: Reduction) -> Section:
    shown = [
        {
            "severity": item.severity,
            "check": item.check,
            "message": item.message,
            "runs": name_runs(item.runs, 12),
            "remedy": item.remedy,
        }
        for item in reduction.findings
    ]
    return Section(
        title="What the checks found",
        paragraphs=[] if shown else ["The checks found nothing to say."],
        findings=shown,
        tables=[zeros_grid(item) for item in reduction.findings if item.by_run],
        figures=list(pictures.of_findings(reduction)),
    )


def _derivatives(reduction: Reduction, reference: Reference | None) -> Section:
    notes = list(dict.fromkeys(reduction.notes))
    return Section(
        title="Derivatives",
        paragraphs=["What these runs tell and do not tell:"] if notes else [],
        points=notes,
        tables=[tables.derivatives(reduction.table, reference)],
        figures=list(pictures.of_derivatives(reduction.table, reference)),
    )


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


def _forces(reduction: Reduction) -> Section | None:
    figures = list(pictures.of_forces(reduction))
    return Section(title="Forces and what was fitted", figures=figures) if figures else None


def _runs(reduction: Reduction) -> Section:
    return Section(title="Runs", tables=[tables.settings(reduction)])


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
