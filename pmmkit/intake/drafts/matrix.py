"""A table among the files that lists the tests: what it says of which run."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath
from typing import Any, Final

import numpy as np

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS
from pmmkit.intake.blocks import statistic_in
from pmmkit.intake.drafts.names import test_named
from pmmkit.intake.file import with_numbers
from pmmkit.intake.folder import FileGroup, Look, block_words
from pmmkit.intake.guessing import suggest
from pmmkit.intake.seen import Blocks, FileLook, SheetBlock
from pmmkit.numerics import Array
from pmmkit.readers import READERS, Cells, as_text, to_number

# A sheet of several blocks as tables of a campaign file: its runs, and what was left.


_FORCES: Final = ("X", "Y", "N", "K")
_LISTED: Final = 8

HEADED: Final = "their drift and sway are 0, their heading is not: the drift is taken from it"


def only_sheet(seen: Look, sheet: str) -> Look:
    """What lies there, of workbooks only one sheet."""
    groups = []
    for group in seen.groups:
        files = [
            item
            for item in group.files
            if item.options.sheet in (None, sheet) or group.first.kind == "unknown"
        ]
        if files and files[0] is not group.first:
            files[0] = with_numbers(files[0])
        groups += [FileGroup(files=tuple(files))] if files else []
    if not any(item.options.sheet == sheet for group in groups for item in group.files):
        there = [item.options.sheet for group in seen.groups for item in group.files]
        named = ", ".join(repr(name) for name in there if name is not None)
        raise CampaignError(
            Problem(
                message=f"no workbook has a table on a sheet {sheet!r}. There are {named}.",
                file=str(seen.path),
            )
        )
    return replace(seen, groups=tuple(groups))


def where_of(block: SheetBlock, blocks: Blocks) -> dict[str, Any]:
    """The condition that takes the rows of a block and no others of its sheet."""
    others = {word for other in blocks.blocks if other is not block for word in other.words}
    if blocks.word and block.words and not others & set(block.words):
        return {blocks.word: _one_or_all(block.words)}
    return {blocks.name: _one_or_all(block.names)} if blocks.name else {}


def skipped(block: SheetBlock, blocks: Blocks) -> tuple[int, ...]:
    """Rows that must be left out where nothing in them tells a block from the others."""
    if where_of(block, blocks):
        return ()
    last = blocks.last_row or max(line for other in blocks.blocks for line in other.lines)
    apart = (other for other in blocks.blocks if other is not block)
    return tuple(sorted(line for other in apart for line in other.lines if line <= last))


def template_of(block: SheetBlock, blocks: Blocks, sheet: str) -> str:
    """The id of the runs of a block: their name, and the row where several have one name."""
    name = f"{{{blocks.name}}}" if blocks.name else ""
    row = (
        "" if block.what == "cycle" or (len(block.names) == len(block.lines) and name) else "{row}"
    )
    return "_".join(part for part in (sheet, name, row) if part)


def as_measured(item: FileLook, block: SheetBlock) -> dict[str, Any]:
    """Columns of steady rows whose heading alone tells the drift, or whose rudder swings."""
    known, found = item.known, dict[str, Any]()
    if block.headed:
        found = {"drift_deg": known["psi"].title, "psi": False}
        found |= {"v": False} if "v" in known else {}
        found |= {"speed": known["u"].title, "u": False} if "u" in known else {}
    if block.what == "sweep" and "delta" in known:
        found |= {"rudder_deg": known["delta"].title, "delta": False}
    return found


def prefixes(looks: Sequence[FileLook]) -> dict[str, str]:
    """What tells the tests of a table from those of others, by `FileLook.shown`: nothing where
    each has its own name, else the sheet, or the file before it where several have such a sheet."""
    named = Counter(
        name
        for look in looks
        for name in {name for block in look.blocks.runs for name in block.names}
    )
    if max(named.values(), default=0) < 2:
        return {look.shown: "" for look in looks}
    books = Counter(look.options.sheet for look in looks)
    found = {}
    for look in looks:
        sheet = look.options.sheet
        book = PurePosixPath(look.file).stem if books[sheet] > 1 else None
        found[look.shown] = "_".join(str(part) for part in (book, sheet) if part is not None)
    return found


def left_lines(look: FileLook) -> list[str]:
    """What of a sheet is not taken, and why."""
    runs = look.blocks.runs
    left = [block for block in look.blocks.blocks if block not in runs]
    return [f"{look.shown}, {block.places}: {block_words(block)}" for block in left]


def strangers(look: FileLook, sheets: Sequence[str]) -> list[str]:
    """Tests whose name begins with that of another sheet, as a line; none where all do not."""
    own = (look.options.sheet if isinstance(look.options.sheet, str) else "").casefold()
    names = [name for block in look.blocks.blocks for name in block.names]
    others = [name for name in names if _of_other(name, own, sheets)]
    mine = sum(name.casefold().startswith(own) for name in names) if own else 0
    if not others or mine <= len(others):
        return []
    more = f" and {len(others) - _LISTED} more" if len(others) > _LISTED else ""
    listed = ", ".join(others[:_LISTED])
    return [f"{look.shown}: tests that bear the name of another sheet: {listed}{more}"]


def _of_other(name: str, own: str, sheets: Sequence[str]) -> bool:
    plain = name.casefold()
    other = any(plain.startswith(sheet.casefold()) for sheet in sheets if sheet.casefold() != own)
    return other and not plain.startswith(own)


def scatter_lines(looks: Sequence[FileLook]) -> list[str]:
    """The standard deviations of repeats that sheets state, as lines that are off.

    The repeats themselves are among the runs, so that the statistics say nothing new.
    """
    found: dict[str, list[float]] = {}
    units: dict[str, str] = {}
    said = []
    for look in looks:
        deviations, lines = _deviations(look)
        for name, values in deviations.items():
            found.setdefault(name, []).extend(map(float, values))
            units[name] = look.known[name].unit or ("N" if name in "XY" else "N m")
        if lines:
            more = f" and {len(lines) - _LISTED} more" if len(lines) > _LISTED else ""
            said.append(f"{look.shown}, rows {', '.join(map(str, lines[:_LISTED]))}{more}")
    if not found:
        return []
    return [
        "# Standard deviations of repeats as the laboratory states them, root mean squares of "
        f"{'; '.join(said)}.",
        "# The repeats are among the runs and tell it: state it only if they are not.",
        "# [uncertainty]",
        *(
            f"# {name}_gauge = {{ std = {math.sqrt(np.mean(np.square(values))):.3g}, "
            f'unit = "{units[name]}" }}'
            for name, values in found.items()
        ),
        "",
    ]


def _deviations(look: FileLook) -> tuple[dict[str, Array], list[int]]:
    """The stated standard deviations of each force, and their rows."""
    statistics = {line for block in look.blocks.of("statistics") for line in block.lines}
    if not statistics:
        return {}, []
    cells = READERS[look.format].cells(look.request)
    rows = [
        index
        for index, line in enumerate(cells.lines)
        if line in statistics and any(statistic_in(cell) == "std" for cell in cells.rows[index])
    ]
    found = {}
    for name in _FORCES:
        if name not in look.known:
            continue
        place = look.known[name].position
        numbers = [to_number(cells.rows[index][place], cells.decimal) for index in rows]
        values: Array = np.array(numbers, dtype=float)
        found[name] = values[np.isfinite(values)]
    return {name: x for name, x in found.items() if len(x)}, [cells.lines[index] for index in rows]


def _one_or_all(values: Sequence[str]) -> Any:
    return values[0] if len(values) == 1 else list(values)


def where_line(where: Mapping[str, Any]) -> str:
    """A condition as TOML."""
    from pmmkit.files import toml_string
    from pmmkit.intake.drafts.columns import toml

    inside = ", ".join(f"{toml_string(key)} = {toml(value)}" for key, value in where.items())
    return f"where = {{ {inside} }}"


_MOST_ROWS: Final = 5000
_TRIED: Final = 5
"""Rows by which it is told how the runs are named after a column."""


@dataclass(frozen=True, kw_only=True)
class MatrixDraft:
    """An entry of ``[[matrix]]``.

    `look`: the table; its columns that are settings have a suggestion, the others none. `file`:
    where it lies, relative to the campaign file. `id, run`: name and file of each run, columns
    in braces. `run_sheet`: sheet of each run, columns in braces. `test`: column, in braces,
    that says the kind of test; or a kind. `tests`: the words of that column, and the kinds that
    they are; None where nobody knows. `skip`: rows of which there is no run. `runs`: kind of
    test of the runs that it lists, by their place: file, or sheet of the workbook.
    """

    look: FileLook
    file: str
    id: str
    run: str
    run_sheet: str | None
    test: str
    tests: Mapping[str, str | None]
    skip: tuple[int, ...]
    runs: Mapping[str, str | None]

    @property
    def settings(self) -> frozenset[str]:
        """Settings that its columns tell."""
        return frozenset(
            name
            for name, column in self.look.known.items()
            if column.suggestion and column.suggestion.certainty != "perhaps"
        )


def matrix_of(
    looks: Sequence[FileLook], base: str, places: Sequence[str], workbook: str | None
) -> MatrixDraft | None:
    """The table that lists most of some runs, or None."""
    found = [
        draft
        for item in looks
        for cells in _cells(item)
        if (draft := _drafted(item, cells, base, places, workbook)) is not None
    ]
    return max(found, key=lambda draft: len(draft.runs), default=None)


def _cells(look: FileLook) -> Iterator[Cells]:
    if look.rows > _MOST_ROWS:
        return
    try:
        cells = READERS[look.format].cells(look.request)
    except CampaignError:
        return
    if all(cells.headers) and len(cells.rows) <= _MOST_ROWS:
        yield cells


def _drafted(
    look: FileLook, cells: Cells, base: str, places: Sequence[str], workbook: str | None
) -> MatrixDraft | None:
    column, template = _naming(cells, places)
    listed = _listed(cells, template, places) if template else {}
    if len(listed) < 2 or 2 * len(listed) < len(places):
        return None
    words = _test_column(cells, listed, besides=column)
    if words is None:
        return None
    test, tests = words
    place = cells.headers.index(test)
    known = suggest(
        [item.header for item in look.columns], [item.unit for item in look.columns], {}, table=True
    )
    columns = tuple(
        replace(
            item,
            suggestion=guess if guess and guess.name in RUN_SETTINGS.units else None,
            numbers=any(_is_number(cells, row, item.position) for row in listed),
        )
        for item, guess in zip(look.columns, known, strict=True)
    )
    settings = [item for item in columns if item.suggestion and item.numbers]
    if not settings:
        return None
    return MatrixDraft(
        look=replace(look, columns=columns),
        file=base + look.shown.partition(", sheet ")[0],
        id=_identity(template, column, workbook),
        run=template if workbook is None else workbook,
        run_sheet=None if workbook is None else template,
        test=f"{{{test}}}",
        tests=tests,
        skip=tuple(line for index, line in enumerate(cells.lines) if index not in listed),
        runs={name: tests.get(as_text(cells.rows[row][place])) for row, name in listed.items()},
    )


def _is_number(cells: Cells, row: int, position: int) -> bool:
    number = to_number(cells.rows[row][position], cells.decimal)
    return number is not None and math.isfinite(number)


def _identity(template: str, column: str, workbook: str | None) -> str:
    """The sheet, or the file without folders and suffix."""
    if workbook is not None:
        return template
    stem = re.sub(r"\.[A-Za-z]\w{0,5}$", "", template.rpartition("/")[2])
    return stem if "{" in stem else f"{{{column}}}"


def _naming(cells: Cells, places: Sequence[str]) -> tuple[str, str]:
    """The column after which runs are named, and their place with it in braces; else empty."""
    best = ("", "", 1)
    for position, header in enumerate(cells.headers):
        if "{" in header or "}" in header or list(cells.headers).count(header) > 1:
            continue
        texts = [as_text(row[position]) for row in cells.rows]
        tried = [text for text in dict.fromkeys(texts) if text][:_TRIED]
        templates = dict.fromkeys(
            f"{place[: found.start()]}{{{header}{_digits(text, found[0])}}}{place[found.end() :]}"
            for text in tried
            for place in places
            for found in _tokens(text, place)
        )
        for template in templates:
            hits = len(_listed(cells, template, places))
            if hits > best[2]:
                best = (header, template, hits)
    return best[:2]


def _tokens(text: str, place: str) -> Iterator[re.Match[str]]:
    """Where a text stands as a word of its own, or a whole number with any zeros before it."""
    if text.isdecimal():
        return re.finditer(rf"(?<![0-9.+-])0*{int(text)}(?![0-9A-Za-z]|\.\d)", place)
    return re.finditer(rf"(?<![0-9A-Za-z.+-]){re.escape(text)}(?![0-9A-Za-z]|\.\d)", place)


def _digits(text: str, found: str) -> str:
    """How a whole number is written out where the cells have it with other zeros before it."""
    if not text.isdecimal() or text == found:
        return ""
    return f":0{len(found)}" if found.startswith("0") else ":01"


def _listed(cells: Cells, template: str, places: Sequence[str]) -> dict[int, str]:
    """Runs by the row that names them, the first of several."""
    there = set(places)
    found: dict[int, str] = {}
    for index in range(len(cells.rows)):
        name = cells.filled_in(template, index)[0].strip()
        if name in there:
            there.remove(name)
            found[index] = name
    return found


def _test_column(
    cells: Cells, listed: Mapping[int, str], *, besides: str
) -> tuple[str, dict[str, str | None]] | None:
    """The column that says the kinds of test of most runs, and its words."""
    best: tuple[str, dict[str, str | None]] | None = None
    most = len(listed) / 2
    for position, header in enumerate(cells.headers):
        if header == besides:
            continue
        words = [as_text(cells.rows[row][position]) for row in listed]
        tests = {word: word if word in TEST_KINDS else test_named(word) for word in words}
        count = sum(tests[word] is not None for word in words)
        if count > most:
            best, most = (header, tests), count
    return best
