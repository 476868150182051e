"""Sections that tell of a reduction: what was done, what each run does, other ways, origin."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from pmmkit.intake import CheckFinding, name_runs
from pmmkit.models import ReferenceTable
from pmmkit.presentation import Grid, Group, Picture, Section
from pmmkit.reduction import Reduction
from pmmkit.views.figures.captions import drawn
from pmmkit.views.report import pictures, tables
from pmmkit.views.report.tables import flattened, gathered

# What the checks found, as a section.


def checked_section(findings: Sequence[CheckFinding], figures: Sequence[Picture] = ()) -> Section:
    """What the checks found, with the zeros of the gauges where they tell them."""
    shown = [
        {
            "severity": item.severity,
            "check": item.check,
            "message": item.message,
            "runs": name_runs(item.runs, 12),
            "remedy": item.remedy,
        }
        for item in findings
    ]
    return Section(
        title="What the checks found",
        paragraphs=[] if shown else ["The checks found nothing to say."],
        findings=shown,
        tables=[item.grid() for item in findings if item.by_run],
        figures=list(figures),
    )


def influence(reduction: Reduction) -> Section:
    """How far each run moves each derivative, and the scatter between runs."""
    found = reduction.influences
    between = reduction.solution.between
    scatter = between.scatter
    sizes = "; ".join(map(between.in_words, scatter.weights)) if scatter else ""
    return Section(
        title="What each run does",
        paragraphs=[
            f"Scatter between runs that the intervals hold (standard deviations): {sizes}.",
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


def done(reduction: Reduction) -> Section:
    """What was done, with the particulars, the runs, those left out and the corrections."""
    return Section(
        title="What was done",
        paragraphs=[said(reduction)],
        tables=[
            tables.particulars(reduction),
            tables.runs(reduction),
            *tables.left_out(reduction.campaign),
            *tables.corrections(reduction.campaign),
        ],
    )


def said(reduction: Reduction) -> str:
    """Structure, method, cycles and inertia in some sentences."""
    origin = reduction.table.provenance
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
    return (
        f"Structure {origin.get('structure', 'custom')}, {fn}, by {reduction.way}. Cycles of "
        f"oscillating tests were chosen {asked}. {inside}"
    )


def remarks(reduction: Reduction) -> list[Section]:
    """The notes of a reduction; nothing where there are none."""
    notes = list(dict.fromkeys(reduction.notes))
    title = "What these runs tell and do not tell"
    return [Section(title=title, points=notes)] if notes else []


def comparison(reduction: Reduction, beside: ReferenceTable | None) -> Section:
    """The same derivatives by families of tests, single runs and other methods."""
    several = len(reduction.estimates) > 1
    told = [item.sentence for item in reduction.differences]
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


def provenance(reduction: Reduction, reference: ReferenceTable | None) -> Section:
    """Sources, versions, settings and the hashes of all files."""
    rows = gathered(flattened(reduction.table.provenance))
    return Section(
        title="Provenance and sources",
        points=list(_sources(reduction, reference)),
        tables=[Grid(head=["What", "Value"], groups=[Group(rows=rows)], texts=(1,))],
    )


def _sources(reduction: Reduction, reference: ReferenceTable | None) -> Iterable[str]:
    structure: Any = reduction.table.provenance.get("source")
    if structure:
        yield f"Structure: {structure}."
    if reference:
        yield f"Values to compare with: {reference.name}."
    yield (
        "Uncertainty: Guide to the expression of uncertainty in measurement (JCGM 100:2008), "
        "95 % intervals."
    )
