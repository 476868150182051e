"""The form filled in: its fields, for a model, and for the trials of a ship."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.conventions import Criterion, Ship
from pmmkit.equations import prepare
from pmmkit.identification import Corrected, Trial
from pmmkit.imo import Condition, Verdict, simulated_conditions
from pmmkit.models import Model
from pmmkit.views.report.imo_form.form import FormField, ImoForm, lines_of

# The fields of the form: from the ship, and from what the table ``[imo]`` states.


TABLE: Final = "imo"
SAME: Final = 0.005
"""Share by which two draughts may differ and be taken for one."""


def read_stated(file: Path) -> dict[str, Any]:
    """The table ``[imo]`` of a file.

    Parameters
    ----------
    file : Path
        TOML; a campaign file is one too.

    Raises
    ------
    DataError
        If the file has no such table, or with everything that is wrong in it.
    """
    from pmmkit.campaigns import CampaignFile
    from pmmkit.files import read_toml

    content = read_toml(file)
    if not isinstance(content.get(TABLE), Mapping):
        raise DataError(f"{file} has no table [{TABLE}]; docs/imo.md lists its keys.")
    return CampaignFile.stated(TABLE, content[TABLE], str(file))


def ship_entries(stated: Mapping[str, Any], ship: Ship, speed: float) -> tuple[FormField, ...]:
    """The ship at full load, in the order of the form.

    speed [m/s].
    """
    full = stated.get("full_load_draught")
    same = full is not None and abs(ship.d / full - 1.0) <= SAME
    draught = ship.d if full is None else full
    note = f"at {ship.d:.4g} m, loading not supplied" if full is None else ""
    block = stated.get("full_load_block", ship.block if same or full is None else None)
    area = stated.get("rudder_area")
    return (
        _words("ship_type", "ship type", stated),
        FormField(name="L", title="length L", value=ship.L, unit="m"),
        FormField(name="L_over_V", title="L/V", value=ship.L / speed, unit="s"),
        FormField(name="L_over_B", title="L/B", value=ship.L / ship.B),
        FormField(name="B_over_T", title="B/T", value=ship.B / draught, note=note),
        FormField(name="block", title="block coefficient CB", value=block, note=note),
        FormField(name="full_load_draught", title="full load draught T", value=full, unit="m"),
        FormField(
            name="full_load_trim",
            title="trim of full load, by the stern",
            value=stated.get("full_load_trim"),
            unit="m",
        ),
        _words("rudder_type", "rudder type", stated),
        _words("rudders", "number of rudders", stated),
        FormField(
            name="rudder_area_over_LT",
            title="total rudder area/(L T)",
            value=None if area is None else area / (ship.L * draught),
        ),
        _words("propeller_type", "propeller type", stated),
        _words("propellers", "number of propellers", stated),
        _words("engine_type", "engine type", stated),
        _words("ballast", "ballast condition", stated),
    )


def head_entries(stated: Mapping[str, Any]) -> tuple[FormField, ...]:
    """To whom the form goes."""
    return (
        _words("administration", "administration", stated),
        _words("reference", "reference number", stated),
    )


def loading_entries(
    stated: Mapping[str, Any], ship: Ship, loading: str | None
) -> tuple[FormField, ...]:
    """The loading as tried."""
    fore, aft = stated.get("draught_fore"), stated.get("draught_aft")
    draught, trim = ship.d, None
    if fore is not None and aft is not None:
        draught, trim = 0.5 * (fore + aft), aft - fore
    return (
        FormField(name="loading", title="loading condition", value=loading),
        FormField(name="draught", title="mean draught", value=draught, unit="m"),
        FormField(name="trim", title="trim, by the stern", value=trim, unit="m"),
    )


def sailed_entries(
    *, speed: str | float | None, rudder: str | float | None, revolutions: float
) -> tuple[FormField, ...]:
    """How the tests were sailed: approach speed [m/s], rudder [deg], revolutions [1/s]."""
    turns = 60.0 * revolutions if math.isfinite(revolutions) else None
    return (
        FormField(name="speed", title="approach speed", value=speed, unit="m/s"),
        FormField(name="rudder", title="rudder of the turning circle", value=rudder),
        FormField(
            name="revolutions", title="revolutions of the approach", value=turns, unit="1/min"
        ),
    )


def place_entries(stated: Mapping[str, Any]) -> tuple[FormField, ...]:
    """Where and when."""
    return (_words("place", "place", stated), _words("date", "date", stated))


def loading_words(draught: float, full: float | None, *, corrected: bool) -> str | None:
    """Whether tests were made at full load; None where that is not known.

    draught [m]; full [m].

    Examples
    --------
    >>> loading_words(20.5, 20.8, corrected=False)
    'tested at full load'
    >>> loading_words(11.0, 20.8, corrected=True)
    'tested at partial load and corrected'
    """
    met = Condition.of_draught(draught, full).met
    if corrected:
        return "tested at partial load and corrected"
    if met is None:
        return None
    return "tested at full load" if met else "tested at partial load, not corrected"


def _words(name: str, title: str, stated: Mapping[str, Any]) -> FormField:
    return FormField(name=name, title=title, value=stated.get(name))


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
        model, speed, depth=depth, full_speed=said.get("speed_85"), full_draught=full
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
        lines = tuple(
            replace(
                line,
                tried=any((run, line.criterion.name) not in carried for run in line.runs.values()),
            )
            for line in lines
        )
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
