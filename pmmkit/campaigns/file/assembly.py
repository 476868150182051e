"""From the ``[[runs]]`` and ``[[tables]]`` of a campaign file to runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pmmkit.campaigns.file.settings import missing_settings, settings_of
from pmmkit.campaigns.file.struts import on_struts
from pmmkit.campaigns.motion.solver_axes import Solver
from pmmkit.campaigns.run import Correction, Kind, Run
from pmmkit.campaigns.samples.bringing import at_hand
from pmmkit.campaigns.samples.column_mapping import ColumnSpec, Picked, pick
from pmmkit.campaigns.samples.conversions import Frame, in_phase_parts
from pmmkit.campaigns.samples.loading import Context, HistoryLoader, RowLoader, check_rows
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.campaigns.test_kinds.struts import Struts
from pmmkit.channels import FORCE_CHANNELS, SETTING_UNITS, STRUT_CHANNELS, harmonic_part
from pmmkit.errors import DataError, Problem
from pmmkit.readers import reader_for
from pmmkit.readers.base import Cells, Options, Request, fault, to_number
from pmmkit.readers.rows import filled_in, matching_rows, no_column
from pmmkit.ship import Ship, Water

if TYPE_CHECKING:
    from pmmkit.campaigns.file.schema import FileEntry, RunEntry, TableEntry

Found = tuple[Cells, tuple[Picked, ...]] | None


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What all runs of a campaign file share.

    Parameters
    ----------
    ship, water : Ship, Water
        Particulars.
    kind, forces : str
        Of the campaign.
    frame : Frame
        Axes and signs of the source.
    options : Options
        ``[source]``.
    columns : mapping of str to ColumnSpec
        ``[columns]``.
    corrections : tuple of Correction
        All corrections of the file.
    find : callable
        What is read for a file that the campaign names, or None.
    missing_file : callable
        The problem of a file that is not there.
    toml : str
        Name of the campaign file.
    trial : mapping
        ``[trial]``.
    solver : Solver
        ``[cfd]``, besides factors.
    struts : Struts or None
        ``[struts]``.
    """

    ship: Ship
    water: Water
    kind: str
    forces: str
    frame: Frame
    options: Options
    columns: Mapping[str, ColumnSpec]
    corrections: tuple[Correction, ...]
    find: Callable[[str], Request | None]
    missing_file: Callable[[str, str], Problem]
    toml: str
    trial: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    solver: Solver = field(default_factory=Solver)
    struts: Struts | None = None


@dataclass
class Assembled:
    """Runs as they are put together, and everything that is wrong with them."""

    problems: list[Problem] = field(default_factory=list)
    runs: list[Run] = field(default_factory=list)
    ids: dict[str, str] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    tables: dict[Any, Found] = field(default_factory=dict)
    incomplete: bool = False

    def claim(self, run_id: str, entry: str, file: str) -> None:
        """Note an id; an id that is there already is a problem."""
        if run_id in self.ids:
            self.problems.append(
                Problem(
                    message=f"id {run_id!r} is used twice; the other is {self.ids[run_id]}.",
                    file=file,
                    entry=entry,
                    remedy="Every run needs an id of its own.",
                )
            )
        self.ids.setdefault(run_id, entry)


def merged(options: Options, entry: FileEntry) -> Options:
    """``[source]`` with what a run or table states of its own."""
    if entry.source is None:
        return options
    own = entry.source
    return replace(options, **{name: getattr(own, name) for name in own.model_fields_set})


def computed(setup: Setup, entry: FileEntry) -> Setup:
    """The setup with what a run or table states of its computation, beside ``[cfd]``."""
    own = {} if entry.cfd is None else entry.cfd.model_dump(exclude_none=True)
    if not own:
        return setup
    frame, solver = setup.frame, setup.solver
    if "rho_inf" in own:
        frame = replace(frame, density_factor=setup.water.rho / own["rho_inf"])
    return replace(
        setup,
        frame=replace(frame, symmetry_factor=own.get("symmetry_factor", frame.symmetry_factor)),
        solver=replace(
            solver,
            axes=own.get("forces_in", solver.axes),
            centre_moves=own.get("moment_centre_moves", solver.centre_moves),
            ramp=own.get("ramp_s", solver.ramp),
            stated=solver.stated | set(own),
        ),
    )


