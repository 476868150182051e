"""What a text beside files without headers says of their columns: "3: Fx [N]", "columns: t, Fx"."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from pmmkit.intake.guessing import bare_header
from pmmkit.intake.seen import FileLook

_WORD: Final = r"(?:col(?:umn)?s?|ch(?:annel)?s?|spalten?|kan[aä]le?)"
_NUMBERED: Final = re.compile(
    rf"[\s#*|>-]*(?:{_WORD}\W*)?(\d{{1,2}})\s*(?:[:.)=|\t]|-(?=\s)|(?=\s))\s*([^\W\d][^|]*?)[\s|;,.]*",
    re.IGNORECASE,
)
"""A number and a name: all of a line."""
_IN_A_ROW: Final = re.compile(rf"[\s#*>-]*(?:the )?{_WORD}[^:=]{{0,40}}[:=]\s*(.+)", re.IGNORECASE)
"""Names in a line behind the word column."""
_LONGEST: Final = 60
_FEWEST: Final = 3


def listed_columns(text: str) -> list[str]:
    """Names of columns in the order of their numbers, none where a text does not list them.

    Examples
    --------
    >>> listed_columns("Columns: 1 time [s], 2 Fx [N], 3 Fy [N]")
    ['time [s]', 'Fx [N]', 'Fy [N]']
    >>> listed_columns("# 1: t (s)\\n# 2: X (N)\\n# 3: Y (N)\\nLpp 4 m")
    ['t (s)', 'X (N)', 'Y (N)']
    """
    numbered: dict[int, str] = {}
    for line in text.splitlines():
        row = _IN_A_ROW.fullmatch(line)
        if row is not None:
            names = [
                re.sub(r"^\s*\d{1,2}\W?\s+", "", part).strip() for part in re.split("[,;]", row[1])
            ]
            if len(names) >= _FEWEST and all(0 < len(name) <= _LONGEST for name in names):
                return [name.rstrip(". ") for name in names]
        found = _NUMBERED.fullmatch(line)
        if found is not None and len(found[2]) <= _LONGEST:
            numbered.setdefault(int(found[1]), found[2].strip())
    count = len(numbered)
    whole = count >= _FEWEST and sorted(numbered) == list(range(1, count + 1))
    return [numbered[place] for place in range(1, count + 1)] if whole else []


def with_told_columns(looks: Sequence[FileLook], beside: Iterable[FileLook]) -> list[FileLook]:
    """Files without headers with the names that a text beside them gives to as many columns."""
    told: dict[int, tuple[str, list[str]]] = {}
    for item in beside:
        names = [] if item.has_sheets else listed_columns(_text(item))
        told.setdefault(len(names), (item.shown, names))
    return [_named(look, *told[len(look.columns)]) if _bare(look, told) else look for look in looks]


def _text(item: FileLook) -> str:
    """A short text; nothing of one that may not be read."""
    try:
        return item.path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _bare(look: FileLook, told: Iterable[int]) -> bool:
    return look.options.header is False and len(look.columns) in set(told)


def _named(look: FileLook, shown: str, names: Sequence[str]) -> FileLook:
    columns = []
    for column, name in zip(look.columns, names, strict=True):
        header, unit = bare_header(name, column.unit)
        columns.append(replace(column, header=header, unit=unit, remark=f"{name!r} in {shown}"))
    return replace(look, columns=tuple(columns))
