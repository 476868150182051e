"""What puts the runs of a campaign file together: what they share, and a run with a history."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pmmkit.base import DataError
from pmmkit.campaigns.file.faults import Faults
from pmmkit.campaigns.file.schema import SettingsEntry
from pmmkit.campaigns.file.search import Search
from pmmkit.campaigns.file.settings import missing_settings, settings_of
from pmmkit.campaigns.file.struts import on_struts
from pmmkit.campaigns.motion.solver_axes import Solver
from pmmkit.campaigns.run import Run, at_hand
from pmmkit.campaigns.run_settings import setting_units
from pmmkit.campaigns.samples.column_mapping import ColumnSpec, Picked, pick
from pmmkit.campaigns.samples.conversions import Frame
from pmmkit.campaigns.samples.loading import STRUT_CHANNELS, Context, HistoryLoader
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.stated_run import Correction
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
from pmmkit.campaigns.test_kinds.struts import Struts
from pmmkit.conventions import Ship, Water
from pmmkit.readers import Cells, Options, Request, reader_for

if TYPE_CHECKING:
    from pmmkit.campaigns.file.schema import FileEntry, RunEntry

Found = tuple[Cells, tuple[Picked, ...]] | None


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What all runs of a campaign file share.

    `frame`: axes and signs of the source. `corrections`: all corrections of the file. `search`:
    where the files are that the campaign names.
    """

    ship: Ship
    water: Water
    kind: str
    forces: str
    frame: Frame
    options: Options
    columns: Mapping[str, ColumnSpec]
    corrections: tuple[Correction, ...]
    search: Search
    trial: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    solver: Solver = field(default_factory=Solver)
    struts: Struts | None = None


@dataclass
class Assembled(Faults):
    """Runs as they are put together, and everything that is wrong with them."""

    runs: list[Run] = field(default_factory=list)
    ids: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    tables: dict[Any, Found] = field(default_factory=dict)
    incomplete: bool = False

    def claim(self, run_id: str, entry: str) -> None:
        """Note an id; an id that is there already is a problem."""
        if run_id in self.ids:
            self.report(
                f"id {run_id!r} is used twice; the other is {self.ids[run_id]}.",
                entry,
                remedy="Every run needs an id of its own.",
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


def request_of(entry: FileEntry, label: str, setup: Setup, out: Assembled) -> Request | None:
    """What is read for an entry; None with a problem where its file is not there."""
    free = TEST_KINDS[entry.test].free_running
    if free != (setup.kind == "free-running"):
        out.report(
            f"test {entry.test!r} is a {'free-running' if free else 'captive'} test, "
            f"the campaign is {setup.kind}.",
            label,
        )
    found = setup.search.find(entry.file)
    excluded = any(
        item.action == "exclude" and item.applies_to(entry.id) for item in setup.corrections
    )
    if found is None:
        if not excluded:
            out.problems.append(setup.search.missing(entry.file, label, out.file))
            return None
        found = Request(path=Path(entry.file), shown=entry.file)
    return replace(found, run=entry.id, options=merged(setup.options, entry))


def windows_fit(corrections: Sequence[Correction], why: str, label: str, out: Assembled) -> None:
    """Windows are of captive histories; what else they are said of is told why not."""
    if why and any(item.action == "window" for item in corrections):
        out.report(f"a correction states a window for it, and {why}.", label)


def add_history(
    entry: RunEntry,
    label: str,
    request: Request,
    specs: Mapping[str, ColumnSpec],
    setup: Setup,
    out: Assembled,
) -> None:
    """A run with a history of its own."""
    corrections = _with_tare(entry, corrections_of(entry.id, setup))
    given = {**entry.settings(), **set_by(corrections)}
    motion = _motion(entry, label, request, setup, out)
    missing = missing_settings(entry.test, given)
    if missing and setup.search.find(entry.file) is not None:
        try:
            measured = _measured(request, specs) | (_measured(motion, {}) if motion else set())
        except DataError as error:
            out.problems += error.problems
            return
        missing = missing_settings(entry.test, given, measured)
    if needs(missing, entry.test, label, out):
        return
    frame = replace(setup.frame, nondimensional=request.options.nondimensional)
    found = settings_in(entry.test, given, frame, label, setup, out)
    if found is None:
        return
    settings, notes = found
    loader = HistoryLoader(
        request=request,
        columns=MappingProxyType(dict(specs)),
        context=replace(
            context_of(entry.test, settings, frame, corrections, notes, setup),
            antenna=(setup.trial.get("antenna_x", 0.0), setup.trial.get("antenna_y", 0.0)),
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
        stated=numbers_in(entry.settings()),
        source=entry.file,
        started="" if entry.started is None else entry.started.isoformat(),
    )
    why = "a free-running record is cut with trim" if setup.kind == "free-running" else ""
    windows_fit(corrections, why, label, out)
    out.runs.append(said(run, corrections, setup))


def context_of(
    test: str,
    settings: Settings,
    frame: Frame,
    corrections: tuple[Correction, ...],
    notes: tuple[str, ...],
    setup: Setup,
) -> Context:
    """What the numbers of a run must be seen with."""
    return Context(
        ship=setup.ship,
        water=setup.water,
        speed=settings.speed,
        frame=frame,
        corrections=corrections,
        notes=notes,
        solver=setup.solver,
        test=test,
        settings=settings,
    )


def settings_in(
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
        out.report(f"{error}.", label)
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
    found = setup.search.find(entry.motion)
    if found is None:
        if not any(item.action == "exclude" for item in corrections_of(entry.id, setup)):
            out.problems.append(setup.search.missing(entry.motion, label, out.file))
        return None
    return replace(found, run=request.run)


def out_of_range(given: Mapping[str, Any], label: str, out: Assembled) -> bool:
    """Whether settings out of cells are none that a campaign file may state; with problems."""
    from pmmkit.campaigns.file.schema import read_entry

    before = len(out.problems)
    read_entry(SettingsEntry, dict(given), label, out)
    return len(out.problems) > before


def needs(missing: Sequence[str], test: str, label: str, out: Assembled) -> bool:
    """Whether a test lacks settings; with the problem."""
    if missing:
        out.report(f"a {test} test needs {', and '.join(missing)}.", label)
    return bool(missing)


def corrections_of(run_id: str, setup: Setup) -> tuple[Correction, ...]:
    """The corrections that apply to a run."""
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


def set_by(corrections: Iterable[Correction]) -> dict[str, Any]:
    """Settings that corrections state."""
    return {
        name: value
        for correction in corrections
        if correction.action == "set"
        for name, value in correction.values.items()
    }


def said(run: Run, corrections: Sequence[Correction], setup: Setup) -> Run:
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


def numbers_in(given: Mapping[str, Any]) -> Mapping[str, float]:
    """The settings of a mapping that are numbers."""
    return MappingProxyType(
        {name: float(value) for name, value in given.items() if name in setting_units()}
    )
