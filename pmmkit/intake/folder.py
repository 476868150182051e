"""What lies there: a file or a folder looked at before anything is known of it."""

from __future__ import annotations

import csv
import io
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns import open_campaign
from pmmkit.files import CAMPAIGN, Url
from pmmkit.intake.file import look_at, with_numbers
from pmmkit.intake.seen import ColumnLook, FileLook, SheetBlock
from pmmkit.intake.told_columns import with_told_columns
from pmmkit.presentation import counted, safe_cell
from pmmkit.readers import READERS, Contents, Request, recognise

MOST_FILES: Final = 2000
"""Files of a folder that are looked at; of more it is only said how many there are."""
MOST_COUNTED: Final = 20_000
"""Further files that are counted."""
_RESULTS: Final = ("derivatives.csv", "comparison.json", "diagnosis.json", "metrics.json")
"""Files by which a folder with results of pmmkit is known; it is passed over."""
_DEEPEST: Final = 8
_PASSED: Final = frozenset(
    {
        ".toml",
        ".py",
        ".m",
        ".md",
        ".ipynb",
        ".html",
        ".png",
        ".jpg",
        ".jpeg",
        ".gif",
        ".svg",
        ".pdf",
        ".doc",
        ".docx",
        ".ppt",
        ".pptx",
        ".mp4",
        ".avi",
        ".mov",
        ".zip",
        ".7z",
        ".gz",
    }
)
"""Suffixes of files that are not measurements and are not opened."""
_LISTS: Final = frozenset({".csv", ".txt", ".tsv", ".dat", ".yml", ".yaml", ".json", ".ini"})
_PROSE: Final = frozenset({".md"})
_SHORT: Final = 64_000
"""Size of a text up to which it is looked through for particulars [bytes]: some hundred rows."""


@dataclass(frozen=True, kw_only=True)
class CampaignLook:
    """A campaign that is there.

    `file`: campaign file or saved campaign. `tests`: runs of each kind. `problem`: why it
    cannot be opened; empty if it can.
    """

    file: str
    title: str = ""
    kind: str = ""
    ship: str = ""
    runs: int = 0
    excluded: int = 0
    tests: Mapping[str, int] = field(default_factory=lambda: MappingProxyType({}))
    speeds: tuple[float, ...] = ()
    problem: str = ""


@dataclass(frozen=True, kw_only=True)
class FileGroup:
    """Files of the same format with the same headers.

    Parameters
    ----------
    files : tuple of FileLook
        The first one with its numbers, the others by their beginnings.
    """

    files: tuple[FileLook, ...]

    @property
    def first(self) -> FileLook:
        """The file that was read."""
        return self.files[0]


@dataclass(frozen=True, kw_only=True)
class Look:
    """What lies at a path.

    Parameters
    ----------
    path : Path
        File or folder.
    groups : tuple of FileGroup
        Files with data; for a file a group for each of its sheets.
    campaigns : tuple of CampaignLook
        Campaign file in the folder, saved campaigns.
    others : mapping of str to int
        How many files without data there are, by suffix.
    problems : tuple of Problem
        Files that cannot be read or understood.
    passed_over : int
        Files that were not looked at because there are too many.
    without_table : tuple of FileLook
        Sheets of workbooks in which no table was found, and short texts: particulars may stand
        there.
    """

    path: Path
    groups: tuple[FileGroup, ...] = ()
    campaigns: tuple[CampaignLook, ...] = ()
    others: Mapping[str, int] = field(default_factory=lambda: MappingProxyType({}))
    problems: tuple[Problem, ...] = ()
    passed_over: int = 0
    without_table: tuple[FileLook, ...] = ()

    def lines(self) -> list[str]:
        """All that was seen, in lines for people."""
        told = [*_campaign_lines(self), *_others_lines(self)]
        for group in self.groups:
            told += ["", *group_lines(group)]
        told += problem_lines(self.problems)
        return told[1:] if told and not told[0] else told

    def to_dict(self) -> dict[str, Any]:
        """All that was seen, for JSON."""
        return {
            "groups": [_group_content(group) for group in self.groups],
            "campaigns": [_campaign_content(item) for item in self.campaigns],
            "other_files": self.others,
            "passed_over": self.passed_over,
            "problems": [str(problem) for problem in self.problems],
        }

    def columns_csv(self) -> str:
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
        for group in self.groups:
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


