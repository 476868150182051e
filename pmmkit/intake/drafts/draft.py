"""From what lies in a folder to the runs and tables of a campaign, for a person to check."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Campaign, open_campaign
from pmmkit.conventions import CHANNEL_UNITS, Ship, channel_of, unit_in_name
from pmmkit.intake.blocks import kind_with
from pmmkit.intake.checks.rest import rest_facts, zeros_off
from pmmkit.intake.drafts.columns import GAUGES, ColumnChoice, column_parts, factor_of, with_choices
from pmmkit.intake.drafts.conventions import Proposal
from pmmkit.intake.drafts.matrix import (
    HEADED,
    MatrixDraft,
    as_measured,
    left_lines,
    matrix_of,
    only_sheet,
    prefixes,
    skipped,
    strangers,
    template_of,
    where_of,
)
from pmmkit.intake.drafts.motion import (
    BY_PATH,
    RunFacts,
    drift_column,
    is_track,
    motion_facts,
    on_plane,
    sharper,
    with_drift,
)
from pmmkit.intake.drafts.names import RunKey, facts_of, facts_of_header, settled
from pmmkit.intake.drafts.questions import Found, particulars_of
from pmmkit.intake.drafts.repeats import without_repeats
from pmmkit.intake.file import LARGE, values_of
from pmmkit.intake.folder import FileGroup, Look, look
from pmmkit.intake.guessing import by_size
from pmmkit.intake.seen import ColumnLook, FileLook, SheetBlock
from pmmkit.numerics import Array
from pmmkit.presentation import counted
from pmmkit.readers import READERS


@dataclass(frozen=True, kw_only=True)
class RunDraft:
    """One entry of ``[[runs]]`` or ``[[tables]]``.

    `id, file`: name of the run; its file relative to the campaign file. `look`: how the file is
    read. `test`: kind of test, None where nobody knows. `problems`: what is wrong with its file.
    `motion`: where the motion of the hull lies beside its forces. `sheet`: sheet of the workbook
    that holds the run, where it has several; `group` of a container likewise, and `only` the rows
    of a text. `skip_rows`: lines above its columns. `computation`: what lies beside it, or the
    format says, of what ``[cfd]`` asks. `listed`: whether a matrix says what it was set to.
    `notes`: what of the motion that it was told to make was not followed. `where`: which rows of a
    table are meant, by their columns. `skip`: rows of a table that are not. `samples`: whether rows
    of one id are samples: ``cycle``. `rest`: what the gauges show while the hull stands at the head
    of its record, as `rest_facts` has it. `template`: id of the rows of a table, with columns in
    braces; empty where it is to be found. `columns`: columns that are others than those of all
    tables. `turned`: side to which a positive rudder turned her, as `RunFacts` has it.
    """

    id: str
    file: str
    look: FileLook
    test: str | None
    settings: tuple[RunKey, ...]
    problems: tuple[str, ...] = ()
    motion: str | None = None
    sheet: str | int | None = None
    group: str | None = None
    only: tuple[tuple[str, Any], ...] = ()
    skip_rows: int = 0
    computation: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    listed: bool = False
    notes: tuple[str, ...] = ()
    where: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    skip: tuple[int, ...] = ()
    samples: str | None = None
    rest: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    template: str = ""
    columns: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    turned: int = 0


@dataclass(frozen=True, kw_only=True)
class Draft:
    """What a campaign file is written from.

    `ship_name`: ship of the library. `runs, tables`: histories; tables whose rows are runs.
    `matrices`: tables that list runs: one for the files, one for each workbook with a sheet per
    run. `particulars`: of the model, as a list beside the tests has them, and where.
    `open_water`: file of the propeller's tested curve, empty where there is none or several.
    `proposal`: axes and signs by the physics of all runs; None where they were not asked.
    `saved`: saved campaigns by their files. `unused`: files with numbers that are none of
    these, and why. `named_tests`: those of them that are named as tests; `repeated`: those
    whose rows other tables tell.
    """

    title: str
    kind: str
    ship_name: str | None
    runs: tuple[RunDraft, ...]
    tables: tuple[RunDraft, ...]
    saved: tuple[tuple[str, Campaign], ...]
    unused: tuple[str, ...]
    look: Look
    named_tests: tuple[str, ...] = ()
    repeated: tuple[str, ...] = ()
    matrices: tuple[MatrixDraft, ...] = ()
    particulars: Found = field(default_factory=lambda: MappingProxyType({}))
    open_water: str = ""
    proposal: Proposal | None = None

    @property
    def words(self) -> str:
        """What it is of, in words."""
        parts = [counted(len(self.runs), "history")] if self.runs else []
        parts += [counted(len(self.tables), "table")] if self.tables else []
        parts += [f"{counted(len(campaign), 'run')} of {file}" for file, campaign in self.saved]
        return f"a {self.kind} campaign of {', '.join(parts) or 'no runs'}"


_BODY_MOTION: Final = "postProcessing/sixDoFRigidBodyState"
_NOT_RUNS: Final = {
    "open water": "propeller coefficients; see open_water in [propeller]",
    "unknown": "no column of time, nor of forces and settings",
}


def draft_of(
    folder: Path,
    target: Path,
    *,
    ship: str | None = None,
    choices: Sequence[ColumnChoice] = (),
    sheet: str | None = None,
) -> Draft:
    """What a campaign file for the files of a folder can say."""
    known = _library_ship(ship)
    if not folder.exists():
        raise CampaignError(
            Problem(
                message="there is no such folder.",
                file=str(folder),
                remedy="Name the folder in which the files of the tests lie.",
            )
        )
    found = look(folder) if sheet is None else only_sheet(look(folder), sheet)
    seen = with_drift(with_choices(found, choices))
    place = folder if folder.is_dir() else folder.parent
    base = _relative(place, target)
    saved = [
        (base + item.file, open_campaign(place / item.file))
        for item in seen.campaigns
        if not item.file.endswith(".toml") and not item.problem
    ]
    length = known.L if known else None
    histories = [group for group in seen.groups if group.first.kind == "history"]
    runs = _with_motions([run for group in histories for run in _runs(group, base, length)])
    listed = [
        item for group in seen.groups if group.first.kind == "table" for item in _read_all(group)
    ]
    once = without_repeats(listed)
    listed = list(once.looks)
    apart = prefixes(listed)
    tables = [
        entry if before is None else replace(entry, skip=before.lines, notes=before.notes)
        for item in listed
        for before in (once.skip.get(item.shown),)
        for entry in _tables(item, base, length, prefix=apart[item.shown])
    ]
    if not (runs or tables or saved):
        raise CampaignError(
            Problem(
                message="no file here has samples in time or rows of forces that are recognised.",
                file=str(folder),
                remedy=f"See what they hold: pmmkit inspect {folder}",
            )
        )
    matrices = _matrices(seen, base, runs)
    for matrix in matrices:
        runs = [_as_listed(run, matrix) for run in runs]
    runs = _at_one_speed(_tared(runs))
    listing = [(matrix.look.path, matrix.look.options) for matrix in matrices]
    kind = _kind(runs, tables, saved[0][1].kind if saved else None)
    left = [_does_not_belong(run, kind) for run in runs]
    kept = [run for run, why in zip(runs, left, strict=True) if not why]
    unused = [f"{run.file}: {why}" for run, why in zip(runs, left, strict=True) if why]
    curve = "" if ship else _curve(seen)
    strange = [
        (base + item.shown, group.first.kind)
        for group in seen.groups
        if group.first.kind in _NOT_RUNS
        for item in group.files
        if (item.path, item.options) not in listing and item.shown != curve
    ]
    unused += [f"{shown}: {_NOT_RUNS[what]}" for shown, what in strange]
    unused += [base + text for text in once.told.values()]
    named_tests = [shown for shown, what in strange if what == "unknown" and _named_test(shown)]
    sheets = [str(item.options.sheet) for item in listed if item.options.sheet is not None]
    unused += [line for item in listed for line in (*left_lines(item), *strangers(item, sheets))]
    taken = [run.id for _, campaign in saved for run in campaign]
    particulars, depths = ({}, {}) if ship else particulars_of(_beside(seen, listed), sheets)
    return Draft(
        title=folder.resolve().stem if folder.is_file() else folder.resolve().name,
        kind=kind,
        ship_name=ship,
        runs=_named_apart(_steady_runs(kept), taken),
        tables=_named_apart([_over_its_bottom(entry, depths) for entry in tables]),
        saved=tuple(saved),
        unused=tuple(unused),
        named_tests=tuple(named_tests),
        repeated=tuple(once.told),
        look=seen,
        matrices=matrices,
        open_water=curve and base + curve,
        particulars=particulars,
    )


def _named_test(shown: str) -> bool:
    """Whether a file without samples is named as a test, with what it was set to."""
    found = facts_of(_stem(shown.partition(", ")[0]))
    return found.test is not None and bool(found.settings)


def _curve(seen: Look) -> str:
    """The one file of an open-water test whose coefficients are those of a propeller."""
    found = [x for group in seen.groups if group.first.kind == "open water" for x in group.files]
    alone = found[0] if len(found) == 1 and found[0].path.suffix.lower() == ".csv" else None
    tops = {} if alone is None else {x.header.lower(): x.high for x in alone.columns}
    torque = max(tops.get("kq", 0.0), tops.get("10kq", 0.0) / 10.0)
    sound = 0.0 < tops.get("kt", 0.0) < _LARGEST_KT and 0.0 < torque < _LARGEST_KQ
    return alone.shown if alone is not None and sound else ""


_LARGEST_KT: Final = 1.2
_LARGEST_KQ: Final = 0.2
"""Of the Wageningen B series at J = 0: KT 0.8 and KQ 0.15 for a pitch of 1.4 D."""


def _over_its_bottom(entry: RunDraft, depths: Mapping[str, tuple[float, str]]) -> RunDraft:
    """A table with the depth of its sheet, where sheets differ."""
    if (known := depths.get(str(entry.sheet))) is None:
        return entry
    depth = RunKey(key="depth", value=known[0], reason=known[1])
    return replace(entry, settings=(*entry.settings, depth))


def _beside(seen: Look, tables: Sequence[FileLook]) -> list[FileLook]:
    """Sheets of the workbooks of tests that hold no runs, then texts beside them."""
    sheets = [item for group in seen.groups for item in group.files if item.has_sheets]
    books = {item.path for item in (*tables, *sheets)}
    looks = [item for group in seen.groups for item in group.files if item.kind == "unknown"]
    own = [item for item in (*looks, *seen.without_table) if item.path in books]
    return [*own, *(item for item in seen.without_table if not item.has_sheets)]


def _matrices(seen: Look, base: str, runs: Sequence[RunDraft]) -> tuple[MatrixDraft, ...]:
    """The tables that list the runs of the layout that most of them have, one for each workbook."""
    counted = Counter(id(run.look) for run in runs)
    likes = [run for run in runs if id(run.look) == max(counted, key=lambda key: counted[key])]
    looks = [
        item for group in seen.groups if group.first.kind == "unknown" for item in _read_all(group)
    ]
    books = dict.fromkeys(run.file if run.sheet is not None else None for run in likes)
    found = []
    for book in books:
        own = [run for run in likes if (run.file if run.sheet is not None else None) == book]
        places = [run.file if book is None else str(run.sheet) for run in own if not run.problems]
        beside = [item for item in looks if base + item.file == book]
        matrix = matrix_of(beside, base, places, book) or matrix_of(looks, base, places, book)
        found += [] if matrix is None else [matrix]
    names = Counter(name for matrix in found for name in matrix.runs)
    return tuple(
        matrix
        if matrix.run_sheet is None or all(names[name] == 1 for name in matrix.runs)
        else replace(matrix, id=f"{PurePosixPath(_stem(matrix.run)).name}_{matrix.id}")
        for matrix in found
    )


def _as_listed(run: RunDraft, matrix: MatrixDraft) -> RunDraft:
    """A run with what a matrix says of it; only a speed that it does not say is still asked."""
    place = run.file if matrix.run_sheet is None else str(run.sheet)
    if place not in matrix.runs or (matrix.run_sheet is not None and run.file != matrix.run):
        return run
    left = () if "speed" in matrix.settings else ("speed",)
    return replace(
        run,
        test=matrix.runs[place],
        settings=tuple(item for item in run.settings if item.key in left),
        listed=True,
    )


_SAME_SPEED: Final = 0.01
"""Share by which speeds of yaw tests may differ that are one."""


def _at_one_speed(runs: Sequence[RunDraft]) -> list[RunDraft]:
    """Runs with the speed that the yaw tests among them show, where nothing else tells one."""
    keys = [x for run in runs for x in run.settings if x.key == "speed" and x.value is not None]
    told = np.array([x.value for x in keys if BY_PATH in x.reason])
    if not told.size or told.size < len(keys) or np.ptp(told) > _SAME_SPEED * told.mean():
        return list(runs)
    speed = RunKey(
        key="speed",
        value=float(f"{np.median(told):.4g}"),
        reason=f"{BY_PATH}, {counted(told.size, 'run')}",
        todo="if a run had another speed",
    )
    return [
        replace(run, settings=tuple(speed if x.key == "speed" else x for x in run.settings))
        for run in runs
    ]


def _tared(runs: Sequence[RunDraft]) -> list[RunDraft]:
    """Runs that begin at rest, their zeros to be taken off where gauges stand off there.

    Runs that a matrix lists have no lines of their own: of them all must begin at rest.
    """
    standing = [run for run in runs if run.rest]
    off = zeros_off([run.rest for run in standing])
    if not off or (any(run.listed for run in runs) and len(standing) < len(runs)):
        return list(runs)
    told = ", ".join(f"{name} {zero:.3g} {CHANNEL_UNITS[name]}" for name, (zero, *_) in off.items())
    reason = f"the gauges show {told} at the rest before {'these' if standing[1:] else 'this'} run"
    tare = RunKey(key="tare", value=True, reason=reason + "s" * bool(standing[1:]))
    return [replace(run, settings=(*run.settings, tare)) if run.rest else run for run in runs]


def _library_ship(name: str | None) -> Ship | None:
    if name is None:
        return None
    from pmmkit.models import load_ship

    return load_ship(name)


def _relative(folder: Path, target: Path) -> str:
    """What stands before the names of files, seen from the campaign file."""
    try:
        path = os.path.relpath(folder.resolve(), target.resolve().parent)
    except ValueError:
        path = str(folder.resolve())
    plain = path.replace("\\", "/")
    return "" if plain == "." else f"{plain}/"


def _runs(group: FileGroup, base: str, length: float | None) -> list[RunDraft]:
    """The histories of a group, each with what its name and its record say."""
    wanted = {
        _channel(column): column
        for column in group.first.columns
        if column.suggestion and column.suggestion.certainty != "perhaps"
    }
    clock = group.first.known["t"]
    drift = drift_column(group.first)
    drafts = []
    sizes: dict[str, float] = {}
    for item in group.files:
        named, headed = facts_of(_name(item)), facts_of_header(item.lines_above)
        here, own, asked = _in_seconds(clock, named, headed)
        columns = {**wanted, "t": here, **({} if drift is None else {"drift": drift})}
        alike = replace(item, kind="history", columns=group.first.columns)
        channels, problems = _channels(alike, columns)
        time = channels.pop("t", np.zeros(0)) if not asked else np.zeros(0)
        channels = on_plane(time, channels)
        for name, numbers in channels.items():
            sizes[name] = max(sizes.get(name, 0.0), _size(numbers))
        test = named.test or headed.test
        moved = motion_facts(time, channels, test) if len(time) else RunFacts()
        told = _told(item, test)
        moved = replace(
            moved, test=moved.test or told.test, settings={**moved.settings, **told.settings}
        )
        test = sharper(test or moved.test, moved)
        motion = _motion_beside(item, base)
        rest = rest_facts(time, channels, {}) if len(time) else {}
        settings = settled(test, named, moved, headed, length=length)
        if rest and motion is None and _phase_unknown(test, channels):
            settings = (*settings, _PHASE)
        settings = (*(x for x in settings if x.key not in {y.key for y in asked}), *asked)
        drafts.append(
            RunDraft(
                id=PurePosixPath(_name(item)).name,
                file=base + item.file,
                sheet=item.options.sheet,
                group=item.options.group,
                only=item.options.where,
                skip_rows=item.options.skip_rows,
                look=group.first,
                test=test,
                settings=tuple(x for x in settings if motion is None or "amplitude" not in x.key),
                problems=problems,
                motion=motion,
                notes=READERS[item.format].prescribed(item.request)[1],
                computation=_computation(item, test),
                columns=own,
                rest=rest,
                turned=moved.turned,
            )
        )
    told_by_all = _by_sizes(group, sizes)
    return drafts if told_by_all == group else _runs(told_by_all, base, length)


def _in_seconds(
    clock: ColumnLook, named: RunFacts, headed: RunFacts
) -> tuple[ColumnLook, dict[str, Any], tuple[RunKey, ...]]:
    """The column of time of a run, what the run must say of it, and what is asked: a time that
    counts in periods needs the period of each."""
    if clock.suggestion is None or not clock.suggestion.of_period:
        return clock, {}, ()
    told = named.settings.get("period") or headed.settings.get("period")
    period = None if told is None else told[0]
    if period is None:
        shown = f'columns = {{ t = {{ name = "{clock.title}", unit = "s", scale = … }} }}'
        todo = f"period [s], by which {clock.title} is to be multiplied: {shown}"
        return clock, {}, (RunKey(key="period", value=None, todo=todo, active=False),)
    own = {"t": {"name": clock.title, "unit": "s", "scale": period}}
    return replace(clock, suggestion=replace(clock.suggestion, scale=period)), own, ()


def _with_motions(runs: Sequence[RunDraft]) -> list[RunDraft]:
    """Records of forces alone, each with the record of the motion alone that has its name but for
    words such as forces and motion; the others as they are."""
    forces, motions = (
        _by_name(run for run in runs if holds(set(run.look.known))) for holds in (_forced, _moved)
    )
    joined = {
        name: motions[name]
        for name in forces.keys() & motions.keys()
        if _one_clock(forces[name].look, motions[name].look)
    }
    used = {id(run) for run in joined.values()}
    found = []
    for run in runs:
        name = _bare_name(run)
        if forces.get(name) is run and name in joined:
            own = joined[name]
            run = replace(
                run,
                id=PurePosixPath(name).name,
                test=own.test or run.test,
                settings=own.settings,
                problems=(*run.problems, *own.problems),
                motion=own.file,
                columns={**run.columns, **_path_columns(own.look)},
                turned=own.turned,
            )
        if id(run) not in used:
            found.append(run)
    return found


def _forced(known: set[str]) -> bool:
    return bool(known & _FORCES) and not known & _MOTION


def _moved(known: set[str]) -> bool:
    return bool(known & {"y", "psi"}) and not known & _FORCES


def _one_clock(look: FileLook, other: FileLook) -> bool:
    """Whether one line says where the time stands in two files."""
    own, theirs = look.known["t"].title, other.known["t"].title
    return own == theirs != ""


def _path_columns(look: FileLook) -> dict[str, Any]:
    """Where place and heading stand in a file of the motion."""
    return {
        name: column_parts(column, column.suggestion, look)
        for name, column in look.known.items()
        if column.suggestion and column.suggestion.certainty != "perhaps" and name in _MOTION
    }


def _by_name(runs: Iterable[RunDraft]) -> dict[str, RunDraft]:
    """Runs by their names, those that share one left out."""
    named: dict[str, list[RunDraft]] = {}
    for run in runs:
        named.setdefault(_bare_name(run), []).append(run)
    return {name: own[0] for name, own in named.items() if len(own) == 1}


def _bare_name(run: RunDraft) -> str:
    parts = PurePosixPath(run.file).with_suffix("").parts
    return "/".join(filter(None, (_PART.sub("", part) for part in parts)))


_FORCES: Final = frozenset({"X", "Y", "N", "K"}) | GAUGES
_MOTION: Final = frozenset({"x", "y", "psi", "psi_deg", "u", "v", "r", "y_forward", "y_aft"})
_PART: Final = re.compile(
    r"(?:^|(?<=[a-z\d])[_\-. ]+)(?:forces?|loads?|balance|gauges?|dyn(?:amometer)?|motions?|"
    r"kin(?:ematics?)?|track(?:ing)?|mocap|pos(?:itions?)?|trajectory)(?=$|[_\-. ])",
    re.IGNORECASE,
)
"""Which part of a test a file holds, in its name or in that of its folder."""


def _size(numbers: Array) -> float:
    """The largest number of a channel, of one that goes one way all the time (an arm) its start."""
    if not numbers.size:
        return 0.0
    one_way = abs(numbers[-1] - numbers[0]) > 0.9 * np.ptp(numbers) > 0.0
    return float(abs(numbers[0]) if one_way else np.abs(numbers).max())


def _by_sizes(group: FileGroup, sizes: Mapping[str, float]) -> FileGroup:
    """With units that the first file does not tell and the largest numbers of all files do."""
    towed = bool({"X", "Y", "N"} & {*sizes})
    columns = tuple(
        replace(column, suggestion=by_size(item, sizes.get(_channel(column), 0.0), towed=towed))
        if (item := column.suggestion) is not None
        and item.certainty != "perhaps"
        and (item.unit, column.unit, unit_in_name(item.name)) == (None, None, None)
        else column
        for column in group.first.columns
    )
    return replace(group, files=(replace(group.first, columns=columns), *group.files[1:]))


_PHASE: Final = RunKey(
    key="phase_deg",
    value=None,
    todo="phase of the motion at t = 0: it is not recorded, and the record begins at rest",
    active=False,
)


def _phase_unknown(test: str | None, channels: Mapping[str, Array]) -> bool:
    """Whether nothing recorded tells where a swing stands."""
    kind = None if test is None else TEST_KINDS[test]
    if kind is None or not (kind.captive and kind.oscillates):
        return False
    return not any(told.channel in channels for told in kind.phase_channels)


def _told(item: FileLook, test: str | None) -> RunFacts:
    """What the path says that the hull was told to follow, where one lies beside the file."""
    path, _ = READERS[item.format].prescribed(item.request)
    if not path:
        return RunFacts()
    found = motion_facts(path["t"], {name: path[name] for name in ("y", "psi")}, test)
    if _only_turns(path):
        found = RunFacts(settings=found.settings)
    along = np.polyfit(path["t"], path["x"], 1)[0]
    settings = {key: (value, f"told to: {why}") for key, (value, why) in found.settings.items()}
    if abs(along) > _AT_REST:
        settings["speed"] = (float(f"{abs(along):.5g}"), "told to: velocity along x")
    return RunFacts(test=found.test, settings=settings)


def _only_turns(path: Mapping[str, Array]) -> bool:
    """Whether a hull turns to and fro without going aside: no test that only yaws."""
    return bool(np.ptp(path["psi"]) > 0 and np.ptp(path["y"]) == 0)


_AT_REST: Final = 0.01
"""Speed of a mesh below which it stays where it is, and the inflow has the speed [m/s]."""


def _computation(item: FileLook, test: str | None) -> dict[str, Any]:
    """What is known of the computation; of a hull that oscillates the mesh moves."""
    reader = READERS[item.format]
    moves = test is not None and TEST_KINDS[test].captive and TEST_KINDS[test].oscillates
    return {**(reader.of_moving_mesh if moves else {}), **reader.computation(item.request)}


def _motion_beside(item: FileLook, base: str) -> str | None:
    """The rigid body motion that a case of OpenFOAM recorded beside its forces."""
    found = item.path / _BODY_MOTION
    return f"{base}{item.shown}/{_BODY_MOTION}" if found.is_dir() else None


def _channels(
    item: FileLook, columns: dict[str, ColumnLook]
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Channels in SI without the rows that are damaged, and what is wrong with the file."""
    if item.path.is_file() and item.path.stat().st_size > LARGE:
        return {}, ("too large to be read for a draft: its motion was not looked at",)
    values = values_of(item, [column.position for column in columns.values()])
    problems = tuple(str(problem) for problem in values.problems)
    if any(column.position not in values.numbers for column in columns.values()):
        return {}, problems
    found = {
        name: values.numbers[column.position] * factor_of(column)
        for name, column in columns.items()
    }
    whole = np.all([np.isfinite(numbers) for numbers in found.values()], axis=0)
    return {name: numbers[whole] for name, numbers in found.items()}, problems


