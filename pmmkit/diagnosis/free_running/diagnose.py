"""From free-running records to a verdict: noise, a missing effect with its rivals, unexplained."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.campaigns.run import Campaign
from pmmkit.diagnosis.captive.adequacy import LEAST
from pmmkit.diagnosis.captive.verdict import CHANCE, RIVALS
from pmmkit.diagnosis.evidence import Entry
from pmmkit.diagnosis.findings import Diagnosis, Verdict
from pmmkit.diagnosis.free_running.candidates import FreeCandidate, candidate_of, candidates_for
from pmmkit.diagnosis.free_running.evidence import (
    Basis,
    Fit,
    Point,
    Screen,
    chance_of,
    fitted,
    point_at,
    screen,
)
from pmmkit.diagnosis.free_running.findings import (
    BEYOND,
    LEFT,
    Names,
    Settled,
    coverage_of,
    errors_held_out,
    errors_of,
    findings_of,
    flags_of,
    left_over,
    model_of,
)
from pmmkit.diagnosis.free_running.question import judge_of, records_of
from pmmkit.diagnosis.free_running.scores import Judge
from pmmkit.diagnosis.free_running.system import FreeSystem, log_likelihood
from pmmkit.diagnosis.free_running.weighing import FLOOR, TOLERANCE, WINDOW, base_prior
from pmmkit.effects.effect import Effect
from pmmkit.effects.seen import CURRENT, RUDDER_ZERO
from pmmkit.errors import ModelError
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model
from pmmkit.models.vessel import Sailing
from pmmkit.numerics import Array

AHEAD: Final = 4
"""Best pairs that are combined with every third."""
REFITTED: Final = 6
"""Best sets that are fitted through the equations."""
FAR: Final = 2.0 * RIVALS
"""A set so far behind the best by the linear problem is not fitted."""
LONGEST: Final = 6
"""A group of more sets names nothing."""


def diagnose_free(
    model: Model,
    records: Sequence[FreeRecord] | Campaign,
    *,
    prior: Prior | None = None,
    spread: float = 0.05,
    loose: float = 0.1,
    floor: float = FLOOR,
    tolerance: tuple[float, float] = TOLERANCE,
    window: float | None = None,
    held_out: Sequence[FreeRecord] = (),
    held_out_window: float | None = None,
    candidates: Sequence[FreeCandidate | Effect] | None = None,
    own: Sequence[Effect] = (),
    windage: tuple[float, float] | None = None,
    sensors: Mapping[str, float] | None = None,
    most: int = 3,
    extrapolate: bool = False,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Name what a model lacks that free-running records show.

    Parameters
    ----------
    model : Model
        Complete, for example from captive tests, with their covariance.
    records : sequence of FreeRecord or Campaign
        At least two; zigzags and turns to both sides.
    prior : Prior, optional
        What is known of the values of the model; by default `base_prior` with `spread` and `loose`.
    spread, loose : float
        As for `base_prior`.
    floor : float
        Unknown forces below this share of the rms force of a channel do not matter.
    tolerance : (float, float)
        Errors of heading [rad] and of speed over the approach that do not matter over a window.
    window : float, optional
        Length of the windows by which sets are judged [s]; by default 5 ship lengths.
    held_out : sequence of FreeRecord
        Records that take no part but in the errors before and after.
    held_out_window : float, optional
        Length of their windows [s]; by default that of the others.
    candidates : sequence of FreeCandidate or Effect, optional
        Who takes part; by default all of `candidates_for`.
    own : sequence of Effect
        Effects beside the catalogue, on equal terms.
    windage : (float, float), optional
        Frontal and lateral area above water [m²].
    sensors : mapping of str to float, optional
        Standard deviations of channels.
    most : int
        Effects in a set.
    extrapolate : bool
        Allow a speed outside the range of the model's values.
    seed : int
        Of the draws that calibrate chance.
    progress : callable, optional
        Is told what is being done.

    Returns
    -------
    Diagnosis
        The evidence of an `Entry` is how much more probable it makes records left out one after
        another, less ln 2K for each effect.

    Raises
    ------
    DataError
        If there are fewer than two records long enough.

    Notes
    -----
    Each record is followed by a Kalman filter that holds the model and unknown forces, a fast and
    a slow one per channel, of the size that the records make most likely under the largest model
    (all candidates) but not below `floor`. Its innovations are white up to a factor, found from
    the scores of stretches of four ship lengths, by which all information is divided. They are
    made linear in all values, so the values of any set follow from any choice of records.

    That is not the verdict yet: such evidence is large for everything that happens fast, and an
    effect that matters over a manoeuvre is slow. So each record is left out in turn, the base and
    the set fitted to the others, and it is predicted over windows with its measured rudder. One
    error of heading and one of speed count as independent per length of a window. Sets of up to
    `most` effects are ranked by that, the best fitted again by Gauss-Newton. Nothing is named
    unless the records are more probable by more than e after the price, and chance gives the
    filter's evidence of the best effect in less than 1 % of campaigns without any.
    """
    tell = progress or (lambda _: None)
    given = records_of(records, model)
    speed = given[0].speed
    prior = prior or base_prior(model, speed, spread=spread, loose=loose, extrapolate=extrapolate)
    every = (
        candidates_for(model, given, windage=windage, own=own)
        if candidates is None
        else tuple(
            item if isinstance(item, FreeCandidate) else candidate_of(item, Sailing(model, speed))
            for item in candidates
        )
    )
    judge, largest = judge_of(
        model,
        given,
        every,
        prior,
        floor=floor,
        tolerance=tolerance,
        window=window,
        sensors=sensors,
        extrapolate=extrapolate,
        tell=tell,
    )
    system, basis, wider = judge.system, judge.basis, judge.wider
    null = fitted(system, basis, (), wider=wider, begin=largest.z)
    here = point_at(system, basis, null.z)
    seen = screen(here, basis, wider)
    before = judge.left_out(here, ())
    price = math.log(2.0 * len(every))

    def gain(names: Names) -> float:
        return judge.gain(before, judge.left_out(here, names)) - price * len(names)

    tell("Sets of effects")
    sets = _sets([item.name for item in every], gain, most)
    tell("Best sets through the equations")
    settled = _settled(sets, judge, null, before, price, (model, every))
    best = settled[0] if settled else None
    single = max((seen.evidence([n]) for n in best.names), default=-math.inf) if best else -math.inf
    chance = chance_of(seen, single, seed=seed)
    named = best is not None and chance < CHANCE and best.gain > LEAST
    group = [
        (item.names, math.exp(item.gain - settled[0].gain))
        for item in settled
        if item.gain > settled[0].gain - RIVALS and len(item.names) <= len(settled[0].names)
    ]
    many = named and len(group) > LONGEST
    left = left_over(judge, judge.kept_in((best.fit if named and best else null).z))
    forced = _forced(system, system.start + basis.T @ null.z) / wider > BEYOND
    verdict: Verdict = "missing_effect" if named and not many else "noise"
    if many or (not named and forced and left > LEFT):
        verdict = "unexplained"
    told = named and not many and best is not None
    fit = best.fit if told and best else null
    made = model_of(model, every, system, basis, fit)
    refitted = model_of(model, every, system, basis, null)
    numbers = dict(zip(system.names, (system.start + basis.T @ fit.z).tolist(), strict=True))
    current = (numbers.get(CURRENT[0], 0.0), numbers.get(CURRENT[1], 0.0))
    zero = numbers.get(RUDDER_ZERO, 0.0)
    tell("Errors of the records held out")
    errors = errors_of(judge, before, best.errors if told and best else None)
    if held_out:
        errors |= errors_held_out(
            model,
            refitted,
            made if told else None,
            held_out,
            window=held_out_window or window or WINDOW * model.ship.L / speed,
            current=current,
            zero=zero,
            sensors=sensors,
            extrapolate=extrapolate,
        )
    covered = coverage_of(seen, _fewer(here, basis, wider), judge.likeness(null.z), every)
    return Diagnosis(
        verdict=verdict,
        group=tuple(group) if told else (),
        flags=flags_of(told, many, left),
        findings=findings_of(best, judge, before, every, covered) if told and best else (),
        chance=chance,
        covered=covered,
        entries=_entries(sets, settled),
        floor=floor,
        base=MappingProxyType({name: numbers[name] for name in prior.names}),
        errors=MappingProxyType(errors),
        model=made,
        refitted=refitted,
        current=current,
        rudder_zero=zero,
        notes=(
            f"information divided by {wider:.2g}; unknown forces hang together over "
            f"{system.memories[0]:g} and {system.memories[1]:g} ship lengths",
            f"{sum(item.count for item in judge.courses):.0f} independent windows",
        ),
    )


