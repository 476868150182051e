"""Derivative tables as Excel workbooks."""

from __future__ import annotations

import io
import json
import math
import re
import unicodedata
import zipfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import Problem, TableError
from pmmkit.files import atomic_path
from pmmkit.models.tables.io.content import NOT_READ, assemble
from pmmkit.models.tables.io.rows import COLUMNS, TableGrid, read_rows
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.numerics import Array

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

_COLUMNS: Final = (*COLUMNS, "dof")
_SHEETS: Final = ("derivatives", "covariance", "about")
_CELL: Final = 30_000
_CELLS: Final = 5_000_000
"""Cells of a sheet, empty ones included: a covariance of more than 2000 derivatives."""
_BYTES: Final = 500_000_000
"""Bytes of a workbook when it is unpacked."""
_REMEDY: Final = "To keep an edit all the same, write null as the fingerprint in the sheet about."


def write_excel(table: DerivativeTable, path: str | Path) -> None:
    """Write a table as a workbook with the sheets derivatives, covariance and about.

    The same table gives the same bytes.
    """
    import openpyxl

    _check_texts(table, str(path))
    k, n = table.value.shape
    low, high = table.interval()
    numbers = np.stack([table.value, table.std, low, high], axis=-1)
    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("derivatives")
    _append(sheet, _COLUMNS)
    for row in range(k):
        for column, name in enumerate(table.names):
            place = row, column
            _append(
                sheet,
                [
                    table.Fn[row],
                    name,
                    *numbers[place],
                    str(table.method[place]),
                    int(table.runs[place]),
                    table.dof[place],
                ],
            )
    sheet = book.create_sheet("covariance")
    labels = _labels(table.names, table.Fn)
    _append(sheet, ["", *labels])
    for label, line in zip(labels, table.covariance.reshape(k * n, k * n), strict=True):
        _append(sheet, [label, *line])
    sheet = book.create_sheet("about")
    for key, value in table.attributes().items():
        text = json.dumps(value)
        cuts = range(0, len(text), _CELL)
        _append(sheet, [key, *(text[start : start + _CELL] for start in cuts)])
    raw = io.BytesIO()
    book.save(raw)
    with atomic_path(path) as part:
        _repack(raw, part)


def _foreign_to_xml(letter: str) -> bool:
    """Control characters but tab and line feed, surrogates, and the two that are no characters."""
    return letter in "\ufffe\uffff" or (
        unicodedata.category(letter) in ("Cc", "Cs") and letter not in "\t\n"
    )


def _check_texts(table: DerivativeTable, file: str) -> None:
    """Refuse what no cell of a workbook holds."""
    wrong = [
        str(text)
        for text in np.unique(table.method)
        if len(text) > _CELL or any(_foreign_to_xml(x) for x in str(text))
    ]
    if wrong:
        raise TableError(
            [
                Problem(
                    message=f"the method {text!r:.60} is one that a workbook does not hold.",
                    file=file,
                    remedy="Write the table as .csv or .nc.",
                )
                for text in wrong
            ]
        )


def read_excel(path: str | Path) -> DerivativeTable:
    """Read a table from a workbook that `write_excel` wrote."""
    file = str(path)
    sheets = _sheets(path)
    missing = [name for name in _SHEETS if name not in sheets]
    if missing:
        raise TableError(
            [Problem(message=f"has no sheet {name}.", file=file) for name in missing],
            title=NOT_READ,
        )
    lines = [
        (number, cells)
        for number, cells in enumerate(sheets["derivatives"], start=1)
        if any(cell is not None for cell in cells)
    ]
    grid = read_rows(lines, file=f"{file}, sheet derivatives", columns=_COLUMNS)
    covariance = _covariance(sheets["covariance"], grid, f"{file}, sheet covariance")
    k, n = len(grid.Fn), len(grid.names)
    table = assemble(
        names=grid.names,
        Fn=grid.Fn,
        value=grid.numbers["value"],
        covariance=covariance.reshape(k, n, k, n),
        dof=grid.numbers["dof"],
        method=grid.method,
        runs=grid.runs,
        header=_header(sheets["about"], f"{file}, sheet about"),
        file=file,
        remedy=_REMEDY,
    )
    grid.check(table, file=f"{file}, sheet derivatives", remedy="Write the workbook again.")
    return table