def _channel(column: ColumnLook) -> str:
    return channel_of(column.suggestion.name) if column.suggestion else ""


def _table(item: FileLook, base: str, length: float | None) -> RunDraft:
    """A table whose rows are runs; its columns give most settings."""
    file, sheet = item.shown.partition(", sheet ")[::2]
    named = facts_of("/".join(part for part in (_stem(file), sheet) if part))
    known = set(item.known)
    if "u" in known:
        known |= {"speed"}
    if "frequency_hz" in known:
        known |= {"period"}
    if "r_amplitude" in known:
        known |= {"yaw_rate"}
    if known & {"v_amplitude", "vdot_amplitude"}:
        known |= {"amplitude_m"}
    if known & {"path_amplitude_m", "r_amplitude", "rdot_amplitude"}:
        known |= {"yaw_amplitude_deg"}
    captive = named.test is not None and TEST_KINDS[named.test].captive
    test = named.test if captive else _test_of_table(known)
    settings = settled(test, named, RunFacts(), length=length)
    return RunDraft(
        id=f"{PurePosixPath(_stem(file)).name}{'_' + sheet if sheet else ''}",
        file=base + file,
        sheet=item.options.sheet,
        look=item,
        test=test,
        settings=tuple(setting for setting in settings if setting.key not in known),
        problems=tuple(str(problem) for problem in item.problems),
    )


