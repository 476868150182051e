"""Several files of one run put together on their time, without any interpolation.

Files with other columns stand side by side: the times of each must be among those of the longest,
and rows are kept at the times that all have. Files with the same columns follow each other in time:
where they overlap they must agree, unless the campaign file states in which order they were
computed; then a later one counts from its first time step on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array
from pmmkit.readers.base import Request

Mask = NDArray[np.bool_]
Places = NDArray[np.intp]

SAME_STEP: Final = 1e-2
"""Times that differ by less than this share of a time step are the same."""
_AGREE: Final = 1e-6
"""Numbers of two files agree within this share of the largest of their column."""


@dataclass(frozen=True, kw_only=True)
class ColumnPart:
    """Columns over time of one file or of several put together.

    `notes`: what was left out.
    """

    files: tuple[str, ...]
    times: Array
    values: Mapping[str, Array]
    notes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The files, for messages."""
        return " + ".join(self.files)

    def taken(self, rows: Mask) -> ColumnPart:
        """Some rows."""
        return replace(
            self,
            times=self.times[rows],
            values={header: numbers[rows] for header, numbers in self.values.items()},
        )


def steps(name: str, times: Array, values: Mapping[str, Array], request: Request) -> ColumnPart:
    """The last row of each time step.

    Examples
    --------
    >>> from pathlib import Path
    >>> request = Request(path=Path("a.csv"), shown="a.csv")
    >>> inner = {"Fx": np.array([3.0, 2.5, 2.4, 2.2])}
    >>> part = steps("a.csv", np.array([0.1, 0.1, 0.2, 0.2]), inner, request)
    >>> part.times, part.values["Fx"]
    (array([0.1, 0.2]), array([2.5, 2.2]))
    """
    back = np.flatnonzero(np.diff(times) < 0)
    if len(back):
        before, after = times[back[0]], times[back[0] + 1]
        raise request.error(
            f"time goes back from {before:.10g} to {after:.10g} after "
            f"{back[0] + 1} rows of numbers.",
            remedy="Make a file of each part; state their order in [source] if they overlap.",
        )
    last = np.append(np.diff(times) > 0, True)
    part = ColumnPart(files=(name,), times=times, values=values)
    if last.all():
        return part
    inner = len(last) - np.count_nonzero(last)
    said = f"{name}: {inner} rows of inner iterations left out, the last of each time step kept"
    return replace(part.taken(last), notes=(said,))


def merged(parts: Sequence[ColumnPart], request: Request) -> ColumnPart:
    """All files of a run as one."""
    groups: dict[frozenset[str], list[ColumnPart]] = {}
    for part in parts:
        groups.setdefault(frozenset(part.values), []).append(part)
    shared = [
        request.problem(
            f"{', '.join(sorted(one & other))} stands in {groups[one][0].name} and in "
            f"{groups[other][0].name}, which have different columns.",
            remedy="Leave one of them out by the pattern in file, or export each column once.",
        )
        for index, one in enumerate(groups)
        for other in list(groups)[:index]
        if one & other
    ]
    if shared:
        raise request.error(*shared)
    unknown = set(request.options.order) - {part.name for part in parts}
    if unknown:
        raise request.error(
            f"order in [source] names {', '.join(sorted(unknown))}; the files are "
            f"{', '.join(part.name for part in parts)}."
        )
    return _side_by_side([_in_sequence(listed, request) for listed in groups.values()], request)


def _in_sequence(parts: Sequence[ColumnPart], request: Request) -> ColumnPart:
    """Files with the same columns, one after the other in time."""
    order = request.options.order
    stated = all(part.name in order for part in parts)
    whole, *others = sorted(
        parts, key=lambda part: order.index(part.name) if stated else float(part.times[0])
    )
    for part in others:
        whole = _later_counts(whole, part) if stated else _agreeing(whole, part, request)
    return whole


def _later_counts(earlier: ColumnPart, later: ColumnPart) -> ColumnPart:
    kept = earlier.taken(earlier.times < later.times[0] - _tolerance(earlier.times))
    lost = len(earlier.times) - len(kept.times)
    said = (
        f"{later.name} counts from {later.times[0]:.10g} on: {lost} rows of {earlier.name} left out"
    )
    return _joined(kept, later, said)


