"""``[defaults]``, ``[[matrix]]``, ``[[runs]]`` and ``[[tables]]`` of a draft."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from pmmkit.base import DataError
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Run, settings_by_key
from pmmkit.files import toml_string
from pmmkit.intake.drafts.columns import (
    Todo,
    aligned,
    column_lines,
    source_lines,
    their_column,
    toml,
)
from pmmkit.intake.drafts.computed import Computed
from pmmkit.intake.drafts.draft import RunDraft
from pmmkit.intake.drafts.matrix import MatrixDraft
from pmmkit.intake.drafts.settle import RunKey, asked_of
from pmmkit.intake.drafts.sheets import where_line
from pmmkit.intake.seen import FileLook
from pmmkit.presentation import printable
from pmmkit.readers import READERS

# What the runs of a draft have in common, to be stated once.


_ASKED_ONCE: Final = ("speed", "period")
"""Settings that whole programmes share: where no run knows them they are asked for once."""


@dataclass(frozen=True, kw_only=True)
class Common:
    """Runs and what they share.

    `every`: what all runs have. `of_kind`: what all runs of a kind of test have. `runs,
    tables`: with what is left of their settings.
    """

    every: tuple[RunKey, ...]
    of_kind: Mapping[str, tuple[RunKey, ...]]
    runs: tuple[RunDraft, ...]
    tables: tuple[RunDraft, ...]


def in_common(runs: Sequence[RunDraft], tables: Sequence[RunDraft]) -> Common:
    """The settings that all runs, or all of a kind, have alike, taken out of them."""
    entries = [*runs, *tables]
    shared = _shared(entries)
    every = tuple(item for item in shared if item.key == "speed")
    entries = _without(entries, every)
    tests = dict.fromkeys(entry.test for entry in entries if entry.test is not None)
    of_kind = {}
    for test in tests:
        own = _shared([entry for entry in entries if entry.test == test])
        if own:
            of_kind[test] = own
            entries = _without(entries, own, test)
    return Common(
        every=every,
        of_kind=of_kind,
        runs=tuple(entries[: len(runs)]),
        tables=tuple(entries[len(runs) :]),
    )


def _shared(entries: Sequence[RunDraft]) -> tuple[RunKey, ...]:
    """Settings that two or more entries have, and all that have them alike."""
    found: dict[str, list[RunKey]] = {}
    for entry in entries:
        for item in entry.settings:
            found.setdefault(item.key, []).append(item)
    return tuple(
        _one(items)
        for key, items in found.items()
        if len(items) > 1
        and len({(item.value, item.todo, item.active) for item in items}) == 1
        and ((items[0].active and not items[0].todo) or (key in _ASKED_ONCE and not items[0].value))
    )


def _one(items: Sequence[RunKey]) -> RunKey:
    """The setting of all, with the reasons of the first few."""
    reasons = list(dict.fromkeys(item.reason for item in items if item.reason))
    more = f" and {len(reasons) - 1} more" if len(reasons) > 1 else ""
    return replace(items[0], reason=f"{reasons[0]}{more}" if reasons else "")


def _without(
    entries: Sequence[RunDraft], items: Sequence[RunKey], test: str | None = None
) -> list[RunDraft]:
    keys = {item.key for item in items}
    return [
        replace(entry, settings=tuple(item for item in entry.settings if item.key not in keys))
        if test in (None, entry.test)
        else entry
        for entry in entries
    ]


def default_lines(common: Common, computed: Computed, todo: Todo) -> list[str]:
    """What runs have in common, and what is asked for all of them at once."""
    tests = dict.fromkeys([*common.of_kind, *computed.of_kind])
    lines: list[str] = []
    guessed = guessed_source(common.tables)
    for key in guessed:
        todo.add(f"{key}: {_ASKED_OF_TABLES[key]}")
    for name, items, cfd in (
        ("defaults", common.every, None),
        *((f"defaults.{x}", common.of_kind.get(x, ()), computed.of_kind.get(x)) for x in tests),
    ):
        asked = guessed if name == "defaults" else {}
        if not items and cfd is None and not asked:
            continue
        lines += ["", f"[{name}]"]
        for item in items:
            lines.append(_line(item))
            if item.todo:
                todo.add(f"[{name}] {_question(item)}.")
        if cfd is not None:
            lines.append(f"cfd = {toml(cfd)}")
        if asked:
            lines.append(aligned(f"# source = {toml(asked)}", "TODO of all tables"))
    return lines


def matrix_lines(matrix: MatrixDraft, todo: Todo) -> list[str]:
    """The table that lists the tests."""
    look = matrix.look
    lines = ["[[matrix]]", aligned(f"file = {toml(matrix.file)}", "each row is a run")]
    source = source_lines(look, look.options)
    lines += [f"source = {{ {', '.join(source)} }}", f"id = {toml(matrix.id)}"]
    lines += [f"test = {toml(matrix.test)}", f"run = {toml(matrix.run)}"]
    if matrix.run_sheet is not None:
        lines.append(f"run_sheet = {toml(matrix.run_sheet)}")
    if matrix.skip:
        lines.append(aligned(f"skip = {toml(matrix.skip)}", "rows of which no run is there"))
    lines.append("[matrix.columns]")
    for column in look.columns:
        item = column.suggestion
        if item is not None and column.numbers:
            sure = item.name in matrix.settings
            note = f"{item.certainty}: {item.reason}"
            theirs = f"{item.name} = {their_column(column, item, look)}"
            lines.append(
                aligned(theirs if sure else f"# {theirs}", note if sure else f"TODO {note}")
            )
            if not sure:
                todo.add(f"[matrix.columns] {item.name}: is it {column.label!r} of {look.shown}?")
        else:
            lines.append(f"# not used: {printable(column.label)}")
    lines.append("[matrix.tests]                   # their word = our kind of test")
    for word, test in matrix.tests.items():
        if test is None:
            lines.append(
                aligned(f"# {toml_string(word)} = ...", f"TODO one of {', '.join(TEST_KINDS)}")
            )
            todo.add(f"[matrix.tests] which kind of test is {word!r}?")
        elif test != word:
            lines.append(f"{toml_string(word)} = {toml(test)}")
    return lines


def entry_lines(
    entry: RunDraft,
    table: str,
    base: FileLook | None,
    kind: str,
    todo: Todo,
    *,
    apart: bool = False,
    computed: Computed | None = None,
) -> list[str]:
    """An entry; `apart` where each run of the shared layout has a sheet of its own.

    What `computed` holds stands in ``[cfd]`` and ``[defaults]``.
    """
    lines = [f"[[{table}]]"]
    identity = entry.id
    if entry.template:
        identity = entry.template
    elif table == "tables":
        plain = entry.id.replace("{", "(").replace("}", ")")
        identity = _told_apart(f"{plain}_{{{_id_column(entry.look)}}}", entry.look)
    lines += [f"id = {toml(identity)}"]
    if entry.test is None:
        free = kind == "free-running"
        usual = ", ".join(name for name, item in TEST_KINDS.items() if item.free_running == free)
        lines.append(f"# test = ...   # TODO one of {usual}")
        todo.of_run("test", entry.id)
    else:
        lines.append(f"test = {toml(entry.test)}")
    lines.append(f"file = {toml(entry.file)}")
    if entry.motion is not None:
        lines.append(aligned(f"motion = {toml(entry.motion)}", "where the hull was, found there"))
    own = {} if computed is None else computed.own(entry)
    if own:
        lines.append(f"cfd = {toml(own)}")
    if entry.look is base and entry.sheet is not None and apart:
        lines.append(f"source = {{ sheet = {toml(entry.sheet)} }}")
    shared = base is not None and entry.look is not base and entry.look.columns == base.columns
    if shared:
        lines.append(f"source = {{ {', '.join(_apart(entry))} }}")
    if entry.where:
        lines.append(where_line(entry.where))
    apart_columns = entry.look is not base and not shared
    if entry.columns and not apart_columns:
        pairs = ", ".join(f"{name} = {toml(value)}" for name, value in entry.columns.items())
        lines.append(f"columns = {{ {pairs} }}")
    if entry.skip:
        lines.append(aligned(f"skip = {toml(entry.skip)}", "rows that are no runs"))
    if entry.samples:
        lines.append(aligned(f"samples = {toml(entry.samples)}", "rows of one name: one cycle"))
    lines += [_setting(setting, entry.id, todo) for setting in entry.settings]
    lines += [f"# {printable(note)}" for note in entry.notes]
    lines += [f"# TODO {printable(problem)}" for problem in entry.problems[:3]]
    if entry.problems:
        todo.of_run('the file is damaged or lacks values (missing = "drop" in [source])', entry.id)
    if apart_columns:
        options = replace(entry.look.options, sheet=entry.sheet)
        source = source_lines(entry.look, options, every=base is not None)
        lines += [f"[{table}.source]", *source]
        lines.append(f"[{table}.columns]")
        lines += column_lines(
            entry.look, kind, todo, table=table == "tables", instead=entry.columns
        )
        here = set(entry.columns) | {
            name
            for name, column in entry.look.known.items()
            if column.suggestion and column.suggestion.certainty != "perhaps"
        }
        for name in () if base is None else base.known:
            if name not in here:
                lines.append(f"{name} = false")
    return lines


def _apart(entry: RunDraft) -> list[str]:
    """What a table whose columns are those of all tables says of its sheet."""
    options = entry.look.options
    said = {"sheet": entry.sheet, "last_row": options.last_row}
    return [f"{key} = {toml(value)}" for key, value in said.items() if value is not None]


def guessed_source(entries: Sequence[RunDraft]) -> dict[str, str]:
    """What tables of non-dimensional forces or of harmonics must say of themselves, as is usual."""
    guessed = {}
    columns = [column for entry in entries for column in entry.look.columns]
    if any("'" in column.title and column.unit is None for column in columns):
        guessed["nondimensional"] = "prime"
    if any("_in" in name or "_out" in name for entry in entries for name in entry.look.known):
        guessed["in_phase_with"] = "displacement"
    return guessed


_ASKED_OF_TABLES: Final = {
    "nondimensional": 'are the forces of the tables "prime", "prime-d" or "bis"?',
    "in_phase_with": "with what are the in-phase parts of the tables: displacement, velocity or "
    "acceleration?",
}


def _told_apart(template: str, look: FileLook) -> str:
    """An id for the rows of a table, with further settings where rows would share one."""
    try:
        cells = READERS[look.format].cells(look.request)
    except DataError:
        return template
    told = [column.title for column in look.known.values() if not column.constant]
    named = [title for title in told if cells.headers.count(title) == 1 and "{" not in title]
    for title in ("", *named):
        longer = f"{template}_{{{title}}}" if title else template
        ids = [cells.filled_in(longer, index)[0] for index in range(len(cells.rows))]
        if len(set(ids)) == len(ids):
            return longer
    return template


def _id_column(look: FileLook) -> str:
    """Header of a column that tells the rows apart."""
    for column in look.columns:
        if "run" in column.title.lower() or column.title.lower() in ("no", "no.", "id", "test"):
            return column.title
    varied = [column for column in look.columns if not column.constant and column.suggestion]
    keys = ("drift_deg", "rudder_deg", "speed", "heel_deg")
    settings = [column for column in look.known.values() if column in varied]
    named = [column for key in keys for column in settings if column is look.known.get(key)]
    return (named or varied or list(look.columns))[0].title


def _setting(setting: RunKey, run_id: str, todo: Todo) -> str:
    if setting.todo:
        todo.of_run(_question(setting), run_id)
    return _line(setting)


def _line(setting: RunKey) -> str:
    value = "..." if setting.value is None else toml(setting.value)
    mark = "" if setting.active else "# "
    asked = f"TODO {setting.todo}" if setting.todo else ""
    note = "; ".join(filter(None, (setting.reason, asked)))
    return aligned(f"{mark}{setting.key} = {value}", note)


def _question(setting: RunKey) -> str:
    """What is asked about a setting, the same for all runs."""
    known = settings_by_key().get(setting.key)
    if setting.value is None:
        return f"{setting.key}: {(known and known.asked) or 'its value'}"
    if not setting.active:
        return f"{setting.key}, a number in the name: is it that?"
    return f"{setting.key}, to be checked"


def saved_run_lines(file: str, run: Run) -> list[str]:
    """A run of a saved campaign, SI and our signs."""
    found = run.settings
    kept = [item for item in RUN_SETTINGS.values() if item.kept and not item.surroundings]
    values = {"speed": found.speed}
    for item in (item for item in kept if item.angle and found.value(item.name)):
        values[item.in_file] = float(f"{item.to_file(found.value(item.name) or 0.0):.9g}")
    for item in sorted(kept, key=lambda item: item.name == "propeller_rps"):
        value = found.value(item.name)
        if value is not None and not item.angle:
            values[item.in_file] = value
    for key in asked_of(run.test):
        if key.endswith("_deg"):
            values.setdefault(key, 0.0)
    lines = ["[[runs]]", f"id = {toml(run.id)}", f"test = {toml(run.test)}", f"file = {toml(file)}"]
    return lines + [f"{key} = {toml(value)}" for key, value in values.items()]