def _tables(item: FileLook, base: str, length: float | None, *, prefix: str) -> list[RunDraft]:
    """The tables of a sheet, one a block of its runs, their ids behind a prefix."""
    whole = _table(item, base, length)
    blocks = item.blocks
    if not blocks.mixed:
        return [whole]
    found = []
    for block in blocks.runs:
        test = block.test or whole.test
        cycle = block.what == "cycle"
        held = [x for x in whole.settings if not cycle or x.key not in _IN_A_CYCLE]
        swept = "the rudder swings slowly: its rows are not as independent as steady tests"
        notes = [swept] if block.what == "sweep" else []
        notes += [HEADED] if block.headed else []
        columns = as_measured(item, block)
        found.append(
            replace(
                whole,
                problems=_problems_of(item, block, columns),
                id=f"{whole.id}_{block.words[0] if block.words else block.what}_{test or ''}",
                test=test,
                settings=tuple(held),
                where=where_of(block, blocks),
                skip=skipped(block, blocks),
                samples="cycle" if cycle else None,
                template=template_of(block, blocks, prefix),
                notes=tuple(notes),
                columns=columns,
            )
        )
    return found


def _problems_of(item: FileLook, block: SheetBlock, columns: Mapping[str, Any]) -> tuple[str, ...]:
    """What is wrong in the rows of a block, in columns that they use."""
    used = {**{name: column.title for name, column in item.known.items()}, **columns}.values()
    return tuple(
        str(problem)
        for problem in item.problems
        if (problem.row is None or problem.row in block.lines)
        and (problem.column is None or problem.column in used)
    )


