"""Measurements that lie in a folder twice: a sheet saved as text, another issue of a programme."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.conventions import channel_of, harmonic_part
from pmmkit.intake.drafts.columns import factor_of
from pmmkit.intake.seen import FileLook
from pmmkit.numerics import Array
from pmmkit.readers import READERS, to_number


@dataclass(frozen=True, kw_only=True)
class RowsBefore:
    """Rows of a table that stand in tables before it, and in which."""

    lines: tuple[int, ...]
    where: str

    @property
    def notes(self) -> tuple[str, ...]:
        """The same in words."""
        return (f"skipped rows stand in {self.where} as well",)


@dataclass(frozen=True, kw_only=True)
class Repeats:
    """What of the tables is listed twice.

    `looks`: the tables that are kept. `skip`: rows of them that stand in a table before, by
    `FileLook.shown`. `told`: tables that are left out by `FileLook.shown`, and why.
    """

    looks: tuple[FileLook, ...]
    skip: Mapping[str, RowsBefore]
    told: Mapping[str, str]


def without_repeats(looks: Sequence[FileLook]) -> Repeats:
    """The tables without those, and without the rows, that tell what another table tells.

    Rows are the same where forces and settings are, digit for digit. Two issues of a programme
    differ by rounding and in some columns: Y and N are asked, and the finer one is kept.
    """
    seen = [(look, found) for look in looks if (found := _rows(look)) is not None]
    told: dict[str, str] = {}
    keys = cache(_keys)
    skip: dict[str, RowsBefore] = {}
    for place, (look, rows) in enumerate(seen):
        before = [item for item in seen[:place] if item[0].shown not in told]
        first = _again(look, rows, keys) | _first_places(rows, before, keys)
        if first and len(first) == len(rows.lines):
            told[look.shown] = f"{look.shown}: its rows are those of {_listed(first.values())}"
        elif len(first) >= _FEWEST and not look.blocks.mixed:
            lines = tuple(sorted(first))
            skip[look.shown] = RowsBefore(lines=lines, where=_listed(first.values()))
    left = [item for item in seen if item[0].shown not in told]
    for place, one in enumerate(left):
        for other in left[:place]:
            if {one[0].shown, other[0].shown} & {*told} or one[0].file == other[0].file:
                continue
            if (share := _share_near(one[1], other[1])) >= _MOST:
                # of equal digits the later: its name is more often that of the revision
                (coarse, few), (fine, many) = sorted((other, one), key=lambda item: item[1].digits)
                more = ", which has more digits" if few.digits < many.digits else ""
                told[coarse.shown] = (
                    f"{coarse.shown}: another issue of {fine.shown}{more}: {share:.0%} of its "
                    "rows have that Y and N"
                )
    kept = [look for look in looks if look.shown not in told]
    return Repeats(looks=tuple(kept), skip=skip, told=told)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Rows:
    """Forces and settings of the runs of a table: line of each, numbers by name, how many digits
    of the forces follow the point in the file, and what the last of them is worth."""

    lines: tuple[int, ...]
    numbers: Mapping[str, Array]
    digits: int
    steps: Mapping[str, float]


_Keys = tuple[tuple[float, ...] | None, ...]


def _keys(rows: _Rows, names: tuple[str, ...]) -> _Keys:
    """The numbers of each row; None where so few digits may be the same by chance."""
    found: list[tuple[float, ...] | None] = []
    for row in np.column_stack([rows.numbers[name] for name in names]).tolist():
        texts = [f"{number:.{_DIGITS}g}" for number in row]
        told = sum(
            len(text.partition("e")[0].strip("-0.").replace(".", ""))
            for name, text in zip(names, texts, strict=True)
            if _is_force(name)
        )
        found.append(tuple(map(float, texts)) if told >= _CERTAIN else None)
    return tuple(found)


_DIGITS: Final = 5
"""Significant digits that a saved copy keeps."""
_CERTAIN: Final = 6
"""Digits of all forces of a row together: a tank does not meet them twice."""
_FEWEST: Final = 3
"""Rows that are told to be skipped; fewer are left to the check of copies."""
_NEAR: Final = 2e-3
"""Difference over the rms of a channel: 1e-4 by the rounding of the first issue of the KCS in
shallow water (report WL2012R00_066), .01 and more between its repeats of a test."""
_MOST: Final = 0.5
"""Share of rows that make a table another issue: .77 to .81 of the KCS's two issues, .01 between
her depths; of tests repeated with an error of .01 it is about .01 too."""
_ASKED: Final = 400
"""Rows that are looked for, evenly among them: their share is then known to 2 %."""
_SMALL: Final = 0.05
"""Rows of so little force over the rms are alike in all programmes."""


def _rows(look: FileLook) -> _Rows | None:
    """What a table says of forces and settings; None where it cannot be read."""
    known = {
        name: column
        for name, column in look.known.items()
        if column.suggestion and column.suggestion.certainty != "perhaps" and column.numbers
    }
    if sum(map(_is_force, known)) < 2:
        return None
    try:
        cells = READERS[look.format].cells(look.request)
    except DataError:
        return None
    runs = {line for block in look.blocks.runs for line in block.lines}
    rows = [
        (line, row)
        for line, row in zip(cells.lines, cells.rows, strict=True)
        if line in runs or not look.blocks.mixed
    ]
    given = {
        name: np.array([to_number(row[column.position], cells.decimal) for _, row in rows], float)
        for name, column in known.items()
    }
    whole = np.all([np.isfinite(x) for name, x in given.items() if _is_force(name)], axis=0)
    forces = np.concatenate([x[whole] for name, x in given.items() if _is_force(name)])
    factors = {name: factor_of(column) for name, column in known.items()}
    fine = next((k for k in range(8) if np.allclose(forces, np.round(forces, k), 0, 1e-9)), 8)
    return _Rows(
        lines=tuple(line for (line, _), use in zip(rows, whole, strict=True) if use),
        numbers={name: x[whole] * factors[name] for name, x in given.items()},
        digits=fine,
        steps={name: 10.0**-fine * abs(factor) for name, factor in factors.items()},
    )


def _is_force(name: str) -> bool:
    part = harmonic_part(name)
    return channel_of(name if part is None else part[0]) in ("X", "Y", "N")


def _again(look: FileLook, rows: _Rows, keys: Callable[..., _Keys]) -> dict[int, FileLook]:
    """Lines of rows that repeat a row above them: a list has a run in two of its series."""
    found: dict[int, FileLook] = {}
    above: set[tuple[float, ...]] = set()
    for line, key in zip(rows.lines, keys(rows, tuple(sorted(rows.numbers))), strict=True):
        if key is not None:
            found |= {line: look} if key in above else {}
            above.add(key)
    return found


def _first_places(
    rows: _Rows, before: Sequence[tuple[FileLook, _Rows]], keys: Callable[..., _Keys]
) -> dict[int, FileLook]:
    """Lines of rows that stand in a table before, and in which."""
    found: dict[int, FileLook] = {}
    for look, other in before:
        names = tuple(name for name in sorted(rows.numbers) if name in other.numbers)
        if sum(map(_is_force, names)) < 2:
            continue
        there = {*keys(other, names)} - {None}
        own = zip(rows.lines, keys(rows, names), strict=True)
        found = {line: look for line, key in own if key in there} | found
    return found


def _share_near(one: _Rows, other: _Rows) -> float:
    """Share of the rows of the smaller table that have a row with their Y and N in the other."""
    from scipy.spatial import KDTree

    names = [
        name
        for name in one.numbers
        if name in other.numbers and _is_force(name) and not name.startswith("X")
    ]
    if len(names) < 2:
        return 0.0
    few, many = sorted(
        (np.column_stack([rows.numbers[name] for name in names]) for rows in (one, other)), key=len
    )
    scale = np.sqrt(np.mean(many**2, axis=0))
    few, many = (x / np.where(scale > 0, scale, 1.0) for x in (few, many))
    asked = few[np.linalg.norm(few, axis=1) > _SMALL]
    steps = np.array([max(rows.steps[name] for rows in (one, other)) for name in names])
    # whole newtons of a small model meet by chance
    coarse = bool(np.any(steps > _NEAR * scale))
    if coarse or len(asked) < _FEWEST or len(asked) < 0.5 * len(many):
        return 0.0
    distance, _ = KDTree(many).query(asked[:: -(-len(asked) // _ASKED)])
    return float(np.mean(distance < _NEAR))


def _listed(looks: Iterable[FileLook]) -> str:
    return ", ".join(dict.fromkeys(look.shown for look in looks))
