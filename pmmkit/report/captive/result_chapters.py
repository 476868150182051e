"""The chapters on what was found: analysis, derivatives, uncertainty, checks, use, origin."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pmmkit.campaigns.test_kinds.registry import kinds
from pmmkit.checks.finding import CheckFinding
from pmmkit.conventions import Convention
from pmmkit.errors import DataError
from pmmkit.observations.blockage import speed_increase
from pmmkit.presentation import Cell, Grid, Group, Section
from pmmkit.reduction import Reduction
from pmmkit.reduction.shares import contributions
from pmmkit.report import pictures, sections
from pmmkit.report.captive.document import Chapter, Item, untitled
from pmmkit.report.captive.stated import of_report, of_uncertainties
from pmmkit.report.checked import checked_section
from pmmkit.report.words import symbol

SHARED = ("Yv", "Nv", "Yr", "Nr")
"""Derivatives whose uncertainty is shared out: those of straight-line stability."""
LEAST = 0.05
"""Percent below which a source has no row."""


def analysis(reduction: Reduction) -> Chapter:
    """Method, windows, cycles, filter, inertia, blockage.

    Parameters
    ----------
    reduction : Reduction
        What was found.
    """
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
    campaign = reduction.campaign
    share = speed_increase(campaign, max(run.settings.speed for run in campaign.runs))
    corrected = reduction.table.provenance.get("blockage") == "correct"
    done = "corrected for" if corrected else "not corrected for"
    return Item(
        what="Blockage: water faster than the carriage by [%]",
        value=None if share is None else f"{100 * share:.2f} at the highest speed, {done}",
        table="water",
        key="tank_width, tank_depth",
    )


def derivatives(reduction: Reduction) -> Chapter:
    """The derivatives with their intervals, what the fit leaves, and other ways to them.

    Parameters
    ----------
    reduction : Reduction
        What was found.
    """
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
    """Stated uncertainties, scatter between runs, and shares of both.

    Parameters
    ----------
    reduction : Reduction
        What was found.
    """
    channels = list(dict.fromkeys(name for item in reduction.runs for name in item.measured))
    shares = _shares(reduction)
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
            *([Section(title="Shares of the variance", tables=[shares])] if shares else []),
            sections.influence(reduction),
        ],
    )


def _shares(reduction: Reduction) -> Grid | None:
    """Which tests and which shared sources make the uncertainty of the linear derivatives [%]."""
    table = reduction.table
    known = np.isfinite([table[name] for name in SHARED if name in table]).sum(axis=0)
    best = np.flatnonzero(known == np.max(known, initial=0))
    row = int(best[len(best) // 2])
    Fn = None if table.pooled else float(table.Fn[row])
    found = {}
    for name in SHARED:
        if name in table and math.isfinite(table[name][row]):
            try:
                found[name] = contributions(reduction, {name: 1.0}, Fn=Fn)["share"]
            except DataError:
                continue
    titles = {name: kind.title for name, kind in kinds().items()}
    rows: list[list[Cell]] = []
    for source in dict.fromkeys(str(source) for own in found.values() for source in own.index):
        shares = [100 * float(own.get(source, 0.0)) for own in found.values()]
        if max(shares) >= LEAST:
            rows.append([titles.get(source, source), *(f"{share:.1f}" for share in shares)])
    if not rows:
        return None
    rows.append(["together", *(f"{100 * float(np.sum(own)):.1f}" for own in found.values())])
    at = "" if Fn is None else f" at Fn {Fn:.3f}"
    return Grid(
        head=["Source", *(symbol(name, table.convention) for name in found)],
        groups=[Group(rows=rows)],
        caption=f"Percent of the variance{at}: by kind of test (noise and scatter of its runs), "
        "and by source that all runs share.",
    )


def checks(reduction: Reduction) -> Chapter:
    """What the checks found.

    Parameters
    ----------
    reduction : Reduction
        With its findings.
    """
    findings: Sequence[CheckFinding] = reduction.findings
    section = checked_section(findings, list(pictures.of_findings(reduction)))
    return Chapter(title=section.title, sections=[untitled(section)])


def use(reduction: Reduction) -> Chapter:
    """Whether the result can be used, within which range, and what it does not say.

    Parameters
    ----------
    reduction : Reduction
        What was found.
    """
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
    rudder = max(abs(math.degrees(x.rudder)) for x in settings)
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
