"""A draft as the text of a campaign file, and what a person must still say."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

from pmmkit.campaigns.run import Campaign, Run
from pmmkit.campaigns.samples.column_mapping import required_channels
from pmmkit.campaigns.test_kinds.registry import kinds
from pmmkit.channels import split_unit
from pmmkit.escaping import toml_comment, toml_string
from pmmkit.inspection import ColumnLook, FileLook
from pmmkit.inspection.drafts.common import Common, in_common
from pmmkit.inspection.drafts.draft import Draft, RunDraft
from pmmkit.inspection.drafts.matrix import MatrixDraft
from pmmkit.inspection.drafts.settle import WORDS, Setting, asked_of
from pmmkit.inspection.guessing import Suggestion
from pmmkit.readers import Options, reader_of
from pmmkit.readers.saved import SavedCampaign

_MEANS: Final[dict[str, str]] = {
    "t": "time [s]",
    "X": "the surge force [N]",
    "Y": "the sway force [N]",
    "N": "the yaw moment [N m]",
    "x": "the position along the first course [m]",
    "y": "the position to starboard [m]",
    "psi": "the heading [rad]",
}
_LISTED: Final = 6


@dataclass(frozen=True, kw_only=True)
class Written:
    """The text of a campaign file.

    Parameters
    ----------
    text : str
        Valid TOML.
    todo : tuple of str
        What a person must fill in or check.
    complete : int
        Runs and tables without anything open.
    """

    text: str
    todo: tuple[str, ...]
    complete: int


def written(draft: Draft) -> Written:
    """The campaign file of a draft.

    Parameters
    ----------
    draft : Draft
        From `draft_of`.
    """
    base = None if draft.saved else _largest(draft)
    stated: Mapping[str, float] = {}
    apart = len({entry.sheet for entry in draft.runs if entry.look is base}) > 1
    todo = _Todo()
    lines = [
        "# A draft made from the files that lie here. Check every line; TODO marks what the files",
        "# do not say. Comments say where a value comes from.",
        "",
        *_campaign(draft, todo),
        "",
        *_ship(draft, todo),
    ]
    if any(reader_of(entry.look.format).computed for entry in draft.runs):
        stated = _of_all(draft.runs)
        lines += ["", *_cfd(draft.runs, stated, todo)]
    if base is not None:
        shared = replace(base.options, sheet=None) if apart else base.options
        lines += ["", "[source]", *_source(base, shared)]
        lines += ["", "[columns]                        # our name = theirs"]
        lines += _columns(base, draft.kind, todo, table=False)
    elif draft.saved:
        lines += ["", "[source]", f"format = {toml(SavedCampaign.name)}"]
    for file, campaign in draft.saved:
        for run in campaign:
            lines += ["", *_saved_run(file, run)]
    common = in_common(draft.runs, draft.tables)
    lines += _defaults(common, todo)
    if draft.matrix is not None:
        lines += ["", *_matrix(draft.matrix, todo)]
    for entry in common.runs:
        if entry.listed:
            continue
        lines += ["", *_entry(entry, "runs", base, draft.kind, todo, apart=apart, stated=stated)]
    for entry in common.tables:
        lines += ["", *_entry(entry, "tables", base, draft.kind, todo)]
    lines += [*_unused(draft), "", "[end]"]
    entries = (
        sum(len(campaign) for _, campaign in draft.saved) + len(draft.runs) + len(draft.tables)
    )
    return Written(
        text="\n".join(lines) + "\n", todo=tuple(todo.all()), complete=entries - len(todo.open_runs)
    )


class _Todo:
    """What is open, the same question about many runs asked once."""

    def __init__(self) -> None:
        self._single: list[str] = []
        self._runs: dict[str, list[str]] = {}

    def add(self, text: str) -> None:
        """A question about the whole campaign."""
        if text not in self._single:
            self._single.append(text)

    def of_run(self, text: str, run_id: str) -> None:
        """A question about a run."""
        self._runs.setdefault(text, []).append(run_id)

    @property
    def open_runs(self) -> set[str]:
        """Runs and tables about which something is asked."""
        return {run_id for ids in self._runs.values() for run_id in ids}

    def all(self) -> list[str]:
        """Everything that is open."""
        asked = list(self._single)
        for text, ids in self._runs.items():
            more = f" and {len(ids) - _LISTED} more" if len(ids) > _LISTED else ""
            asked.append(f"{text}: {', '.join(ids[:_LISTED])}{more}.")
        return asked


def _campaign(draft: Draft, todo: _Todo) -> list[str]:
    lines = ["[campaign]", f"title = {toml(draft.title)}", f"kind = {toml(draft.kind)}"]
    lines.append("closed = true                    # the last line is [end]: a cut is noticed")
    if draft.saved:
        return [*lines, *_as_saved(draft.saved[0][1], todo)]
    turns = 'rudder_positive = "starboard"    # TODO "port" if + rudder turns her to port'
    if draft.kind == "free-running":
        todo.add("[campaign] rudder_positive, and [axes] if x, y or z point the other way.")
        return [*lines, turns]
    todo.add(
        "[campaign] forces: is the inertia of the model removed from the forces of oscillating "
        "tests?"
    )
    todo.add(
        "[campaign] signs: which way drift and rudder are positive, and to which point the moments "
        "refer ([axes] if x, y or z point the other way)."
    )
    return [
        *lines,
        'forces = "hydrodynamic"          # TODO "balance" if the model\'s inertia is in them',
        'drift_positive = "starboard-bow" # TODO "port-bow" if they count drift the other way',
        turns,
        "# moment_reference_x = 0.0       # TODO point to which moments refer, forward of midship",
        '# free = ["heave", "pitch"]      # TODO what the mount leaves free',
    ]


def _as_saved(saved: Campaign, todo: _Todo) -> list[str]:
    """What a saved campaign says of all of its runs."""
    todo.add(
        "[uncertainty], [propeller], [rudder], [cfd] of the saved campaign are not repeated. Open "
        "the saved file itself if nothing is to be changed."
    )
    keys = ("moment_reference_x", "moment_reference_z", "motion_reference_x")
    stated = [f"{key} = {toml(getattr(saved, key))}" for key in keys if getattr(saved, key)]
    free = [f"free = {toml(saved.free)}"] if saved.free else []
    return [f"forces = {toml(saved.forces)}", *stated, *free]


def _ship(draft: Draft, todo: _Todo) -> list[str]:
    if draft.saved and draft.ship_name is None:
        return _particulars(draft.saved[0][1])
    if draft.ship_name is not None:
        todo.add(
            f"[ship] the library holds {draft.ship_name!r} at one scale: give the particulars of "
            "your model in full if it is another."
        )
        lines = [
            "[ship]",
            f"name = {toml(draft.ship_name)}  # of the library, at the scale it has there; or in "
            "full: L, B, d, mass, volume, Izz",
        ]
    else:
        todo.add(
            "[ship] the particulars L, B, d, mass or volume, Izz, or the name of a library ship."
        )
        lines = [
            "[ship]",
            '# name = "..."                   # TODO a ship of the library (pmmkit ships), or:',
            "# L = ...                        # TODO length between perpendiculars [m]",
            "# B = ...                        # TODO breadth [m]",
            "# d = ...                        # TODO draught [m]",
            "# volume = ...                   # TODO displaced volume [m³]",
            "# mass = ...                     # TODO mass as tested [kg]",
            "# Izz = ...                      # TODO yaw inertia about midship [kg m²]",
            "# xG = 0.0                       # TODO centre of gravity forward of midship [m]",
            *(_ROLL if any("K" in entry.look.known for entry in draft.runs) else ()),
        ]
    todo.add("[water] rho: the density of the water [kg/m³].")
    rho = "# rho = ...                      # TODO density [kg/m³]; fresh water of 15 °C: 999.1"
    return [*lines, "", "[water]", rho]


_ROLL: Final = (
    "# zG = 0.0                       # TODO centre of gravity below the origin [m]",
    "# GM = ...                       # TODO metacentric height [m], for a model that rolls",
    "# Ix = ...                       # TODO inertia of roll [kg m²], for a model that rolls",
)
"""What roll asks of a ship, where K was measured."""


def _of_all(runs: Sequence[RunDraft]) -> Mapping[str, float]:
    """What all computations say alike."""
    first = runs[0].computation
    return {
        key: value
        for key, value in first.items()
        if all(run.computation.get(key) == value for run in runs)
    }


def _cfd(runs: Sequence[RunDraft], stated: Mapping[str, float], todo: _Todo) -> list[str]:
    """What forces that were computed need."""
    todo.add(
        "[axes] which way the axes of the mesh point; [cfd] the point of the moments, whether "
        "forces are along the hull, the start-up, the density, half or whole ship."
    )
    return [
        "# [axes]                         # TODO of the mesh: which way theirs point, seen in ours",
        '# y = "-y"                       # x forward and z up: y to port (x aft, z up: x = "-x")',
        '# z = "-z"',
        "",
        f"{'' if stated else '# '}[cfd]".ljust(33) + "# TODO of forces that were computed",
        '# forces_in = "earth"            # TODO if they stay along the tank while the hull moves',
        "# moment_centre = 0.0            # TODO where moments refer at rest, forward of midship",
        "# moment_centre_moves = false    # TODO if that point stays behind while the hull moves",
        "# ramp_s = ...                   # TODO start-up of the computation, cut off every run",
        "# symmetry_factor = 2.0          # TODO if half a ship was computed",
        *_density(stated.get("rho_inf"), todo),
        "# U_SN = { X = ..., Y = ..., N = ... }  # TODO numerical uncertainty [N, N m], if known",
        *_otherwise(runs),
    ]


def _density(rho_inf: float | None, todo: _Todo) -> list[str]:
    if rho_inf is None:
        return [
            "# rho_inf = ...                  # TODO density of the computation, if it is another"
        ]
    if rho_inf != 1.0:
        return [_aligned(f"rho_inf = {toml(rho_inf)}", "rhoInf beside the results")]
    todo.add("[cfd] rho_inf = 1: are the forces per density, or multiplied by it already?")
    why = "rhoInf beside the results: forces per density; TODO else take the line away"
    return [_aligned("rho_inf = 1.0", why)]


def _otherwise(runs: Sequence[RunDraft]) -> list[str]:
    """A hint that tests of one kind may have been computed in another way."""
    steady = [run.test for run in runs if run.test is not None and kinds()[run.test].steady]
    if not steady or len(steady) == len(runs):
        return []
    return [
        "",
        f"# [defaults.{steady[0]}.cfd]".ljust(33)
        + "# TODO if these were computed otherwise, e.g. by rotated inflow",
        '# forces_in = "body"',
        "# moment_centre_moves = true",
    ]


def _particulars(saved: Campaign) -> list[str]:
    """Ship and water of a saved campaign."""
    ship, water = asdict(saved.ship), asdict(saved.water)
    ours = {_SHIP_KEYS.get(key, key): value for key, value in ship.items() if value is not None}
    lines = ["[ship]                           # as in the saved campaign"]
    lines += [f"{key} = {toml(value)}" for key, value in ours.items()]
    lines += ["", "[water]"]
    return lines + [f"{key} = {toml(value)}" for key, value in water.items() if value is not None]


_SHIP_KEYS: Final = {"Ixx": "Ix", "block_stated": "CB"}
"""Keys of ``[ship]`` that differ from the fields of a Ship."""


def _largest(draft: Draft) -> FileLook | None:
    """The layout that most histories share; it stands in ``[source]`` and ``[columns]``."""
    counted: dict[int, int] = {}
    looks: dict[int, FileLook] = {}
    for entry in draft.runs:
        looks[id(entry.look)] = entry.look
        counted[id(entry.look)] = counted.get(id(entry.look), 0) + 1
    return looks[max(counted, key=lambda key: counted[key])] if counted else None


def _source(look: FileLook, options: Options, *, every: bool = False) -> list[str]:
    values: dict[str, Any] = {"format": look.format}
    if look.layout is not None or look.has_sheets:
        values |= {"skip_rows": options.skip_rows} if options.skip_rows or every else {}
        if look.layout is not None:
            values |= {"encoding": options.encoding or "utf-8"} if options.encoding or every else {}
            values |= {"delimiter": options.delimiter, "decimal": options.decimal}
        stated = options.header is not None and every
        values |= {"header": options.header} if options.header is False or stated else {}
        values |= {"units_row": True} if options.units_row else {}
        values |= {"sheet": options.sheet} if options.sheet else {}
    return [f"{key} = {toml(value)}" for key, value in values.items()]


def _columns(look: FileLook, kind: str, todo: _Todo, *, table: bool) -> list[str]:
    """The columns with the reason for each, what is not used, what is still wanted."""
    lines = []
    for column in look.columns:
        item = column.suggestion
        if item is None or not column.numbers:
            continue
        mark = "# " if item.certainty == "perhaps" else ""
        note = f"{item.certainty}: {item.reason}"
        if column.unit is None and item.unit is None and not table:
            note += "; no unit stated, taken as SI"
        if mark:
            note = f"TODO {note}"
            todo.add(f"{look.shown}, column {column.label!r}: {item.certainty} {item.name}?")
        lines.append(_aligned(f"{mark}{item.name} = {_theirs(column, item, look)}", note))
    unused = [
        f"{column.label}{' (' + column.remark + ')' if column.remark else ''}"
        for column in look.columns
        if column.suggestion is None
    ]
    known = {
        name
        for name, column in look.known.items()
        if column.suggestion and column.suggestion.certainty != "perhaps"
    }
    for name in () if table else required_channels(kind):
        if name not in known and not any(other.startswith(f"{name}_") for other in known):
            lines.append(f"# {name} = ...   # TODO which column is {_MEANS[name]}? (false if none)")
            todo.add(f"[columns] {name}: which column of {look.shown} is {_MEANS[name]}?")
    lines += [f"# not used: {toml_comment(text)}" for text in unused]
    return lines + [f"# note: {toml_comment(note)}" for note in look.notes]


def _theirs(column: ColumnLook, item: Suggestion, look: FileLook) -> str:
    """The right side of a line of ``[columns]``."""
    titles = [other.title for other in look.columns]
    named = look.options.header is not False and titles.count(column.title) == 1 and column.title
    parts: dict[str, Any] = {"name": column.title} if named else {"column": column.position + 1}
    unit = item.unit or column.unit
    if unit and (item.unit or not named or split_unit(column.title)[1] is None):
        parts["unit"] = unit
    if item.scale != 1.0:
        parts["scale"] = item.scale
    return toml(column.title) if list(parts) == ["name"] else toml(parts)


def _entry(
    entry: RunDraft,
    table: str,
    base: FileLook | None,
    kind: str,
    todo: _Todo,
    *,
    apart: bool = False,
    stated: Mapping[str, float] | None = None,
) -> list[str]:
    """An entry; `apart` where each run of the shared layout has a sheet of its own.

    What `stated` holds of the computation stands in ``[cfd]``.
    """
    lines = [f"[[{table}]]"]
    identity = entry.id
    if table == "tables":
        plain = entry.id.replace("{", "(").replace("}", ")")
        identity = f"{plain}_{{{_id_column(entry.look)}}}"
    lines += [f"id = {toml(identity)}"]
    if entry.test is None:
        free = kind == "free-running"
        usual = ", ".join(name for name, item in kinds().items() if item.free_running == free)
        lines.append(f"# test = ...   # TODO one of {usual}")
        todo.of_run("test", entry.id)
    else:
        lines.append(f"test = {toml(entry.test)}")
    lines.append(f"file = {toml(entry.file)}")
    if entry.motion is not None:
        lines.append(_aligned(f"motion = {toml(entry.motion)}", "where the hull was, found there"))
    own = {key: value for key, value in entry.computation.items() if key not in (stated or {})}
    if own:
        lines.append(f"cfd = {toml(own)}")
    if entry.look is base and entry.sheet is not None and apart:
        lines.append(f"source = {{ sheet = {toml(entry.sheet)} }}")
    lines += [_setting(setting, entry.id, todo) for setting in entry.settings]
    lines += [f"# TODO {toml_comment(problem)}" for problem in entry.problems[:3]]
    if entry.problems:
        todo.of_run('the file is damaged or lacks values (missing = "drop" in [source])', entry.id)
    if entry.look is not base:
        options = replace(entry.look.options, sheet=entry.sheet)
        source = _source(entry.look, options, every=base is not None)
        lines += [f"[{table}.source]", *source]
        if table == "tables":
            lines += _conventions(entry, todo)
        lines.append(f"[{table}.columns]")
        lines += _columns(entry.look, kind, todo, table=table == "tables")
        here = {
            name
            for name, column in entry.look.known.items()
            if column.suggestion and column.suggestion.certainty != "perhaps"
        }
        for name in () if base is None else base.known:
            if name not in here:
                lines.append(f"{name} = false")
    return lines


def _conventions(entry: RunDraft, todo: _Todo) -> list[str]:
    """What a table of non-dimensional forces or of harmonics must say of itself."""
    lines = []
    look = entry.look
    titles = " ".join(look.titles)
    if "'" in titles:
        lines.append('# nondimensional = "prime"       # TODO "prime", "prime-d" or "bis"')
        todo.of_run("nondimensional: in which system are the forces of the table?", entry.id)
    if any("_in" in name or "_out" in name for name in look.known):
        lines.append('# in_phase_with = "displacement" # TODO or "velocity", "acceleration"')
        todo.of_run("in_phase_with: with what are the in-phase parts of the table?", entry.id)
    return lines


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


def _matrix(matrix: MatrixDraft, todo: _Todo) -> list[str]:
    """The table that lists the tests."""
    look = matrix.look
    lines = ["[[matrix]]", _aligned(f"file = {toml(matrix.file)}", "each row is a run")]
    source = _source(look, look.options)
    lines += [f"source = {{ {', '.join(source)} }}", f"id = {toml(matrix.id)}"]
    lines += [f"test = {toml(matrix.test)}", f"run = {toml(matrix.run)}"]
    if matrix.run_sheet is not None:
        lines.append(f"run_sheet = {toml(matrix.run_sheet)}")
    if matrix.skip:
        lines.append(_aligned(f"skip = {toml(matrix.skip)}", "rows of which no run is there"))
    lines.append("[matrix.columns]")
    for column in look.columns:
        item = column.suggestion
        if item is not None and column.numbers:
            sure = item.name in matrix.settings
            note = f"{item.certainty}: {item.reason}"
            theirs = f"{item.name} = {_theirs(column, item, look)}"
            lines.append(
                _aligned(theirs if sure else f"# {theirs}", note if sure else f"TODO {note}")
            )
            if not sure:
                todo.add(f"[matrix.columns] {item.name}: is it {column.label!r} of {look.shown}?")
        else:
            lines.append(f"# not used: {toml_comment(column.label)}")
    lines.append("[matrix.tests]                   # their word = our kind of test")
    for word, test in matrix.tests.items():
        if test is None:
            lines.append(
                _aligned(f"# {toml_string(word)} = ...", f"TODO one of {', '.join(kinds())}")
            )
            todo.add(f"[matrix.tests] which kind of test is {word!r}?")
        elif test != word:
            lines.append(f"{toml_string(word)} = {toml(test)}")
    return lines


def _defaults(common: Common, todo: _Todo) -> list[str]:
    """What runs have in common, and what is asked for all of them at once."""
    tables = {"defaults": common.every}
    tables |= {f"defaults.{test}": items for test, items in common.of_kind.items()}
    lines = []
    for name, items in tables.items():
        if not items:
            continue
        lines += ["", f"[{name}]"]
        for item in items:
            lines.append(_line(item))
            if item.todo:
                todo.add(f"[{name}] {_question(item)}.")
    return lines


def _setting(setting: Setting, run_id: str, todo: _Todo) -> str:
    if setting.todo:
        todo.of_run(_question(setting), run_id)
    return _line(setting)


def _line(setting: Setting) -> str:
    value = "..." if setting.value is None else toml(setting.value)
    mark = "" if setting.active else "# "
    asked = f"TODO {setting.todo}" if setting.todo else ""
    note = "; ".join(filter(None, (setting.reason, asked)))
    return _aligned(f"{mark}{setting.key} = {value}", note)


def _question(setting: Setting) -> str:
    """What is asked about a setting, the same for all runs."""
    if setting.value is None:
        return f"{setting.key}: {WORDS.get(setting.key, 'its value')}"
    if not setting.active:
        return f"{setting.key}, a number in the name: is it that?"
    return f"{setting.key}, to be checked"


def _saved_run(file: str, run: Run) -> list[str]:
    """A run of a saved campaign, SI and our signs."""
    found = run.settings
    degrees = {
        "drift_deg": found.drift,
        "heel_deg": found.heel,
        "rudder_deg": found.rudder,
        "yaw_amplitude_deg": found.yaw_amplitude,
        "phase_deg": found.phase,
        "switch_deg": found.switch,
    }
    plain = {
        "period": found.period,
        "amplitude_m": found.amplitude,
        "yaw_rate": found.yaw_rate,
        "radius": found.radius,
        "propeller_rps": found.propeller_rps,
    }
    values = {"speed": found.speed}
    values |= {key: float(f"{math.degrees(value):.9g}") for key, value in degrees.items() if value}
    values |= {key: value for key, value in plain.items() if value is not None}
    for key in asked_of(run.test):
        if key.endswith("_deg"):
            values.setdefault(key, 0.0)
    lines = ["[[runs]]", f"id = {toml(run.id)}", f"test = {toml(run.test)}", f"file = {toml(file)}"]
    return lines + [f"{key} = {toml(value)}" for key, value in values.items()]


def _unused(draft: Draft) -> list[str]:
    lines = [f"# {toml_comment(text)}" for text in draft.unused]
    matrix = None if draft.matrix is None else draft.matrix.look.shown
    problems = [problem for problem in draft.look.problems if problem.file != matrix]
    lines += [f"# {toml_comment(str(problem))}" for problem in problems]
    return ["", "# Files that are not used:", *lines] if lines else []


def _aligned(left: str, note: str) -> str:
    return f"{left:<32} # {toml_comment(note)}" if note else left


def toml(value: Any) -> str:
    r"""A value as TOML.

    Examples
    --------
    >>> print(toml({"name": 'Fx "total"', "column": 2, "scale": -1.0, "header": False}))
    { name = "Fx \"total\"", column = 2, scale = -1.0, header = false }
    """
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(float(value)) if isinstance(value, float) else repr(int(value))
