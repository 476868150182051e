"""Criteria of IMO resolution MSC.137(76): what each asks, and whether a ship meets it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError
from pmmkit.conventions import METRICS, Criterion, Metric
from pmmkit.effects import CATALOGUE
from pmmkit.equations import Gear
from pmmkit.imo.conditions import Condition, simulated_conditions
from pmmkit.imo.verdict import FullAstern, Verdict, judge, reached, track_conditions, verdict_of
from pmmkit.models import Model, Standing, load_model
from pmmkit.simulation import MANOEUVRES, Track, simulate, stopping_ship

if TYPE_CHECKING:
    from pmmkit.simulation import Ensemble

SURE: Final = 0.05
"""A verdict by assumptions is settled where fewer than this share of the ships differ from it."""
STOPPED: Final = "What the engine does in the stop is assumed."


def imo_turning(track: Track) -> list[Verdict]:
    """Turning ability: advance at most 4.5 L, tactical diameter at most 5 L.

    Parameters
    ----------
    track : Track
        A turning circle.

    Returns
    -------
    list of Verdict
        With the conditions of the standard that the track does not meet or does not show.

    Raises
    ------
    DataError
        If the track is no turning circle.

    References
    ----------
    IMO resolution MSC.137(76), Standards for ship manoeuvrability, 2002.

    Examples
    --------
    >>> from pmmkit.simulation.single import simulate
    >>> [(v.criterion, v.limit, v.passed) for v in imo_turning(simulate("s175", speed=9.0))]
    [('advance', 4.5, True), ('tactical_diameter', 5.0, True)]
    """
    if track.manoeuvre != "turning":
        raise DataError(f"The criteria are for a turning circle, not for {track.manoeuvre!r}.")
    return [
        verdict_of(metric, item, track, track_conditions(track), alone=True)
        for metric, item in METRICS.criteria
        if item.manoeuvre == track.manoeuvre
    ]


def metrics_of(track: Track) -> dict[str, Any]:
    """The numbers of a manoeuvre, what they belong to, and the IMO limits beside them.

    Parameters
    ----------
    track : Track
        The manoeuvre.
    """
    return {
        **track.metrics,
        "name": track.name,
        "manoeuvre": track.manoeuvre,
        "rudder_deg": track.rudder_deg,
        "speed": track.speed,
        "Fn": track.Fn,
        "L": track.L,
        "scale": track.scale,
        "notes": list(track.notes),
        "standing": track.standing.to_dict(),
        "tested_range": track.tested.numbers if track.tested else None,
        "imo": [verdict.to_dict() for verdict in imo_turning(track)]
        if track.manoeuvre == "turning"
        else [],
    }


_AROUND: Final = ("depth", "wind_speed", "current_speed", "wave_height", "revolutions")
"""Settings of a simulation that the standard has a condition for."""


def imo_verdicts(
    model: Model | str | Path,
    speed: float,
    *,
    n: int = 2000,
    spread: float | None = None,
    seed: int = 0,
    astern: float | None = None,
    reversal: float | None = None,
    torque: float | None = None,
    full_speed: float | None = None,
    full_draught: float | None = None,
    **settings: Any,
) -> list[Verdict]:
    """Every criterion of the standard, to both sides.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    speed : float
        Test speed [m/s].
    n : int
        Ships drawn for the probability of passing, where the model has a covariance or `spread`
        is given, and of a stop by an engine that is assumed; 0 for none.
    spread, seed
        As for `monte_carlo`.
    astern : float, optional
        Revolutions of the full astern stop over those of the approach, negative. The standard does
        not say them.
    reversal : float, optional
        Time from that order until those revolutions are reached [s], whatever the engine.
    torque : float, optional
        Largest torque astern over that of the approach. What is stated of none of the three is that
        of the model's engine, or assumed with the spread that ships have: see
        `pmmkit.simulation.machinery`.
    full_speed : float, optional
        Speed at 85 % of the engine's output [m/s], of which the approach must have 90 %.
    full_draught : float, optional
        Mean draught of full load [m], from which that of the model may differ by 5 %.
    **settings
        Handed on to `simulate`: `fn`, `depth`, `rudder_rate_deg`, `compiled` …

    Returns
    -------
    list of Verdict
        Turning circles, initial turning, zigzags 10/10 and 20/20, stopping. The stop is that of
        `simulate`; what is assumed of engine and propeller stands beside it with a 95 % band, and
        it is settled where 95 % of such ships agree. A model with neither a propulsion astern nor
        an open water ahead is not judged.

    References
    ----------
    IMO resolution MSC.137(76), Standards for ship manoeuvrability, 2002.

    Examples
    --------
    >>> found = imo_verdicts("kcs", 12.35)
    >>> sum(bool(verdict.passed) for verdict in found), len(found), found[-1].words
    (12, 13, 'not settled')
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    known = spread is not None or loaded.covariance is not None
    draws = {"spread": spread, "seed": seed}
    tests = sided_tests(loaded)
    asked = simulated_conditions(
        loaded,
        speed,
        **{name: settings[name] for name in _AROUND if name in settings},
        full_speed=full_speed,
        full_draught=full_draught,
    )
    found: list[Verdict] = []
    for side in (1.0, -1.0):
        for manoeuvre, starboard, pairs in tests:
            given = starboard | {"rudder_deg": side * starboard["rudder_deg"]}
            track = simulate(loaded, manoeuvre, speed=speed, **settings, **given)
            many = _many(loaded, manoeuvre, speed, n if known else 0, settings | draws, given)
            for metric, item in pairs:
                said = (*track_conditions(track, asked), *track.unfelt, *track.standing.sentences)
                verdict = verdict_of(metric, item, track, said)
                if many is not None and not track.standing.forced:
                    probability = many.probability(verdict.metric, verdict.limit)
                    verdict = replace(verdict, probability=probability)
                found.append(verdict)
    sided = {item.name for _, _, pairs in tests for _, item in pairs}
    alone = [(metric, item) for metric, item in METRICS.criteria if item.name not in sided]
    stated = {"turns": astern, "reversal_s": reversal, "torque": torque}
    given = {name: x for name, x in stated.items() if x is not None}
    if astern is not None and not astern < 0.0:
        raise DataError(f"Revolutions of a stop are negative: astern is {astern:g}.")
    return [
        *found,
        *(
            _stopping(loaded, speed, n, known, draws, asked, settings, given, *pair)
            for pair in alone
        ),
    ]


