"""A draft as the text of a campaign file, and what a person must still say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

from pmmkit.campaigns import Campaign
from pmmkit.intake.drafts.columns import (
    GAUGES,
    Todo,
    aligned,
    column_lines,
    commented,
    source_lines,
    toml,
)
from pmmkit.intake.drafts.conventions import Proposal
from pmmkit.intake.drafts.draft import Draft, RunDraft
from pmmkit.intake.drafts.entries import (
    Computed,
    axes_lines,
    cfd_lines,
    computed_in,
    default_lines,
    entry_lines,
    in_common,
    matrix_lines,
    saved_run_lines,
)
from pmmkit.intake.drafts.matrix import scatter_lines
from pmmkit.intake.drafts.questions import TANK_WATER, Found, estimate_of, with_density
from pmmkit.intake.seen import FileLook
from pmmkit.presentation import printable
from pmmkit.readers import READERS


@dataclass(frozen=True, kw_only=True)
class CampaignText:
    """The text of a campaign file.

    `todo`: what a person must fill in or check. `complete`: runs and tables without anything
    open.
    """

    text: str
    todo: tuple[str, ...]
    complete: int


def written(draft: Draft) -> CampaignText:
    """The campaign file of a draft.

    Parameters
    ----------
    draft : Draft
        From `draft_of`.
    """
    base = None if draft.saved else _largest(draft)
    computed = Computed()
    apart = len({(x.sheet, x.group, x.only) for x in draft.runs if x.look is base}) > 1
    todo = Todo()
    lines = [
        "# A draft made from the files that lie here. Check every line; TODO marks what the files",
        "# do not say. Comments say where a value comes from.",
        "",
        *_campaign(draft, todo),
        "",
        *_ship(draft, todo),
        *_behind(draft),
    ]
    if any(READERS[entry.look.format].computed for entry in draft.runs):
        computed = computed_in(draft.runs)
        lines += axes_lines(draft.proposal, todo, computed=True)
        lines += ["", *cfd_lines(draft.runs, computed, draft.proposal, todo)]
    else:
        lines += axes_lines(draft.proposal, todo, computed=False)
    if base is not None:
        several = apart or not draft.runs
        shared = (
            replace(base.options, sheet=None, group=None, where=(), last_row=None)
            if several
            else base.options
        )
        lines += ["", "[source]", *source_lines(base, shared)]
        lines += ["", "[columns]                        # our name = theirs"]
        lines += column_lines(base, draft.kind, todo, table=not draft.runs)
    elif draft.saved:
        lines += ["", "[source]", f"format = {toml('pmmkit')}"]
    for file, campaign in draft.saved:
        for run in campaign:
            lines += ["", *saved_run_lines(file, run)]
    common, runs, tables = in_common(draft.runs, draft.tables)
    lines += default_lines(common, (*draft.runs, *tables), computed, todo)
    for matrix in draft.matrices:
        lines += ["", *matrix_lines(matrix, todo)]
    for entry in runs:
        if entry.listed:
            continue
        lines += [
            "",
            *entry_lines(entry, "runs", base, draft.kind, todo, apart=apart, computed=computed),
        ]
    for entry in tables:
        lines += ["", *entry_lines(entry, "tables", base, draft.kind, todo)]
    sheets = {entry.look.shown: entry.look for entry in draft.tables}
    lines += ["", *scatter_lines(list(sheets.values()))]
    if len({entry.sheet for entry in draft.tables if entry.look.blocks.mixed}) > 1:
        told = all(any(x.key == "depth" for x in entry.settings) for entry in draft.tables)
        todo.add(_DEPTHS if told or "depth" in draft.particulars else _SHEETS)
    if draft.named_tests:
        first = ", ".join(draft.named_tests[:_FIRST])
        left = len(draft.named_tests) - _FIRST
        more = f" and {left} more" if left > 0 else ""
        todo.add(f"Named as tests, but not taken, for no column of time is found: {first}{more}.")
    lines += [*_unused(draft), "", "[end]"]
    entries = (
        sum(len(campaign) for _, campaign in draft.saved) + len(draft.runs) + len(draft.tables)
    )
    return CampaignText(
        text=with_density("\n".join(lines) + "\n"),
        todo=tuple(todo.all()),
        complete=entries - len(todo.open_runs),
    )


_FIRST: Final = 4
_SHEETS: Final = (
    "The runs stand on several sheets. If the water was not as deep for all of them, state depth = "
    "... [m] of each table."
)
_DEPTHS: Final = "[[tables]] depth: taken by sheet from a list beside the tests. Is it so?"


def _campaign(draft: Draft, todo: Todo) -> list[str]:
    lines = ["[campaign]", f"title = {toml(draft.title)}", f"kind = {toml(draft.kind)}"]
    lines.append("closed = true                    # the last line is [end]: a cut is noticed")
    if draft.saved:
        return [*lines, *_as_saved(draft.saved[0][1], todo)]
    if draft.kind == "free-running":
        todo.add("[campaign] rudder_positive, and [axes] if x, y or z point the other way.")
        return [*lines, _turns(draft.runs)]
    gauged = any({*run.look.known} >= GAUGES for run in draft.runs)
    if gauged:
        todo.add("[campaign] side_gauges_x: where do the gauges Y_forward and Y_aft stand?")
    else:
        todo.add("[campaign] moment_reference_x: to which point do the moments refer?")
    return [
        *lines,
        _forces(draft.proposal, todo),
        *_signs(draft.proposal, todo, steered=_steered(draft)),
        *([_PLACES] if gauged else [_POINT]),
        '# free = ["heave", "pitch"]      # TODO what the mount leaves free',
    ]


def _turns(runs: Sequence[RunDraft]) -> str:
    """Which way a positive rudder turns the ship, by all records that tell it."""
    told = [run.turned for run in runs if run.turned]
    if not told or abs(sum(told)) < len(told):
        return _TURNS
    side, way = ("starboard", "raises") if told[0] > 0 else ("port", "lowers")
    seen = f"+ rudder {way} psi in {len(told)} of {len(runs)} records"
    return aligned(f'rudder_positive = "{side}"', f"{seen}; TODO right where psi is + to starboard")


_POINT: Final = (
    "# moment_reference_x = 0.0       # TODO point to which moments refer, forward of midship"
)
_PLACES: Final = (
    "# side_gauges_x = ...            # TODO places of Y_forward and Y_aft [m] forward of midship, "
    "such as [1.2, -1.1]"
)
_TURNS: Final = 'rudder_positive = "starboard"    # TODO "port" if + rudder turns her to port'


def _forces(proposal: Proposal | None, todo: Todo) -> str:
    if proposal is not None and proposal.balance is not None:
        forces = "balance" if proposal.balance else "hydrodynamic"
        if proposal.balance:
            todo.add('Proposed from the physics of all runs: forces = "balance". Is it so?')
        return aligned(f'forces = "{forces}"', proposal.why_balance)
    todo.add(
        "[campaign] forces: is the inertia of the model removed from the forces of oscillating "
        "tests?"
    )
    return 'forces = "hydrodynamic"          # TODO "balance" if the model\'s inertia is in them'


def _steered(draft: Draft) -> bool:
    """Whether a rudder is set or recorded in some run."""
    entries = (*draft.runs, *draft.tables)
    named = {name for entry in entries for name in (*entry.look.known, entry.test or "")}
    named |= {setting.key for entry in entries for setting in entry.settings}
    named |= {name for matrix in draft.matrices for name in matrix.settings}
    return any("rudder" in name or name == "delta" for name in named)


def _signs(proposal: Proposal | None, todo: Todo, *, steered: bool) -> list[str]:
    """How drift and rudder are counted: as physics says, else asked."""
    found = None if proposal is None else proposal.convention
    rudder = [_TURNS] if steered else []
    if proposal is None or found is None:
        todo.add(
            "[campaign] signs: which way drift and rudder are positive ([axes] if x, y or z point "
            "the other way)."
        )
        asked = '# TODO "port-bow" if they count drift the other way'
        return [f'drift_positive = "starboard-bow" {asked}', *rudder]
    bow = "port-bow" if "drift" in found.flips else "starboard-bow"
    drift = f'drift_positive = "{bow}"'
    if "drift" in proposal.recorded and "drift" not in found.flips:
        drift = aligned(f"# {drift}", "drift was recorded: it goes with [axes]")
    if "rudder" in found.flips:
        rudder = ['rudder_positive = "port"']
    if found.changes:
        todo.add(f"Proposed from the physics of all runs: {found}. Is it so?")
    return [
        *commented(f"Axes and signs by the physics of all runs: {proposal.seen}."),
        "# All sideways forces and motions turned at once would give the same but for Y0 and N0.",
        drift,
        *rudder,
    ]


def _as_saved(saved: Campaign, todo: Todo) -> list[str]:
    """What a saved campaign says of all of its runs."""
    todo.add(
        "[uncertainty], [propeller], [rudder], [cfd] of the saved campaign are not repeated. Open "
        "the saved file itself if nothing is to be changed."
    )
    keys = ("moment_reference_x", "moment_reference_z", "motion_reference_x")
    stated = [f"{key} = {toml(getattr(saved, key))}" for key in keys if getattr(saved, key)]
    free = [f"free = {toml(saved.free)}"] if saved.free else []
    return [f"forces = {toml(saved.forces)}", *stated, *free]


def _ship(draft: Draft, todo: Todo) -> list[str]:
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
    elif draft.particulars:
        return _listed(draft, todo)
    else:
        todo.add(
            "[ship] the particulars L, B, d, mass or volume, Izz, or the name of a library ship."
        )
        lines = [
            "[ship]",
            '# name = "..."                   # TODO a ship of the library (pmmkit ships), or:',
            *map(_asked, _OF_SHIP_ASKED),
            "# xG = 0.0                       # TODO centre of gravity forward of midship [m]; if "
            "absent 0 ± 0.04 L where a balance weighs the model",
            *(_ROLL if any("K" in entry.look.known for entry in draft.runs) else ()),
        ]
    return [*lines, "", "[water]", _density(draft)]


def _density(draft: Draft) -> str:
    """As listed, else as `with_density` guesses it."""
    rho, where = draft.particulars.get("rho", (None, ""))
    return TANK_WATER if rho is None else aligned(f"rho = {rho:g}", where)


def _asked(key: str) -> str:
    """The line of a particular that nobody stated."""
    return aligned(f"# {key} = ...", f"TODO {_OF_SHIP_ASKED.get(key, key)}")


_OF_SHIP_ASKED: Final = {
    "L": "length between perpendiculars [m]",
    "B": "breadth [m]",
    "d": "draught [m]",
    "mass": "mass as tested [kg], or volume = ... [m³]",
    "Izz": "yaw inertia about midship [kg m²]",
}


def _listed(draft: Draft, todo: Todo) -> list[str]:
    """Ship and water as a list beside the tests has them."""
    found = draft.particulars
    todo.add("[ship] taken from a list beside the tests: is it the model as it was tested?")
    lines = ["[ship]"]
    for key in _OF_SHIP:
        if key in found:
            lines.append(aligned(f"{key} = {toml(found[key][0])}", found[key][1]))
        elif key == "Izz" and draft.kind == "free-running" and (guess := _inertia(found)):
            lines.append(guess)
        elif key not in ("mass", "xG") and not (key == "volume" and "mass" in found):
            lines.append(_asked(key))
            todo.add(f"[ship] {key}: it is not in the list.")
    lines += ["", "[water]", _density(draft)]
    if "depth" in found:
        lines.append(aligned(f"depth = {toml(found['depth'][0])}", found["depth"][1]))
    return lines


def _inertia(found: Found) -> str:
    """The yaw inertia as most ships have it: the manoeuvres of a record are measured without it."""
    stated = {key: value for key, (value, _) in found.items() if isinstance(value, float)}
    value, why = estimate_of("ship.Izz", {"ship": stated, "water": stated})
    return aligned(f"Izz = {value}", f"{why}; TODO {_OF_SHIP_ASKED['Izz']}") if value else ""


def _behind(draft: Draft) -> list[str]:
    """What is known of propeller and rudder."""
    known: dict[str, tuple[Any, str]] = dict(draft.particulars)
    if draft.open_water:
        known["propeller.open_water"] = (draft.open_water, "the only file with J, KT and KQ")
    tables: dict[str, list[str]] = {}
    for place, (value, where) in known.items():
        table, _, key = place.partition(".")
        if key:
            tables.setdefault(table, []).append(aligned(f"{key} = {toml(value)}", where))
    return [line for table, own in tables.items() for line in ("", f"[{table}]", *own)]


_OF_SHIP: Final = ("L", "B", "d", "volume", "mass", "Izz", "xG")
_ROLL: Final = (
    "# zG = 0.0                       # TODO centre of gravity below the origin [m]",
    "# GM = ...                       # TODO metacentric height [m], for a model that rolls",
    "# Ix = ...                       # TODO inertia of roll [kg m²], for a model that rolls",
)
"""What roll asks of a ship, where K was measured."""


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
    mixed = [entry.look for entry in draft.tables if entry.look.blocks.mixed]
    if not draft.runs and mixed and len(mixed) == len(draft.tables):
        alike = all(look.columns == mixed[0].columns for look in mixed)
        # not itself: each table says its own sheet
        return replace(mixed[0]) if alike else None
    return looks[max(counted, key=lambda key: counted[key])] if counted else None


def _unused(draft: Draft) -> list[str]:
    lines = [f"# {printable(text)}" for text in draft.unused]
    listing = {matrix.look.shown for matrix in draft.matrices}
    problems = [problem for problem in draft.look.problems if problem.file not in listing]
    lines += [f"# {printable(str(problem))}" for problem in problems]
    return ["", "# Files that are not used:", *lines] if lines else []