_IN_A_CYCLE: Final = ("speed", "period", "amplitude_m", "yaw_amplitude_deg")
"""Settings that the motion within a cycle tells."""


def _test_of_table(known: set[str]) -> str | None:
    if "rudder_amplitude_deg" in known:
        return "harmonic_rudder"
    held = [name for name in ("drift", "rudder") if RUN_SETTINGS.key_of(name) in known]
    kind = kind_with(held=held) if len(held) == 2 or (held and "period" not in known) else None
    return kind.name if kind else None


def _read_all(group: FileGroup) -> list[FileLook]:
    """Each file of a group of tables as it was looked at, its columns those of the first."""
    first = group.first
    return [first] + [
        replace(
            first,
            path=item.path,
            shown=item.shown,
            options=item.options,
            blocks=item.blocks,
            problems=(),
        )
        for item in group.files[1:]
    ]


def _kind(runs: Sequence[RunDraft], tables: Sequence[RunDraft], saved: str | None) -> str:
    """Free-running where most histories are of such tests."""
    if saved is not None:
        return saved
    counted = Counter(
        (run.test is not None and TEST_KINDS[run.test].free_running) or is_track(run.look.known)
        for run in runs
    )
    return "free-running" if counted[True] > counted[False] + len(tables) else "captive"


