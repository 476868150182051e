"""Rows of a derivative table as text or cells, taken apart with every problem named."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import Problem, TableError, UnknownNameError
from pmmkit.conventions import parse_derivative
from pmmkit.models.tables.io.content import NOT_READ
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.numerics import Array

COLUMNS: Final = ("Fn", "derivative", "value", "std", "ci_low", "ci_high", "method", "runs")
_MATCH: Final = 1e-6
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True, kw_only=True)
class TableGrid:
    """The rows of a file on the grid of Froude numbers and derivatives.

    `names`: derivatives in the order of their first row. `Fn (k,)`: Froude numbers, ascending;
    one NaN for a pooled table. `numbers (k, n)`: value, std, ci_low, ci_high and, where asked
    for, dof. `row (k, n)`: row of the file that each entry comes from.
    """

    names: tuple[str, ...]
    Fn: Array
    numbers: dict[str, Array]
    method: NDArray[Any]
    runs: NDArray[np.int64]
    row: NDArray[np.int64]

    def ordered(self, names: Sequence[str]) -> TableGrid:
        """The same rows with the derivatives in another order."""
        columns = [self.names.index(name) for name in names]
        return TableGrid(
            names=tuple(names),
            Fn=self.Fn,
            numbers={key: array[:, columns] for key, array in self.numbers.items()},
            method=self.method[:, columns],
            runs=self.runs[:, columns],
            row=self.row[:, columns],
        )

    def check(self, table: DerivativeTable, *, file: str, remedy: str) -> None:
        """Refuse rows whose std or interval is not that of the table's covariance."""
        low, high = table.interval()
        problems = [
            Problem(
                message=(
                    f"{self.numbers[column][place]:g} does not follow from the covariance "
                    f"({expected[place]:g})."
                ),
                file=file,
                column=column,
                row=int(self.row[place]),
                remedy=remedy,
            )
            for column, expected in (("std", table.std), ("ci_low", low), ("ci_high", high))
            for place in zip(
                *np.nonzero(
                    ~np.isclose(self.numbers[column], expected, rtol=_MATCH, atol=0, equal_nan=True)
                ),
                strict=True,
            )
        ]
        if problems:
            raise TableError(problems, title=NOT_READ)


def read_rows(
    lines: Sequence[tuple[int, Sequence[Any]]], *, file: str, columns: Sequence[str] = COLUMNS
) -> TableGrid:
    """Take the rows of a table apart."""
    if not lines:
        raise TableError(Problem(message="holds no rows.", file=file), title=NOT_READ)
    first, header = lines[0]
    titles = ["" if cell is None else str(cell).strip() for cell in header]
    problems = [
        Problem(message="is missing.", file=file, row=first, column=name)
        for name in columns
        if name not in titles
    ]
    problems += [
        Problem(message="stands twice.", file=file, row=first, column=name)
        for name in dict.fromkeys(titles)
        if titles.count(name) > 1
    ]
    problems += [
        Problem(
            message="is not a column of a derivative table.",
            file=file,
            row=first,
            column=name or "(without a name)",
            remedy=f"Expected {', '.join(columns)}.",
        )
        for name in dict.fromkeys(titles)
        if name not in columns
    ]
    if problems:
        raise TableError(problems, title=NOT_READ)
    entries: dict[tuple[float | None, str], tuple[int, dict[str, Any]]] = {}
    for number, cells in lines[1:]:
        if len(cells) != len(titles):
            problems.append(
                Problem(
                    message=f"has {len(cells)} cells, expected {len(titles)}.",
                    file=file,
                    row=number,
                )
            )
            continue
        entry = _entry(dict(zip(titles, cells, strict=True)), file, number, problems)
        if entry is None:
            continue
        key = (entry["Fn"], entry["derivative"])
        if key in entries:
            problems.append(
                Problem(
                    message=f"{key[1]} stands already in row {entries[key][0]}.",
                    file=file,
                    row=number,
                )
            )
        else:
            entries[key] = (number, entry)
    if len(lines) == 1:
        problems.append(Problem(message="holds no rows below the header.", file=file))
    speeds = {speed for speed, _ in entries}
    names = tuple(dict.fromkeys(name for _, name in entries))
    if None in speeds and len(speeds) > 1:
        rows = [str(row) for (speed, _), (row, _) in entries.items() if speed is None]
        problems.append(
            Problem(
                message="is empty in some rows and a number in others.",
                file=file,
                column="Fn",
                row=", ".join(rows[:10]),
                remedy="A table is pooled (all empty) or per Froude number (none empty).",
            )
        )
    elif not problems:
        problems += [
            Problem(
                message=f"no row for {name}" + ("." if speed is None else f" at Fn {speed:g}."),
                file=file,
                remedy="The file is not complete; a value that is not known is an empty cell.",
            )
            for speed in speeds
            for name in names
            if (speed, name) not in entries
        ]
    if problems:
        raise TableError(problems, title=NOT_READ)
    order: list[float | None] = (
        [None] if None in speeds else [*sorted(speed for speed in speeds if speed is not None)]
    )
    grid = [[entries[speed, name] for name in names] for speed in order]
    return TableGrid(
        names=names,
        Fn=np.array([np.nan if speed is None else speed for speed in order]),
        numbers={
            key: np.array([[entry[key] for _, entry in line] for line in grid], float)
            for key in columns
            if key not in ("Fn", "derivative", "method", "runs")
        },
        method=np.array([[entry["method"] for _, entry in line] for line in grid], np.str_),
        runs=np.array([[entry["runs"] for _, entry in line] for line in grid], np.int64),
        row=np.array([[row for row, _ in line] for line in grid], np.int64),
    )


