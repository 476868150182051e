"""How wide the columns of a printed table are, and how small its letters."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from pmmkit.presentation import Grid

SIZES: Final = (8.5, 7.5, 7.0)
"""Letters that a table may have [pt], the usual first."""
NO_LINE_ENDS: Final = 7.5
"""Letters down to which a table is made smaller so that no cell takes two lines [pt]."""
EM: Final = 2.54 / 72
"""Letters of one point [cm]."""
USUAL: Final = 0.56
"""Width of a letter over its size: a digit of Arial; those of Calibri are narrower."""
OTHERS: Final = {**dict.fromkeys(" .,:;-'|()[]/il′″", 0.33), **dict.fromkeys("…%mwMW", 0.95)}
"""That of letters which are much narrower or wider."""
PADDING: Final = 0.3
"""Room beside the text of a cell [cm]."""
LARGEST: Final = 0.45
"""Part of the width that one word may claim; longer ones are broken."""
LOOSE: Final = 1.3
"""How far beyond its text a table spreads, up to the whole width."""


@dataclass(frozen=True, kw_only=True)
class TableColumns:
    """Columns of a table.

    `size`: size of the letters [pt]. `widths`: of the columns [cm]. `fits`: whether no number
    is broken.
    """

    size: float
    widths: tuple[float, ...]
    fits: bool = True


def columns_of(
    head: Sequence[str | None],
    rows: Sequence[Sequence[str | None]],
    *,
    texts: Collection[int],
    width: float,
) -> TableColumns:
    """Columns in which numbers stay whole and texts take as few lines as they can.

    width [cm].

    Examples
    --------
    >>> rows = [["SD_1", "0.142", "a mean from the table"]]
    >>> columns_of(["Run", "Fn", "What counts"], rows, texts={0, 2}, width=16.5).size
    8.5
    >>> columns_of([], [["-21.87 ± 0.71"] * 16], texts=(), width=16.5).fits
    False
    """
    longest = list(_longest(head, rows, texts))
    found = TableColumns(size=SIZES[-1], widths=(), fits=False)
    for size in SIZES:
        wanted = [PADDING + size * EM * most for _, most in longest]
        needed = [
            min(PADDING + size * EM * least, LARGEST * width if place in texts else width)
            for place, (least, _) in enumerate(longest)
        ]
        if sum(wanted) <= width and size >= NO_LINE_ENDS:
            loose = min(LOOSE, width / sum(wanted))
            return TableColumns(size=size, widths=tuple(loose * x for x in wanted))
        if sum(needed) <= width and not found.fits:
            found = TableColumns(size=size, widths=_shared(needed, wanted, width))
    if found.fits:
        return found
    return TableColumns(
        size=size, widths=tuple(width / sum(needed) * x for x in needed), fits=False
    )


def columns_for(table: Grid, width: float) -> TableColumns:
    """Columns of a table on a page of some width.

    width [cm].
    """
    rows = [row for group in table.groups for row in group.rows]
    return columns_of(table.head, rows or [table.head], texts={0, *table.texts}, width=width)


def _longest(
    head: Sequence[str | None], rows: Sequence[Sequence[str | None]], texts: Collection[int]
) -> Iterator[tuple[float, float]]:
    """Of each column the longest piece that is not broken and the longest cell, in letters."""
    for place in range(len(rows[0])):
        cells = [row[place] or "" for row in rows]
        words = [word for cell in (cells if place in texts else []) for word in cell.split()]
        named = [head[place] or ""] if any(head) else []
        broken = [*(words if place in texts else cells), *(x for own in named for x in own.split())]
        yield (
            max(map(_letters, broken), default=0.0),
            max(map(_letters, [*cells, *named]), default=0.0),
        )


def _letters(text: str) -> float:
    """Width of a text over the size of its letters."""
    return sum(OTHERS.get(letter, USUAL) for letter in text)


def _shared(needed: Sequence[float], wanted: Sequence[float], width: float) -> tuple[float, ...]:
    """What is left of the width goes to all columns alike, to none more than it wants."""
    widths, left = list(needed), width - sum(needed)
    order = sorted(range(len(needed)), key=lambda place: wanted[place] - needed[place])
    for done, place in enumerate(order):
        more = min(max(wanted[place] - needed[place], 0.0), left / (len(order) - done))
        widths[place] += more
        left -= more
    return tuple(widths)