def _does_not_belong(run: RunDraft, kind: str) -> str:
    """Why a record is no run of a campaign of that kind; empty where it may be one."""
    test = None if run.test is None else TEST_KINDS[run.test]
    if test is not None and test.free_running != (kind == "free-running"):
        return f"a {run.test} test does not belong to a {kind} campaign"
    slowest = RUN_SETTINGS["speed"].bounds.least or 0.0
    speeds = [x.value for x in run.settings if x.key == "speed" and x.value is not None]
    still = test is not None and test.captive and not test.at_rest
    if still and kind == "captive" and any(abs(speed) < slowest for speed in speeds):
        return (
            "the carriage stands still: no run of a moving model. If a known weight hung on it, "
            'write it as a run with test = "check_load"'
        )
    return ""


def _steady_runs(runs: Sequence[RunDraft]) -> list[RunDraft]:
    """A straight run without drift among runs of static drift is the one at zero."""
    if not any(run.test == "static_drift" for run in runs):
        return list(runs)
    return [
        replace(run, test="static_drift", settings=(*run.settings, _NO_DRIFT))
        if run.test == "resistance" and not run.listed and facts_of(_stem(run.file)).test is None
        else run
        for run in runs
    ]


_NO_DRIFT: Final = RunKey(key="drift_deg", value=0.0, reason="no drift is recorded")


