"""The appendices: every run with what was measured, and where everything comes from."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pmmkit.conventions import CHANNEL_UNITS, CHANNELS, bibliography, cite
from pmmkit.numerics import coverage_factor
from pmmkit.presentation import Cell, Grid, Group, Section, plus_minus
from pmmkit.reduction import Reduction, RunResult
from pmmkit.views.report import sections, tables
from pmmkit.views.report.captive.document import Chapter, untitled

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


def _force(result: RunResult, channel: str, part: str) -> Cell:
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
