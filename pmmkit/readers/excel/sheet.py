"""Where the table stands in a sheet: title block, header, units, then rows of values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from pmmkit.conventions import is_unit, split_unit
from pmmkit.readers.base import Cell, Request, to_number
from pmmkit.readers.vectors import with_unit

Row = Sequence[Cell]

_NO_UNIT: Final = frozenset({"", "-", "–", "1", "%"})


@dataclass(frozen=True, kw_only=True)
class SheetLayout:
    """Where the table of a sheet stands.

    `headers`: names of the columns with their units; None where there are none. `first`: row in
    which the values begin, counted from 0.
    """

    headers: tuple[str, ...] | None
    first: int


def layout_of(grid: Sequence[Row], request: Request) -> SheetLayout:
    """Find the header of a sheet.

    It is the row after ``skip_rows``, where that or ``header = true`` is stated. Else it stands
    above the first row with half as many numbers as any row has, and is the last row of nothing but
    texts that names every column below it; or the first row of the sheet, if only that one names
    them; or just the last row of texts. A row of units may follow.
    """
    start = request.options.skip_rows
    if request.options.header is False:
        return SheetLayout(headers=None, first=start)
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
        return SheetLayout(headers=None, first=body)
    good = [row for row in above if _names_all(grid, filled, row)]
    if good or above:
        layout = _named(grid, filled, (good or above)[-1])
        used = {place for row in filled if row >= body for place in _places(grid[row])}
        named = {place for place, title in enumerate(layout.headers or ()) if title}
        if 2 * len(used & named) >= len(used):
            return layout
    raise request.error(
        f"numbers begin in row {body + 1}; which row above names them cannot be told.",
        remedy="State in [source] how many rows stand above the header, e.g. skip_rows = 4, "
        "or header = true if there are none.",
    )


def _named(grid: Sequence[Row], filled: Sequence[int], row: int) -> SheetLayout:
    """The layout with the header in a row."""
    below = next((other for other in filled if other > row), row)
    units = _units(grid[below]) if below > row else None
    titles = _titles(grid, filled, row)
    if units is not None:
        titles = tuple(map(with_unit, titles, units))
    return SheetLayout(headers=titles, first=row + 1 if units is None else below + 1)


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
