"""Rows of tables as runs: one row a run, or the rows of one id as the samples of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.campaigns.file.assembly import (
    Assembled,
    Found,
    Setup,
    add_history,
    computed,
    context_of,
    corrections_of,
    frame_of,
    left_where_not_made,
    needs,
    numbers_in,
    out_of_range,
    request_of,
    said,
    set_by,
    settings_in,
    specs_of,
    windows_fit,
)
from pmmkit.campaigns.file.settings import missing_settings
from pmmkit.campaigns.run import Run, at_hand
from pmmkit.campaigns.run_settings import RUN_SETTINGS
from pmmkit.campaigns.samples.column_mapping import ColumnSpec, Picked, pick
from pmmkit.campaigns.samples.conversions import in_phase_parts
from pmmkit.campaigns.samples.loading import RowLoader, check_rows
from pmmkit.campaigns.stated_run import Kind
from pmmkit.campaigns.test_kinds.kind import TEST_KINDS
from pmmkit.conventions import FORCE_CHANNELS, harmonic_part
from pmmkit.numerics import Array
from pmmkit.readers import Cells, Request, reader_for

if TYPE_CHECKING:
    from pmmkit.campaigns.file.schema import FileEntry, RunEntry, TableEntry


# What a test was set to, from the motion that was measured where nobody states it.


_PERIOD: Final = ("period", "frequency_hz")


def speed_measured(values: Mapping[str, Any]) -> dict[str, float]:
    """The speed through the water from u and v, where u is there.

    Examples
    --------
    >>> speed_measured({"u": 0.6, "v": -0.8, "Y": 3.0}), speed_measured({"Y": 3.0})
    ({'speed': 1.0}, {})
    """
    if "u" not in values:
        return {}
    return {"speed": float(np.mean(np.hypot(values["u"], values.get("v", 0.0))))}


def settings_measured(
    test: str, values: Mapping[str, Array], stated: Mapping[str, Any]
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Speed, period and amplitudes of one cycle that was sampled evenly, and whence they are.

    The angular frequency is the root mean square of a velocity over that of its displacement,
    both without their means.

    Examples
    --------
    >>> phase = np.arange(24) * 2 * np.pi / 24
    >>> sway = {"u": np.full(24, 0.6), "y": 0.2 * np.sin(phase), "v": 0.1 * np.cos(phase)}
    >>> found, notes = settings_measured("pure_sway", sway, {"speed": 0.6})
    >>> {key: round(value, 3) for key, value in found.items()}, notes
    ({'period': 12.566, 'amplitude_m': 0.2}, ('period from v over y',))
    """
    found = {} if "speed" in stated else speed_measured(values)
    notes: tuple[str, ...] = ("speed from u and v",) if found else ()
    for swing in TEST_KINDS[test].swings:
        size = _rms(values, swing.displacement)
        rate = _rms(values, swing.velocity)
        if not size:
            continue
        key = RUN_SETTINGS.key_of(swing.amplitude)
        if key not in stated:
            found[key] = RUN_SETTINGS[swing.amplitude].to_file(math.sqrt(2.0) * size)  # of a sine
        if rate and not {*_PERIOD} & {*stated, *found}:
            found["period"] = 2 * math.pi * size / rate
            notes = (*notes, f"period from {swing.velocity} over {swing.displacement}")
    return {key: found[key] for key in ("speed", "period", *found) if key in found}, notes


