"""Workbooks: .xls, .xlsx, .xlsm, .xlsb, .ods.

The values are those that were last computed; formulas are not.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from pmmkit.base import did_you_mean
from pmmkit.conventions import is_unit, split_unit
from pmmkit.readers.base import (
    Cell,
    Cells,
    Choose,
    Columns,
    Request,
    columns_of,
    first_line,
    to_number,
)
from pmmkit.readers.excel.guard import check_workbook
from pmmkit.readers.vectors import with_unit

# Where the table stands in a sheet: title block, header, units, then rows of values.


Row = Sequence[Cell]

_NO_UNIT: Final = frozenset({"", "-", "–", "1", "%"})


def layout_of(grid: Sequence[Row], request: Request) -> tuple[tuple[str, ...] | None, int]:
    """Find the header of a sheet.

    It is the row after ``skip_rows``, where that or ``header = true`` is stated. Else it stands
    above the first row with half as many numbers as any row has, and is the last row of nothing but
    texts that names every column below it; or the first row of the sheet, if only that one names
    them; or just the last row of texts. A row of units may follow.
    """
    start = request.options.skip_rows
    if request.options.header is False:
        return None, start
    filled = [row for row in range(start, len(grid)) if any(cell is not None for cell in grid[row])]
    if not filled:
        raise request.error("the sheet is empty.")
    counts = {row: _numbers(grid[row]) for row in filled}
    most = max(counts.values())
    if request.options.header or start or not most:
        return _named(grid, filled, filled[0])
    body = next(row for row in filled if counts[row] >= most / 2)
    above = [row for row in filled if row < body and not counts[row]]
    while above and _units(grid[above[-1]]) is not None:
        above.pop()
    if body == filled[0]:
        return None, body
    good = [row for row in above if _names_all(grid, filled, row)]
    if good or above:
        headers, first = _named(grid, filled, (good or above)[-1])
        used = {place for row in filled if row >= body for place in _places(grid[row])}
        named = {place for place, title in enumerate(headers) if title}
        if 2 * len(used & named) >= len(used):
            return headers, first
    raise request.error(
        f"numbers begin in row {body + 1}; which row above names them cannot be told.",
        remedy="State in [source] how many rows stand above the header, e.g. skip_rows = 4, "
        "or header = true if there are none.",
    )


def _named(grid: Sequence[Row], filled: Sequence[int], row: int) -> tuple[tuple[str, ...], int]:
    """The layout with the header in a row."""
    below = next((other for other in filled if other > row), row)
    units = _units(grid[below]) if below > row else None
    titles = _titles(grid, filled, row)
    if units is not None:
        titles = tuple(map(with_unit, titles, units))
    return titles, row + 1 if units is None else below + 1


def _titles(grid: Sequence[Row], filled: Sequence[int], row: int) -> tuple[str, ...]:
    """Names of the columns; the row above helps where cells are merged over both."""
    own = [text(cell) for cell in grid[row]]
    place = filled.index(row)
    over = grid[filled[place - 1]] if place and filled[place - 1] == row - 1 else ()
    upper = [text(cell) for cell in over] if not _numbers(over) else []
    upper += [""] * (len(own) - len(upper))
    grouped = len({title for title in upper if title}) > 1
    if not grouped:
        return tuple(own)
    bare = [split_unit(title)[0] for title in own]
    plain = _plain(own, bare, upper)
    return tuple(
        group
        if not title
        else f"{group} {title}"
        if bare.count(name) > 1 and group and place not in plain
        else title
        for place, (title, name, group) in enumerate(zip(own, bare, upper, strict=True))
    )


def _plain(own: Sequence[str], bare: Sequence[str], upper: Sequence[str]) -> set[int]:
    """Columns that keep a name which others have: the only one of it that is alone in its group.

    ``X`` of a hull stands below a word of its own, ``X`` of a rudder beside other columns of it.
    """
    alone = [place for place, group in enumerate(upper) if group and upper.count(group) == 1]
    found: set[int] = set()
    for name in {bare[place] for place in alone if own[place]}:
        places = [place for place, other in enumerate(bare) if other == name]
        single = [place for place in places if place in alone]
        rest = [place for place in places if place not in alone]
        if len(single) == 1 and rest and all(upper[place] for place in rest):
            found.add(single[0])
    return found


def _names_all(grid: Sequence[Row], filled: Sequence[int], row: int) -> bool:
    """Whether a row has a text of its own for every column that is used below it."""
    titles = [text(cell) for cell in grid[row] if cell is not None]
    used = {place for other in filled if other > row for place in _places(grid[other])}
    return len(set(titles)) == len(titles) > 1 and used <= _places(grid[row])


def _places(row: Row) -> set[int]:
    return {place for place, cell in enumerate(row) if cell is not None}


def _numbers(row: Row) -> int:
    """How many cells of a row are numbers."""
    found = (to_number(cell) for cell in row if cell is not None)
    return sum(number is not None and number == number for number in found)


def _units(row: Row) -> list[str] | None:
    """The units in a row, None if it is not one of units."""
    found = [text(cell).strip("[]() ") for cell in row]
    known = [unit in _NO_UNIT or is_unit(unit) for unit in found]
    if not all(len(unit) <= 12 for unit in found) or _numbers(row):
        return None
    stated = sum(unit != "" for unit in found)
    good = sum(fits for fits, unit in zip(known, found, strict=True) if unit)
    real = sum(unit not in _NO_UNIT for unit in found)
    return found if real and 2 * good > stated else None


def text(cell: Cell) -> str:
    """A cell as text, whole numbers without their decimals."""
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    return "" if cell is None else str(cell).strip()


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
    headers, first = layout_of(plain, request)
    body = [
        (line, row)
        for line, row in enumerate(plain[first:], start=first + 1)
        if any(cell is not None for cell in row)
    ]
    if not body:
        raise request.error("the sheet has no rows below its header.")
    above = [[text(cell) for cell in row if cell is not None] for row in plain[:first]]
    return Cells(
        headers=headers if headers is not None else ("",) * len(body[0][1]),
        rows=tuple(row for _, row in body),
        lines=tuple(line for line, _ in body),
        above=tuple("; ".join(row) for row in above if 2 <= len(row) <= 3),
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
