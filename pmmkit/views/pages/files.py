"""What lies in a folder: files, their channels with a picture each, and what is asked of them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import RUN_SETTINGS
from pmmkit.conventions import CHANNEL_UNITS, DEGREE_CHANNELS, FORCE_CHANNELS, factor_to
from pmmkit.intake import LARGE, ColumnLook, Drafted, FileGroup, FileLook, seen_values
from pmmkit.numerics import Array
from pmmkit.views.pages.numbers import short, thinned

PIECES: Final = 60
"""Pieces of a picture of a channel."""
MOST_COLUMNS: Final = 60
"""Columns of a layout that are shown."""
MOST_FILES: Final = 200
"""Names of files that are listed."""
MOST_FIELDS: Final = 400
"""Questions that are asked at once."""
USUAL_UNITS: Final = (
    *("N", "kN", "kgf", "N m", "kN m", "kgf m", "m", "mm", "m/s", "kn", "m/s2", "deg", "rad"),
    *("deg/s", "rad/s", "rad/s2", "deg/s2", "s", "ms", "min", "1/s", "rpm", "Hz"),
)
"""Units between which one chooses, each where it fits."""


def files_page(found: Drafted) -> dict[str, Any]:
    """What lies in a folder and what its campaign file says."""
    seen = found.seen
    return {
        "groups": [
            {**_group(group), "apart": group.first.shown in found.apart} for group in seen.groups
        ],
        "campaigns": [
            {"file": x.file, "title": x.title, "runs": x.runs, "problem": x.problem}
            for x in seen.campaigns
            if not x.file.endswith(".toml")
        ],
        "others": {suffix: count for suffix, count in seen.others.items() if suffix != ".toml"},
        "passed_over": seen.passed_over,
        "problems": [str(problem) for problem in seen.problems[:MOST_FILES]],
        "vocabulary": vocabulary(),
        "text": found.text,
        "fields": [item.to_dict() for item in found.fields[:MOST_FIELDS]],
        "more_fields": max(len(found.fields) - MOST_FIELDS, 0),
        "faults": [str(problem) for problem in found.problems[:MOST_FILES]],
        "new": found.new,
        "changed": found.changed,
        "complete": found.complete,
    }


def vocabulary() -> dict[str, dict[str, list[str]]]:
    """Our names with the units that fit, SI first: of histories, and of tables besides."""
    names = {**CHANNEL_UNITS, **dict.fromkeys(DEGREE_CHANNELS, "deg")}
    parts = {
        f"{channel}_{part}": CHANNEL_UNITS[channel]
        for channel in FORCE_CHANNELS[:4]
        for part in ("sin1", "cos1", "sin2", "cos2", "sin3", "cos3")
    }
    return {
        "history": {name: _units(unit) for name, unit in names.items()},
        "table": {name: _units(unit) for name, unit in {**RUN_SETTINGS.units, **parts}.items()},
    }


def _units(own: str) -> list[str]:
    fitting = [unit for unit in USUAL_UNITS if own and _fits(unit, own)]
    return list(dict.fromkeys([own, *fitting])) if own else []


def _fits(unit: str, own: str) -> bool:
    try:
        return factor_to(unit, own) is not None
    except DataError:
        return False


def _group(group: FileGroup) -> dict[str, Any]:
    first = group.first
    values, times = _numbers(first)
    return {
        "file": first.shown,
        "files": [item.shown for item in group.files[:MOST_FILES]],
        "count": len(group.files),
        "kind": first.kind,
        "words": first.words,
        "clock": first.clock_words,
        "rows": first.rows,
        "sampled": first.sampled,
        "size": first.size,
        "columns": [
            _column(column, values.get(column.position), times)
            for column in first.columns[:MOST_COLUMNS]
        ],
        "more_columns": max(len(first.columns) - MOST_COLUMNS, 0),
    }


def _numbers(look: FileLook) -> tuple[dict[int, Array], Array | None]:
    """Numbers of the columns for their pictures, of a large text those of its parts."""
    try:
        numbers = dict(seen_values(look).numbers)
    except OSError:
        if look.layout is None or look.size < LARGE:
            raise
        numbers = {}
    time = look.known.get("t")
    return numbers, None if time is None else numbers.get(time.position)


def _column(column: ColumnLook, numbers: Array | None, times: Array | None) -> dict[str, Any]:
    item = column.suggestion
    page: dict[str, Any] = {
        "column": column.position,
        "label": column.clipped,
        "unit": column.unit or "",
        "numbers": column.numbers,
        "low": short(column.low),
        "high": short(column.high),
        "remark": column.remark,
        "name": "" if item is None or item.certainty == "perhaps" else item.name,
        "perhaps": item.name if item is not None and item.certainty == "perhaps" else "",
        "certainty": "" if item is None else item.certainty,
        "reason": "" if item is None else item.reason,
        "chosen_unit": "" if item is None else item.unit or "",
        "sign": -1 if item is not None and item.scale < 0 else 1,
        "t": [],
        "values": [],
    }
    if numbers is None or not np.isfinite(numbers).any():
        return page
    over = np.arange(len(numbers), dtype=float)
    if times is not None and times.shape == numbers.shape and np.isfinite(times).all():
        over = times
    kept = thinned({"x": np.where(np.isfinite(numbers), numbers, np.nanmean(numbers))}, PIECES)
    return page | {"t": short(over[kept]), "values": short(numbers[kept])}
