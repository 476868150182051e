"""Workbooks: .xls, .xlsx, .xlsm, .xlsb, .ods.

The values are those that were last computed; formulas are not.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from pmmkit.base import did_you_mean
from pmmkit.readers.base import Cell, Cells, Choose, Columns, Request, columns_of, first_line
from pmmkit.readers.excel.guard import check_workbook
from pmmkit.readers.excel.sheet import layout_of

_MOST_MERGED: Final = 1_000_000
Grid = list[list[Any]]


def sheets(request: Request) -> tuple[str, ...]:
    """Names of the sheets."""
    return tuple(_workbook(request).sheet_names)


def columns(request: Request, choose: Choose) -> Columns:
    """Some columns of the sheet as numbers; times of day and dates as seconds.

    A time or a duration gives its seconds, a date the seconds since the first one in its column.
    """
    grid = _grid(request)
    sheet = _table(grid, request)
    positions = tuple(choose(sheet.headers, len(sheet.headers)))
    timed = {
        place: seconds
        for place in positions
        if (seconds := _seconds([grid[line - 1][place] for line in sheet.lines])) is not None
    }
    rows = [
        tuple(timed[place][index] if place in timed else cell for place, cell in enumerate(row))
        for index, row in enumerate(sheet.rows)
    ]
    found = columns_of(replace(sheet, rows=tuple(rows)) if timed else sheet, positions, request)
    told = [f"column {sheet.headers[place] or place + 1!r}: times as seconds" for place in timed]
    return replace(found, notes=(*found.notes, *told))


def cells(request: Request) -> Cells:
    """All cells below the header; dates as text.

    The header is found (see `layout_of`), or stands after ``skip_rows``; a row of units below it
    goes into the names. The table ends with the sheet; rows without any cell are not counted.
    Merged cells all have the value of the first. Without ``sheet`` the workbook must have only one.
    """
    return _table(_grid(request), request)


def _table(grid: Grid, request: Request) -> Cells:
    plain = [tuple(_cell(value) for value in row) for row in grid]
    layout = layout_of(plain, request)
    body = [
        (line, row)
        for line, row in enumerate(plain[layout.first :], start=layout.first + 1)
        if any(cell is not None for cell in row)
    ]
    if not body:
        raise request.error("the sheet has no rows below its header.")
    return Cells(
        headers=layout.headers if layout.headers is not None else ("",) * len(body[0][1]),
        rows=tuple(row for _, row in body),
        lines=tuple(line for line, _ in body),
    )


def _workbook(request: Request) -> Any:
    import python_calamine as calamine

    try:
        check_workbook(request)
    except OSError as error:
        raise request.unreadable(error) from error
    try:
        return calamine.CalamineWorkbook.from_path(str(request.path))
    except BaseException as error:
        raise _unreadable(request, error) from error


def _grid(request: Request) -> Grid:
    """All values of the sheet that is asked for."""
    workbook = _workbook(request)
    wanted = _wanted(list(workbook.sheet_names), request)
    try:
        sheet = workbook.get_sheet_by_name(wanted)
        rows = sheet.to_python(skip_empty_area=False)
        merged = sheet.merged_cell_ranges or []
    except BaseException as error:
        raise _unreadable(request, error) from error
    if not any(value != "" for row in rows for value in row):
        raise request.error("the sheet is empty.")
    if len(rows) <= request.options.skip_rows:
        raise request.error(
            f"the sheet has {len(rows)} rows, skip_rows is {request.options.skip_rows}."
        )
    return _unmerged(rows[: request.options.last_row], merged, request)


def _wanted(sheets: Sequence[str], request: Request) -> str:
    """Name of the sheet that is asked for."""
    asked = request.options.sheet
    listed = ", ".join(f"{place} {sheet!r}" for place, sheet in enumerate(sheets, start=1))
    if asked is None and len(sheets) == 1:
        return sheets[0]
    if isinstance(asked, str) and asked in sheets:
        return asked
    if isinstance(asked, int) and 1 <= asked <= len(sheets):
        return sheets[asked - 1]
    if asked is None:
        raise request.error(
            f"the workbook has {len(sheets)} sheets ({listed}).",
            remedy='Name one in [source]: sheet = "...", or give its number: sheet = 2.',
        )
    hint = did_you_mean(asked, sheets) if isinstance(asked, str) else ""
    raise request.error(f"there is no sheet {asked!r}{hint or '.'} The workbook has {listed}.")


def _unmerged(rows: Grid, merged: Sequence[Any], request: Request) -> Grid:
    """The rows with the value of merged cells in each of them."""
    filled = 0
    for (top, left), (bottom, right) in merged:
        if top >= len(rows) or left >= len(rows[top]):
            continue
        last, end = min(bottom, len(rows) - 1), min(right, len(rows[top]) - 1)
        filled += (last - top + 1) * (end - left + 1)
        if filled > _MOST_MERGED:
            raise request.error(f"more than {_MOST_MERGED:,} cells of the sheet are merged.")
        for row in rows[top : last + 1]:
            row[left : end + 1] = [rows[top][left]] * (end + 1 - left)
    return rows


def _unreadable(request: Request, error: BaseException) -> BaseException:
    if isinstance(error, (KeyboardInterrupt, SystemExit, MemoryError)):
        return error
    return request.error(
        "cannot be read as a workbook: damaged, cut short or of another format "
        f"({first_line(error)}).",
        remedy='If it is plain text, write format = "csv" in [source].',
    )


def _cell(value: Any) -> Cell:
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, (int, float)):
        return float(value)
    text = str(value)
    return text if text.strip() else None


def _seconds(values: Sequence[Any]) -> list[float | None] | None:
    """A column of dates, times or durations in seconds; None if it is not one."""
    there = [value for value in values if value != ""]
    if there and all(isinstance(value, dt.date) for value in there):
        first = _moment(there[0])
        return [
            None if value == "" else (_moment(value) - first).total_seconds() for value in values
        ]
    if there and all(isinstance(value, (dt.time, dt.timedelta)) for value in there):
        return [None if value == "" else _duration(value).total_seconds() for value in values]
    return None


def _moment(value: dt.date) -> dt.datetime:
    return value if isinstance(value, dt.datetime) else dt.datetime(*value.timetuple()[:3])


def _duration(value: dt.time | dt.timedelta) -> dt.timedelta:
    if isinstance(value, dt.timedelta):
        return value
    return dt.timedelta(
        hours=value.hour, minutes=value.minute, seconds=value.second, microseconds=value.microsecond
    )
