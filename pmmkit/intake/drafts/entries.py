"""``[defaults]``, ``[[matrix]]``, ``[[runs]]`` and ``[[tables]]`` of a draft."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Run
from pmmkit.files import toml_string
from pmmkit.intake.drafts.columns import (
    Todo,
    aligned,
    column_lines,
    commented,
    source_lines,
    their_column,
    toml,
)
from pmmkit.intake.drafts.conventions import Proposal
from pmmkit.intake.drafts.draft import RunDraft
from pmmkit.intake.drafts.matrix import MatrixDraft, where_line
from pmmkit.intake.drafts.names import RunKey, asked_of
from pmmkit.intake.guessing import COUNTED, WITHOUT, coefficient
from pmmkit.intake.seen import FileLook
from pmmkit.presentation import printable
from pmmkit.readers import READERS

# ``[axes]`` and ``[cfd]`` of a draft: what forces that were computed need.


@dataclass(frozen=True, kw_only=True)
class Computed:
    """What ``[cfd]`` says, as far as it is known.

    `every`: what all runs have alike. `of_kind`: what all runs of a kind of test have alike
    besides.
    """

    every: Mapping[str, Any] = field(default_factory=dict)
    of_kind: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def own(self, run: RunDraft) -> dict[str, Any]:
        """What is left for the run itself to say."""
        said = {**self.every, **self.of_kind.get(run.test or "", {})}
        return {key: value for key, value in run.computation.items() if said.get(key) != value}


def computed_in(runs: Sequence[RunDraft]) -> Computed:
    """What computations say alike, taken together."""
    every = _alike(runs)
    of_kind = {}
    for test in dict.fromkeys(run.test for run in runs if run.test is not None):
        group = [run for run in runs if run.test == test]
        own = {key: value for key, value in _alike(group).items() if key not in every}
        if own and len(group) > 1:
            of_kind[test] = own
    return Computed(every=every, of_kind=of_kind)


def _alike(runs: Sequence[RunDraft]) -> dict[str, Any]:
    return {
        key: value
        for key, value in runs[0].computation.items()
        if all(run.computation.get(key) == value for run in runs)
    }


def axes_lines(proposal: Proposal | None, todo: Todo, *, computed: bool) -> list[str]:
    """``[axes]``: what physics says of them, else what a person must say of a mesh."""
    found = None if proposal is None else proposal.convention
    if proposal is not None and found is not None and found.reversed_axes:
        lines = [f'{axis} = "-{axis}"' for axis in found.reversed_axes]
        return ["", aligned("[axes]", "proposed, see [campaign]"), *lines]
    remaining = [] if proposal is None else list(proposal.remaining)
    if remaining:
        assert proposal is not None
        todo.add(
            "[axes], signs: the forces of all runs leave several ways, listed in the file; which "
            "is so? Or do the moments refer to a point far from midship, or do oscillations "
            "begin at another phase (phase_deg)?"
        )
        listed = [f"#   {number}. {item}" for number, item in enumerate(remaining, start=1)]
        seen = commented(f"TODO axes and signs: {proposal.seen}.")
        asked = "# One of these, or moments about a point far from midship, or another phase_deg:"
        return ["", *seen, asked, *listed]
    if found is not None or not computed:
        return []
    todo.add("[axes] which way the axes of the mesh point.")
    return [
        "",
        "# [axes]                         # TODO of the mesh: which way theirs point, seen in ours",
        '# y = "-y"                       # x forward and z up: y to port (x aft, z up: x = "-x")',
        '# z = "-z"',
    ]


def cfd_lines(
    runs: Sequence[RunDraft], found: Computed, proposal: Proposal | None, todo: Todo
) -> list[str]:
    """``[cfd]``: what is known of the computation, and what is asked."""
    known = {key for run in runs for key in run.computation}
    along = proposal is not None and proposal.along_tank is not None
    oscillates = any(run.test is not None and TEST_KINDS[run.test].oscillates for run in runs)
    turned = "forces_in" in known if oscillates else along
    asked = "" if turned else "whether forces are along the hull, "
    todo.add(f"[cfd] the point of the moments, {asked}the start-up, half or whole ship.")
    lines = [
        f"{'' if found.every else '# '}[cfd]".ljust(33) + "# TODO of forces that were computed",
        *(
            aligned(f"{key} = {toml(value)}", "")
            for key, value in found.every.items()
            if key != "rho_inf"
        ),
        "# moment_centre = 0.0            # TODO where moments refer at rest, forward of midship",
        "# ramp_s = ...                   # TODO start-up of the computation, cut off every run",
        "# symmetry_factor = 2.0          # TODO if half a ship was computed",
        *_density(found.every.get("rho_inf"), todo),
        "# U_SN = { X = ..., Y = ..., N = ... }  # TODO numerical uncertainty [N, N m], if known",
    ]
    if not turned:
        lines += [
            '# forces_in = "earth"            # TODO if they stay along the tank while she moves',
            "# moment_centre_moves = false    # TODO if that point stays behind while she moves",
        ]
    if proposal is not None and proposal.why_along:
        lines.append(f"# {printable(_steady(runs))}: {printable(proposal.why_along)}")
    return lines


def _steady(runs: Sequence[RunDraft]) -> str:
    """Kinds of test with a constant drift angle, in words."""
    tests = dict.fromkeys(run.test for run in runs if run.test is not None)
    return ", ".join(test for test in tests if TEST_KINDS[test].steady)


def _density(rho_inf: float | None, todo: Todo) -> list[str]:
    if rho_inf is None:
        return [
            "# rho_inf = ...                  # TODO density of the computation, if it is another"
        ]
    if rho_inf != 1.0:
        return [aligned(f"rho_inf = {toml(rho_inf)}", "rhoInf beside the results")]
    todo.add("[cfd] rho_inf = 1: are the forces per density, or multiplied by it already?")
    why = "rhoInf beside the results: forces per density; TODO else take the line away"
    return [aligned("rho_inf = 1.0", why)]


# What the runs of a draft have in common, to be stated once.


_ASKED_ONCE: Final = ("speed", "period")
"""Settings that whole programmes share: where they are asked, they are asked for once."""


Shared = tuple[tuple[RunKey, ...], Mapping[str, tuple[RunKey, ...]]]
"""What all runs have, and what all runs of a kind of test have."""


def in_common(
    runs: Sequence[RunDraft], tables: Sequence[RunDraft]
) -> tuple[Shared, tuple[RunDraft, ...], tuple[RunDraft, ...]]:
    """The settings that all runs, or all of a kind, have alike; runs and tables without them."""
    entries = [*runs, *tables]
    shared = _shared(entries)
    every = tuple(item for item in shared if item.key in ("speed", "tare"))
    entries = _without(entries, every)
    tests = dict.fromkeys(entry.test for entry in entries if entry.test is not None)
    of_kind = {}
    for test in tests:
        own = _shared([entry for entry in entries if entry.test == test])
        if own:
            of_kind[test] = own
            entries = _without(entries, own, test)
    return (every, of_kind), tuple(entries[: len(runs)]), tuple(entries[len(runs) :])


def _shared(entries: Sequence[RunDraft]) -> tuple[RunKey, ...]:
    """Settings that two or more entries have, and all that have them alike; tare only of all."""
    found: dict[str, list[RunKey]] = {}
    for entry in entries:
        for item in entry.settings:
            found.setdefault(item.key, []).append(item)
    return tuple(
        _one(items)
        for key, items in found.items()
        if len(items) > 1
        and (key != "tare" or len(items) == len(entries))
        and len({(item.value, item.todo, item.active) for item in items}) == 1
        and ((items[0].active and not items[0].todo) or key in _ASKED_ONCE)
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


def default_lines(
    common: Shared, entries: Sequence[RunDraft], computed: Computed, todo: Todo
) -> list[str]:
    """What runs have in common, and what is asked for all of them at once."""
    every, of_kind = common
    tests = dict.fromkeys([*of_kind, *computed.of_kind])
    lines: list[str] = []
    guessed = guessed_source(entries)
    for key in guessed:
        todo.add(f"{key}: {_GUESSED_OF_TABLES[key]}")
    for name, items, cfd in (
        ("defaults", every, None),
        *((f"defaults.{x}", of_kind.get(x, ()), computed.of_kind.get(x)) for x in tests),
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
            # The checks hold the size of the forces against the hull's, and their phase against
            # its inertia: a wrong system and a wrong phase are told.
            why = "; ".join(_GUESSED_OF_TABLES[key] for key in asked)
            lines.append(aligned(f"source = {toml(asked)}", f"as is usual; TODO {why}"))
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
    if entry.look is base and _part(entry) and apart:
        lines.append(f"source = {toml(_part(entry))}")
    elif entry.look is base and table == "runs" and entry.skip_rows != base.options.skip_rows:
        lines.append(f"source = {{ skip_rows = {entry.skip_rows} }}")
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
        lines.append(aligned(f"skip = {toml(entry.skip)}", "rows left out"))
    if entry.samples:
        lines.append(aligned(f"samples = {toml(entry.samples)}", "rows of one name: one cycle"))
    lines += [_setting(setting, entry.id, todo) for setting in entry.settings]
    lines += [f"# {printable(note)}" for note in entry.notes]
    lines += [f"# TODO {printable(problem)}" for problem in entry.problems[:3]]
    if entry.problems:
        todo.of_run('the file is damaged or lacks values (missing = "drop" in [source])', entry.id)
    if apart_columns:
        options = replace(
            entry.look.options, sheet=entry.sheet, group=entry.group, where=entry.only
        )
        if table == "runs":
            options = replace(options, skip_rows=entry.skip_rows)
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
    last_row = entry.look.options.last_row
    said = {**_part(entry), **({} if last_row is None else {"last_row": last_row})}
    return [f"{key} = {toml(value)}" for key, value in said.items()]


def _part(entry: RunDraft) -> dict[str, Any]:
    """Which part of its file an entry is, by the keys of ``[source]``."""
    said = {"sheet": entry.sheet, "group": entry.group, "where": dict(entry.only) or None}
    return {key: value for key, value in said.items() if value is not None}


def guessed_source(entries: Sequence[RunDraft]) -> dict[str, str]:
    """What files of non-dimensional forces or of harmonics must say of themselves, as is usual."""
    guessed = {}
    columns = [column for entry in entries for column in entry.look.columns]
    if any(
        column.unit in WITHOUT and ("'" in column.title or coefficient(column.header))
        for column in columns
    ):
        guessed["nondimensional"] = "prime"
    if any("_in" in name or "_out" in name for entry in entries for name in entry.look.known):
        guessed["in_phase_with"] = "displacement"
    return guessed


_GUESSED_OF_TABLES: Final = {
    "nondimensional": '"prime-d" if over ½ρLdU², "bis" if by ∇ and g',
    "in_phase_with": '"velocity" or "acceleration" if the in-phase parts are in phase with that',
}


def _told_apart(template: str, look: FileLook) -> str:
    """An id for the rows of a table, with further settings where rows would share one."""
    try:
        cells = READERS[look.format].cells(look.request)
    except DataError:
        return template
    columns = (*look.known.values(), *look.columns)
    told = dict.fromkeys(column.title for column in columns if not column.constant)
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
        if "run" in column.title.lower() or (column.title and COUNTED.fullmatch(column.title)):
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
    known = RUN_SETTINGS.by_key.get(setting.key)
    if setting.value is None:
        return f"{setting.key}: {(known and known.asked) or setting.todo or 'its value'}"
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