def look(path: str | Path) -> Look:
    """Look at a file or a folder of which nothing is known; nothing is changed.

    Parameters
    ----------
    path : path
        A file of measurements, a campaign (folder, campaign file or saved), or a folder.

    Returns
    -------
    Look
        Of text files above 64 MB only beginning, middle and end are read; of a folder's files all
        beginnings and the first file of each group.

    Raises
    ------
    CampaignError
        If there is nothing, if the layout of a single file is not known (with its first lines), or
        if a folder holds no measurements.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "run.csv"
    >>> _ = file.write_text("Time;Fx [kN]\\n0,0;1,5\\n0,1;1,6\\n0,2;1,4\\n")
    >>> (group,) = look(file).groups
    >>> [column.suggestion.name for column in group.first.columns]
    ['t', 'X']
    """
    place = Path(path).expanduser()
    url = Url.of(path)
    if url is not None:
        raise CampaignError(
            Problem(
                message="files behind a URL are not looked through.",
                file=url.shown,
                remedy="Copy them to a folder; of a campaign the command pmmkit check tells what "
                "is wrong with it.",
            )
        )
    if not place.exists():
        raise CampaignError(Problem(message="there is no such file or folder.", file=str(place)))
    if place.is_dir() and not _is_one_run(place):
        return _look_folder(place)
    if not (place.is_file() or place.is_dir()):
        raise CampaignError(Problem(message="this is neither file nor folder.", file=str(place)))
    if place.suffix == ".toml" or _is_packed(place):
        return Look(path=place, campaigns=(_campaign(place, place.name),))
    looks = look_at(place, place.name, numbers=False)
    if looks[0].is_campaign:
        return Look(path=place, campaigns=(_campaign(place, place.name),))
    found, problems = _grouped([item for item in looks if item.columns])
    problems = [*(fault for item in looks for fault in item.problems), *problems]
    if not found:
        raise CampaignError(problems)
    return Look(
        path=place, groups=found, problems=tuple(problems), without_table=_without_table(looks)
    )


def _without_table(looks: Sequence[FileLook]) -> tuple[FileLook, ...]:
    return tuple(
        item for item in looks if not item.columns and (item.has_sheets or _may_list(item))
    )


def _may_list(item: FileLook) -> bool:
    """Whether a file that no reader knows is a short text of rows."""
    return not item.format and item.size <= _SHORT and item.path.suffix.lower() in _LISTS


def _is_packed(path: Path) -> bool:
    """Whether a file is an archive that holds a campaign file; a damaged one does not."""
    if path.suffix.lower() != ".zip":
        return False
    try:
        return bool(Contents.of(Request(path=path, shown=path.name)).named(CAMPAIGN.file))
    except CampaignError:
        return False


def _look_folder(folder: Path) -> Look:
    files, passed_over = _files(folder)
    campaigns = [_campaign(folder, CAMPAIGN.file)] if (folder / CAMPAIGN.file).is_file() else []
    others: Counter[str] = Counter()
    problems: list[Problem] = []
    looks: list[FileLook] = []
    bare: list[FileLook] = []
    for path in files:
        shown = path.relative_to(folder).as_posix()
        if not _is_text(shown):
            problems.append(_ODD_NAME)
            continue
        if path.suffix.lower() in _PASSED and not path.is_dir():
            others[path.suffix.lower()] += 1
            if path.suffix.lower() in _PROSE and (size := path.stat().st_size) <= _SHORT:
                bare.append(FileLook(path=path, shown=shown, size=size))
            continue
        seen = look_at(path, shown, numbers=False)
        bare += _without_table(seen)
        for item in seen:
            if item.is_campaign:
                campaigns.append(_campaign(path, shown))
            elif item.columns:
                looks.append(item)
            elif item.format or not item.size or _refused(item):
                problems += item.problems
            else:
                others[path.suffix.lower()] += 1
    if not (looks or campaigns):
        raise _nothing(folder, others, problems)
    groups, damaged = _grouped(with_told_columns(looks, bare))
    problems += damaged
    return Look(
        path=folder,
        groups=groups,
        campaigns=tuple(campaigns),
        others=MappingProxyType(dict(others)),
        problems=tuple(problems),
        passed_over=passed_over,
        without_table=tuple(bare),
    )


