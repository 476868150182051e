"""The chapters on what was found: repeats, analysis, derivatives, uncertainty, checks, use."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import TEST_KINDS, Run
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS, Convention, bibliography, cite
from pmmkit.intake import CheckFinding
from pmmkit.numerics import Array, coverage_factor
from pmmkit.presentation import Grid, Group, Section, at_froude, counted, number, plus_minus
from pmmkit.reduction import Budget, Reduction, RunResult, derivative_budget
from pmmkit.views.figures.captions import drawn
from pmmkit.views.report import pictures, sections, tables
from pmmkit.views.report.captive.document import (
    Chapter,
    Item,
    of_report,
    of_uncertainties,
    untitled,
)
from pmmkit.views.report.sections import checked_section
from pmmkit.views.report.tables import symbol

# The chapter on runs that repeat each other: how far their forces scatter.


LISTED = 40
"""Conditions that are listed one by one; of more, the first."""


def repeatability(reduction: Reduction) -> Chapter:
    """Repeated runs: mean, standard deviation and range, by kind of test and one by one."""
    results = {item.run.id: item for item in reduction.runs}
    groups = [
        tuple(results[run.id] for run in group)
        for group in Run.repeats([item.run for item in reduction.runs])
        if len(group) > 1
    ]
    count = sum(map(len, groups))
    said = f"{counted(count, 'run')} of {counted(len(groups), 'condition')}" if groups else "none"
    channels = [x for x in ("X", "Y", "N", "K") if any(x in it.measured for it in reduction.runs)]
    return Chapter(
        title="Repeatability",
        items=[Item(what="Runs that repeat each other", value=said)],
        sections=[
            Section(
                paragraphs=[
                    "Runs repeat each other where the campaign says so, or where they were set "
                    "alike. The standard deviation is pooled over the conditions; the range is "
                    "the largest between two runs of one condition. Of oscillating tests the "
                    "number is the root mean square over the first harmonic."
                ],
                tables=[_by_kind(groups, channels), _one_by_one(groups, channels)],
            )
        ]
        if groups
        else [],
    )


def _by_kind(groups: Sequence[Sequence[RunResult]], channels: Sequence[str]) -> Grid:
    """A row per kind of test: pooled standard deviation and largest range of each channel."""
    kinds: dict[str, list[Sequence[RunResult]]] = {}
    for group in groups:
        kinds.setdefault(group[0].run.kind_of_test.title, []).append(group)
    rows: list[list[str | None]] = []
    for title, own in kinds.items():
        row: list[str | None] = [title, str(len(own)), str(sum(map(len, own)))]
        for channel in channels:
            apart = [_apart(group, channel) for group in own]
            known = [x for x in apart if x is not None]
            if not known:
                row += [None, None]
                continue
            freedom = sum(len(x) - 1 for x in known)
            row.append(number((sum(float(np.sum(x**2)) for x in known) / freedom) ** 0.5, 3))
            row.append(number(max(_range(group, channel) for group in own), 3))
        rows.append(row)
    head = ["kind of test", "conditions", "runs"]
    for channel in channels:
        head += [f"{channel} std [{CHANNEL_UNITS[channel]}]", "range"]
    return Grid(head=head, groups=[Group(rows=rows)], caption="By kind of test")


def _one_by_one(groups: Sequence[Sequence[RunResult]], channels: Sequence[str]) -> Grid:
    """A row per condition: its first run, how many, mean and standard deviation."""
    rows: list[list[str | None]] = []
    for group in groups[:LISTED]:
        row: list[str | None] = [_setting(group[0].run), str(len(group))]
        for channel in channels:
            apart = _apart(group, channel)
            mean = np.mean([_level(item, channel) for item in group if channel in item.measured])
            row.append(None if apart is None else number(float(mean), 4))
            std = None if apart is None else float(np.sqrt(np.sum(apart**2) / (len(apart) - 1)))
            row.append(None if std is None else number(std, 3))
        rows.append(row)
    left = f"; {len(groups) - LISTED} more are in runs.csv" if len(groups) > LISTED else ""
    head = ["condition", "runs"]
    for channel in channels:
        head += [f"{channel} mean [{CHANNEL_UNITS[channel]}]", "std"]
    return Grid(head=head, groups=[Group(rows=rows)], caption=f"Conditions{left}", texts=(0,))


def _setting(run: Run) -> str:
    said = ", ".join(run.settings.words)
    return f"{run.id}: {run.settings.speed:.4g} m/s{f', {said}' if said else ''}"


def _values(item: RunResult, channel: str) -> Array:
    """The mean of a steady run; cosine and sine of the first harmonic of an oscillating one."""
    measured = item.measured[channel]
    if not item.run.dynamic:
        return measured[:1]
    places = [place for place, label in enumerate(item.labels) if label in ("C1", "S1")]
    return measured[places]


def _level(item: RunResult, channel: str) -> float:
    values = _values(item, channel)
    return float(np.hypot(*values)) if len(values) > 1 else float(values[0])


def _apart(group: Sequence[RunResult], channel: str) -> Array | None:
    """How far each run is from the mean of its condition [N, N m]; None of fewer than two."""
    own = [item for item in group if channel in item.measured]
    if len(own) < 2:
        return None
    values = np.stack([_values(item, channel) for item in own])
    apart = values - values.mean(axis=0)
    found: Array = np.sqrt(np.mean(apart**2, axis=1))
    return found


def _range(group: Sequence[RunResult], channel: str) -> float:
    levels = [_level(item, channel) for item in group if channel in item.measured]
    return max(levels) - min(levels) if levels else 0.0


# The appendices: every run with what was measured, and where everything comes from.


OSCILLATING = (("X", "C0"), ("Y", "C1"), ("Y", "S1"), ("N", "C1"), ("N", "S1"))
"""Parts of the forces that oscillating tests are for."""


def runs(reduction: Reduction) -> Chapter:
    """Every run with its settings, what of its record counts, and what was measured."""
    steady = [item for item in reduction.runs if not item.run.dynamic]
    swung = [item for item in reduction.runs if item.run.dynamic]
    parts = (
        ("Forces of steady tests", steady, [(channel, "C0") for channel in CHANNELS]),
        ("Harmonics of oscillating tests", swung, OSCILLATING),
    )
    forces = [
        Section(title=title, tables=[_forces(own, what)]) for title, own, what in parts if own
    ]
    every = Section(tables=[tables.settings(reduction)])
    return Chapter(title="Runs", sections=[every, *forces], appendix=True)


def _forces(results: Sequence[RunResult], parts: Sequence[tuple[str, str]]) -> Grid:
    """Parts of the forces of some runs with half of their 95 % intervals, as recorded."""
    kept = [part for part in parts if any(_force(result, *part) for result in results)]
    rows = [[result.run.id, *(_force(result, *part) for part in kept)] for result in results]
    units = {channel: CHANNEL_UNITS[channel] for channel, _ in kept}
    told = ""
    if results[0].run.dynamic:
        told = " cos θ goes with the velocity of the motion, sin θ with its displacement."
    names = {"C0": "mean", "C1": "cos θ", "S1": "sin θ"}
    return Grid(
        head=["Run", *(f"{channel}, {names[part]} [{units[channel]}]" for channel, part in kept)],
        groups=[Group(rows=rows)],
        caption="As recorded, in SI and ship axes, ± half of the 95 % interval where the record "
        f"tells one.{told}",
    )


def _force(result: RunResult, channel: str, part: str) -> str | None:
    if channel not in result.measured or part not in result.labels:
        return None
    place = result.labels.index(part)
    covariance = result.covariance.get(channel)
    half = math.nan
    if covariance is not None:
        factor = coverage_factor(result.dof.get(channel, math.inf))
        half = float(factor * np.sqrt(covariance[place, place]))
    return plus_minus(float(result.measured[channel][place]), half) or None


def origin(reduction: Reduction, sources: Sequence[str]) -> Chapter:
    """Sources, versions, files and their hashes."""
    section = sections.provenance(reduction, None)
    named = [f"{cite(key)}: {bibliography()[key].title}." for key in sources]
    return Chapter(
        title=section.title,
        sections=[untitled(section), Section(title="Procedures named", points=named)],
        appendix=True,
    )


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
    rows: list[list[str | None]] = [
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
            Item(what="Verdict", value=f"{judged.use.capitalize()}{judged.proviso}"),
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
