"""Workbooks: .xls, .xlsx, .xlsm, .xlsb, .ods."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path
from typing import Any, Final

from pmmkit.runs.channels import did_you_mean
from pmmkit.runs.readers.base import Cell, Cells, Choose, Columns, Request, columns_of

_OLE: Final = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
"""First bytes of an OLE2 compound file: .xls, but .doc too."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether the file is a workbook, by its list of parts."""
    if head.startswith(_OLE):
        return _has_workbook_stream(path, head)
    if not head.startswith(b"PK"):
        return False
    try:
        with zipfile.ZipFile(path) as parts:
            listed = set(parts.namelist())
            if "mimetype" in listed and parts.getinfo("mimetype").file_size < 200:
                return b"opendocument.spreadsheet" in parts.read("mimetype")
    except Exception:
        return False
    return bool({"xl/workbook.xml", "xl/workbook.bin"} & listed)


def sheets(request: Request) -> tuple[str, ...]:
    """Names of the sheets."""
    return tuple(_workbook(request).sheet_names)


def names(request: Request) -> tuple[str, ...]:
    """Headers of the sheet."""
    return cells(request).headers


def columns(request: Request, choose: Choose) -> Columns:
    """Some columns of the sheet as numbers."""
    sheet = cells(request)
    return columns_of(sheet, choose(sheet.headers, len(sheet.headers)), request)


def cells(request: Request) -> Cells:
    """All cells below the header.

    The header is the row after ``skip_rows``. The table ends with the sheet; rows without any
    cell are not counted. Without ``sheet`` the workbook must have only one.

    Raises
    ------
    CampaignError
        If the workbook or the sheet cannot be read.
    """
    grid = _grid(request)
    first = request.options.skip_rows
    header = request.options.header is not False
    names = tuple("" if cell is None else _text(cell) for cell in grid[first]) if header else None
    body = [
        (line, row)
        for line, row in enumerate(grid[first + header :], start=first + header + 1)
        if any(cell is not None for cell in row)
    ]
    if not body:
        raise request.error(request.problem("the sheet has no rows below its header."))
    return Cells(
        headers=names if names is not None else ("",) * len(body[0][1]),
        rows=tuple(row for _, row in body),
        lines=tuple(line for line, _ in body),
    )


def _has_workbook_stream(path: Path, head: bytes) -> bool:
    """Whether the first sector of the directory of an OLE2 file lists a workbook ([MS-CFB] 2.2)."""
    try:
        (shift,), (sector,) = struct.unpack_from("<H", head, 30), struct.unpack_from("<i", head, 48)
        with path.open("rb") as stream:
            stream.seek((sector + 1) << shift)
            listed = stream.read(8192)
    except (OSError, ValueError, OverflowError, struct.error):
        return False
    return any(name.encode("utf-16-le") in listed for name in ("Workbook", "Book"))


def _workbook(request: Request) -> Any:
    import python_calamine as calamine

    try:
        return calamine.CalamineWorkbook.from_path(str(request.path))
    except BaseException as error:
        raise _unreadable(request, error) from error


def _grid(request: Request) -> list[tuple[Cell, ...]]:
    workbook = _workbook(request)
    sheets = list(workbook.sheet_names)
    wanted = request.options.sheet
    if wanted is None and len(sheets) != 1:
        listed = ", ".join(repr(sheet) for sheet in sheets)
        raise request.error(
            request.problem(
                f"the workbook has {len(sheets)} sheets ({listed}).",
                remedy='Name one in [source]: sheet = "...".',
            )
        )
    if wanted is not None and wanted not in sheets:
        raise request.error(
            request.problem(
                f"there is no sheet {wanted!r}{did_you_mean(wanted, sheets)} "
                f"It has {', '.join(repr(sheet) for sheet in sheets)}."
            )
        )
    try:
        rows = workbook.get_sheet_by_name(wanted or sheets[0]).to_python(skip_empty_area=False)
    except BaseException as error:
        raise _unreadable(request, error) from error
    if len(rows) <= request.options.skip_rows:
        raise request.error(
            request.problem(
                f"the sheet has {len(rows)} rows, skip_rows is {request.options.skip_rows}."
            )
        )
    return [tuple(_cell(value) for value in row) for row in rows]


def _unreadable(request: Request, error: BaseException) -> BaseException:
    if isinstance(error, (KeyboardInterrupt, SystemExit, MemoryError)):
        return error
    detail = (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
    return request.error(
        request.problem(
            f"cannot be read as a workbook: damaged, cut short or of another format ({detail}).",
            remedy='If it is plain text, write format = "csv" in [source].',
        )
    )


def _cell(value: Any) -> Cell:
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, (int, float)):
        return float(value)
    text = str(value)
    return text if text.strip() else None


def _text(cell: Cell) -> str:
    """A cell as text, whole numbers without their decimals."""
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    return str(cell).strip()
