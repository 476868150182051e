"""``[[matrix]]``: a table that says of each run what it was set to and where its history lies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from pmmkit.base import DataError, Problem
from pmmkit.campaigns.file.assembly import Assembled, Setup
from pmmkit.campaigns.file.schema import MatrixEntry
from pmmkit.campaigns.run import at_hand
from pmmkit.campaigns.run_settings import setting_units
from pmmkit.campaigns.samples.column_mapping import ColumnSpec, Picked, pick
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
from pmmkit.readers import Cells, Options, Request, as_text, reader_for

_NOTHING: Final = ("", "-", "–", "—", "/")
"""Cells that say that a test has no such setting."""


def entries_of(
    matrix: MatrixEntry, label: str, setup: Setup, out: Assembled
) -> Iterator[tuple[str, dict[str, Any]]]:
    """An entry of ``[[runs]]`` for every row that is not left out, with its place in words."""
    found = setup.search.find(matrix.file)
    if found is None:
        out.problems.append(setup.search.missing(matrix.file, label, out.file))
        out.incomplete = True
        return
    stated = {} if matrix.source is None else matrix.source.model_dump(exclude_unset=True)
    request = replace(found, options=Options(**stated))
    try:
        request = at_hand(request)
        cells = reader_for(request).cells(request)
    except DataError as error:
        out.problems += error.problems
        out.incomplete = True
        return
    specs = {name: ColumnSpec(**item.model_dump()) for name, item in matrix.columns.items()}
    picked, problems = pick(cells.headers, len(cells.headers), specs, request, table=True)
    chosen, unfit = cells.matching_rows(matrix.where, request)
    templates = " ".join((matrix.id, matrix.test, matrix.run, matrix.run_sheet or ""))
    problems += [
        *unfit,
        *(cells.no_column(name, request) for name in cells.filled_in(templates, 0)[1]),
    ]
    out.problems += problems
    if problems:
        out.incomplete = True
        return
    settings = [column for column in picked if column.name in setting_units()]
    for index in chosen:
        line = cells.lines[index]
        if line not in matrix.skip:
            place = f"{label}, row {line} of {matrix.file}"
            yield place, _entry(matrix, cells, settings, index, request, out)


def _entry(
    matrix: MatrixEntry,
    cells: Cells,
    settings: list[Picked],
    index: int,
    request: Request,
    out: Assembled,
) -> dict[str, Any]:
    """A row as an entry of ``[[runs]]``."""

    def filled(template: str) -> str:
        return cells.filled_in(template, index)[0].strip()

    line = cells.lines[index]
    entry: dict[str, Any] = {"id": filled(matrix.id), "file": filled(matrix.run)}
    word = filled(matrix.test)
    test = matrix.tests.get(word, word)
    if test not in TEST_KINDS:
        out.problems.append(_unknown(word, test, line, request))
        out.incomplete = True
    else:
        entry["test"] = test
    if matrix.run_sheet is not None:
        entry["source"] = {"sheet": filled(matrix.run_sheet)}
    for column in settings:
        if as_text(cells.rows[index][column.position]) in _NOTHING:
            continue
        number, why = cells.number_at(index, column.position)
        if why is not None or number is None:
            problem = request.problem(why or "this is no number.", row=line, column=column.title)
            out.problems.append(problem)
        else:
            entry[column.name] = number * column.scale + column.offset
    return {**matrix.settings(), **entry}


def _unknown(word: str, test: str, line: int, request: Request) -> Problem:
    known = f'tests = {{ "{word}" = "static_drift" }}' if word == test else TEST_KINDS.unknown(test)
    return request.problem(
        f"{test!r} is no kind of test.",
        row=line,
        remedy=f"Say under [[matrix]] which it is, e.g. {known}.",
    )