def _named_apart(runs: Sequence[RunDraft], taken: Collection[str] = ()) -> tuple[RunDraft, ...]:
    """Ids of their own: with the folders, where files of several folders have the same name."""
    counted = Counter([run.id for run in runs] + list(taken))
    apart = [replace(run, id=_with_folders(run)) if counted[run.id] > 1 else run for run in runs]
    seen = Counter(taken)
    out = []
    for run in apart:
        seen[run.id] += 1
        out.append(run if seen[run.id] == 1 else replace(run, id=f"{run.id}_{seen[run.id]}"))
    return tuple(out)


def _name(item: FileLook) -> str:
    """What names a run: the file without suffix, and what of it where it holds several."""
    part = item.options.group if item.options.sheet is None else item.options.sheet
    for name, value in item.options.where:
        part = value if isinstance(value, str) else f"{name}_{value}"
    return _stem(item.file) if part is None else f"{_stem(item.file)}/{str(part).replace('/', '-')}"


def _with_folders(run: RunDraft) -> str:
    stem = _stem(run.file).replace("../", "").replace("/", "_")
    return stem if run.sheet is None else f"{stem}_{run.sheet}"


def _stem(shown: str) -> str:
    """The name without suffix; what follows the point of a number is none."""
    return re.sub(r"\.[A-Za-z]\w{0,5}$", "", shown.partition(", sheet ")[0])
