"""A table among the files that lists the tests: what it says of which run."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from pmmkit.base import CampaignError
from pmmkit.campaigns import TEST_KINDS, setting_units
from pmmkit.intake.drafts.names import test_named
from pmmkit.intake.guessing import suggest
from pmmkit.intake.seen import FileLook
from pmmkit.readers import READERS, Cells, as_text, to_number

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
            suggestion=guess if guess and guess.name in setting_units() else None,
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