def _agreeing(earlier: ColumnPart, later: ColumnPart, request: Request) -> ColumnPart:
    """Two files that overlap only where both have the same numbers."""
    tolerance = _tolerance(earlier.times)
    first, last = later.times[0], earlier.times[-1]
    if first > last + tolerance:
        said = f"{later.name} ({len(later.times)} rows) follows {earlier.name}"
        return _joined(earlier, later, said)
    end = min(last, later.times[-1]) + tolerance
    one = earlier.taken((earlier.times >= first - tolerance) & (earlier.times <= end))
    other = later.taken(later.times <= end)
    fault = _disagreement(one, other, tolerance)
    if fault is not None:
        listed = ", ".join(f'"{name}"' for name in (*earlier.files, *later.files))
        raise request.error(
            f"{earlier.name} and {later.name} overlap from {first:.10g} to "
            f"{end - tolerance:.10g} and disagree there: {fault}.",
            remedy="State in [source] in which order they were computed, and each counts "
            f"from its first time step on: order = [{listed}].",
        )
    said = f"{later.name} and {earlier.name} agree where they overlap ({len(other.times)} rows)"
    return _joined(earlier, later.taken(later.times > end), said)


def _joined(earlier: ColumnPart, later: ColumnPart, said: str) -> ColumnPart:
    return ColumnPart(
        files=(*earlier.files, *later.files),
        times=np.concatenate([earlier.times, later.times]),
        values={
            header: np.concatenate([numbers, later.values[header]])
            for header, numbers in earlier.values.items()
        },
        notes=(*earlier.notes, *later.notes, said),
    )


def _disagreement(one: ColumnPart, other: ColumnPart, tolerance: float) -> str | None:
    """The first place where two files over the same span differ, in words."""
    if len(one.times) != len(other.times) or np.any(np.abs(one.times - other.times) > tolerance):
        return f"{len(one.times)} and {len(other.times)} rows, not at the same times"
    for header, numbers in one.values.items():
        apart = np.abs(numbers - other.values[header])
        wrong = np.flatnonzero(apart > _AGREE * np.max(np.abs(numbers)))
        if len(wrong):
            row = wrong[0]
            return (
                f"{header} at {one.times[row]:.10g} is {numbers[row]:.10g} and "
                f"{other.values[header][row]:.10g}"
            )
    return None


def _side_by_side(parts: Sequence[ColumnPart], request: Request) -> ColumnPart:
    """Files with different columns at the times that all of them have."""
    base = max(parts, key=lambda part: len(part.times))
    tolerance = _tolerance(base.times)
    common = np.ones(len(base.times), dtype=bool)
    places: dict[str, Places] = {}
    problems = []
    for part in parts:
        rows, there = _found(part.times, base.times, tolerance)
        if there.all():
            common &= np.isin(np.arange(len(base.times)), rows)
            places[part.name] = rows
            continue
        missing = np.count_nonzero(~there)
        problems.append(
            request.problem(
                f"{part.name} has a row at {part.times[~there][0]:.10g}, {base.name} has none "
                f"there; so it is with {missing} of the {len(part.times)} rows of {part.name}.",
                remedy="Export them with the same trigger and over the same time; nothing is "
                "interpolated.",
            )
        )
    if problems:
        raise request.error(*problems)
    if not common.any():
        listed = ", ".join(f"{part.name} ({len(part.times)} rows)" for part in parts)
        raise request.error(f"no time is common to all of {listed}.")
    notes = [note for part in parts for note in part.notes]
    if not common.all():
        listed = ", ".join(f"{part.name} {len(part.times)}" for part in parts)
        notes.append(f"{np.count_nonzero(common)} common times kept; rows: {listed}")
    values: dict[str, Array] = {}
    for part in parts:
        kept = common[places[part.name]]
        values |= {header: numbers[kept] for header, numbers in part.values.items()}
    return ColumnPart(
        files=tuple(name for part in parts for name in part.files),
        times=base.times[common],
        values=values,
        notes=tuple(notes),
    )


def _found(times: Array, among: Array, tolerance: float) -> tuple[Places, Mask]:
    """Index of the nearest of other times for each time, and whether it is the same time."""
    middles = (among[1:] + among[:-1]) / 2
    nearest = np.searchsorted(middles, times)
    return nearest, np.abs(among[nearest] - times) <= tolerance


def _tolerance(times: Array) -> float:
    """Difference up to which two times are the same."""
    if len(times) < 2:
        return 1e-9 * max(1.0, float(np.max(np.abs(times))))
    return SAME_STEP * float(np.min(np.diff(times)))
