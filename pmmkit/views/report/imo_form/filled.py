"""The form filled in: for a model, and for the trials of a ship."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from pmmkit.campaigns import Campaign
from pmmkit.conventions import Criterion
from pmmkit.equations import prepare
from pmmkit.identification import Corrected, Trial
from pmmkit.imo import Condition, Verdict, simulated_conditions
from pmmkit.models import Model
from pmmkit.views.report.imo_form.fields import (
    head_entries,
    loading_entries,
    loading_words,
    place_entries,
    sailed_entries,
    ship_entries,
)
from pmmkit.views.report.imo_form.form import CriterionLine, FormField, ImoForm, lines_of

SAME_RUDDER: Final = 1.0
"""By which the rudders of two turning circles may differ and be taken for one [deg]."""
Groups = tuple[tuple[str, tuple[FormField, ...]], ...]


def form_of_model(
    model: Model,
    verdicts: Sequence[Verdict],
    *,
    speed: float,
    stated: Mapping[str, Any] | None = None,
    depth: float | None = None,
) -> ImoForm:
    """The form of a simulated ship.

    Parameters
    ----------
    model : Model
        The ship.
    verdicts : sequence of Verdict
        From `imo_verdicts`.
    speed : float
        Test speed [m/s].
    stated : mapping, optional
        The table ``[imo]``.
    depth : float, optional
        Depth of the water that was simulated [m].

    Returns
    -------
    ImoForm
    """
    said, ship = dict(stated or {}), model.ship
    full = said.get("full_load_draught")
    conditions = simulated_conditions(
        ship, speed, depth=depth, full_speed=said.get("speed_85"), full_draught=full
    )
    rudder = min(Criterion.HARD_OVER, model.steering.get("max_deg", Criterion.HARD_OVER))
    revolutions = prepare(model, speed, extrapolate=True).self_propulsion()
    loading = loading_words(ship.d, full, corrected=False)
    groups: Groups = (
        ("", head_entries(said)),
        ("Ship, full load condition", ship_entries(said, ship, speed)),
        (
            "As simulated",
            (
                *loading_entries(
                    said, ship, None if loading is None else loading.replace("tested", "simulated")
                ),
                *sailed_entries(
                    speed=speed, rudder=f"{rudder:g}°", revolutions=revolutions or math.nan
                ),
            ),
        ),
    )
    shown = {*(item.words for item in conditions), Verdict.LARGE}
    told = dict.fromkeys(text for x in verdicts for text in x.conditions if text not in shown)
    return ImoForm(
        name=model.name,
        basis="predicted",
        groups=groups,
        conditions=conditions,
        lines=lines_of([(x.manoeuvre, x) for x in verdicts], L=ship.L, speed=speed),
        assumptions=_assumed(verdicts),
        remarks=(
            *said.get("remarks", ()),
            *told,
            *_large([("", x) for x in verdicts]),
            *model.notes,
        ),
        scale=model.scale,
    )


def form_of_trials(
    campaign: Campaign,
    trials: Sequence[Trial],
    *,
    corrected: Sequence[Corrected] = (),
    notes: Sequence[str] = (),
) -> ImoForm:
    """The form of a full-scale trial.

    Parameters
    ----------
    campaign : Campaign
        Gives the ship and ``[imo]``.
    trials : sequence of Trial
        From `evaluate_trials`.
    corrected : sequence of Corrected
        From `LoadingPrediction.to_full_load`: they stand in the place of what was measured.
    notes : sequence of str
        What keeps that correction from full load.

    Returns
    -------
    ImoForm
        Turning circles are those with the most rudder to each side; of several runs to one side
        it has the one with the least margin.
    """
    said, ship = campaign.imo, campaign.ship
    trials = _with_most_rudder(trials)
    draught, full = campaign.draught, said.get("full_load_draught")
    speeds = [item.speed for item in trials]
    speed = sum(speeds) / len(speeds)
    turns = [item.revolutions for item in trials if math.isfinite(item.revolutions)]
    circles = [item for item in trials if item.manoeuvre == "turning"]
    rudders = [f"{item.rudder_deg:+.1f}° ({item.run})" for item in circles]
    groups: Groups = (
        ("", head_entries(said)),
        ("Ship, full load condition", ship_entries(said, ship, speed)),
        (
            "As tried",
            (
                *loading_entries(
                    said, ship, loading_words(draught, full, corrected=bool(corrected))
                ),
                *sailed_entries(
                    speed=_range(speeds),
                    rudder=", ".join(rudders) or None,
                    revolutions=sum(turns) / len(turns) if turns else math.nan,
                ),
                *place_entries(said),
            ),
        ),
    )
    carried = {(item.run, item.measured.criterion): item.verdict for item in corrected}
    verdicts = [
        (item.run, carried.get((item.run, x.criterion), x))
        for item in trials
        for x in item.verdicts
    ]
    lines = lines_of(verdicts, L=ship.L, speed=speed)
    if carried:
        lines = tuple(replace(line, tried=_is_tried(line, carried)) for line in lines)
    return ImoForm(
        name=ship.name,
        basis="corrected" if corrected else "measured",
        groups=groups,
        conditions=_worst(trials),
        lines=lines,
        assumptions=_assumed([verdict for _, verdict in verdicts]),
        remarks=(*said.get("remarks", ()), *_of_current(trials), *notes, *_large(verdicts)),
        corrections=Corrected.grid(corrected) if corrected else None,
        loaded=bool(corrected) and not notes,
        scale=f"as measured, L = {ship.L:.4g} m",
    )


def _is_tried(line: CriterionLine, carried: Collection[tuple[str, str]]) -> bool:
    """Whether a result of a line was not carried to full load."""
    return any((run, line.criterion.name) not in carried for run in line.runs.values())


def _with_most_rudder(trials: Sequence[Trial]) -> list[Trial]:
    """All runs but turning circles with less rudder than others to the same side."""
    most: dict[bool, float] = {}
    for item in trials:
        if item.manoeuvre == "turning":
            side = item.rudder_deg < 0.0
            most[side] = max(most.get(side, 0.0), abs(item.rudder_deg))
    return [
        item
        for item in trials
        if item.manoeuvre != "turning"
        or abs(item.rudder_deg) > most[item.rudder_deg < 0.0] - SAME_RUDDER
    ]


def _assumed(verdicts: Sequence[Verdict]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(x.full_astern.words for x in verdicts if x.full_astern))


def _large(verdicts: Sequence[tuple[str, Verdict]]) -> tuple[str, ...]:
    """What a stop that is too long may plead."""
    failed = any(x.full_astern and x.passed is False for _, x in verdicts)
    return (Verdict.LARGE,) if failed else ()


def _range(values: Sequence[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:.2f}" if f"{low:.2f}" == f"{high:.2f}" else f"{low:.2f} to {high:.2f}"


def _worst(trials: Sequence[Trial]) -> tuple[Condition, ...]:
    """Each condition in the run that is farthest from meeting it."""
    rank = {False: 2, None: 1, True: 0}
    found = [condition for trial in trials for condition in trial.conditions]
    return tuple(
        max((x for x in found if x.name == name), key=lambda x: (rank[x.met], x.excess))
        for name in dict.fromkeys(x.name for x in found)
    )


def _of_current(trials: Sequence[Trial]) -> list[str]:
    """From how much of a turn the current comes, and by the notes' way too."""
    found = []
    for item in trials:
        if item.current is None or not math.isfinite(item.turned_deg):
            continue
        words = (
            f"{item.run}: current {item.current.speed:.3f} m/s to "
            f"{item.current.direction_deg:03.0f}° from a turn of {item.turned_deg:.0f}°"
        )
        if item.turned_deg < Trial.FULL_TURN:
            words += f" (the notes ask for {Trial.FULL_TURN:g}°)"
        if item.equal_headings is not None:
            words += (
                f"; by the drift of equal headings {item.equal_headings.speed:.3f} m/s to "
                f"{item.equal_headings.direction_deg:03.0f}°"
            )
        found.append(f"{words}.")
    return found
