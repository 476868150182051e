"""Axes and signs for a draft: its runs are read, and what they say together is tried on them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeVar

from pmmkit.base import DataError
from pmmkit.campaigns import TEST_KINDS, Campaign, Run, campaign_of
from pmmkit.intake.checks.finding import Summary
from pmmkit.intake.checks.inertia import inertia_beside_mass
from pmmkit.intake.checks.physics import AskedSign, along_tank, asked_signs, inertia_inside
from pmmkit.intake.checks.reading import summarise
from pmmkit.intake.drafts.columns import ColumnChoice
from pmmkit.intake.drafts.conventions import Proposal, SourceConvention, ranked
from pmmkit.intake.drafts.draft import Draft, RunDraft, draft_of
from pmmkit.intake.drafts.entries import guessed_source
from pmmkit.intake.drafts.names import RunKey
from pmmkit.intake.drafts.write import written
from pmmkit.intake.file import LARGE
from pmmkit.intake.guessing import Suggestion
from pmmkit.intake.seen import FileLook
from pmmkit.readers import READERS

# A draft tried before a person has completed it, to ask its runs what they say together.


Item = TypeVar("Item")

_SHIP: Final[Mapping[str, Any]] = {
    "name": "stand-in",
    "L": 4.0,
    "B": 0.6,
    "d": 0.25,
    "volume": 0.4,
    "mass": 400.0,
    "Izz": 400.0,
}
"""A ship for drafts that name none: it scales forces and changes no sign."""
_WATER: Final[Mapping[str, Any]] = {"rho": 1000.0}
_GAUGES: Final = [0.25, -0.25]
"""Places of two gauges [m] where nobody states them: either gives the moment its sign."""
_SPEED: Final = 1.0
"""Speed [m/s] where nobody knows it; the same for all runs, so that it changes no sign."""
_MOST: Final = 12
"""Histories of a kind of test that are read, evenly among them: enough for every sign."""


def trial_campaign(text: str, target: Path, source: Mapping[str, str]) -> Campaign | None:
    """The runs of a campaign file that are complete, with stand-ins for ship, water and speed."""
    raw: dict[str, Any] = tomllib.loads(text)
    ship = raw.get("ship", {})
    if "name" not in ship:
        weighed = {"mass", "volume"} if {"mass", "volume"} & {*ship} else set()
        stand_in = {key: value for key, value in _SHIP.items() if key not in weighed}
        raw["ship"] = {**stand_in, **ship}
    raw["water"] = {**_WATER, **raw.get("water", {})}
    raw["campaign"] = {"side_gauges_x": _GAUGES, **raw.get("campaign", {})}
    stated = raw.get("defaults", {})
    raw["defaults"] = {"speed": _SPEED, **stated, "source": {**source, **stated.get("source", {})}}
    found = [campaign for part in _parts(raw) if (campaign := _opened(part, target)) is not None]
    if not found:
        return None
    return found[0].with_(runs=tuple(run for campaign in found for run in campaign.runs))


def knows_speed(text: str) -> bool:
    """Whether a draft states the speed of all of its runs."""
    raw = tomllib.loads(text)
    entries = [entry for name in ("runs", "tables", "matrix") for entry in raw.get(name, [])]
    shared = raw.get("columns", {}) if "tables" in raw and "runs" not in raw else {}
    return "speed" in raw.get("defaults", {}) or all(
        "speed" in entry or {"speed", "u"} & {*shared, *entry.get("columns", {})}
        for entry in entries
    )


def summaries_of(campaign: Campaign) -> tuple[Summary, ...]:
    """What the runs say, of some histories of each kind of test and of all rows of tables, whose
    steady tests need drift and rudder one by one; those that cannot be read are left out."""
    kinds: dict[tuple[str, str], list[Run]] = {}
    for run in campaign:
        kinds.setdefault((run.test, run.kind), []).append(run)
    found = []
    for (_, kind), runs in kinds.items():
        for run in _some(runs) if kind == "history" else runs:
            try:
                if not _large(run):
                    found.append(summarise(run, campaign))
            except DataError:
                continue
    return tuple(found)


def _parts(raw: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The file with one run, table or matrix each: what is wrong with one leaves the others.

    Of many runs of a kind of test some are taken, evenly among them.
    """
    names = ("runs", "tables", "matrix")
    rest = {name: item for name, item in raw.items() if name not in names}
    for name in names:
        kinds: dict[Any, list[Any]] = {}
        for entry in raw.get(name, []):
            kinds.setdefault(entry.get("test"), []).append(entry)
        for entries in kinds.values():
            for entry in _some(entries) if name == "runs" else entries:
                yield {**rest, name: [entry]}