def specs_of(entry: FileEntry | None, base: Mapping[str, ColumnSpec]) -> dict[str, ColumnSpec]:
    """``[columns]`` with what a run or table maps of its own."""
    own = {} if entry is None else entry.columns
    return {**base, **{name: ColumnSpec(**column.model_dump()) for name, column in own.items()}}


def add_run(entry: RunEntry, label: str, setup: Setup, out: Assembled) -> None:
    """One entry of ``[[runs]]``: a history, or a row of a table."""
    out.claim(entry.id, label, setup.toml)
    setup = computed(setup, entry)
    request = _request(entry, label, setup, out)
    if request is None:
        return
    specs = specs_of(entry, setup.columns)
    if entry.row is None:
        _add_history(entry, label, request, specs, setup, out)
        return
    table = _table(request, specs, entry.rows, out)
    if table is None:
        return
    chosen, problems = matching_rows(table[0], entry.row, request)
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
        _add_row(entry, entry.id, label, request, table, chosen[0], setup, out)


def add_table(entry: TableEntry, label: str, setup: Setup, out: Assembled) -> None:
    """One entry of ``[[tables]]``: every row that is not left out becomes a run."""
    setup = computed(setup, entry)
    request = _request(entry, label, setup, out)
    if request is None:
        return
    request = replace(request, run=None)
    table = _table(request, specs_of(entry, setup.columns), entry.rows, out)
    if table is None:
        return
    cells, _ = table
    chosen, problems = matching_rows(cells, entry.where, request)
    unknown = sorted(set(entry.skip) - set(cells.lines))
    if unknown:
        problems.append(
            request.problem(
                f"skip names row {', '.join(map(str, unknown))}; rows of numbers are "
                f"{cells.lines[0]} to {cells.lines[-1]}."
            )
        )
    names = filled_in(entry.id, cells, 0)[1]
    problems += [no_column(cells, name, request) for name in names]
    if not problems and not chosen:
        problems.append(request.problem("no row is as stated under where."))
    if len(chosen) > 1 and "{" not in entry.id:
        problems.append(
            Problem(
                message=f"{len(chosen)} rows would all have the id {entry.id!r}.",
                file=setup.toml,
                entry=label,
                remedy='Put a column of theirs in it, e.g. id = "SD_{Run No.}".',
            )
        )
    out.problems += problems
    if problems:
        return
    for index in chosen:
        if cells.lines[index] not in entry.skip:
            run_id = filled_in(entry.id, cells, index)[0]
            place = f"{label}, row {cells.lines[index]} of {entry.file}"
            out.claim(run_id, place, setup.toml)
            _add_row(entry, run_id, place, request, table, index, setup, out)


def _request(entry: FileEntry, label: str, setup: Setup, out: Assembled) -> Request | None:
    free = kind_of(entry.test).free_running
    if free != (setup.kind == "free-running"):
        out.problems.append(
            Problem(
                message=f"test {entry.test!r} is a {'free-running' if free else 'captive'} test, "
                f"the campaign is {setup.kind}.",
                file=setup.toml,
                entry=label,
            )
        )
    found = setup.find(entry.file)
    excluded = any(
        item.action == "exclude" and item.applies_to(entry.id) for item in setup.corrections
    )
    if found is None:
        if not excluded:
            out.problems.append(setup.missing_file(entry.file, label))
            return None
        found = Request(path=Path(entry.file), shown=entry.file)
    return replace(found, run=entry.id, options=merged(setup.options, entry))


