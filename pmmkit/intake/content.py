"""What was seen of files, as data for programs."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np

from pmmkit.intake.folder import CampaignLook, FileGroup, Look
from pmmkit.intake.seen import ColumnLook, FileLook
from pmmkit.presentation import safe_cell


def look_content(found: Look) -> dict[str, Any]:
    """All that was seen, for JSON."""
    return {
        "groups": [_group_content(group) for group in found.groups],
        "campaigns": [_campaign_content(item) for item in found.campaigns],
        "other_files": found.others,
        "passed_over": found.passed_over,
        "problems": [str(problem) for problem in found.problems],
    }


def _campaign_content(item: CampaignLook) -> dict[str, Any]:
    return {
        "file": item.file,
        "title": item.title,
        "kind": item.kind,
        "ship": item.ship,
        "runs": item.runs,
        "excluded": item.excluded,
        "tests": item.tests,
        "speeds": list(item.speeds),
        "problem": item.problem,
    }


def _group_content(group: FileGroup) -> dict[str, Any]:
    first = group.first
    clock = first.clock
    return {
        "files": [item.shown for item in group.files],
        "format": first.format,
        "kind": first.kind,
        "source": _source(first),
        "rows": first.rows,
        "sampled": first.sampled,
        "clock": None if clock is None else {**vars(clock)},
        "columns": [_column_content(column) for column in first.columns],
    }


def _source(look: FileLook) -> dict[str, Any]:
    """What ``[source]`` must state."""
    options = look.options
    keys = ("format", "skip_rows", "encoding", "delimiter", "decimal", "header", "sheet")
    return {key: getattr(options, key) for key in keys if getattr(options, key) is not None}


def _column_content(column: ColumnLook) -> dict[str, Any]:
    item = column.suggestion
    return {
        "header": column.title,
        "column": column.position + 1,
        "unit": column.unit,
        "numbers": column.numbers,
        "min": column.low,
        "max": column.high,
        "mean": column.mean,
        "first": column.first,
        "constant": column.constant,
        "suggestion": None if item is None else vars(item),
        "remark": column.remark,
    }


def columns_csv(found: Look) -> str:
    """Every column of the first file of each group, a row each, as text of a CSV file."""
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow(
        [
            "file",
            "column",
            "header",
            "unit",
            "min",
            "max",
            "mean",
            "first",
            "constant",
            "suggestion",
            "certainty",
            "reason",
            "remark",
        ]
    )
    for group in found.groups:
        for column in group.first.columns:
            item = column.suggestion
            guess = ("", "", "") if item is None else (item.name, item.certainty, item.reason)
            numbers = [
                f"{value:.9g}" if np.isfinite(value) else ""
                for value in (column.low, column.high, column.mean, column.first)
            ]
            row = [
                group.first.shown,
                str(column.position + 1),
                column.title,
                column.unit or "",
                *numbers,
                "yes" if column.constant else "no",
                *guess,
                column.remark,
            ]
            writer.writerow(map(safe_cell, row))
    return table.getvalue()
