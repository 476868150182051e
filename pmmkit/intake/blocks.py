"""What stands in the rows of a sheet: runs, cycles of dynamic tests, statistics, another table."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, TestKind
from pmmkit.conventions import CHANNEL_UNITS, factor_to
from pmmkit.intake.seen import Blocks, ColumnLook, SheetBlock, What
from pmmkit.numerics import Array
from pmmkit.presentation import meanings
from pmmkit.readers import Cell, Cells, as_text, to_number

FEWEST: Final = 8
"""Rows of one name that can be a cycle."""
_OTHER: Final = 3
"""Texts among the numbers that make a row one of other names."""
_SWINGS: Final = {"v": 0.01, "r": math.radians(0.2)}
"""Changes within a cycle that are a motion [m/s, rad/s]."""
_HELD: Final = math.radians(0.3)
"""Mean drift or rudder angle that is a setting [rad]."""
_SWEPT: Final = math.radians(2.0)
"""Change of the rudder within a cycle that is a sweep [rad]."""
_STEADY: Final[tuple[What, str | None]] = ("steady", None)
_TYPES: Final = 12
"""Different words of a column that says the kinds of test, at most."""


def blocks_of(cells: Cells, columns: Sequence[ColumnLook]) -> Blocks:
    """What the rows of a sheet are."""
    numeric = [column.position for column in columns if column.numbers]
    texts = [column.position for column in columns if not column.numbers]
    end = next(
        (index for index, row in enumerate(cells.rows) if _names_otherwise(row, numeric, cells)),
        len(cells.rows),
    )
    found: dict[tuple[What, str | None], dict[int, list[str]]] = {}
    whole: list[int] = []
    for index, row in enumerate(cells.rows[:end]):
        said = next((kind for at in texts if (kind := statistic_in(row[at]))), "")
        if said:
            found.setdefault(("statistics", None), {})[index] = [said]
        elif sum(_is_number(row[at], cells) for at in numeric) < len(numeric) / 2:
            found.setdefault(("incomplete", None), {})[index] = []
        else:
            whole.append(index)
    name, word = _telling(cells, texts, whole)
    groups: dict[str, list[int]] = {}
    for index in whole:
        key = f"row {cells.lines[index]}" if name is None else as_text(cells.rows[index][name])
        groups.setdefault(key, []).append(index)
    known = {column.suggestion.name: column for column in columns if column.suggestion}
    for key, members in groups.items():
        told = _kind(cells, members, known) if len(members) >= FEWEST else _STEADY
        found.setdefault(told, {}).update({index: [key] for index in members})
    if end < len(cells.rows):
        row = cells.rows[end]
        other = [as_text(cell) for cell in row if isinstance(cell, str) and cell.strip()]
        left = dict.fromkeys(range(end, len(cells.rows)), other)
        found["other names", None] = left
    blocks = [
        replace(
            _block(cells, kind, rows, word),
            headed=kind[0] in ("steady", "sweep") and _headed(cells, sorted(rows), known),
        )
        for kind, rows in found.items()
    ]
    return Blocks(
        blocks=tuple(sorted(blocks, key=lambda block: block.lines)),
        name="" if name is None else cells.headers[name],
        word="" if word is None else cells.headers[word],
    )


def _block(
    cells: Cells, kind: tuple[What, str | None], rows: Mapping[int, Sequence[str]], word: int | None
) -> SheetBlock:
    indices = sorted(rows)
    words = [as_text(cells.rows[index][word]) for index in indices] if word is not None else []
    return SheetBlock(
        what=kind[0],
        test=kind[1],
        lines=tuple(cells.lines[index] for index in indices),
        names=tuple(dict.fromkeys(name for index in indices for name in rows[index])),
        words=tuple(dict.fromkeys(text for text in words if text)),
    )


def statistic_in(cell: Cell) -> str:
    """Which statistic a cell names and nothing else: mean, std, relative, range, sum; or empty.

    Examples
    --------
    >>> statistic_in("STAND. DEV."), statistic_in("Average SD"), statistic_in("Mean drift 4°")
    ('std', 'std', '')
    """
    if not isinstance(cell, str) or not cell.strip():
        return ""
    told = meanings("statistic", cell)
    left = cell.casefold()
    for _, word, _ in told:
        left = left.replace(word.casefold(), " ")
    kinds = {kind for kind, *_ in told}
    if not kinds or any(letter.isalnum() for letter in left):
        return ""
    return next(kind for kind in ("std", "range", "relative", "sum", "mean") if kind in kinds)


def _names_otherwise(row: Sequence[Cell], numeric: Sequence[int], cells: Cells) -> bool:
    """Whether a row has texts where numbers stand above."""
    filled = [row[place] for place in numeric if row[place] is not None]
    texts = [cell for cell in filled if to_number(cell, cells.decimal) is None]
    worded = [cell for cell in texts if any(letter.isalpha() for letter in str(cell))]
    return len(worded) >= min(_OTHER, len(numeric)) and 2 * len(worded) > len(filled)


def _is_number(cell: Cell, cells: Cells) -> bool:
    number = to_number(cell, cells.decimal)
    return number is not None and math.isfinite(number)


def _telling(
    cells: Cells, texts: Sequence[int], rows: Sequence[int]
) -> tuple[int | None, int | None]:
    """The columns that name the tests and say their kinds."""
    distinct = {
        place: len({as_text(cells.rows[index][place]) for index in rows} - {""}) for place in texts
    }
    filled = {
        place: sum(bool(as_text(cells.rows[index][place])) for index in rows) for place in texts
    }
    full = [place for place in texts if filled[place] >= 0.9 * len(rows) and distinct[place] > 1]
    name = max(full, key=lambda place: distinct[place], default=None)
    if name is not None and distinct[name] < 2:
        name = None
    words = [place for place in full if place != name and distinct[place] <= _TYPES]
    return name, (words[0] if words else None)


def _kind(
    cells: Cells, rows: Sequence[int], known: Mapping[str, ColumnLook]
) -> tuple[What, str | None]:
    """What the rows of one name are."""

    def change(name: str) -> float:
        values = _values(cells, rows, known.get(name))
        return float(np.ptp(values)) if len(values) else 0.0

    def mean(name: str) -> float:
        values = _values(cells, rows, known.get(name))
        return float(np.mean(values)) if len(values) else 0.0

    swings = [name for name in ("v", "r") if change(name) > 2 * _SWINGS[name]]
    rudder = "rudder_deg" if "rudder_deg" in known else "delta"
    if not swings:
        swept = change(rudder) > _SWEPT
        each = kind_with(held=("drift", "rudder"))
        return ("sweep", each.name) if swept and each is not None else _STEADY
    held = (
        []
        if "v" in swings
        else [
            name
            for name, column in (("drift", "drift_deg"), ("rudder", rudder))
            if abs(mean(column)) > _HELD
        ]
    )
    kind = kind_with(swings=swings, held=held) or kind_with(swings=swings, held=held[:1])
    return "cycle", None if kind is None else kind.name


def _headed(cells: Cells, rows: Sequence[int], known: Mapping[str, ColumnLook]) -> bool:
    """Whether rows have a heading while their columns of drift and sway hold nothing but zero."""
    heading = _values(cells, rows, known.get("psi"))
    still = [_values(cells, rows, known[name]) for name in ("drift_deg", "v") if name in known]
    return (
        bool(still)
        and not any(np.any(values) for values in still)
        and bool(np.any(np.abs(heading) > _HELD))
    )


def _values(cells: Cells, rows: Sequence[int], column: ColumnLook | None) -> Array:
    """The numbers of a column in SI."""
    if column is None or column.suggestion is None:
        return np.zeros(0)
    name = column.suggestion.name
    unit = column.suggestion.unit or column.unit or RUN_SETTINGS.units.get(name)
    target = "rad" if name in RUN_SETTINGS.units else CHANNEL_UNITS.get(name, "")
    try:
        factor = (factor_to(unit, target) if unit else 1.0) or 1.0
    except DataError:
        factor = 1.0
    numbers = [to_number(cells.rows[index][column.position], cells.decimal) for index in rows]
    values: Array = np.array(numbers, dtype=float) * factor * column.suggestion.scale
    return values[np.isfinite(values)]


def kind_with(
    *, swings: Collection[str] = (), held: Collection[str] = (), turning: bool = False
) -> TestKind | None:
    """The captive kind that oscillates so and holds these settings; the simplest of several.

    Examples
    --------
    >>> kind_with(swings={"r"}, held={"drift"}).name, kind_with(held={"drift", "rudder"}).name
    ('yaw_drift', 'drift_rudder')
    """
    wanted = {*held, *(("yaw_rate",) if turning else ())}
    for kind in TEST_KINDS.values():
        if (
            kind.captive
            and set(kind.held) == wanted
            and {swing.velocity for swing in kind.swings} == set(swings)
        ):
            return kind
    return None


def held_too(kind: TestKind, name: str) -> TestKind:
    """The kind of test with one more angle held; the same where there is none.

    Examples
    --------
    >>> from pmmkit.campaigns import TEST_KINDS
    >>> [held_too(TEST_KINDS[name], "rudder").name for name in ("pure_yaw", "pure_sway")]
    ['yaw_rudder', 'pure_sway']
    """
    swings = {swing.velocity for swing in kind.swings}
    return kind_with(swings=swings, held={*kind.held, name}) or kind