def _table(
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


def _windows_fit(
    corrections: Sequence[Correction], why: str, label: str, setup: Setup, out: Assembled
) -> None:
    """Windows are of captive histories; what else they are said of is told why not."""
    if why and any(item.action == "window" for item in corrections):
        message = f"a correction states a window for it, and {why}."
        out.problems.append(Problem(message=message, file=setup.toml, entry=label))


def _add_history(
    entry: RunEntry,
    label: str,
    request: Request,
    specs: Mapping[str, ColumnSpec],
    setup: Setup,
    out: Assembled,
) -> None:
    corrections = _with_tare(entry, _corrections(entry.id, setup))
    given = {**entry.settings(), **_set(corrections)}
    motion = _motion(entry, label, request, setup, out)
    missing = missing_settings(entry.test, given)
    if missing and setup.find(entry.file) is not None:
        try:
            measured = _measured(request, specs) | (_measured(motion, {}) if motion else set())
        except DataError as error:
            out.problems += error.problems
            return
        missing = missing_settings(entry.test, given, measured)
    if _needs(missing, entry.test, label, setup, out):
        return
    frame = replace(setup.frame, nondimensional=request.options.nondimensional)
    found = _settings(entry.test, given, frame, label, setup, out)
    if found is None:
        return
    settings, notes = found
    loader = HistoryLoader(
        request=request,
        columns=MappingProxyType(dict(specs)),
        context=Context(
            ship=setup.ship,
            water=setup.water,
            speed=settings.speed,
            frame=frame,
            corrections=corrections,
            notes=notes,
            antenna=(setup.trial.get("antenna_x", 0.0), setup.trial.get("antenna_y", 0.0)),
            solver=setup.solver,
            test=entry.test,
            settings=settings,
            struts=setup.struts,
        ),
        kind=setup.kind,
        rows=entry.rows,
        motion=motion,
    )
    run = Run(
        id=entry.id,
        test=entry.test,
        kind="history",
        settings=settings,
        loader=loader,
        stated=_numbers(entry.settings()),
        source=entry.file,
        started="" if entry.started is None else entry.started.isoformat(),
    )
    why = "a free-running record is cut with trim" if setup.kind == "free-running" else ""
    _windows_fit(corrections, why, label, setup, out)
    out.runs.append(_said(run, corrections, setup))


def _settings(
    test: str,
    given: Mapping[str, Any],
    frame: Frame,
    label: str,
    setup: Setup,
    out: Assembled,
    *,
    turn_phase: bool = True,
) -> tuple[Settings, tuple[str, ...]] | None:
    """What a test was set to, with its struts, in SI and in words; None where they cannot do it."""
    settings, notes = settings_of(test, given, frame, setup.ship.L, turn_phase=turn_phase)
    try:
        settings, more = on_struts(test, given, settings, setup.struts, frame)
    except ValueError as error:
        out.problems.append(Problem(message=f"{error}.", file=setup.toml, entry=label))
        return None
    return settings, (*notes, *more)


def _measured(request: Request, specs: Mapping[str, ColumnSpec]) -> set[str]:
    """Channels that a file holds."""
    request = at_hand(request)
    reader = reader_for(request)
    names = reader.names(request)
    found, _ = pick(names, len(names), specs, request, usual=reader.usual(names))
    channels = {column.name for column in found}
    return channels | ({"x", "y", "psi"} if channels >= STRUT_CHANNELS else set())


def _motion(
    entry: RunEntry, label: str, request: Request, setup: Setup, out: Assembled
) -> Request | None:
    """The file of the hull's motion beside the one of its forces."""
    if entry.motion is None:
        return None
    found = setup.find(entry.motion)
    if found is None:
        if not any(item.action == "exclude" for item in _corrections(entry.id, setup)):
            out.problems.append(setup.missing_file(entry.motion, label))
        return None
    return replace(found, run=request.run)


def _add_row(
    entry: FileEntry,
    run_id: str,
    label: str,
    request: Request,
    table: tuple[Cells, tuple[Picked, ...]],
    index: int,
    setup: Setup,
    out: Assembled,
) -> None:
    cells, picked = table
    line = cells.lines[index]
    request = replace(request, run=run_id)
    numbers = _row_numbers(cells, picked, index, request, out)
    if numbers is None:
        return
    corrections = _corrections(run_id, setup)
    from_cells = {name: value for name, value in numbers.items() if name in SETTING_UNITS}
    stated = {**entry.settings(), **from_cells}
    given = {**stated, **_set(corrections)}
    kind, values, dimensional = _contents(numbers, picked, request.options.in_phase_with)
    dynamic = kind_of(entry.test).oscillates
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
    if _out_of_range(from_cells, label, setup, out) or _needs(
        missing_settings(entry.test, given, values), entry.test, label, setup, out
    ):
        return
    frame = replace(setup.frame, nondimensional=request.options.nondimensional)
    found = _settings(entry.test, given, frame, label, setup, out, turn_phase=kind == "means")
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
        context=Context(
            ship=setup.ship,
            water=setup.water,
            speed=settings.speed,
            frame=frame,
            corrections=corrections,
            notes=notes,
            solver=setup.solver,
            test=entry.test,
            settings=settings,
        ),
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
        stated=_numbers(stated),
        source=f"{entry.file} row {line}",
    )
    _windows_fit(corrections, "a row of a table has no samples", label, setup, out)
    out.runs.append(_said(run, corrections, setup))


