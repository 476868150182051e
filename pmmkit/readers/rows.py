"""Rows of a table of tests: choosing them, naming them, taking their numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

from pmmkit.base import Problem, did_you_mean
from pmmkit.conventions import split_unit
from pmmkit.readers.base import Cell, Cells, Request, to_number

Plain = str | float | int | bool
Wanted = Plain | Sequence[Plain]
"""The value of a cell, or several of which it may have any."""
_BRACES: Final = re.compile(r"\{([^{}]*)\}")
ROW: Final = "row"
"""In braces: the row of the file."""
_FILLED: Final = re.compile(r"(.+):0([1-9]\d?)")
"""A column whose whole numbers stand with at least so many digits: ``Run:04`` is 0101."""


def column_named(cells: Cells, name: str) -> int | None:
    """Position of a column by its header, with or without its unit; None if not exactly one."""
    for titles in (cells.headers, [split_unit(header)[0] for header in cells.headers]):
        places = [place for place, title in enumerate(titles) if title == name.strip()]
        if len(places) == 1:
            return places[0]
    return None


def matching_rows(
    cells: Cells, where: Mapping[str, Wanted], request: Request
) -> tuple[list[int], list[Problem]]:
    """Indices of the rows whose cells are as stated, and what is wrong with the statement.

    Cells are compared as numbers where both are numbers, else as text.
    """
    problems: list[Problem] = []
    chosen = list(range(len(cells.rows)))
    for name, wanted in where.items():
        place = column_named(cells, name)
        if place is None:
            problems.append(no_column(cells, name, request))
            continue
        either = [wanted] if isinstance(wanted, (str, float, int)) else list(wanted)
        chosen = [
            index
            for index in chosen
            if any(_same(cells.rows[index][place], value, cells.decimal) for value in either)
        ]
    return chosen, problems


def no_column(cells: Cells, name: str, request: Request) -> Problem:
    """The problem of a column that is not there, or there twice."""
    return request.problem(
        f"there is not exactly one column {name!r}{did_you_mean(name, cells.headers) or '.'} "
        f"The file has {', '.join(repr(header) for header in cells.headers)}."
    )


def filled_in(template: str, cells: Cells, index: int) -> tuple[str, list[str]]:
    """An id with the cells of a row in place of ``{their column}``, and columns not found.

    ``{their column:04}`` writes a whole number with four digits, ``{their column:01}`` without
    the zeros before it. ``{row}`` is the row of the file where no column is named so.

    Examples
    --------
    >>> table = Cells(headers=("Run No.", "beta"), rows=((376.0, "4"),), lines=(2,))
    >>> filled_in("SD_{Run No.}_b{beta}", table, 0)
    ('SD_376_b4', [])
    >>> filled_in("Run{Run No.:04}", table, 0)
    ('Run0376', [])
    """
    missing = [
        name
        for name in _BRACES.findall(template)
        if name != ROW and _column_of(cells, name) is None
    ]

    def cell(found: re.Match[str]) -> str:
        place = _column_of(cells, found[1])
        if place is None:
            return str(cells.lines[index]) if found[1] == ROW else found[0]
        text, digits = as_text(cells.rows[index][place[0]]), place[1]
        return f"{int(text):0{digits}d}" if digits and text.isdecimal() else text

    return _BRACES.sub(cell, template), missing


def _column_of(cells: Cells, name: str) -> tuple[int, int] | None:
    """Position of the column of braces, and to how many digits its whole numbers are filled."""
    place = column_named(cells, name)
    if place is not None:
        return place, 0
    found = _FILLED.fullmatch(name)
    place = None if found is None else column_named(cells, found[1])
    return None if found is None or place is None else (place, int(found[2]))


def as_text(cell: Cell) -> str:
    """A cell as text; whole numbers without decimals."""
    if isinstance(cell, float):
        return f"{cell:.15g}"
    return (cell or "").strip()


def _same(cell: Cell, wanted: Plain, decimal: str) -> bool:
    number = to_number(cell, decimal)
    if isinstance(wanted, bool):
        return as_text(cell).lower() == str(wanted).lower()
    target = to_number(wanted if isinstance(wanted, str) else float(wanted))
    if number is not None and target is not None:
        return number == target
    return as_text(cell) == str(wanted).strip()
