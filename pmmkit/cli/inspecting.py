"""The work behind ``pmmkit inspect``: what was seen, in words, as JSON and as a figure."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from pmmkit.cli.console import Outcome
from pmmkit.cli.tracks import check_folder
from pmmkit.errors import DataError, Problem
from pmmkit.files import write_text
from pmmkit.inspection import CampaignLook, Clock, ColumnLook, FileLook, Group, Look, look
from pmmkit.inspection.folder import MOST_COUNTED
from pmmkit.inspection.sampling import sample_of
from pmmkit.inspection.values import values_of
from pmmkit.readers import reader_of

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


def inspect(path: Path, *, out: Path | None = None) -> Outcome:
    """What lies at a path.

    Parameters
    ----------
    path : Path
        File or folder.
    out : Path, optional
        Folder for ``inspect.csv`` and, of the first history, ``inspect.png``.

    Returns
    -------
    Outcome
    """
    if out:
        check_folder(out)
    found = look(path)
    lines = [*_campaign_lines(found), *_others_lines(found)]
    for group in found.groups:
        lines += ["", *group_lines(group)]
    lines += problem_lines(found.problems)
    files = [] if out is None else _write(found, out)
    lines += [f"Written: {file}" for file in files]
    if found.groups and not any(item.file == "campaign.toml" for item in found.campaigns):
        folder = path if path.is_dir() else path.parent
        lines += ["", f"Next: pmmkit new-campaign {_quoted(folder)}"]
    content = {
        "path": str(path),
        "groups": [_group_content(group) for group in found.groups],
        "campaigns": [_campaign_content(item) for item in found.campaigns],
        "other_files": found.others,
        "passed_over": found.passed_over,
        "problems": [str(problem) for problem in found.problems],
        "files": [str(file) for file in files],
    }
    return Outcome(content=content, lines=lines[1:] if lines and not lines[0] else lines)


def group_lines(group: Group) -> list[str]:
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
    lines += [f"  {line}" for line in column_table(first.columns)]
    lines += [f"  Note: {note}." for note in first.notes]
    return lines


def file_words(look: FileLook) -> str:
    """Format, layout and size of a file in words."""
    words = [reader_of(look.format).words, _KINDS[look.kind]]
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
        rows.append([_clip(column.label), column.unit or "", *shown, _is(column)])
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


def _clip(text: str) -> str:
    plain = "".join(char if char.isprintable() else "?" for char in text)
    return plain if len(plain) <= 36 else plain[:34] + " …"


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


def _quoted(path: Path) -> str:
    text = str(path)
    return f'"{text}"' if " " in text else text


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


def _group_content(group: Group) -> dict[str, Any]:
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


def _write(found: Look, out: Path) -> list[Path]:
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
            writer.writerow(
                [
                    group.first.shown,
                    column.position + 1,
                    column.title,
                    column.unit or "",
                    *numbers,
                    "yes" if column.constant else "no",
                    *guess,
                    column.remark,
                ]
            )
    files = []
    if found.groups:
        write_text(out / "inspect.csv", table.getvalue())
        files.append(out / "inspect.csv")
    drawn = _drawn(found.groups)
    if drawn is not None:
        files.append(_draw(drawn, out / "inspect.png"))
    return files


def _drawn(groups: Sequence[Group]) -> FileLook | None:
    """The file whose columns are drawn: the first history, else the first with numbers."""
    rank = {"history": 0, "unknown": 1, "table": 2, "open water": 3}
    files = [
        group.first for group in groups if any(column.numbers for column in group.first.columns)
    ]
    return min(files, key=lambda item: rank[item.kind], default=None)


def _draw(look: FileLook, target: Path) -> Path:
    from dataclasses import replace

    from pmmkit.figures.inspecting import columns_over_time
    from pmmkit.plotting.style import save

    try:
        with sample_of(look.path) as sample:
            values = values_of(replace(look, path=sample.path)).numbers
    except OSError as error:
        raise DataError(f"{look.shown} cannot be read: {error.strerror}.") from error
    clock = look.known.get("t") if look.kind == "history" else None
    count = max(len(numbers) for numbers in values.values())
    time = values[clock.position] if clock else np.arange(1.0, count + 1.0)
    unit = (clock.unit or (clock.suggestion and clock.suggestion.unit) or "s") if clock else ""
    columns = {
        f"{_clip(column.label)} [{_unit(column)}]": values[column.position]
        for column in look.columns
        if column.position in values and column is not clock
    }
    figure = columns_over_time(
        time,
        columns,
        time_label=f"{_clip(clock.label)} [{unit}]" if clock else "row",
        title=look.shown + (" (beginning, middle and end)" if look.sampled else ""),
    )
    return save(figure, target)


def _unit(column: ColumnLook) -> str:
    stated = column.unit or (column.suggestion.unit if column.suggestion else None)
    return stated or "no unit stated"
