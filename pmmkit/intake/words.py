"""What was seen of files, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from pmmkit.base import Problem
from pmmkit.intake.folder import MOST_COUNTED, FileGroup, Look
from pmmkit.intake.seen import Clock, ColumnLook, FileLook, SheetBlock
from pmmkit.presentation import counted
from pmmkit.readers import READERS

_DELIMITERS: Final = {",": "commas", ";": "semicolons", "\t": "tabs", " ": "blanks", "|": "bars"}
_KINDS: Final = {
    "history": "samples in time",
    "table": "a table whose rows are runs",
    "open water": "propeller coefficients",
    "unknown": "numbers",
}
_HEAD: Final = ("column", "unit", "min", "max", "mean", "first", "is")
_SHOWN: Final = 12
"""Names and problems that are listed before the rest is only counted."""


def look_lines(found: Look) -> list[str]:
    """All that was seen, in lines for people."""
    lines = [*_campaign_lines(found), *_others_lines(found)]
    for group in found.groups:
        lines += ["", *group_lines(group)]
    lines += problem_lines(found.problems)
    return lines[1:] if lines and not lines[0] else lines


def group_lines(group: FileGroup) -> list[str]:
    """A group of files in words: its first file with a table of the columns."""
    first = group.first
    lines = [f"{first.shown}: {file_words(first)}."]
    if len(group.files) > 1:
        names = [item.shown for item in group.files[1:]]
        more = "" if len(names) <= _SHOWN else f" and {len(names) - _SHOWN} more"
        lines.append(
            f"  {len(names)} more with the same columns: {', '.join(names[:_SHOWN])}{more}."
        )
    if first.clock is not None:
        lines.append(f"  {clock_words(first.clock, first.known['t'])}")
    lines += [f"  {line}" for item in group.files for line in block_lines(item, len(group.files))]
    lines += [f"  {line}" for line in column_table(first.columns)]
    lines += [f"  Note: {note}." for note in first.notes]
    return lines


def block_lines(look: FileLook, files: int = 1) -> list[str]:
    """What the rows of a sheet are, a line a block; nothing where all of them are runs."""
    if not look.blocks.mixed:
        return []
    where = f"{look.options.sheet}: " if files > 1 else ""
    return [f"{where}{block.places}: {block_words(block)}." for block in look.blocks.blocks]


def block_words(block: SheetBlock) -> str:
    """What rows are, in words."""
    said = f" ({', '.join(block.words)})" if block.words else ""
    count = len(block.names)
    if block.what == "steady":
        return f"{len(block.lines)} steady tests{said}"
    if block.what == "cycle":
        test = block.test or "dynamic"
        each = f"{len(block.lines) / count:.3g} rows each"
        return f"{counted(count, 'test')} of one cycle, {each}: {test}{said}"
    if block.what == "sweep":
        each = f"{len(block.lines) / count:.3g} rows each"
        swept = f"{counted(count, 'sweep')} of the rudder, {each}"
        return f"{swept}: every row as a steady test{said}"
    if block.what == "statistics":
        return f"statistics of repeats, no runs: {', '.join(block.names)}{said}"
    if block.what == "other names":
        return f"another table, with names of its own: {', '.join(block.names[:_SHOWN])}; not read"
    return "less than half of the numbers are there; not read"


def file_words(look: FileLook) -> str:
    """Format, layout and size of a file in words."""
    words = [READERS[look.format].words, _KINDS[look.kind]]
    layout = look.layout
    if layout is not None:
        sign = "comma" if layout.decimal == "," else "point"
        words.append(f"{_DELIMITERS[layout.delimiter]} between, decimal {sign}, {layout.encoding}")
        header = layout.header_line
        words.append("no header" if header is None else f"names in line {header}")
        if layout.units:
            words.append("units below them")
        words.append(f"numbers from line {layout.first_row}")
    elif look.options.skip_rows:
        words.append(f"{look.options.skip_rows} rows above the table")
    if look.rows:
        about = "about " if look.sampled else ""
        words.append(f"{about}{look.rows} rows")
    if look.sampled:
        words.append("only beginning, middle and end were read")
    return ", ".join(words)


def clock_words(clock: Clock, column: ColumnLook) -> str:
    """The clock of a history in words."""
    unit = (column.suggestion.unit if column.suggestion else None) or column.unit or "s"
    even = "even" if clock.even else "uneven"
    words = [
        f"Sampled every {clock.interval:.6g} {unit} ({even}), {clock.duration:.6g} {unit} long"
    ]
    if clock.gaps:
        words.append(f"{clock.gaps} gaps, the longest {clock.longest:.6g} {unit}")
    if clock.repeated:
        words.append(f"{clock.repeated} times stand twice")
    if clock.backward:
        words.append(f"time runs backward at {clock.backward} places")
    return ", ".join(words) + "."


def column_table(columns: Sequence[ColumnLook]) -> list[str]:
    """The columns as an aligned table, the longest headers cut."""
    rows = [list(_HEAD)]
    for column in columns:
        numbers = [column.low, column.high, column.mean, column.first]
        shown = [f"{value:.5g}" if np.isfinite(value) else "" for value in numbers]
        if column.constant:
            shown[1:3] = ["constant", ""]
        if not column.numbers and not column.remark:
            shown[0] = "no numbers"
        rows.append([column.clipped, column.unit or "", *shown, _is(column)])
    widths = [max(len(row[place]) for row in rows) for place in range(len(_HEAD))]
    return [
        "  ".join(
            cell.ljust(width) if place in (0, 1, 6) else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def problem_lines(problems: Sequence[Problem]) -> list[str]:
    """Problems in words, numbered; the first dozen in full."""
    if not problems:
        return []
    lines = ["", f"Not read as it is ({len(problems)}):"]
    lines += [f"  {number}. {item}" for number, item in enumerate(problems[:_SHOWN], start=1)]
    if len(problems) > _SHOWN:
        lines.append(f"  and {len(problems) - _SHOWN} more.")
    return lines


def _is(column: ColumnLook) -> str:
    item = column.suggestion
    said = ""
    if item is not None:
        unit = f" in {item.unit}" if item.unit and item.unit not in item.reason else ""
        said = f"{item.certainty} {item.name}{unit} ({item.reason})"
    return "; ".join(part for part in (said, column.remark) if part)


def _campaign_lines(found: Look) -> list[str]:
    lines = []
    for item in found.campaigns:
        if item.problem:
            lines.append(f"{item.file}: a campaign that cannot be opened. {item.problem}")
            continue
        tests = ", ".join(f"{count} {test}" for test, count in item.tests.items())
        speeds = ", ".join(f"{speed:g}" for speed in item.speeds)
        left = f", {item.excluded} left out" if item.excluded else ""
        lines.append(
            f"{item.file}: {item.kind} campaign {item.title!r}, ship {item.ship}, "
            f"{item.runs} runs ({tests}){left}, at {speeds} m/s."
        )
    return lines


def _others_lines(found: Look) -> list[str]:
    lines = []
    if found.others:
        counted = ", ".join(
            f"{count} {suffix or 'without suffix'}" for suffix, count in found.others.items()
        )
        lines.append(f"Other files, without measurements that are recognised: {counted}.")
    if found.passed_over:
        lines.append(
            f"{_many(found.passed_over)} more files were not looked at: name a folder with fewer."
        )
    return lines


def _many(count: int) -> str:
    return str(count) if count < MOST_COUNTED else f"more than {count}"
