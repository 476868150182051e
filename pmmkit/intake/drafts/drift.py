"""Columns of histories that say the drift angle: a setting, and no channel."""

from __future__ import annotations

from dataclasses import replace

from pmmkit.intake.folder import FileGroup, Look
from pmmkit.intake.guessing import suggest
from pmmkit.intake.seen import ColumnLook, FileLook


def with_drift(seen: Look) -> Look:
    """With a remark at columns that are no channel, and say the drift angle of their runs."""
    return replace(seen, groups=tuple(_drift_told(group) for group in seen.groups))


def _drift_told(group: FileGroup) -> FileGroup:
    found = drift_column(group.first) if group.first.kind == "history" else None
    if found is None:
        return group
    columns = tuple(
        replace(column, remark="it says the drift angle of each run")
        if column.position == found.position
        else column
        for column in group.first.columns
    )
    return replace(group, files=(replace(group.first, columns=columns), *group.files[1:]))


def drift_column(look: FileLook) -> ColumnLook | None:
    """A column of a history that is the drift angle: no channel of ours, but a setting."""
    for column in look.columns:
        if column.suggestion is None and column.numbers:
            (found,) = suggest([column.header], [column.unit], {}, table=True)
            if found is not None and found.name == "drift_deg":
                unit = found.unit or column.unit or "deg"
                return replace(column, suggestion=replace(found, unit=unit))
    return None