def _is_text(name: str) -> bool:
    """Whether a name can be written as UTF-8."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


_ODD_NAME: Final = Problem(
    message="the name of a file is not Unicode text: it was passed over.", remedy="Rename it."
)


def _refused(item: FileLook) -> bool:
    return any("cannot be read" in problem.message for problem in item.problems)


def _grouped(looks: Sequence[FileLook]) -> tuple[tuple[FileGroup, ...], list[Problem]]:
    """Files and sheets of the same layout and headers, the first of each with its numbers."""
    groups: dict[object, list[FileLook]] = {}
    for item in looks:
        groups.setdefault(_key(item), []).append(item)
    found = [
        FileGroup(files=(with_numbers(members[0]), *members[1:])) for members in groups.values()
    ]
    return tuple(found), [problem for group in found for problem in group.first.problems]


def _key(item: FileLook) -> tuple[object, ...]:
    """What files of a group have alike: histories may have more or fewer lines above."""
    above = 0 if item.kind == "history" else item.options.skip_rows
    own = replace(item.options, sheet=None, group=None, where=(), last_row=None, skip_rows=above)
    return item.format, item.titles, own


def _files(folder: Path) -> tuple[list[Path], int]:
    """Files below a folder, folders of a format among them, in order; and how many more."""
    found: list[Path] = []
    more = 0
    for path in _walk(folder, 0):
        if len(found) < MOST_FILES:
            found.append(path)
        elif more < MOST_COUNTED:
            more += 1
        else:
            break
    return found, more


def _walk(folder: Path, depth: int) -> Iterator[Path]:
    """Regular files and folders of a format; links to folders are not followed."""
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: (entry.is_dir(), entry.name))
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith((".", "~$")):
            continue
        path = Path(entry.path)
        if entry.is_file():
            yield path
        elif not entry.is_dir(follow_symlinks=False) or any(
            (path / name).is_file() for name in _RESULTS
        ):
            continue
        elif _is_one_run(path):
            yield path
        elif depth < _DEEPEST:
            yield from _walk(path, depth + 1)


def _is_one_run(folder: Path) -> bool:
    """Whether a folder is one measurement: of a format of folders, its files parts of one run."""
    name = recognise(folder)
    return name is not None and READERS[name].is_one_run(folder)


def _campaign(path: Path, shown: str) -> CampaignLook:
    try:
        opened = open_campaign(path)
    except DataError as error:
        return CampaignLook(file=shown, problem=str(error))
    return CampaignLook(
        file=shown,
        title=opened.title,
        kind=opened.kind,
        ship=opened.ship.name,
        runs=len(opened),
        excluded=len(opened.excluded),
        tests=MappingProxyType(dict(Counter(run.test for run in opened))),
        speeds=tuple(sorted({run.settings.speed for run in opened})),
    )


def _nothing(folder: Path, others: Mapping[str, int], problems: list[Problem]) -> CampaignError:
    there = ", ".join(f"{count} {suffix or 'without suffix'}" for suffix, count in others.items())
    said = f"There are {sum(others.values())} other files: {there}." if others else "It is empty."
    if problems and not others:
        said = "Its files cannot be read."
    main = Problem(
        message=f"there are no measurements in this folder. {said}",
        file=str(folder),
        remedy=f"Expected: files of the formats {', '.join(READERS)}.",
    )
    return CampaignError([main, *problems])


# What was seen, in lines for people.


_HEAD: Final = ("column", "unit", "min", "max", "mean", "first", "is")
_SHOWN: Final = 12
"""Names and problems that are listed before the rest is only counted."""


def group_lines(group: FileGroup) -> list[str]:
    """A group of files in words: its first file with a table of the columns."""
    first = group.first
    lines = [f"{first.shown}: {first.words}."]
    if len(group.files) > 1:
        names = [item.shown for item in group.files[1:]]
        more = "" if len(names) <= _SHOWN else f" and {len(names) - _SHOWN} more"
        lines.append(
            f"  {len(names)} more with the same columns: {', '.join(names[:_SHOWN])}{more}."
        )
    if first.clock is not None:
        lines.append(f"  {first.clock_words}")
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
