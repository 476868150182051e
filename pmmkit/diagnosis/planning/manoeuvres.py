"""The next manoeuvre of a free-running ship, and captive tests where none tells rivals apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.any_campaign import complete_model
from pmmkit.diagnosis.captive.candidate import no_such_effect
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.free_running.base import known_faults
from pmmkit.diagnosis.free_running.diagnose import FreeSystem, answer, free_system
from pmmkit.diagnosis.planning.free_offer import FreeOffer, free_offer
from pmmkit.diagnosis.planning.ground import Asked, ground_of
from pmmkit.diagnosis.planning.options import Limits, Option
from pmmkit.diagnosis.planning.planned_records import COURSES, RUN_UP, free_options
from pmmkit.diagnosis.planning.programme import TestPlan, plan, sights
from pmmkit.diagnosis.planning.ranking import Advice, apart, apart_at_usual_size, shown
from pmmkit.effects import CATALOGUE, CURRENT
from pmmkit.identification import FreeRecord
from pmmkit.models import Model, scaled
from pmmkit.presentation import counted

TOWED: Final = 6.0
"""Length of the model that captive tests are planned for, of a ship that is longer [m]."""
CAPTIVE_RUNS: Final = 8
"""Captive tests that are thought of where no manoeuvre tells rivals apart."""


def next_manoeuvres(
    model: Asked,
    records: Campaign | Sequence[FreeRecord],
    found: Diagnosis | None = None,
    *,
    effects: Sequence[str] = (),
    limits: Limits | None = None,
    options: Sequence[Option] | None = None,
    most: int = 10,
    **settings: Any,
) -> Advice:
    """Which manoeuvre, or which captive tests, to make next.

    Parameters
    ----------
    model : Model, str or path
        Complete, as for `diagnose`.
    records : Campaign or sequence of FreeRecord
        At least two.
    found : Diagnosis, optional
        Of that model and these records; made if absent.
    effects : sequence of str
        What to ask about, as for `next_runs`.
    limits : Limits, optional
        Speeds, the largest rudder angle and the wait between runs count; by default the speeds of
        the records and the rudder of the model.
    options : sequence of Option, optional
        Of no use here: captive tests.
    most : int
        Manoeuvres that are listed.
    **settings
        As for `diagnose_free`: ``floor``, ``window``, ``spread``, ``sensors``, ``candidates``,
        ``windage``, ``extrapolate`` and ``progress``.

    Returns
    -------
    Advice
        With captive tests where no manoeuvre tells the rivals apart.

    Raises
    ------
    DataError
        If there are fewer than two records, the diagnosis is of other tests, or captive tests are
        given to choose from.
    UnknownNameError
        If an effect does not take part.

    Notes
    -----
    A manoeuvre is simulated without noise, by the best model, in the wind of the last record and
    the current that was found. The diagnosis of records then tells what such a record would say of
    the values, in windows, beside the sensors' noise and unknown forces of the size found. Each
    rival predicts it with its coefficients and its base as uncertain as the records leave them, the
    base at each spread by its share; the gain in ln odds to be expected is the divergence of one
    prediction from the other, as for captive tests.
    """
    if options is not None:
        raise DataError(
            "Runs to choose from are captive tests; free-running records take [limits]."
        )
    complete = complete_model(model)
    system = free_system(complete, records, **settings)
    if len(system.records) < 2:
        raise DataError(
            "What one record leaves open cannot be told: make a second manoeuvre, to the other "
            "side if the first is a turn, and plan with at least two."
        )
    there = {item.name for item in system.every}
    begun = tuple(name for name in known_faults(complete, system.records) if name in there)
    known = [item.name for item in system.every if item.name not in begun]
    for name in effects:
        if name not in known:
            raise no_such_effect(name, known)
    allowed = limits or Limits.of_records(complete, system.records)
    if not effects and found is None:
        found = answer(system, begun)
    group = () if effects or found is None else found.group
    strange = {name for names, _ in group for name in names} - set(known)
    if strange:
        raise DataError(
            f"The diagnosis names {', '.join(sorted(strange))}, which these records cannot be "
            "asked for: it is of other tests. Leave it out, or diagnose these records."
        )
    rivals = tuple(dict.fromkeys(name for names, _ in group for name in names))
    offer = free_offer(
        system,
        group[0][0] if group else (),
        free_options(allowed, complete.ship.L, courses=_courses(system, rivals or effects)),
        given=begun,
        rivals=rivals if len(group) > 1 else None,
        wait=allowed.wait,
        tell=system.tell,
    )
    advice = replace(_asked(offer, effects, group, most), notes=_taken_for_granted(system, allowed))
    return _with_captive_tests(advice, complete, allowed)


def _taken_for_granted(system: FreeSystem, limits: Limits) -> tuple[str, ...]:
    """How time is counted, and the weather."""
    time = (
        f"Hours are those of the record, of a run-up of {RUN_UP:g} ship lengths, and "
        f"{limits.wait / 60.0:g} min to the next run."
    )
    wind = "The wind is that of the last record of like speed."
    return (time, wind) if _windy(system) else (time,)


def _windy(system: FreeSystem) -> bool:
    return any(item.wind_speed is not None for item in system.records)


def _asked(
    offer: FreeOffer,
    effects: Sequence[str],
    group: Sequence[tuple[tuple[str, ...], float]],
    most: int,
) -> Advice:
    if len(effects) > 1:
        return apart_at_usual_size(offer, effects, most)
    if len(group) > 1:
        rivals, against = zip(*group, strict=True)
        return apart(offer, rivals, against, most)
    advice = shown(offer, effects, most)
    if effects:
        return advice
    alone = f"{' and '.join(group[0][0])} stands alone" if group else "nothing is named"
    return replace(advice, words=f"The records leave no rivals: {alone}. {advice.words}")


def _courses(system: FreeSystem, names: Sequence[str]) -> Sequence[float]:
    """Courses on which what is asked may show differently: in wind, or where a current may be."""
    flows = any(
        name in CURRENT for item in system.every if item.name in names for name in item.values
    )
    return COURSES if _windy(system) or flows else COURSES[:1]


def _with_captive_tests(advice: Advice, model: Model, limits: Limits) -> Advice:
    """The advice, with captive tests where rivals are left that no manoeuvre tells apart.

    Faults of the records' own instruments are no matter of captive tests.
    """
    every = CATALOGUE
    asked = [
        name
        for name in advice.wanted
        if name in every and not every[name].faulty and not every[name].not_captive
    ]
    if advice.runs or not advice.rivals or not asked:
        return advice
    made = captive_tests(model, asked, limits)
    if made is None:
        return advice
    seen = {item.name for item in made.sights}
    settled = " and ".join(name for name in asked if name in seen)
    words = (
        f"{advice.words} Or captive tests that settle {settled}: "
        f"{counted(len(made.steps), 'run')} in {made.hours:.1f} h."
    )
    towed = f"Captive tests are those of a model of {min(model.ship.L, TOWED):g} m."
    return replace(advice, captive=made, words=words, notes=(*advice.notes, towed))


def captive_tests(model: Model, effects: Sequence[str], limits: Limits) -> TestPlan | None:
    """The first captive tests of a plan that show effects and tell them apart.

    They are those of the ship, or of a model of her.
    """
    ratio = max(model.ship.L / TOWED, 1.0)
    towed = scaled(model, model.ship.L / ratio) if ratio > 1.0 else model
    speeds = tuple(speed / math.sqrt(ratio) for speed in limits.speeds)
    rig = Limits(speeds=speeds, rudder=limits.rudder, wait=limits.wait)
    ground = ground_of(towed, limits=rig)
    asked = {name for name in effects if name in ground.candidates}
    if not asked:
        return None
    made = plan(towed, limits=rig, effects=sorted(asked), runs=CAPTIVE_RUNS)
    runs = [step.option.run().id for step in made.steps]
    for count in range(1, len(runs) + 1):
        known = [item for item in sights(ground, runs[:count]) if item.name in asked]
        if all(item.shown and not asked & set(item.twins) - {item.name} for item in known):
            return replace(made, steps=made.steps[:count])
    return None
