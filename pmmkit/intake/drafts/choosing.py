"""What a person chose of the columns, in the place of what was guessed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pmmkit.base import DataError, did_you_mean
from pmmkit.campaigns import unit_of
from pmmkit.conventions import factor_to
from pmmkit.intake.columns import clock_of
from pmmkit.intake.folder import FileGroup, Look
from pmmkit.intake.guessing import Suggestion
from pmmkit.intake.seen import ColumnLook, FileLook
from pmmkit.intake.values import values_of


@dataclass(frozen=True, kw_only=True)
class ColumnChoice:
    """What a column is.

    Parameters
    ----------
    file : str
        First file of its layout, as it is shown.
    column : int
        Its position, counted from 0.
    name : str
        Our name; empty where it is not used.
    unit : str or None
        None as the header states it, or SI.
    sign : {-1, 1} or None
        -1 where it points the other way; None as the physics of the runs says.
    """

    file: str
    column: int
    name: str
    unit: str | None = None
    sign: int | None = None


def with_choices(seen: Look, choices: Sequence[ColumnChoice]) -> Look:
    """What lies in a folder, with columns as a person chose them."""
    known = {group.first.shown for group in seen.groups}
    for choice in choices:
        if choice.file not in known:
            raise DataError(f"There is no file {choice.file!r} with columns to choose.")
    return replace(seen, groups=tuple(_group(group, choices) for group in seen.groups))


def signed(look: FileLook, choices: Sequence[ColumnChoice]) -> FileLook:
    """A layout whose columns have the signs that were chosen, whatever is proposed."""
    signs = {x.column: x.sign for x in choices if x.file == look.shown and x.sign is not None}
    return replace(
        look,
        columns=tuple(
            replace(
                column,
                suggestion=replace(
                    column.suggestion, scale=abs(column.suggestion.scale) * signs[column.position]
                ),
            )
            if column.suggestion is not None and column.position in signs
            else column
            for column in look.columns
        ),
    )


def _group(group: FileGroup, choices: Sequence[ColumnChoice]) -> FileGroup:
    own = [choice for choice in choices if choice.file == group.first.shown]
    if not own:
        return group
    look = group.first
    for choice in own:
        look = _chosen(look, choice)
    return FileGroup(files=(_judged(look), *group.files[1:]))


def _chosen(look: FileLook, choice: ColumnChoice) -> FileLook:
    if not 0 <= choice.column < len(look.columns):
        raise DataError(f"{look.shown} has no column {choice.column + 1}.")
    column = look.columns[choice.column]
    suggestion = _suggestion(look, column, choice) if choice.name else None
    return replace(
        look,
        columns=tuple(
            replace(other, suggestion=suggestion)
            if other.position == choice.column
            else _without(other, choice.name)
            for other in look.columns
        ),
    )


def _suggestion(look: FileLook, column: ColumnLook, choice: ColumnChoice) -> Suggestion:
    own = unit_of(choice.name, table=look.kind == "table")
    if own is None:
        hint = did_you_mean(choice.name, look.known) or "."
        raise DataError(f"{choice.name!r} is no name of ours{hint}")
    unit = choice.unit or column.unit
    if unit and own and factor_to(unit, own) is None:
        raise DataError(
            f"{column.label}: {unit} is no unit of {choice.name}, which is measured in {own}. "
            "Choose another unit, or another name."
        )
    before = 1.0 if column.suggestion is None else column.suggestion.scale
    scale = before if choice.sign is None else float(choice.sign)
    stated = None if unit == column.unit else unit
    return Suggestion(
        name=choice.name, certainty="surely", reason="chosen", unit=stated, scale=scale
    )


def _without(column: ColumnLook, name: str) -> ColumnLook:
    held = column.suggestion
    return replace(column, suggestion=None) if name and held and held.name == name else column


def _judged(look: FileLook) -> FileLook:
    """A layout that became, or is no longer, one of samples in time."""
    if look.kind not in ("history", "unknown"):
        return look
    time = look.known.get("t")
    if time is None:
        return replace(look, kind="unknown", clock=None)
    if look.kind == "history" and look.clock is not None:
        return look
    numbers = {} if look.sampled else values_of(look, [time.position]).numbers
    clock = clock_of(numbers[time.position]) if time.position in numbers else None
    return replace(look, kind="history", clock=clock)
