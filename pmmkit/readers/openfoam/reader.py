"""Forces, coefficients and rigid body motions that OpenFOAM wrote.

``file`` may be a ``.dat`` file, a start-time folder, a function object in ``postProcessing`` or a
case. What each start of the computation wrote is joined; forces and moments in files of their own
are joined by time. Formats: source of the function objects ``forces``, ``forceCoeffs`` and
``sixDoFRigidBodyState`` of the OpenFOAM Foundation (2014 to 2021) and of OpenCFD (2016 to 2025).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import Problem
from pmmkit.numerics import Array
from pmmkit.readers.base import Choose, Columns, Request, abridged, head_of
from pmmkit.readers.openfoam.header import MOVED, read_rows
from pmmkit.readers.openfoam.mesh_motion import (
    density_doubt,
    entries_of,
    is_motion_table,
    motion_table,
    told,
)
from pmmkit.readers.openfoam.places import FileSeries, RestartPart, series_of

TIME: Final = "Time [s]"
USUAL: Final[Mapping[str, str]] = MappingProxyType(
    {
        "t": "Time",
        "X": "Fx",
        "Y": "Fy",
        "N": "Mz",
        "K": "Mx",
        "x": f"{MOVED}_x",
        "y": f"{MOVED}_y",
        "psi": "rotation_z",
    }
)
"""Where our channels stand."""

SAME_TIME: Final = 1e-6
"""Times of forces and moments are one where they differ by less than this share of a step."""
ROUNDING: Final = 2e-3
"""Share by which a total may differ from the sum of its parts, which are rounded as printed."""


_OF_TABLE: Final = (
    TIME,
    *(f"{MOVED}_{axis} [m]" for axis in "xyz"),
    *(f"rotation_{axis} [deg]" for axis in "xyz"),
)
"""Columns of a table of six degrees of freedom."""


def names(request: Request) -> tuple[str, ...]:
    """Headers that the files offer: the time, sums over the parts of a force, and the parts."""
    if holds_motion_table(request):
        return _OF_TABLE
    return _headers(series_of(request))


def columns(request: Request, choose: Choose) -> Columns:
    """Some columns of the whole history, from the first start of the computation to the last."""
    if holds_motion_table(request):
        return _of_table(request, choose)
    series = series_of(request)
    headers = _headers(series)
    positions = tuple(choose(headers, len(headers)))
    wanted = [headers[place] for place in positions]
    notes = [*series.notes]
    _same_layouts(series, request)
    tables, dropped = [], 0
    for family in series.families:
        offered = family[0].layout.offered
        table, lost = _family(family, [name for name in wanted if name in offered], notes)
        tables.append(table)
        dropped += lost
    table = _joined(tables, series, request, notes)
    if not len(table[TIME]):
        raise request.error("there are no rows of numbers.")
    moved = {name: table[name] - table[name][0] for name in wanted if name.startswith(MOVED)}
    table |= moved
    if moved:
        notes.append("displacement: from the place of the centre of rotation at the first time")
    entries = entries_of(series.parts[0].request.path)
    of_forces = any(name.endswith(("[N]", "[N m]")) for name in wanted)
    doubt = density_doubt(entries) if of_forces else None
    return Columns(
        headers=headers,
        positions=positions,
        values=tuple(table[name] for name in wanted),
        dropped=dropped,
        notes=(*notes, *told(series, entries)),
        unsettled={"rho_inf": doubt} if doubt is not None else {},
    )


def holds_motion_table(request: Request) -> bool:
    """Whether the file is the table by which a mesh was moved."""
    return request.path.is_file() and is_motion_table(head_of(request.path))


def _of_table(request: Request, choose: Choose) -> Columns:
    """The path of the mesh as its table has it."""
    table = motion_table(request.path)
    if table is None:
        raise request.error(
            "this is no whole table of times, places and angles.",
            remedy="Write it again: its length, then a row (t ((x y z) (rx ry rz))) each.",
        )
    positions = tuple(choose(_OF_TABLE, len(_OF_TABLE)))
    return Columns(
        headers=_OF_TABLE,
        positions=positions,
        values=tuple(table[place] for place in positions),
        notes=("the path of the mesh as its table has it",),
    )


def _headers(series: FileSeries) -> tuple[str, ...]:
    offered = [name for family in series.families for name in family[0].layout.offered]
    return (TIME, *offered)


def _same_layouts(series: FileSeries, request: Request) -> None:
    """Refuse starts that offer other columns or took moments about another point."""
    problems: list[Problem] = []
    first = series.families[0][0]
    for family in series.families:
        for part in family:
            missing = sorted(set(family[0].layout.offered) ^ set(part.layout.offered))
            if missing:
                problems.append(
                    part.request.problem(
                        f"the columns are not those of {family[0].request.shown}: "
                        f"{', '.join(missing[:6])}.",
                        remedy="Name the file or start-time folder that is to be read.",
                    )
                )
            for name in ("CofR", "Aref", "lRef", "magUInf"):
                ours, theirs = first.layout.values.get(name), part.layout.values.get(name)
                if not _alike(ours, theirs):
                    problems.append(
                        part.request.problem(
                            f"{name} is {theirs}; in {first.request.shown} it is {ours}.",
                            remedy="Name the file or start-time folder that is to be read.",
                        )
                    )
    if problems:
        raise request.error(*abridged(problems, request))


def _alike(one: str | None, other: str | None) -> bool:
    """Whether two values of headers are the same, as numbers where they are some."""
    if one is None or other is None or one == other:
        return True
    try:
        left, right = (np.array(text.strip("() ").split(), float) for text in (one, other))
    except ValueError:
        return False
    return left.shape == right.shape and bool(np.allclose(left, right, rtol=1e-6, atol=1e-12))


def _family(
    family: Sequence[RestartPart], wanted: Sequence[str], notes: list[str]
) -> tuple[dict[str, Array], int]:
    """One file of each start, joined: what a later start computed counts."""
    pieces: list[dict[str, Array]] = []
    dropped = 0
    later = math.inf
    for part in reversed(family):
        values, lost, said = _part(part, wanted)
        notes += said
        dropped += lost
        times = values[TIME]
        if not len(times):
            notes.append(f"{part.request.shown}: there are no rows of numbers")
            continue
        kept = int(np.searchsorted(times, later))
        if kept < len(times):
            notes.append(
                f"{part.request.shown}: {len(times) - kept} rows from t = {times[kept]:.10g} on "
                "replaced by those of a later start"
            )
        pieces.append({name: numbers[:kept] for name, numbers in values.items()})
        later = min(later, float(times[0]), _after(part.start))
    pieces.reverse()
    names = (TIME, *wanted)
    if not pieces:
        return {name: np.empty(0) for name in names}, dropped
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in names}, dropped


def _after(start: float) -> float:
    """The first time that is later than a start."""
    return start + 1e-9 * max(abs(start), 1e-3) if math.isfinite(start) else math.inf


def _part(
    part: RestartPart, wanted: Sequence[str]
) -> tuple[dict[str, Array], int, tuple[str, ...]]:
    """What one file holds of some headers; totals that it states are compared with their parts."""
    layout = part.layout
    places = sorted(
        {0}
        | {place for name in wanted for place in layout.offered[name]}
        | {place for name in wanted for place in layout.parts.get(name, ())}
    )
    table, dropped, notes = read_rows(part.request, layout, places)
    column = {place: table[index] for index, place in enumerate(places)}
    values = {TIME: column[0]}
    for name in wanted:
        values[name] = _sum(column, layout.offered[name])
        if name in layout.parts:
            _check_total(column, values[name], name, part)
    return values, dropped, notes


def _sum(column: Mapping[int, Array], places: Sequence[int]) -> Array:
    total = column[places[0]]
    for place in places[1:]:
        total = total + column[place]
    return total


def _check_total(column: Mapping[int, Array], total: Array, name: str, part: RestartPart) -> None:
    places = part.layout.parts[name]
    size = np.abs(total)
    for place in places:
        size = size + np.abs(column[place])
    wrong = np.flatnonzero(np.abs(total - _sum(column, places)) > ROUNDING * size)
    if len(wrong):
        raise part.request.error(
            *abridged(
                [
                    part.request.problem(
                        f"the total {total[row]:.7g} is not the sum of its parts "
                        f"{' and '.join(f'{column[place][row]:.7g}' for place in places)} at "
                        f"t = {column[0][row]:.10g}: the row is damaged.",
                        column=name,
                    )
                    for row in wrong[:100].tolist()
                ],
                part.request,
            )
        )


def _joined(
    tables: Sequence[dict[str, Array]], series: FileSeries, request: Request, notes: list[str]
) -> dict[str, Array]:
    """Forces and moments at the same times."""
    if len(tables) == 1:
        return tables[0]
    count = min(len(table[TIME]) for table in tables)
    one, other = (table[TIME][:count] for table in tables)
    step = float(np.median(np.diff(one))) if count > 1 else 1.0
    apart = np.flatnonzero(np.abs(one - other) > SAME_TIME * step)
    surplus = [len(table[TIME]) - count for table in tables]
    files = " and ".join(family[-1].request.shown for family in series.families)
    if len(apart) or max(surplus) > 1:
        where = (
            f"row {int(apart[0]) + 1} of numbers is at t = {one[apart[0]]:.10g} and "
            f"t = {other[apart[0]]:.10g}"
            if len(apart)
            else f"{count + surplus[0]} and {count + surplus[1]} rows"
        )
        raise request.error(
            f"{files} do not stand at the same times: {where}.",
            remedy="Copy both again from the same computation.",
        )
    if max(surplus):
        notes.append(f"{files}: the last row has no partner in the other file and was left out")
    return {name: numbers[:count] for table in reversed(tables) for name, numbers in table.items()}