def _entry(
    cells: dict[str, Any], file: str, row: int, problems: list[Problem]
) -> dict[str, Any] | None:
    """One row as values; None (and the problems named) where something is wrong with it."""
    before = len(problems)

    def wrong(column: str, message: str, remedy: str | None = None) -> None:
        problems.append(Problem(message=message, file=file, row=row, column=column, remedy=remedy))

    entry: dict[str, Any] = {}
    for column, cell in cells.items():
        text = "" if cell is None else str(cell)
        if column == "derivative":
            try:
                entry[column] = parse_derivative(text.strip()).name
            except UnknownNameError as error:
                wrong(column, str(error))
        elif column == "method":
            entry[column] = text
        elif column == "dof" and text.strip() == "inf":
            entry[column] = math.inf
        else:
            number = _number(cell)
            if number is None:
                comma = "Write the decimal point as a point." if "," in text else None
                wrong(column, f"{text!r} is not a number.", comma)
            else:
                entry[column] = number
    for column in ("Fn", "std", "runs", "dof"):
        if entry.get(column, 0.0) < 0:
            wrong(column, f"{entry[column]:g} is negative.")
    count = entry.get("runs", 0.0)
    if not (math.isfinite(count) and float(count).is_integer() and count < 2**53):
        wrong("runs", f"{count:g} is not a number of runs.")
    value = entry.get("value", math.nan)
    for column, sign in (("ci_low", 1.0), ("ci_high", -1.0)):
        if sign * entry.get(column, math.nan) > sign * value:
            wrong(column, f"{entry[column]:g} is on the wrong side of the value {value:g}.")
    if len(problems) > before:
        return None
    entry["Fn"] = None if math.isnan(entry["Fn"]) else entry["Fn"]
    entry["runs"] = int(entry["runs"])
    return entry


def _number(cell: Any) -> float | None:
    """A finite number; NaN for an empty cell; None for anything else."""
    if cell is None or (isinstance(cell, str) and not cell.strip()):
        return math.nan
    if isinstance(cell, bool):
        return None
    if isinstance(cell, str):
        if not _NUMBER.fullmatch(cell.strip()):
            return None
        cell = float(cell)
    if isinstance(cell, int | float) and math.isfinite(cell):
        return float(cell)
    return None


def cell_text(number: float) -> str:
    """A number with all its digits; empty for NaN."""
    return "" if math.isnan(number) else repr(float(number))
