"""Criteria of IMO resolution MSC.137(76): what each asks, and whether a ship meets it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.four_quadrant import FOUR_QUADRANT_PROPELLER
from pmmkit.errors import DataError
from pmmkit.metrics import HARD_OVER, Criterion, Metric, criteria
from pmmkit.models import Model, load_model
from pmmkit.models.astern import ESTIMATED, LOST, as_it_stops, reversed_by_bucket
from pmmkit.models.standing import standing
from pmmkit.simulation.imo.full_astern import (
    ASTERN,
    FullAstern,
    reached,
    usual_turns,
    with_torque_limit,
)
from pmmkit.simulation.imo.verdict import (
    Verdict,
    judge,
    track_conditions,
    turning_conditions,
    verdict_of,
)
from pmmkit.simulation.simulate import REVERSAL, simulate, steering
from pmmkit.simulation.track import Track

if TYPE_CHECKING:
    from pmmkit.simulation.ensemble import Ensemble

LARGE: Final = "The administration may allow up to 20 L for ships of large displacement."


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
    >>> from pmmkit.simulation import simulate
    >>> [(v.criterion, v.limit, v.passed) for v in imo_turning(simulate("s175", speed=9.0))]
    [('advance', 4.5, True), ('tactical_diameter', 5.0, True)]
    """
    if track.manoeuvre != "turning":
        raise DataError(f"The criteria are for a turning circle, not for {track.manoeuvre!r}.")
    conditions = turning_conditions(track.rudder_deg, track_conditions(track))
    return [
        verdict_of(metric, item, track, conditions)
        for metric, item in criteria()
        if item.manoeuvre == track.manoeuvre
    ]


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
        is given; 0 for none.
    spread, seed
        As for `monte_carlo`.
    astern : float, optional
        Revolutions of the full astern stop over those of the approach, negative; by default those
        of the manoeuvre `stopping`. The standard does not say them: what other ones give stands
        beside the verdict.
    reversal : float, optional
        Time from that order until those revolutions are reached [s]; by default they fall to zero
        in two ship lengths over the speed and go on at that rate, or as a part ``shaft`` has it.
    torque : float, optional
        Largest torque astern over that of the approach; by default as much as the revolutions
        need. For models that know their torque.
    full_speed : float, optional
        Speed at 85 % of the engine's output [m/s], of which the approach must have 90 %.
    **settings
        Handed on to `simulate`: `fn`, `depth`, `rudder_rate_deg`, `compiled` …

    Returns
    -------
    list of Verdict
        Turning circles, initial turning, zigzags 10/10 and 20/20, stopping. A model that does not
        say what its propeller does astern stops by an estimate of that (`with_estimated_astern`),
        which stands beside the verdict; without an open water ahead the stop is not judged.

    References
    ----------
    IMO resolution MSC.137(76), Standards for ship manoeuvrability, 2002.

    Examples
    --------
    >>> found = imo_verdicts("kcs", 12.35)
    >>> sum(bool(verdict.passed) for verdict in found), len(found)
    (13, 13)
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    drawn = n if spread is not None or loaded.covariance is not None else 0
    tests = sided_tests(loaded)
    warned = standing(loaded, speed)
    found: list[Verdict] = []
    for side in (1.0, -1.0):
        for manoeuvre, starboard, pairs in tests:
            given = starboard | {"rudder_deg": side * starboard["rudder_deg"]}
            track = simulate(loaded, manoeuvre, speed=speed, **settings, **given)
            many = _many(loaded, manoeuvre, speed, drawn, spread, seed, settings, given)
            for metric, item in pairs:
                verdict = verdict_of(
                    metric, item, track, (*track_conditions(track, full_speed), *warned.sentences)
                )
                if many is not None and not warned.forced:
                    probability = many.probability(verdict.metric, verdict.limit)
                    verdict = replace(verdict, probability=probability)
                found.append(verdict)
    sided = {item.name for _, _, pairs in tests for _, item in pairs}
    alone = [(metric, item) for metric, item in criteria() if item.name not in sided]
    engine = FullAstern(
        turns=usual_turns() if astern is None else astern,
        reversal_s=math.nan if reversal is None else reversal,
        torque=torque,
    )
    return [
        *found,
        *(_stopping(loaded, speed, engine, full_speed, settings, *pair) for pair in alone),
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
    hard = min(HARD_OVER, steering(model).get("max_deg", HARD_OVER))
    sided = [(metric, item) for metric, item in criteria() if "rudder_deg" in item.settings]
    tests = groupby(sided, key=lambda pair: (pair[1].manoeuvre, dict(pair[1].settings)))
    found = []
    for (manoeuvre, given), pairs in tests:
        rudder = given["rudder_deg"]
        asked = given | {"rudder_deg": hard if rudder == HARD_OVER else rudder}
        found.append((manoeuvre, asked, tuple(pairs)))
    return found


def _many(
    model: Model,
    manoeuvre: str,
    speed: float,
    n: int,
    spread: float | None,
    seed: int,
    settings: Mapping[str, Any],
    given: Mapping[str, Any],
) -> Ensemble | None:
    if not n:
        return None
    from pmmkit.simulation.ensemble import monte_carlo

    kept = {name: x for name, x in settings.items() if name not in ("compiled", "dt")}
    return monte_carlo(
        model, manoeuvre, speed=speed, n=n, spread=spread, seed=seed, **kept, **given
    )


def _stopping(
    model: Model,
    speed: float,
    engine: FullAstern,
    full_speed: float | None,
    settings: Mapping[str, Any],
    metric: Metric,
    criterion: Criterion,
) -> Verdict:
    """Track reach of a full astern stop, if it is known or can be estimated what happens astern."""
    turning = as_it_stops(model)
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
                f"{', '.join(x.name for x in catalogue().values() if x.astern)} do, and it has no "
                "propeller from whose open water they could be estimated.",
            ),
            unsettled=standing(model, speed).unsettled,
        )
    if not engine.turns < 0.0:
        raise DataError(f"Revolutions of a stop are negative: astern is {engine.turns:g}.")
    allowed = bool(settings.get("extrapolate"))
    limited = (
        turning
        if engine.torque is None
        else with_torque_limit(turning, speed, engine.torque, extrapolate=allowed)
    )
    usual = REVERSAL * model.ship.L / speed
    bucket = reversed_by_bucket(model)

    def stopped(own: float, ship: Model) -> Track:
        given: dict[str, Any] = {"turns": own, **settings}
        if math.isfinite(engine.reversal_s):
            given["reversal_s"] = engine.reversal_s
        elif engine.torque is not None and not bucket:
            given["reversal_s"] = (1.0 - own) * usual
        return simulate(ship, criterion.manoeuvre, speed=speed, **given)

    track = stopped(engine.turns, limited)
    said = (*track_conditions(track, full_speed), LARGE, *standing(model, speed).sentences)
    verdict = verdict_of(metric, criterion, track, said)
    reach = {
        own: stopped(own, limited).metrics[verdict.metric] for own in ASTERN if own != engine.turns
    }
    propeller = ""
    if turning is not model:
        losing = limited.with_values(FOUR_QUADRANT_PROPELLER.name, t_astern=LOST)
        longer = stopped(engine.turns, losing).metrics[verdict.metric]
        propeller = f"{ESTIMATED} With a thrust deduction astern of {LOST:g}: {longer:.3g} L."
    ahead = float(track.n[0])
    there = reached(track.t, track.n, ahead, engine.turns)
    if bucket:
        there = usual if math.isnan(engine.reversal_s) else engine.reversal_s
    found = replace(
        engine,
        bucket=bucket,
        reversal_s=there,
        most=float(track.n.min()) / ahead,
        others=tuple(reach.items()),
        limit=verdict.limit,
        propeller=propeller,
    )
    return replace(verdict, full_astern=found)
