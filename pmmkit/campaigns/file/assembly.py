"""What puts the runs of a campaign file together: what they share, and a run with a history."""

from __future__ import annotations

import glob
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError, Problem
from pmmkit.campaigns.file.schema import MatrixEntry, SettingsEntry
from pmmkit.campaigns.file.search import Search
from pmmkit.campaigns.file.settings import missing_settings, settings_of
from pmmkit.campaigns.file.single_tables import Faults
from pmmkit.campaigns.run import Run, at_hand
from pmmkit.campaigns.run_settings import RUN_SETTINGS
from pmmkit.campaigns.samples.column_mapping import ColumnSpec, Picked, pick
from pmmkit.campaigns.samples.conversions import Frame, Solver
from pmmkit.campaigns.samples.loading import STRUT_CHANNELS, Context, HistoryLoader
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.stated_run import Correction
from pmmkit.campaigns.test_kinds.kind import TEST_KINDS, Struts
from pmmkit.conventions import Ship, Water
from pmmkit.readers import Cells, Options, Request, as_text, reader_for

if TYPE_CHECKING:
    from pmmkit.campaigns.file.schema import FileEntry, RunEntry


# Two struts: what a run states of them, as settings of the motion that they make.


SWAYS: Final = 0.02
"""Share of the carriage's speed up to which a test counts as pure yaw."""
_KEYS: Final = ("strut_amplitude_m", "strut_phase_deg")


def on_struts(
    test: str, given: Mapping[str, Any], settings: Settings, struts: Struts | None, frame: Frame
) -> tuple[Settings, tuple[str, ...]]:
    """Settings with the motion of two struts, where a run states it, and that in words.

    Without ``strut_phase_deg`` the struts of pure sway go together, and those of pure yaw lead by
    2 atan(ωb/2U), at which the hull follows its heading.
    """
    stated = [name for name in _KEYS if name in given]
    if not stated:
        return settings, ()
    kind = TEST_KINDS[test]
    if not (kind.sways or kind.yaws):
        raise ValueError(f"a {test} test is not made by two struts: leave {stated[0]} out")
    if struts is None:
        raise ValueError("strut_amplitude_m needs the distance of the struts: [struts] spacing")
    if "strut_amplitude_m" not in given:
        raise ValueError("strut_phase_deg needs strut_amplitude_m, the amplitude of each strut")
    omega = settings.omega
    if omega is None:
        raise ValueError("strut_amplitude_m needs the period")
    own = struts.of_pure_yaw(omega, settings.speed) if kind.yaws else 0.0
    phase = own if "strut_phase_deg" not in given else math.radians(given["strut_phase_deg"])
    midway, heading = struts.swing(given["strut_amplitude_m"], phase)
    sideways = abs(midway * omega - settings.speed * math.tan(heading))
    if kind.sways and not kind.yaws and abs(heading) > 0.0:
        raise ValueError(
            f"struts {math.degrees(phase):.4g}° apart turn the hull by "
            f"{math.degrees(heading):.3g}°: a pure_sway test has strut_phase_deg = 0, and this one "
            "is a sway_yaw test"
        )
    if kind.yaws and not kind.sways and sideways > SWAYS * settings.speed:
        raise ValueError(
            f"struts {math.degrees(phase):.4g}° apart let the hull sway by {sideways:.3g} m/s: at "
            f"{settings.speed:g} m/s, T = {settings.period:g} s and {struts.spacing:g} m between "
            f"them yaw alone has strut_phase_deg = {math.degrees(own):.4g}, and this one is a "
            "sway_yaw test"
        )
    # The heading goes by the y of the struts, whichever way their x axis points.
    half = math.pi if frame.motion_sign(test) != frame.sign("y") else 0.0
    both = kind.sways and kind.yaws
    return (
        replace(
            settings,
            amplitude=midway,
            yaw_amplitude=(-heading if both else heading) if kind.yaws else None,
            phase=settings.phase + half,
            strut_spacing=struts.signed,
            strut_centre=struts.centre,
        ),
        (
            f"struts {struts.spacing:g} m apart, the forward one leads by "
            f"{math.degrees(phase):.6g}°: the point midway goes {midway:.6g} m, the heading "
            f"{math.degrees(heading):.6g}°",
        ),
    )


Found = tuple[Cells, tuple[Picked, ...]] | None


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What all runs of a campaign file share.

    `frame`: axes and signs of the source. `corrections`: all corrections of the file. `search`:
    where the files are that the campaign names. `planned`: whether runs may be still to be made.
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
    side_gauges: tuple[float, float] | None = None
    planned: bool = False


@dataclass
class Assembled(Faults):
    """Runs as they are put together, and everything that is wrong with them."""

    runs: list[Run] = field(default_factory=list)
    ids: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    not_made: list[str] = field(default_factory=list)
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