def _entries(sets: Sequence[tuple[Names, float]], settled: Sequence[Settled]) -> tuple[Entry, ...]:
    """All sets, those that were fitted through the equations with what they gave then."""
    gains = dict(sets) | {item.names: item.gain for item in settled}
    order = sorted(gains.items(), key=lambda item: -item[1])
    return tuple(Entry(names=names, log_evidence=gain, values=()) for names, gain in order)


def _forced(system: FreeSystem, values: Array) -> float:
    """ln of how much more likely the records are with unknown forces than with the floor's."""
    small = system.with_shares(system.least)
    return log_likelihood(system, values) - log_likelihood(small, values)


def _fewer(here: Point, basis: Basis, wider: float) -> list[Screen]:
    """The linear problem without one record after another."""
    found = []
    for number in np.unique(here.linear.owners):
        kept = here.linear.owners != number
        found.append(screen(replace(here, G=here.G[kept], y=here.y[kept]), basis, wider))
    return found


def _sets(
    names: Sequence[str], gain: Callable[[Names], float], most: int
) -> list[tuple[Names, float]]:
    """All single effects and pairs, and the best pairs with every third, best first."""
    found: dict[Names, float] = {(name,): gain((name,)) for name in names}
    if most > 1:
        found |= {pair: gain(pair) for pair in combinations(names, 2)}
    if most > 2:
        order = {name: i for i, name in enumerate(names)}
        pairs = sorted((item for item in found if len(item) == 2), key=lambda x: -found[x])
        for pair in pairs[:AHEAD]:
            for other in names:
                three: Names = tuple(sorted({*pair, other}, key=order.__getitem__))
                if len(three) == 3 and three not in found:
                    found[three] = gain(three)
    return sorted(found.items(), key=lambda item: -item[1])


def _settled(
    sets: Sequence[tuple[Names, float]],
    judge: Judge,
    null: Fit,
    before: Array,
    price: float,
    asked: tuple[Model, Sequence[FreeCandidate]],
) -> list[Settled]:
    """The best sets fitted through the equations; what no model can have is left out."""
    found = []
    for names, linear in sets[:REFITTED]:
        if linear < sets[0][1] - FAR:
            break
        fit = fitted(judge.system, judge.basis, names, wider=judge.wider, begin=null.z)
        try:
            model_of(*asked, judge.system, judge.basis, fit)
        except ModelError:
            continue
        errors = judge.left_out(fit.here, names)
        value = judge.gain(before, errors) - price * len(names)
        found.append(Settled(names=names, gain=value, fit=fit, errors=errors))
    return sorted(found, key=lambda item: -item.gain)