def _append(sheet: Worksheet, values: Iterable[Any]) -> None:
    """A row whose numbers keep all their digits and whose texts are never formulas."""
    from openpyxl.cell import WriteOnlyCell

    cells = []
    for value in values:
        if isinstance(value, str):
            cell = WriteOnlyCell(sheet, value)
            cell.data_type = "s"
        elif isinstance(value, int):
            cell = WriteOnlyCell(sheet, value)
        elif math.isnan(value):
            cell = None
        elif math.isinf(value):
            cell = WriteOnlyCell(sheet, "inf")
        else:
            cell = WriteOnlyCell(sheet, repr(float(value)))
            cell.data_type = "n"
        cells.append(cell)
    sheet.append(cells)


def _repack(raw: io.BytesIO, target: Path) -> None:
    """The workbook without the times at which it was written."""
    stamp = re.compile(rb"(<dcterms:(created|modified)[^>]*>)[^<]*")
    with (
        zipfile.ZipFile(raw) as source,
        zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as result,
    ):
        for item in source.infolist():
            content = source.read(item)
            if item.filename == "docProps/core.xml":
                content = stamp.sub(rb"\g<1>2000-01-01T00:00:00Z", content)
            result.writestr(zipfile.ZipInfo(item.filename), content, zipfile.ZIP_DEFLATED)


def _sheets(path: str | Path) -> dict[str, list[list[Any]]]:
    import openpyxl

    try:
        with zipfile.ZipFile(path) as parts:
            if sum(item.file_size for item in parts.infolist()) > _BYTES:
                raise ValueError(f"it would take more than {_BYTES:,} bytes")
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        try:
            return {sheet.title: _padded(_rows(sheet)) for sheet in book.worksheets}
        finally:
            book.close()
    except Exception as error:
        raise TableError(
            Problem(
                message=f"is not a readable workbook ({type(error).__name__}: {error}).",
                file=str(path),
                remedy="The file is damaged or of another kind. Write it again.",
            ),
            title=NOT_READ,
        ) from error


def _rows(sheet: Any) -> list[list[Any]]:
    """The rows of a sheet, as long as there are not absurdly many cells."""
    rows, cells = [], 0
    for row in sheet.iter_rows(values_only=True):
        cells += max(len(row), 1)
        if cells > _CELLS:
            raise ValueError(f"sheet {sheet.title} has more than {_CELLS:,} cells")
        rows.append(list(row))
    return rows


def _padded(rows: list[list[Any]]) -> list[list[Any]]:
    """Rows at least as long as the first: a workbook leaves out empty cells at the end."""
    width = len(rows[0]) if rows else 0
    return [row + [None] * (width - len(row)) for row in rows]


def _header(lines: Sequence[Sequence[Any]], file: str) -> dict[str, Any]:
    header: dict[str, Any] = {}
    problems = []
    for number, (key, *cells) in enumerate(lines, start=1):
        if key is None:
            continue
        try:
            header[str(key)] = json.loads("".join(str(cell) for cell in cells if cell is not None))
        except (ValueError, RecursionError) as error:
            problems.append(
                Problem(
                    message=f"is not readable ({error}).", file=file, row=number, column=str(key)
                )
            )
    if problems:
        raise TableError(problems, title=NOT_READ)
    return header


def _labels(names: Sequence[str], Fn: Array) -> list[str]:
    return [
        name if math.isnan(speed) else f"{name} @ {speed:.6g}" for speed in Fn for name in names
    ]


def _covariance(lines: Sequence[Sequence[Any]], grid: TableGrid, file: str) -> Array:
    labels = _labels(grid.names, grid.Fn)
    problems = []
    if not lines or list(lines[0][1:]) != labels:
        problems.append(Problem(message="is not that of the derivatives.", file=file, row=1))
    if [line[0] if line else None for line in lines[1:]] != labels:
        problems.append(Problem(message="is not that of the derivatives.", file=file, column="A"))
    problems += [
        Problem(message=f"{cell!r} is not a number.", file=file, row=row, column=label)
        for row, line in enumerate(lines[1:], start=2)
        for label, cell in zip(labels, line[1:], strict=False)
        if not (cell is None or (isinstance(cell, int | float) and not isinstance(cell, bool)))
    ]
    problems += [
        Problem(message=f"has {len(line)} cells.", file=file, row=row)
        for row, line in enumerate(lines[1:], start=2)
        if len(line) != len(labels) + 1
    ]
    if problems:
        raise TableError(problems, title=NOT_READ)
    square = [[math.nan if cell is None else cell for cell in line[1:]] for line in lines[1:]]
    return np.array(square, float).reshape(len(labels), len(labels))
