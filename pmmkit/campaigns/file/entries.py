"""The ``[[runs]]`` and ``[[tables]]`` of a campaign file, one by one."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from pmmkit.base import Problem
from pmmkit.campaigns.file.assembly import (
    Assembled,
    Setup,
    add_history,
    computed,
    request_of,
    specs_of,
)
from pmmkit.campaigns.file.rows import add_row, add_samples, table_of

if TYPE_CHECKING:
    from pmmkit.campaigns.file.schema import RunEntry, TableEntry


def add_run(entry: RunEntry, label: str, setup: Setup, out: Assembled) -> None:
    """One entry of ``[[runs]]``: a history, or a row of a table."""
    out.claim(entry.id, label)
    setup = computed(setup, entry)
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