def _rms(values: Mapping[str, Array], name: str) -> float:
    """Root mean square of a channel about its mean; zero where it is not there."""
    return float(np.std(values[name])) if name in values else 0.0


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
    corrections = corrections_of(run_id, entry.test, setup)
    from_cells = {name: value for name, value in numbers.items() if name in RUN_SETTINGS.units}
    stated = {**entry.settings(), **from_cells}
    given = {**stated, **set_by(corrections)}
    at_rest = TEST_KINDS[entry.test].at_rest
    if at_rest and given.get("speed") == 0:
        given, from_cells = (
            {name: x for name, x in own.items() if name != "speed"} for own in (given, from_cells)
        )
    elif given.get("speed") == 0:
        out.left_out[f"{request.shown} row {line}"] = AT_REST
        return
    kind, values, dimensional = _contents(numbers, picked, request.options.in_phase_with)
    given = {**(speed_measured(values) if kind == "means" and not at_rest else {}), **given}
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
    frame = frame_of(entry.test, request, setup)
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
    names = [name for name in numbers if name not in RUN_SETTINGS.units]
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
    corrections = corrections_of(run_id, entry.test, setup)
    columns = {
        name: float(np.mean([numbers[name] for numbers in whole]))
        for name in whole[0]
        if name in RUN_SETTINGS.units
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
    names = [name for name in rows[0] if name not in RUN_SETTINGS.units]
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


# The ``[[runs]]`` and ``[[tables]]`` of a campaign file, one by one.


def add_run(entry: RunEntry, label: str, setup: Setup, out: Assembled) -> None:
    """One entry of ``[[runs]]``: a history, or a row of a table."""
    out.claim(entry.id, label)
    setup = left_where_not_made(entry, computed(setup, entry), out)
    request = request_of(entry, label, setup, out)
    if request is None:
        return
    specs = specs_of(entry, setup.columns)
    if entry.row is None:
        add_history(entry, label, request, specs, setup, out)
        return
    table = table_of(request, specs, entry.rows, out)
    if table is None:
        return
    chosen, problems = table[0].matching_rows(entry.row, request)
    if not problems and len(chosen) != 1:
        stated = " and ".join(f"{name} = {value!r}" for name, value in entry.row.items())
        lines = ", ".join(str(table[0].lines[index]) for index in chosen[:10])
        problems = [
            request.problem(
                f"no row has {stated}."
                if not chosen
                else f"{len(chosen)} rows have {stated}: rows {lines}.",
                remedy="" if not chosen else "Name a further column under row.",
            )
        ]
    out.problems += problems
    if not problems:
        add_row(entry, entry.id, label, request, table, chosen[0], setup, out)


def add_table(entry: TableEntry, label: str, setup: Setup, out: Assembled) -> None:
    """One entry of ``[[tables]]``: every row that is not left out becomes a run, or a sample."""
    setup = computed(setup, entry)
    request = request_of(entry, label, setup, out)
    if request is None:
        return
    request = replace(request, run=None)
    table = table_of(request, specs_of(entry, setup.columns), entry.rows, out)
    if table is None:
        return
    cells, _ = table
    chosen, problems = cells.matching_rows(entry.where, request)
    unknown = sorted(set(entry.skip) - set(cells.lines))
    if unknown:
        problems.append(
            request.problem(
                f"skip names row {', '.join(map(str, unknown))}; rows of numbers are "
                f"{cells.lines[0]} to {cells.lines[-1]}."
            )
        )
    names = cells.filled_in(entry.id, 0)[1]
    problems += [cells.no_column(name, request) for name in names]
    if not problems and not chosen:
        problems.append(request.problem("no row is as stated under where."))
    if len(chosen) > 1 and "{" not in entry.id and entry.samples is None:
        problems.append(
            Problem(
                message=f"{len(chosen)} rows would all have the id {entry.id!r}.",
                file=out.file,
                entry=label,
                remedy='Put a column of theirs in it, e.g. id = "SD_{Run No.}".',
            )
        )
    out.problems += problems
    if problems:
        return
    kept = [index for index in chosen if cells.lines[index] not in entry.skip]
    if entry.samples is None:
        for index in kept:
            run_id = cells.filled_in(entry.id, index)[0]
            place = f"{label}, row {cells.lines[index]} of {entry.file}"
            out.claim(run_id, place)
            add_row(entry, run_id, place, request, table, index, setup, out)
        return
    samples: dict[str, list[int]] = {}
    for index in kept:
        samples.setdefault(cells.filled_in(entry.id, index)[0], []).append(index)
    for run_id, rows in samples.items():
        place = f"{label}, rows {cells.lines[rows[0]]} to {cells.lines[rows[-1]]} of {entry.file}"
        out.claim(run_id, place)
        add_samples(entry, run_id, place, request, table, rows, setup, out)
