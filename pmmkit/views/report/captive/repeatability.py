"""The chapter on runs that repeat each other: how far their forces scatter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.numerics import Array
from pmmkit.presentation import Cell, Grid, Group, Section, counted, number
from pmmkit.reduction import Reduction, RunResult
from pmmkit.views.report.captive.document import Chapter, Item

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
    rows: list[list[Cell]] = []
    for title, own in kinds.items():
        row: list[Cell] = [title, str(len(own)), str(sum(map(len, own)))]
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
    rows: list[list[Cell]] = []
    for group in groups[:LISTED]:
        row: list[Cell] = [_setting(group[0].run), str(len(group))]
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
