"""What the columns of a file probably are, and of what kind the file is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pmmkit.intake.guessing import Suggestion, rates_of, suggest, wrong_unit
from pmmkit.intake.seen import Clock, ColumnLook, FileLook, concerns, doubt_in, without_doubt
from pmmkit.numerics import Array
from pmmkit.readers import READERS


def judged(look: FileLook, values: Mapping[int, Array], seams: Sequence[int] = ()) -> FileLook:
    """A look with what the columns probably are, their numbers, the clock and the kind of file."""
    headers = [without_doubt(column.header) for column in look.columns]
    units = [column.unit for column in look.columns]
    usual = READERS[look.format].usual(headers)
    found = suggest(headers, units, values, usual=usual)
    kind = _kind(headers, found, values, look.columns)
    if kind in ("table", "open water"):
        found = suggest(headers, units, values, table=True)
    columns = tuple(
        _seen(_doubted(replace(column, suggestion=item), kind), values.get(column.position))
        for column, item in zip(look.columns, found, strict=True)
    )
    look = replace(look, kind=kind, columns=columns)
    time = look.known.get("t") if kind == "history" else None
    if time is None or time.position not in values:
        return look
    look = replace(look, clock=clock_of(values[time.position], seams))
    return look if seams else _with_rates(look, values, time.position)


def _with_rates(look: FileLook, values: Mapping[int, Array], clock: int) -> FileLook:
    """With a remark at columns that are the rate of another one."""
    others = {
        place: numbers
        for place, numbers in values.items()
        if place != clock and np.all(np.isfinite(numbers))
    }
    rates = rates_of(values[clock], others)
    columns = []
    for column in look.columns:
        other, factor = rates.get(column.position, (None, 1.0))
        if other is not None:
            times = "" if factor == 1.0 else f", times {factor:g}"
            said = f"the rate of {look.columns[other].label}{times}"
            column = replace(column, remark=_also(column, said))
        columns.append(column)
    return replace(look, columns=tuple(columns))


def _kind(
    headers: Sequence[str],
    found: Sequence[Suggestion | None],
    values: Mapping[int, Array],
    columns: Sequence[ColumnLook],
) -> str:
    folded = {header.lower().lstrip("10") for header in headers}
    if {"j", "kt", "kq"} <= folded:
        return "open water"
    names = {item.name for item in found if item}
    if "t" in names:
        return "history"
    rows = max((len(numbers) for numbers in values.values()), default=0)
    units = [column.unit for column in columns]
    as_table = {item.name for item in suggest(headers, units, values, table=True) if item}
    forces = {name.partition("_")[0] for name in as_table} & {"X", "Y", "N", "K"}
    settings = as_table & {"speed", "drift_deg", "rudder_deg", "heel_deg", "yaw_rate"}
    return "table" if forces and settings and rows < 5000 else "unknown"


def _doubted(column: ColumnLook, kind: str) -> ColumnLook:
    """Without what its header doubts, with a remark; also where name and unit do not agree."""
    said = doubt_in(column.title)
    if concerns(said, column.unit):
        remark = f"its header says {said!r}: left out unless you name it under [columns]"
        return replace(column, suggestion=None, remark=remark)
    if column.suggestion is not None:
        return column
    said = wrong_unit(column.header, column.unit, table=kind == "table")
    return replace(column, remark=said) if said else column


def _seen(column: ColumnLook, numbers: Array | None) -> ColumnLook:
    finite = None if numbers is None else numbers[np.isfinite(numbers)]
    if finite is None or not len(finite):
        return column if numbers is None else replace(column, remark=_also(column, "no numbers"))
    missing = len(numbers) - len(finite) if numbers is not None else 0
    return replace(
        column,
        numbers=True,
        low=float(finite.min()),
        high=float(finite.max()),
        mean=float(finite.mean()),
        first=float(finite[0]),
        remark=_also(column, f"{missing} without a number" if missing else ""),
    )


def _also(column: ColumnLook, said: str) -> str:
    """The remark on a column with another one."""
    return "; ".join(filter(None, (column.remark, said)))


def clock_of(time: Array, seams: Sequence[int] = ()) -> Clock | None:
    """Facts about a column of times; None for fewer than three.

    Examples
    --------
    >>> found = clock_of(np.array([0.0, 0.1, 0.2, 0.5, 0.5, 0.6]))
    >>> round(found.interval, 9), found.gaps, found.repeated, found.even
    (0.1, 1, 1, False)
    """
    finite = np.isfinite(time)
    if np.count_nonzero(finite) < 3:
        return None
    steps = np.diff(time)
    steps[[row - 1 for row in seams if 0 < row <= len(steps)]] = np.nan
    steps = steps[np.isfinite(steps)]
    forward = steps[steps > 0]
    interval = float(np.median(forward)) if len(forward) else 0.0
    gaps = steps > 1.5 * interval
    usual = steps[~gaps]
    return Clock(
        interval=interval,
        duration=float(np.ptp(time[finite])),
        even=bool(interval > 0 and np.all(np.abs(usual - interval) < 0.02 * interval)),
        gaps=int(np.count_nonzero(gaps)),
        repeated=int(np.count_nonzero(steps == 0)),
        backward=int(np.count_nonzero(steps < 0)),
        longest=float(steps.max()),
    )
