"""The chapters on what was found: analysis, derivatives, uncertainty, checks, use, origin."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import TEST_KINDS
from pmmkit.conventions import Convention
from pmmkit.intake import CheckFinding
from pmmkit.presentation import Cell, Grid, Group, Section, at_froude
from pmmkit.reduction import Budget, Reduction, derivative_budget
from pmmkit.views.report import pictures, sections
from pmmkit.views.report.captive.document import Chapter, Item, untitled
from pmmkit.views.report.captive.stated import of_report, of_uncertainties
from pmmkit.views.report.checked import checked_section
from pmmkit.views.report.drawn import drawn
from pmmkit.views.report.tables import symbol

SHARED = ("Yv", "Nv", "Yr", "Nr")
"""Derivatives whose uncertainty is shared out: those of straight-line stability."""
FEW = 4
"""How many are, where there is none of these."""


def analysis(reduction: Reduction) -> Chapter:
    """Method, windows, cycles, filter, inertia, blockage."""
    convention: Convention = reduction.table.convention
    origin = reduction.table.provenance
    structure = origin.get("structure", "custom")
    source = origin.get("source")
    return Chapter(
        title="Analysis",
        items=[
            Item(what="Structure", value=f"{structure} ({source})" if source else str(structure)),
            Item(what="Non-dimensional by", value=convention.meaning),
            Item(what="Digital filter", value="none: means and harmonics are fitted to the record"),
            _blockage(reduction),
        ],
        sections=[
            Section(
                paragraphs=[
                    sections.said(reduction),
                    "Of steady tests counts the part of the record that is found to be steady; its "
                    "mean has the uncertainty of an autocorrelated record. Of oscillating tests "
                    "count whole cycles; harmonics are found by least squares on the phase of the "
                    "motion. Forces and regressors go through the same projection, and all runs "
                    "are fitted together.",
                ]
            )
        ],
    )


def _blockage(reduction: Reduction) -> Item:
    """How much faster the water passes the model between the walls, and whether that is mended."""
    share = reduction.speed_increase
    corrected = reduction.table.provenance.get("blockage") == "correct"
    done = "corrected for" if corrected else "not corrected for"
    return Item(
        what="Blockage: water faster than the carriage by [%]",
        value=None if share is None else f"{100 * share:.2f} at the highest speed, {done}",
        table="water",
        key="tank_width, tank_depth",
    )


def derivatives(reduction: Reduction) -> Chapter:
    """The derivatives with their intervals, what the fit leaves, and other ways to them."""
    table = reduction.table
    grid = table.grid(label=lambda name: symbol(name, table.convention))
    others = sections.comparison(reduction, None)
    return Chapter(
        title="Derivatives",
        sections=[
            Section(tables=[grid], figures=list(pictures.of_derivatives(table, None))),
            Section(
                title="Forces and what the fit leaves",
                tables=[_left(reduction)],
                figures=list(pictures.of_forces(reduction)),
            ),
            *([others] if others.tables or others.figures else []),
        ],
    )


def _left(reduction: Reduction) -> Grid:
    """What the fit leaves of each channel, over its force and over the noise."""
    solution = reduction.solution
    pooled = reduction.table.pooled
    rows: list[list[Cell]] = [
        [
            fit.channel,
            "all speeds" if pooled else f"{solution.Fn[group]:.3f}",
            str(len(fit.blocks)),
            f"{100 * fit.left:.2f}",
            f"{math.sqrt(fit.scale):.2f}",
        ]
        for group, fit in solution.fits
    ]
    return Grid(
        head=["Channel", "Fn", "Runs", "Left [% of the force]", "Over what is expected"],
        groups=[Group(rows=rows)],
        caption="Root mean square of what the fit leaves of means and harmonics. Above 1 the "
        "intervals have been widened by that factor.",
        texts=(1,),
    )


def uncertainty(reduction: Reduction) -> Chapter:
    """Stated uncertainties, the budget of the derivatives, and what each run does to them."""
    channels = list(dict.fromkeys(name for item in reduction.runs for name in item.measured))
    return Chapter(
        title="Uncertainty",
        items=of_uncertainties(reduction.campaign, channels),
        sections=[
            Section(
                paragraphs=[
                    "Intervals are those of 95 %, by the Guide to the expression of uncertainty "
                    "in measurement (JCGM 100:2008): type A from the noise of the records and "
                    "from the scatter between runs, type B from what is stated above. What is "
                    "not supplied counts as zero, so that intervals are too narrow by it."
                ]
            ),
            *_budget(reduction),
            sections.influence(reduction),
        ],
    )


def _budget(reduction: Reduction) -> list[Section]:
    """The budget of the derivatives; nothing where none has an uncertainty."""
    try:
        budget = derivative_budget(reduction)
    except DataError:
        return []
    shown = _shown(budget)
    convention, at = reduction.table.convention, at_froude(shown.results[0].Fn)
    return [
        Section(
            title="Where the uncertainty comes from",
            paragraphs=[
                "Shares of each source in the variance of a derivative. They add up to the "
                "variance behind the interval of that derivative: nothing is left over. A bias "
                "is the same error in all runs; of a precision each run draws its own.",
                *_listed("Not stated, so not in the budget", budget.not_stated),
                *_listed("Not covered by any statement", budget.outside),
            ],
            tables=[
                _shares(shown, convention, f"By source{at}, type A or B of the Guide."),
                _by_test(shown, convention, at),
            ],
            figures=[
                drawn(item.plot(), "Shares of each source in the variance of each derivative.")
                for item in [budget]
                if len(item.sources) > 1
            ],
        )
    ]


def _listed(what: str, names: Sequence[str]) -> list[str]:
    return [f"{what}: {'; '.join(names)}."] if names else []


def _shown(budget: Budget) -> Budget:
    """The derivatives of straight-line stability at a speed in the middle that tells most."""
    known = {item.name for item in budget.results}
    chosen = budget.of(*([name for name in SHARED if name in known] or list(known)[:FEW]))
    count = Counter(item.Fn for item in chosen.results if not math.isnan(item.Fn))
    best = sorted(Fn for Fn, number in count.items() if number == max(count.values()))
    return chosen.of(Fn=best[len(best) // 2]) if best else chosen


def _shares(budget: Budget, convention: Convention, caption: str) -> Grid:
    grid = budget.grid()
    symbols = [symbol(item.name, convention) for item in budget.results]
    first = len(grid.head) - len(symbols)
    head = ["Source", *(text[:1].upper() + text[1:] for text in grid.head[1:first]), *symbols]
    return replace(grid, head=head, caption=caption, texts=tuple(range(first)))


def _by_test(budget: Budget, convention: Convention, at: str) -> Grid:
    """The same budget with what single runs draw under their kind of test."""
    by_test, names = budget.by_test(), TEST_KINDS
    titled = [
        replace(item, title=names[item.title].title) if item.drawn else item
        for item in by_test.sources
    ]
    caption = (
        f"The same variance{at}, with what single runs draw (noise, scatter, their settings) "
        "under their kind of test."
    )
    grid = _shares(replace(by_test, sources=tuple(titled)), convention, caption)
    shares, (together, *_) = grid.groups[0].rows, grid.groups[1].rows
    return replace(grid, groups=[Group(rows=shares), Group(rows=[together])])


def checks(reduction: Reduction) -> Chapter:
    """What the checks found."""
    findings: Sequence[CheckFinding] = reduction.findings
    section = checked_section(findings, list(pictures.of_findings(reduction)))
    return Chapter(title=section.title, sections=[untitled(section)])


def use(reduction: Reduction) -> Chapter:
    """Whether the result can be used, within which range, and what it does not say."""
    judged, table = reduction.verdict, reduction.table
    doubts = judged.reasons
    undetermined = [name for name in table.names if not np.isfinite(table[name]).any()]
    return Chapter(
        title="How the result may be used",
        items=[
            Item(what="Verdict", value=judged.use.capitalize()),
            Item(what="Froude numbers tested", value=_froude(reduction)),
            *_ranges(reduction),
            Item(
                what="Derivatives that these runs do not determine",
                value=", ".join(symbol(name, table.convention) for name in undetermined) or "none",
            ),
            *of_report(reduction.campaign, "geometry_deviations", "condition_deviations"),
            *of_report(reduction.campaign, "deviations", "remarks"),
        ],
        sections=[
            Section(
                paragraphs=[
                    "The derivatives are those of the model as tested, within the ranges above. "
                    "They are not corrected for the scale; outside of the ranges they extrapolate "
                    "a polynomial."
                ]
            ),
            *([Section(title="What speaks against it", points=doubts)] if doubts else []),
            *sections.remarks(reduction),
        ],
    )


def _froude(reduction: Reduction) -> str:
    found = sorted(dict.fromkeys(f"{item.froude:.3f}" for item in reduction.runs))
    return ", ".join(found) if len(found) < 8 else f"{found[0]} … {found[-1]}"


def _ranges(reduction: Reduction) -> list[Item]:
    """The largest angles and the largest rate of turn that were tested."""
    L = reduction.campaign.ship.L
    settings = [item.run.settings for item in reduction.runs]
    drift = max(abs(math.degrees(x.drift)) for x in settings)
    rudder = max(math.degrees(x.largest_rudder) for x in settings)
    turning = [
        L / x.speed * abs(x.turn_rate or (x.yaw_amplitude or 0.0) * (x.omega or 0.0))
        for x in settings
    ]
    swaying = [(x.amplitude or 0.0) * (x.omega or 0.0) / x.speed for x in settings]
    entries = (
        ("Largest drift angle, steady [°]", drift),
        ("Largest sway velocity of oscillating tests v′ [–]", max(swaying)),
        ("Largest rate of turn r′ [–]", max(turning)),
        ("Largest rudder angle [°]", rudder),
    )
    return [Item(what=what, value=f"{value:.3g}") for what, value in entries if value]
