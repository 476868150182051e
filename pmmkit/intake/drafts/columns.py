"""``[source]`` and ``[columns]`` of a draft: how its files are read and which column is what."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

from pmmkit.campaigns import Campaign
from pmmkit.conventions import split_unit
from pmmkit.files import toml_string
from pmmkit.intake.guessing import Suggestion
from pmmkit.intake.seen import ColumnLook, FileLook
from pmmkit.presentation import printable
from pmmkit.readers import Options

# What the sections of a draft are written with: values as TOML, comments, open questions.


_LISTED: Final = 6


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
}


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
        if column.unit is None and item.unit is None and not table:
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
    for name in () if table else Campaign.REQUIRED[kind]:
        if name not in known and not any(other.startswith(f"{name}_") for other in known):
            lines.append(f"# {name} = ...   # TODO which column is {_MEANS[name]}? (false if none)")
            todo.add(f"[columns] {name}: which column of {look.shown} is {_MEANS[name]}?")
    lines += [f"# not used: {printable(text)}" for text in unused]
    return lines + [f"# note: {printable(note)}" for note in look.notes]


def their_column(column: ColumnLook, item: Suggestion, look: FileLook) -> str:
    """The right side of a line of ``[columns]``."""
    titles = [other.title for other in look.columns]
    named = look.options.header is not False and titles.count(column.title) == 1 and column.title
    parts: dict[str, Any] = {"name": column.title} if named else {"column": column.position + 1}
    unit = item.unit or column.unit
    if unit and (item.unit or not named or split_unit(column.title)[1] is None):
        parts["unit"] = unit
    if item.scale != 1.0:
        parts["scale"] = item.scale
    return toml(column.title) if list(parts) == ["name"] else toml(parts)