def _some(items: Sequence[Item]) -> Sequence[Item]:
    return items[:: -(-len(items) // _MOST)]


def _opened(raw: Mapping[str, Any], target: Path) -> Campaign | None:
    try:
        return campaign_of(raw, target)
    except DataError:
        return None


def _large(run: Run) -> bool:
    path = getattr(run.loader, "path", None)
    return path is not None and path.is_file() and path.stat().st_size > LARGE


_RECORDED: Final = {"drift": {"v", "psi"}, "sway": {"v", "y"}, "yaw": {"r", "psi"}}
"""Channels by which a motion is known from the record."""
_AXES_OF_FORCES: Final = ("forces_in", "moment_centre_moves")


def campaign_draft(
    folder: Path,
    target: Path,
    *,
    ship: str | None = None,
    choices: Sequence[ColumnChoice] = (),
    sheet: str | None = None,
) -> Draft:
    """What a campaign file for the files of a folder can say, with axes and signs by the physics.

    Parameters
    ----------
    folder : Path
        Where the files lie, or a single file.
    target : Path
        The campaign file that is to be written.
    ship : str, optional
        A ship of the library.
    choices : sequence of ColumnChoice
        What a person chose of the columns.
    sheet : str, optional
        The only sheet of workbooks that is meant.

    Raises
    ------
    CampaignError
        If there are no measurements.
    UnknownNameError
        If the library has no such ship.
    """
    return proposed(draft_of(folder, target, ship=ship, choices=choices, sheet=sheet), target)


def proposed(draft: Draft, target: Path) -> Draft:
    """The draft with axes and signs that agree with the physics of all of its runs."""
    if draft.kind != "captive" or draft.saved:
        return draft
    plain = written(_seen_from_mesh(draft)).text
    trial = trial_campaign(plain, target, guessed_source((*draft.runs, *draft.tables)))
    if trial is None:
        return draft
    summaries = summaries_of(trial)
    recorded = _recorded(draft)
    computed = any(READERS[run.look.format].computed for run in draft.runs)
    found = ranked(asked_signs(trial, summaries), recorded=recorded, computed=computed)
    known = Proposal(recorded=recorded)
    if computed:
        why = "computed forces hold no inertia of a model"
        known = replace(known, balance=False, why_balance=why)
    if found.best is None:
        sure = bool(found.remaining) and not found.remaining[0].changes and not found.contradicted
        remaining = () if sure else found.remaining
        return replace(
            draft, proposal=replace(known, remaining=remaining, seen=_words(found.signs))
        )
    proposal = replace(known, convention=found.best, seen=_agreeing(found.signs))
    if found.best.changes:
        summaries = _summaries(_seen_from_mesh(_with(draft, proposal)), target)
    timed = _timed(draft, plain) and not computed
    ship = tomllib.loads(plain).get("ship", {})
    weighed = "name" in ship or ({"L", "B", "d"} <= {*ship} and bool({"mass", "volume"} & {*ship}))
    further = _further(proposal, trial, summaries, timed=timed, weighed=weighed)
    tried = _with(draft, further)
    if not (found.best.changes or computed):
        return tried  # the runs were read as they stand in the draft
    found_then = asked_signs(trial, _summaries(tried, target))
    if against := [sign for sign in found_then if sign.verdict < 0]:
        refused = replace(known, remaining=(found.best,), seen=_words(against))
        return replace(draft, proposal=refused)
    return tried


def _summaries(draft: Draft, target: Path) -> tuple[Summary, ...]:
    campaign = trial_campaign(
        written(draft).text, target, guessed_source((*draft.runs, *draft.tables))
    )
    return () if campaign is None else summaries_of(campaign)


def _further(
    proposal: Proposal, trial: Campaign, summaries: Sequence[Summary], *, timed: bool, weighed: bool
) -> Proposal:
    """With what can be told once the signs are right; of the inertia where r u is known.

    A stated mass tells it, as it does in the check of inertia; a ratio of forces where none is.
    """
    if timed and weighed and (told := inertia_beside_mass(trial, summaries)) is not None:
        why = f"Y/(r u) beside the mass of {trial.ship.mass:.4g} kg: "
        why += "the inertia is inside" if told else "the inertia is removed"
        proposal = replace(proposal, balance=told, why_balance=why)
    elif timed and (inside := inertia_inside(summaries)) is not None:
        why = f"Y/(r u) over Y/(sway acceleration) is {inside[1]:.2f}: "
        why += "0.3 to 0.5 with the inertia"
        proposal = replace(proposal, balance=inside[0], why_balance=why)
    along = along_tank(trial, summaries)
    if along is not None:
        usual = "-1 along the tank" if along[0] else "-0.1 to -0.7 along the hull"
        why = f"X grows with drift squared by {along[1]:+.2f} of Y's slope: about {usual}"
        proposal = replace(proposal, along_tank=along[0], why_along=why)
    return proposal


def _timed(draft: Draft, text: str) -> bool:
    """Whether r u is known: the speed is, or the yaw follows from paths in metres."""
    yawing = [
        run for run in draft.runs if run.test is not None and TEST_KINDS[run.test].pure == "r"
    ]
    paths = all(any(x.key == "path_amplitude_m" for x in run.settings) for run in yawing)
    return knows_speed(text) or (bool(yawing) and paths)


def _recorded(draft: Draft) -> frozenset[str]:
    """Motions that some run recorded, in its file or, of an oscillation, beside it."""
    beside = {"sway", "yaw"} if any(run.motion is not None for run in draft.runs) else set()
    return frozenset(beside) | {
        motion
        for motion, channels in _RECORDED.items()
        if any(channels & set(run.look.known) for run in (*draft.runs, *draft.tables))
    }


def _seen_from_mesh(draft: Draft) -> Draft:
    """The draft with forces as they stand in the files, turned by no heading."""
    return replace(
        draft,
        runs=tuple(
            replace(
                run,
                computation={
                    key: value
                    for key, value in run.computation.items()
                    if key not in _AXES_OF_FORCES
                },
            )
            for run in draft.runs
        ),
    )


def _with(draft: Draft, proposal: Proposal) -> Draft:
    """The draft with what is proposed in its runs and columns."""
    convention = proposal.convention or SourceConvention()
    looks: dict[int, FileLook] = {}

    def turned(look: FileLook) -> FileLook:
        return looks.setdefault(id(look), _turned(look, convention))

    runs = [_begun(run, convention) for run in draft.runs]
    if proposal.along_tank:
        runs = [_along(run) for run in runs]
    return replace(
        draft,
        runs=tuple(replace(run, look=turned(run.look)) for run in runs),
        tables=tuple(replace(entry, look=turned(entry.look)) for entry in draft.tables),
        proposal=proposal,
    )


def _turned(look: FileLook, convention: SourceConvention) -> FileLook:
    """A layout whose columns of turned forces have a factor of -1."""
    return replace(
        look,
        columns=tuple(
            replace(column, suggestion=_opposite(column.suggestion))
            if column.suggestion is not None and column.suggestion.name in convention.flips
            else column
            for column in look.columns
        ),
    )


def _opposite(item: Suggestion) -> Suggestion:
    return replace(
        item, scale=-item.scale, reason=f"{item.reason}; these hulls are held back by it"
    )


def _begun(run: RunDraft, convention: SourceConvention) -> RunDraft:
    """A run whose oscillation begins half a period later, where that is proposed."""
    pure = "" if run.test is None else TEST_KINDS[run.test].leading
    motion = {"v": "sway", "r": "yaw"}.get(getattr(pure, "velocity", ""), "")
    if motion not in convention.flips or any(x.key == "phase_deg" for x in run.settings):
        return run
    later = RunKey(
        key="phase_deg", value=math.degrees(math.pi), reason="forces answer the other way"
    )
    return replace(run, settings=(*run.settings, later))


def _along(run: RunDraft) -> RunDraft:
    """A computation of a constant drift angle whose forces stay along the tank."""
    kind = None if run.test is None else TEST_KINDS[run.test]
    steady = kind is not None and kind.captive and kind.steady
    if not steady or not READERS[run.look.format].computed:
        return run
    turned = {"forces_in": "earth", **READERS[run.look.format].of_moving_mesh}
    return replace(run, computation={**turned, **run.computation})


_ANSWERS: Final = {
    ("Y", "drift"): "Y rises with drift",
    ("N", "drift"): "N rises with drift",
    ("Y", "rudder"): "Y falls with the rudder",
    ("N", "rudder"): "N rises with the rudder",
    ("Y", "sway"): "sway is damped",
    ("N", "sway"): "Nv < 0",
    ("N", "yaw"): "yaw is damped",
    ("X", "ahead"): "X holds back",
}


def _agreeing(signs: Sequence[AskedSign]) -> str:
    """What the runs show with the proposal."""
    said = dict.fromkeys(_ANSWERS[sign.channel, sign.motion] for sign in signs)
    runs = {run for sign in signs for run in sign.runs}
    return f"with what stands here {', '.join(said)} ({len(runs)} runs)"


def _words(signs: Sequence[AskedSign]) -> str:
    return "; ".join(str(sign) for sign in signs)
