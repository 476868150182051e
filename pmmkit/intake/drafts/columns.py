"""``[source]`` and ``[columns]`` of a draft: how its files are read and which column is what."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import DataError, did_you_mean
from pmmkit.campaigns import Campaign, unit_of
from pmmkit.conventions import (
    CHANNEL_UNITS,
    channel_of,
    factor_to,
    split_unit,
    unit_factor,
    unit_in_name,
)
from pmmkit.files import toml_string
from pmmkit.intake.file import clock_of, values_of
from pmmkit.intake.folder import FileGroup, Look
from pmmkit.intake.guessing import Suggestion
from pmmkit.intake.seen import ColumnLook, FileLook
from pmmkit.presentation import printable
from pmmkit.readers import Options

# What a person chose of the columns, in the place of what was guessed.


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


# What the sections of a draft are written with: values as TOML, comments, open questions.


_LISTED: Final = 6
GAUGES: Final = frozenset({"Y_forward", "Y_aft"})
"""Two gauges of the side force, in place of side force and moment."""


class Todo:
    """What is open, the same question about many runs asked once."""

    def __init__(self) -> None:
        self._single: list[str] = []
        self._runs: dict[str, list[str]] = {}

    def add(self, text: str) -> None:
        """A question about the whole campaign."""
        if text not in self._single:
            self._single.append(text)

    def of_run(self, text: str, run_id: str) -> None:
        """A question about a run."""
        self._runs.setdefault(text, []).append(run_id)

    @property
    def open_runs(self) -> set[str]:
        """Runs and tables about which something is asked."""
        return {run_id for ids in self._runs.values() for run_id in ids}

    def all(self) -> list[str]:
        """Everything that is open."""
        asked = list(self._single)
        for text, ids in self._runs.items():
            more = f" and {len(ids) - _LISTED} more" if len(ids) > _LISTED else ""
            asked.append(f"{text}: {', '.join(ids[:_LISTED])}{more}.")
        return asked


def aligned(left: str, note: str) -> str:
    """A line with its comment, the comments of a section below each other."""
    return f"{left:<32} # {printable(note)}" if note else left


def commented(text: str) -> list[str]:
    """A longer text as lines of comment."""
    return textwrap.wrap(printable(text), 98, initial_indent="# ", subsequent_indent="# ")


def toml(value: Any) -> str:
    r"""A value as TOML.

    Examples
    --------
    >>> print(toml({"name": 'Fx "total"', "column": 2, "scale": -1.0, "header": False}))
    { name = "Fx \"total\"", column = 2, scale = -1.0, header = false }
    """
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(float(value)) if isinstance(value, float) else repr(int(value))


_MEANS: Final[dict[str, str]] = {
    "t": "time [s]",
    "X": "the surge force [N]",
    "Y": "the sway force [N]",
    "N": "the yaw moment [N m]",
    "x": "the position along the first course [m]",
    "y": "the position to starboard [m]",
    "psi": "the heading [rad]",
    "delta": "the rudder angle [rad]",
    "n": "the revolutions of the propeller [1/s]",
}
_STEERED: Final = ("delta", "n")
"""What a model needs of a free-running record besides its track."""


def source_lines(look: FileLook, options: Options, *, every: bool = False) -> list[str]:
    """How files are read: what is not usual, or every option where a base has others."""
    values: dict[str, Any] = {"format": look.format}
    if look.layout is not None or look.has_sheets:
        values |= {"skip_rows": options.skip_rows} if options.skip_rows or every else {}
        if look.layout is not None:
            values |= {"encoding": options.encoding or "utf-8"} if options.encoding or every else {}
            values |= {"delimiter": options.delimiter, "decimal": options.decimal}
        stated = options.header is not None and every
        values |= {"header": options.header} if options.header is False or stated else {}
        values |= {"units_row": True} if options.units_row else {}
        values |= {"sheet": options.sheet} if options.sheet else {}
        values |= {"last_row": options.last_row} if options.last_row else {}
    values |= {"group": options.group} if options.group else {}
    values |= {"where": dict(options.where)} if options.where else {}
    return [f"{key} = {toml(value)}" for key, value in values.items()]


def column_lines(
    look: FileLook,
    kind: str,
    todo: Todo,
    *,
    table: bool,
    instead: Mapping[str, Any] = MappingProxyType({}),
) -> list[str]:
    """The columns with the reason for each, or what an entry takes instead; what is not used, what
    is still wanted."""
    lines = [f"{name} = {toml(value)}" for name, value in instead.items()]
    for column in look.columns:
        item = column.suggestion
        if item is None or not column.numbers or item.name in instead:
            continue
        mark = "# " if item.certainty == "perhaps" else ""
        note = f"{item.certainty}: {item.reason}"
        bare = "without dimension" in item.reason
        if column.unit is None and item.unit is None and not (table or bare):
            note += "; no unit stated, taken as SI"
        if mark:
            note = f"TODO {note}"
            todo.add(f"{look.shown}, column {column.label!r}: {item.certainty} {item.name}?")
        lines.append(aligned(f"{mark}{item.name} = {their_column(column, item, look)}", note))
    unused = [
        f"{column.label}{' (' + column.remark + ')' if column.remark else ''}"
        for column in look.columns
        if column.suggestion is None
    ]
    known = {
        name
        for name, column in look.known.items()
        if column.suggestion and column.suggestion.certainty != "perhaps"
    }
    wanted = () if table else Campaign.REQUIRED[kind]
    steered = {"u", "v"} <= known and bool({"psi", "psi_deg", "r", "r_deg_s"} & known)
    if {"lat", "lon"} <= known or steered:
        wanted = tuple(name for name in wanted if name not in ("x", "y"))
    if steered and {"r", "r_deg_s"} & known:
        wanted = tuple(name for name in wanted if name != "psi")
    if known >= GAUGES:
        wanted = tuple(name for name in wanted if name not in ("Y", "N"))
    if kind == "free-running" and not table:
        wanted = (*wanted, *(name for name in _STEERED if name not in look.known))
    for name in wanted:
        if name not in known and not any(other.startswith(f"{name}_") for other in known):
            lines.append(f"# {name} = ...   # TODO which column is {_MEANS[name]}? (false if none)")
            todo.add(f"[columns] {name}: which column of {look.shown} is {_MEANS[name]}?")
    lines += [f"# not used: {printable(text)}" for text in unused]
    return lines + [f"# note: {printable(note)}" for note in look.notes]


def their_column(column: ColumnLook, item: Suggestion, look: FileLook) -> str:
    """The right side of a line of ``[columns]``."""
    parts = column_parts(column, item, look)
    return toml(column.title) if list(parts) == ["name"] else toml(parts)


def factor_of(column: ColumnLook) -> float:
    """From the numbers of a column to SI; 1 where its unit is not known."""
    item = column.suggestion
    if item is None:
        return 1.0
    named = unit_in_name(item.name)
    unit = item.unit or column.unit or (named[1] if named else None)
    if unit is None:
        return item.scale
    try:
        unit_factor(unit)
        return (
            factor_to(unit, CHANNEL_UNITS.get(channel_of(item.name), "rad")) or 1.0
        ) * item.scale
    except DataError:
        return item.scale


def column_parts(column: ColumnLook, item: Suggestion, look: FileLook) -> dict[str, Any]:
    """How a line of ``[columns]`` names a column."""
    titles = [other.title for other in look.columns]
    named = look.options.header is not False and titles.count(column.title) == 1 and column.title
    parts: dict[str, Any] = {"name": column.title} if named else {"column": column.position + 1}
    unit = item.unit or column.unit
    if unit and (item.unit or not named or split_unit(column.title)[1] is None):
        parts["unit"] = unit
    if item.scale != 1.0:
        parts["scale"] = item.scale
    return parts