def left_where_not_made(entry: RunEntry, setup: Setup, out: Assembled) -> Setup:
    """The setup with the exclusion of a run of a programme that has no file yet."""
    if not setup.planned or entry.row is not None or setup.search.find(entry.file) is not None:
        return setup
    out.not_made.append(entry.id)
    reason = f"not made yet: there is no {entry.file}"
    own = Correction(runs=(glob.escape(entry.id),), action="exclude", reason=reason)
    return replace(setup, corrections=(*setup.corrections, own))


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
    corrections = _with_tare(entry, corrections_of(entry.id, entry.test, setup))
    given = {**entry.settings(), **set_by(corrections)}
    motion = _motion(entry, label, request, setup, out)
    missing = missing_settings(entry.test, given)
    if missing and setup.search.find(entry.file) is not None:
        try:
            measured = _measured(request, specs) | (_measured(motion, specs) if motion else set())
        except DataError as error:
            out.problems += error.problems
            return
        missing = missing_settings(entry.test, given, measured)
    if needs(missing, entry.test, label, out):
        return
    frame = frame_of(entry.test, request, setup)
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


def frame_of(test: str, request: Request, setup: Setup) -> Frame:
    """How the numbers of a file differ from ours; at rest nothing is made non-dimensional."""
    system = None if TEST_KINDS[test].at_rest else request.options.nondimensional
    return replace(setup.frame, nondimensional=system)


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
        side_gauges=setup.side_gauges,
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
        if not any(
            item.action == "exclude" for item in corrections_of(entry.id, entry.test, setup)
        ):
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


def corrections_of(run_id: str, test: str, setup: Setup) -> tuple[Correction, ...]:
    """The corrections that apply to a run; what is said of all runs and of how a test goes does
    not mean one at rest."""
    found = tuple(item for item in setup.corrections if item.applies_to(run_id))
    if not TEST_KINDS[test].at_rest:
        return found
    return tuple(x for x in found if x.action not in _OF_MOTION or "*" not in x.runs)


_OF_MOTION: Final = ("tare", "trim", "window", "set", "drop means")
"""What is done to a test because of its motion and its record."""


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
        {name: float(value) for name, value in given.items() if name in RUN_SETTINGS.units}
    )


# ``[[matrix]]``: a table that says of each run what it was set to and where its history lies.


_NOTHING: Final = ("", "-", "–", "—", "/")
"""Cells that say that a test has no such setting."""


def entries_of(
    matrix: MatrixEntry, label: str, setup: Setup, out: Assembled
) -> Iterator[tuple[str, dict[str, Any]]]:
    """An entry of ``[[runs]]`` for every row that is not left out, with its place in words."""
    found = setup.search.find(matrix.file)
    if found is None:
        out.problems.append(setup.search.missing(matrix.file, label, out.file))
        out.incomplete = True
        return
    stated = {} if matrix.source is None else matrix.source.model_dump(exclude_unset=True)
    request = replace(found, options=Options(**stated))
    try:
        request = at_hand(request)
        cells = reader_for(request).cells(request)
    except DataError as error:
        out.problems += error.problems
        out.incomplete = True
        return
    specs = {name: ColumnSpec(**item.model_dump()) for name, item in matrix.columns.items()}
    picked, problems = pick(cells.headers, len(cells.headers), specs, request, table=True)
    chosen, unfit = cells.matching_rows(matrix.where, request)
    templates = " ".join((matrix.id, matrix.test, matrix.run, matrix.run_sheet or ""))
    problems += [
        *unfit,
        *(cells.no_column(name, request) for name in cells.filled_in(templates, 0)[1]),
    ]
    out.problems += problems
    if problems:
        out.incomplete = True
        return
    settings = [column for column in picked if column.name in RUN_SETTINGS.units]
    for index in chosen:
        line = cells.lines[index]
        if line not in matrix.skip:
            place = f"{label}, row {line} of {matrix.file}"
            yield place, _entry(matrix, cells, settings, index, request, out)


def _entry(
    matrix: MatrixEntry,
    cells: Cells,
    settings: list[Picked],
    index: int,
    request: Request,
    out: Assembled,
) -> dict[str, Any]:
    """A row as an entry of ``[[runs]]``."""

    def filled(template: str) -> str:
        return cells.filled_in(template, index)[0].strip()

    line = cells.lines[index]
    entry: dict[str, Any] = {"id": filled(matrix.id), "file": filled(matrix.run)}
    word = filled(matrix.test)
    test = matrix.tests.get(word, word)
    if test not in TEST_KINDS:
        out.problems.append(_unknown(word, test, line, request))
        out.incomplete = True
    else:
        entry["test"] = test
    if matrix.run_sheet is not None:
        entry["source"] = {"sheet": filled(matrix.run_sheet)}
    for column in settings:
        if as_text(cells.rows[index][column.position]) in _NOTHING:
            continue
        number, why = cells.number_at(index, column.position)
        if why is not None or number is None:
            problem = request.problem(why or "this is no number.", row=line, column=column.title)
            out.problems.append(problem)
        else:
            entry[column.name] = number * column.scale + column.offset
    return {**matrix.settings(), **entry}


def _unknown(word: str, test: str, line: int, request: Request) -> Problem:
    known = f'tests = {{ "{word}" = "static_drift" }}' if word == test else TEST_KINDS.unknown(test)
    return request.problem(
        f"{test!r} is no kind of test.",
        row=line,
        remedy=f"Say under [[matrix]] which it is, e.g. {known}.",
    )