def _row_numbers(
    cells: Cells, picked: Sequence[Picked], index: int, request: Request, out: Assembled
) -> dict[str, float] | None:
    problems: list[Problem] = []
    numbers: dict[str, float] = {}
    line = cells.lines[index]
    for column in picked:
        cell = cells.rows[index][column.position]
        number = to_number(cell, cells.decimal)
        why = fault(number, cell)
        if why is None and number is not None:
            numbers[column.name] = number * column.scale + column.offset
        elif number is not None and number != number and request.options.missing == "drop":
            out.left_out.append(f"{request.shown} row {line}: no value of {column.name}")
            return None
        elif why is not None:
            problems.append(request.problem(why, row=line, column=column.title))
    out.problems += problems
    return None if problems else numbers


def _contents(
    numbers: Mapping[str, float], picked: Sequence[Picked], phase: str | None
) -> tuple[Kind, dict[str, float], frozenset[str]]:
    """Kind of a row, its channels under the names of that kind, and those with a stated unit."""
    names = [name for name in numbers if name not in SETTING_UNITS]
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


def _out_of_range(given: Mapping[str, Any], label: str, setup: Setup, out: Assembled) -> bool:
    from pmmkit.campaigns.file.schema import SettingsEntry, read_entry

    before = len(out.problems)
    read_entry(SettingsEntry, dict(given), file=setup.toml, entry=label, problems=out.problems)
    return len(out.problems) > before


def _needs(missing: Sequence[str], test: str, label: str, setup: Setup, out: Assembled) -> bool:
    if missing:
        out.problems.append(
            Problem(
                message=f"a {test} test needs {', and '.join(missing)}.",
                file=setup.toml,
                entry=label,
            )
        )
    return bool(missing)


def _corrections(run_id: str, setup: Setup) -> tuple[Correction, ...]:
    return tuple(item for item in setup.corrections if item.applies_to(run_id))


def _with_tare(entry: FileEntry, corrections: tuple[Correction, ...]) -> tuple[Correction, ...]:
    """With the tare that a run or the defaults state, before what else is done to its samples."""
    stated = entry.tare
    if stated is None or stated.off or any(item.action == "tare" for item in corrections):
        return corrections
    tare = Correction(
        runs=("*",),
        action="tare",
        reason="tare of the run, or of [defaults]",
        values=MappingProxyType(stated.model_dump(exclude_defaults=True)),
    )
    return (tare, *corrections)


def _set(corrections: Iterable[Correction]) -> dict[str, Any]:
    return {
        name: value
        for correction in corrections
        if correction.action == "set"
        for name, value in correction.values.items()
    }


def _said(run: Run, corrections: Sequence[Correction], setup: Setup) -> Run:
    """The run with what the corrections say of it."""
    forces, use_means = setup.forces, True
    for correction in corrections:
        if correction.action == "inertia still inside":
            forces = "balance"
        elif correction.action == "inertia already removed":
            forces = "hydrodynamic"
        elif correction.action == "drop means":
            use_means = False
    return run.with_(forces=forces, use_means=use_means, corrections=tuple(corrections))


def _numbers(given: Mapping[str, Any]) -> Mapping[str, float]:
    return MappingProxyType(
        {name: float(value) for name, value in given.items() if name in SETTING_UNITS}
    )