def sided_tests(
    model: Model,
) -> list[tuple[str, dict[str, Any], tuple[tuple[Metric, Criterion], ...]]]:
    """The tests of the standard that are made to both sides: manoeuvre, settings, what is limited.

    Parameters
    ----------
    model : Model
        Whose largest rudder stands for that of the turning circle where it is less.

    Returns
    -------
    list of (str, dict, tuple)
        Settings to starboard; limited are pairs of metric and criterion.
    """
    hard = min(Criterion.HARD_OVER, model.steering.get("max_deg", Criterion.HARD_OVER))
    sided = [(metric, item) for metric, item in METRICS.criteria if "rudder_deg" in item.settings]
    tests = groupby(sided, key=lambda pair: (pair[1].manoeuvre, dict(pair[1].settings)))
    found = []
    for (manoeuvre, given), pairs in tests:
        rudder = given["rudder_deg"]
        asked = given | {"rudder_deg": hard if rudder == Criterion.HARD_OVER else rudder}
        found.append((manoeuvre, asked, tuple(pairs)))
    return found


def _many(
    model: Model,
    manoeuvre: str,
    speed: float,
    n: int,
    settings: Mapping[str, Any],
    given: Mapping[str, Any],
) -> Ensemble | None:
    """Ships drawn for a probability, where any are asked for."""
    if not n:
        return None
    from pmmkit.simulation import monte_carlo

    kept = {name: x for name, x in settings.items() if name not in ("compiled", "dt")}
    return monte_carlo(model, manoeuvre, speed=speed, n=n, **kept, **given)


def _stopping(
    model: Model,
    speed: float,
    n: int,
    known: bool,
    draws: dict[str, Any],
    asked: tuple[Condition, ...],
    settings: dict[str, Any],
    given: Mapping[str, Any],
    metric: Metric,
    criterion: Criterion,
) -> Verdict:
    """Track reach of a full astern stop, if it is known or can be estimated what happens astern."""
    turning = model.as_it_stops()
    if turning is None:
        return judge(
            metric,
            criterion,
            {},
            L=model.ship.L,
            speed=speed,
            scale=model.scale,
            manoeuvre="stopping, full astern",
            conditions=(
                "Not judged: the model does not say what its propulsion does astern; the effects "
                f"{', '.join(x.name for x in CATALOGUE.values() if x.astern)} do, and it has no "
                "propeller from whose open water they could be estimated.",
            ),
            unsettled=Standing.of(model, speed).unsettled,
        )
    stopping = MANOEUVRES[criterion.manoeuvre]
    allowed = bool(settings.get("extrapolate"))
    ship, guessed = stopping_ship(stopping, model, speed, given, extrapolate=allowed)
    track = simulate(model, criterion.manoeuvre, speed=speed, **settings, **given)
    bucket = ship.has_bucket
    differs = guessed or known or any(part.std for part in ship.parts.values())
    wanted = n if differs else 0
    many = _many(model, criterion.manoeuvre, speed, wanted, settings | draws, given)
    said = (
        *track_conditions(track, asked),
        *track.unfelt,
        Verdict.LARGE,
        *track.standing.sentences,
    )
    verdict = verdict_of(metric, criterion, track, said)
    ordered = stopping.filled(given)["turns"]
    ahead = float(track.n[0])
    there = reached(track.t, track.n, ahead, ordered)
    if bucket:
        there = given.get("reversal_s", Gear.REVERSAL * model.ship.L / speed)
    low, high = (math.nan, math.nan) if many is None else many.interval(verdict.metric)
    engine = FullAstern(
        turns=ordered,
        reversal_s=there,
        most=float(track.n.min()) / ahead,
        torque=given.get("torque"),
        assumed=guessed if turning is model else f"{guessed} {turning.steps[-1].note}".strip(),
        low=low,
        high=high,
        bucket=bucket,
    )
    verdict = replace(verdict, full_astern=engine)
    if many is not None and not track.standing.forced:
        share = many.probability(verdict.metric, verdict.limit)
        verdict = replace(verdict, probability=share)
    verdict = _by_probability(verdict) if guessed else verdict
    heavy = Standing.of(model, speed).heavy
    if heavy:
        verdict = replace(verdict, unsettled=(*verdict.unsettled, heavy))
    return verdict


def _by_probability(verdict: Verdict) -> Verdict:
    """A verdict by assumptions, which is settled where nearly all of them agree."""
    share = verdict.probability
    if share is not None and not SURE <= share <= 1.0 - SURE:
        return verdict
    met = (
        "How many such ships meet the limit was not asked."
        if share is None
        else f"{100 * share:.0f} % of such ships meet the limit."
    )
    why = f"{STOPPED} {met}"
    return replace(verdict, unsettled=(*verdict.unsettled, why))
