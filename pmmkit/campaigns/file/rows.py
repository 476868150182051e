"""Rows of tables as runs: one row a run, or the rows of one id as the samples of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.campaigns.file.assembly import (
    Assembled,
    Found,
    Setup,
    context_of,
    corrections_of,
    needs,
    numbers_in,
    out_of_range,
    said,
    set_by,
    settings_in,
    windows_fit,
)
from pmmkit.campaigns.file.measured import settings_measured, speed_measured
from pmmkit.campaigns.file.settings import missing_settings
from pmmkit.campaigns.run import Run, at_hand
from pmmkit.campaigns.run_settings import setting_units
from pmmkit.campaigns.samples.column_mapping import ColumnSpec, Picked, pick
from pmmkit.campaigns.samples.conversions import in_phase_parts
from pmmkit.campaigns.samples.loading import RowLoader, check_rows
from pmmkit.campaigns.stated_run import Kind
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
from pmmkit.conventions import FORCE_CHANNELS, harmonic_part
from pmmkit.numerics import Array
from pmmkit.readers import Cells, Request, reader_for

if TYPE_CHECKING:
    from pmmkit.campaigns.file.schema import FileEntry, TableEntry

Table = tuple[Cells, tuple[Picked, ...]]
FEWEST: Final = 8
"""Samples of a cycle at least: with fewer the third harmonic cannot be told from the first."""
AT_REST: Final = "at no speed (a zero of the gauges, or a turn on the spot)"


def table_of(
    request: Request, specs: Mapping[str, ColumnSpec], rows: int | None, out: Assembled
) -> Found:
    """The cells and used columns of a table, read once; its problems are told once."""
    key = (
        request.path,
        request.origin,
        request.options,
        tuple(sorted(specs.items(), key=lambda item: item[0])),
    )
    if key not in out.tables:
        out.tables[key] = None
        whole = replace(request, run=None)
        try:
            whole = at_hand(whole)
            cells = reader_for(whole).cells(whole)
            check_rows(len(cells.rows), rows, whole)
        except DataError as error:
            out.problems += error.problems
            return None
        picked, problems = pick(cells.headers, len(cells.headers), specs, whole, table=True)
        problems += _unfit(picked, whole)
        out.problems += problems
        if not problems:
            out.tables[key] = (cells, picked)
    return out.tables[key]


def _unfit(picked: Sequence[Picked], request: Request) -> list[Problem]:
    names = [column.name for column in picked]
    parts = [found for name in names if (found := harmonic_part(name))]
    ways = {way for _, way, _ in parts}
    problems = []
    if not parts and not set(names) & set(FORCE_CHANNELS):
        problems.append(
            request.problem(
                "no column is known as a force or a harmonic of one.",
                remedy='Map them under [columns], e.g. Y = "their name" or Y_sin1 = "their name".',
            )
        )
    if ways & {"in", "out"} and request.options.in_phase_with is None:
        problems.append(
            request.problem(
                "columns are mapped as in phase and out of phase, without saying with what.",
                remedy='Say it in [source]: in_phase_with = "displacement" (or velocity, '
                "acceleration).",
            )
        )
    if ways & {"in", "out"} and ways & {"sin", "cos"}:
        problems.append(request.problem("_in and _out are mapped together with _sin and _cos."))
    doubled = [name for name in names if name in FORCE_CHANNELS and f"{name}_mean" in names]
    problems += [
        request.problem(f"{name} and {name}_mean are both there; they are the same.")
        for name in doubled
    ]
    if ways - {"mean", "std"} and "std" in ways:
        problems.append(request.problem("_std belongs to tables of means, not of harmonics."))
    return problems


def add_row(
    entry: FileEntry,
    run_id: str,
    label: str,
    request: Request,
    table: Table,
    index: int,
    setup: Setup,
    out: Assembled,
) -> None:
    """A row of a table as a run."""
    cells, picked = table
    line = cells.lines[index]
    request = replace(request, run=run_id)
    numbers = row_numbers(cells, picked, index, request, out)
    if numbers is None:
        return
    corrections = corrections_of(run_id, setup)
    from_cells = {name: value for name, value in numbers.items() if name in setting_units()}
    stated = {**entry.settings(), **from_cells}
    given = {**stated, **set_by(corrections)}
    if given.get("speed") == 0:
        out.left_out[f"{request.shown} row {line}"] = AT_REST
        return
    kind, values, dimensional = _contents(numbers, picked, request.options.in_phase_with)
    given = {**(speed_measured(values) if kind == "means" else {}), **given}
    dynamic = TEST_KINDS[entry.test].oscillates
    if dynamic != (kind == "harmonics"):
        out.problems.append(
            request.problem(
                f"a row of {kind} cannot be a {entry.test} test.",
                row=line,
                remedy="An oscillating test needs columns such as Y_sin1 and Y_cos1, a static one "
                "columns such as Y.",
            )
        )
        return
    if out_of_range(from_cells, label, out) or needs(
        missing_settings(entry.test, given, values), entry.test, label, out
    ):
        return
    frame = replace(setup.frame, nondimensional=request.options.nondimensional)
    found = settings_in(entry.test, given, frame, label, setup, out, turn_phase=kind == "means")
    if found is None:
        return
    settings, notes = found
    phase = request.options.in_phase_with
    if kind == "harmonics" and phase:
        notes = (*notes, f"in-phase parts of harmonics are in phase with the {phase}")
    loader = RowLoader(
        request=request,
        kind=kind,
        values=MappingProxyType(values),
        context=context_of(entry.test, settings, frame, corrections, notes, setup),
        dimensional=dimensional,
        turned=frame.motion_sign(entry.test) < 0,
        notes=(*cells.notes, *(column.note for column in picked if column.note)),
    )
    run = Run(
        id=run_id,
        test=entry.test,
        kind=kind,
        settings=settings,
        loader=loader,
        stated=numbers_in(stated),
        source=f"{entry.file} row {line}",
    )
    windows_fit(corrections, "a row of a table has no samples", label, out)
    out.runs.append(said(run, corrections, setup))


def row_numbers(
    cells: Cells, picked: Sequence[Picked], index: int, request: Request, out: Assembled
) -> dict[str, float] | None:
    """The numbers of a row by our names; None where they are wrong or the row is left out."""
    problems: list[Problem] = []
    numbers: dict[str, float] = {}
    line = cells.lines[index]
    for column in picked:
        number, why = cells.number_at(index, column.position)
        if why is None and number is not None:
            numbers[column.name] = number * column.scale + column.offset
        elif number is not None and number != number and request.options.missing == "drop":
            out.left_out[f"{request.shown} row {line}"] = f"no value of {column.name}"
            return None
        elif why is not None:
            problems.append(request.problem(why, row=line, column=column.title))
    out.problems += problems
    return None if problems else numbers


def _contents(
    numbers: Mapping[str, float], picked: Sequence[Picked], phase: str | None
) -> tuple[Kind, dict[str, float], frozenset[str]]:
    """Kind of a row, its channels under the names of that kind, and those with a stated unit."""
    names = [name for name in numbers if name not in setting_units()]
    parts = [found for name in names if (found := harmonic_part(name))]
    harmonics = any(way not in ("mean", "std") for _, way, _ in parts)
    values: dict[str, float] = {}
    dimensional = set()
    units = {column.name: column.unit for column in picked}
    for name in names:
        ours, sign = in_phase_parts(name, phase or "displacement")
        if harmonics and name in FORCE_CHANNELS:
            ours = f"{name}_mean"
        elif not harmonics:
            ours = name.removesuffix("_mean")
        values[ours] = sign * numbers[name]
        if units[name] is not None:
            dimensional.add(ours)
    return "harmonics" if harmonics else "means", values, frozenset(dimensional)


def add_samples(
    entry: TableEntry,
    run_id: str,
    label: str,
    request: Request,
    table: Table,
    rows: Sequence[int],
    setup: Setup,
    out: Assembled,
) -> None:
    """Rows of one id: the samples of a run, of one cycle or in time."""
    cells, picked = table
    request = replace(request, run=run_id)
    found = [row_numbers(cells, picked, index, request, out) for index in rows]
    whole = [numbers for numbers in found if numbers is not None]
    if len(whole) < len(found):
        return
    kept, dimensional = _channels(whole, picked)
    corrections = corrections_of(run_id, setup)
    columns = {
        name: float(np.mean([numbers[name] for numbers in whole]))
        for name in whole[0]
        if name in setting_units()
    }
    stated = {**columns, **entry.settings()}
    measured, notes = settings_measured(entry.test, kept, stated)
    given = {**measured, **stated, **set_by(corrections)}
    problem = _not_sampled(entry, kept, len(rows), given)
    if problem:
        out.problems.append(request.problem(problem, row=cells.lines[rows[0]]))
        return
    if needs(missing_settings(entry.test, given, kept), entry.test, label, out):
        return
    frame = replace(setup.frame, nondimensional=request.options.nondimensional)
    settled = settings_in(entry.test, given, frame, label, setup, out)
    if settled is None:
        return
    settings, more = settled
    if entry.samples == "cycle":
        kept["t"] = np.arange(len(rows)) * (settings.period or 0.0) / len(rows)
        notes = (*notes, f"t counted over one period of {settings.period:.5g} s")
    loader = RowLoader(
        request=request,
        kind="history",
        values=MappingProxyType({name: tuple(map(float, x)) for name, x in kept.items()}),
        context=context_of(entry.test, settings, frame, corrections, (*more, *notes), setup),
        dimensional=dimensional,
        notes=(*cells.notes, *(column.note for column in picked if column.note)),
    )
    run = Run(
        id=run_id,
        test=entry.test,
        kind="history",
        settings=settings,
        loader=loader,
        stated=numbers_in(stated),
        source=f"{entry.file} rows {cells.lines[rows[0]]} to {cells.lines[rows[-1]]}",
    )
    out.runs.append(said(run, corrections, setup))


def _channels(
    rows: Sequence[Mapping[str, float]], picked: Sequence[Picked]
) -> tuple[dict[str, Array], frozenset[str]]:
    """The channels of rows that are samples, and those whose unit was stated."""
    names = [name for name in rows[0] if name not in setting_units()]
    values = {
        name.removesuffix("_mean"): np.array([numbers[name] for numbers in rows]) for name in names
    }
    units = {column.name: column.unit for column in picked}
    stated = {name.removesuffix("_mean") for name in names if units[name] is not None}
    return values, frozenset(stated)


def _not_sampled(
    entry: TableEntry, values: Mapping[str, Array], count: int, given: Mapping[str, float]
) -> str:
    """Why rows cannot be the samples that the campaign file says they are; empty if they can."""
    if any(harmonic_part(name) for name in values):
        return "columns of means or harmonics cannot be samples."
    if entry.samples == "time":
        return "" if "t" in values else "samples in time need a column t."
    if count < FEWEST:
        return f"a cycle of {count} samples is too short: {FEWEST} are needed."
    if not TEST_KINDS[entry.test].oscillates:
        return f"a {entry.test} test has no cycle; its rows are samples in time, or runs."
    if not {"period", "frequency_hz"} & set(given):
        return "the samples of a cycle need its period, or displacement and velocity measured."
    return ""
