"""From free-running records to a verdict: noise, a missing effect with its rivals, unexplained."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import Workers
from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.captive.candidate import no_such_effect
from pmmkit.diagnosis.captive.verdict import CHANCE
from pmmkit.diagnosis.evidence import LEAST, PRICE, RIVALS, Visible, not_asked, not_held
from pmmkit.diagnosis.findings import Diagnosis, Finding, Nearest, Transfer, Verdict
from pmmkit.diagnosis.free_running.base import FLOOR, SPREAD, FreeBase, base_of, stated_base
from pmmkit.diagnosis.free_running.contest import (
    MOST,
    Contest,
    base_alone,
    contest_of,
    price_of,
    steady,
    why_not,
)
from pmmkit.diagnosis.free_running.disagreement import disagreements
from pmmkit.diagnosis.free_running.findings import (
    NamedSet,
    coverage_of,
    findings_of,
    held_out_errors,
    model_of,
    moved,
    moved_most,
    odd_sizes,
)
from pmmkit.diagnosis.free_running.fits import (
    Linearised,
    SetFit,
    at_place,
    first_place,
    fitted,
    having,
    place_at,
)
from pmmkit.diagnosis.free_running.hypotheses import (
    FreeCandidate,
    Names,
    candidates_for,
    check_seas,
    excited,
    free_candidate_of,
    lacking,
    screen,
    why_not_asked,
)
from pmmkit.diagnosis.free_running.left_out import (
    each,
    kinds,
    log_left_out,
    missed,
    noise_level,
    pooled,
    predicted,
)
from pmmkit.diagnosis.free_running.misfit import LeftOutMisfit, left_out_squares
from pmmkit.diagnosis.free_running.question import RecordQuestion, question_of, records_of
from pmmkit.diagnosis.free_running.transfer import transfers_of
from pmmkit.diagnosis.free_running.windows import WINDOW
from pmmkit.effects import CATALOGUE, OUTSIDE, Effect
from pmmkit.identification import FreeRecord, Prior, sea_notes
from pmmkit.intake import Disagreement
from pmmkit.models import Model, Sailing

# Records, a model and its candidates, with what is made of them once.


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeSystem:
    """What free-running records are asked about a model.

    `model`: complete, without the candidates. `base`: what is known of the values of the model.
    `tell`: is told what is being done. `executor`: who fits the sets. `lost`: records that are
    left out, since the model as it is given turns another way in them.
    """

    model: Model
    records: tuple[FreeRecord, ...]
    every: tuple[FreeCandidate, ...]
    base: FreeBase
    floor: float
    window: float | None
    sensors: Mapping[str, float] | None
    extrapolate: bool
    tell: Callable[[str], None]
    executor: Workers = None
    lost: tuple[str, ...] = ()

    @property
    def speed(self) -> float:
        """Speed of the approach [m/s]."""
        return self.records[0].speed

    @cached_property
    def question(self) -> RecordQuestion:
        """The question, with starts and noise of the records."""
        return question_of(
            self.model,
            self.records,
            self.every,
            self.base,
            floor=self.floor,
            window=self.window,
            sensors=self.sensors,
            extrapolate=self.extrapolate,
            tell=self.tell,
        )

    @cached_property
    def place(self) -> Linearised:
        """The linear problem about the model as it is given, with the slopes of all."""
        question = self.question
        self.tell(f"Slopes of {len(question.numbers.values)} values")
        return first_place(question)

    @cached_property
    def alone(self) -> tuple[Linearised, SetFit]:
        """The base without any effect, as far as it may move, and the linear problem of that."""
        place = self.place
        self.tell("The base alone")
        return base_alone(place)

    @cached_property
    def fit(self) -> Callable[[Names], SetFit]:
        """The base fitted together with a set of candidates, each set once."""
        return cache(lambda names: steady(self._moving(names)))

    @cached_property
    def _moving(self) -> Callable[[Names], SetFit]:
        """The same with a base that moves, each set from where the one before its last ended.

        From the model as it is given the way to several effects is long, and may end elsewhere.
        """

        def made(names: Names) -> SetFit:
            if not names:
                return self.alone[1]
            before = self._moving(names[:-1])
            self.tell(f"Fit with {' and '.join(names)}")
            return fitted(place_at(before.place.question, before.z), names, before.forces)

        return cache(made)

    @cached_property
    def errors(self) -> Callable[[Names, Names], dict[str, float]]:
        """Errors of records left out one after another, by a fit with a set of candidates.

        The noise of the sensors that is taken off is that of a fit with another set.
        """

        def made(names: Names, last: Names) -> dict[str, float]:
            fit = self.fit(names).read_by(self.fit(last).sensors)
            return pooled(predicted(fit, each(self.records)))

        return cache(made)

    def held_out_errors(
        self,
        records: Sequence[FreeRecord],
        window: float | None,
        others: Mapping[str, Model],
        better: tuple[Model, SetFit] | None,
    ) -> dict[str, dict[str, float]]:
        """Errors of records that are held out: of the model as it is given, of others, and of one
        with effects, whose fit corrects the records for faults.

        window [s].
        """
        change = moved(better[1]) if better else {}
        return held_out_errors(
            self.model,
            others,
            better[0] if better else None,
            records,
            window=window or self.window or WINDOW * self.model.ship.L / self.speed,
            corrections={name: x for name, x in change.items() if name in OUTSIDE},
            sensors=self.sensors,
            extrapolate=self.extrapolate,
        )


def free_system(
    model: Model,
    records: Sequence[FreeRecord] | Campaign,
    *,
    prior: Prior | None = None,
    spread: float = SPREAD,
    floor: float = FLOOR,
    window: float | None = None,
    candidates: Sequence[FreeCandidate | Effect | str] | None = None,
    own: Sequence[Effect] = (),
    windage: tuple[float, float] | None = None,
    sensors: Mapping[str, float] | None = None,
    extrapolate: bool = False,
    progress: Callable[[str], None] | None = None,
    also: Sequence[str] = (),
    executor: Workers = None,
) -> FreeSystem:
    """What records are asked about a model; nothing of it is worked out before it is needed."""
    given = tuple(records_of(records, model))
    check_seas(model, given)
    speed = given[0].speed
    offered = {x.name: x for x in candidates_for(model, given, windage=windage, own=own)}
    every: dict[str, FreeCandidate] = offered if candidates is None else {}
    for item in candidates or ():
        if isinstance(item, str) and item not in offered:
            raise no_such_effect(item, list(offered))
        if isinstance(item, str):
            chosen = offered[item]
        else:
            chosen = (
                item
                if isinstance(item, FreeCandidate)
                else free_candidate_of(item, Sailing(model, speed))
            )
        every[chosen.name] = chosen
    beside = {name: offered[name] for name in also if name in offered}
    return FreeSystem(
        model=model,
        records=given,
        every=tuple((every | {n: x for n, x in beside.items() if n not in every}).values()),
        base=(
            base_of(model, speed, spread=spread, extrapolate=extrapolate)
            if prior is None
            else stated_base(prior)
        ),
        floor=floor,
        window=window,
        sensors=sensors,
        extrapolate=extrapolate,
        tell=progress or (lambda _: None),
        executor=executor,
    )


FEW: Final = 1.0 / 3.0
"""Share of the records below which those in which the model turns another way are left out: a
choice; of the Esso Osaka it is 1 of 9."""


def sailing(system: FreeSystem) -> FreeSystem:
    """The system without records in which the model as it is given turns another way.

    About such a motion no linear problem means anything, no step of a fit is taken that does not
    sail them all, and unknown forces that bring it back hide all else: one decides for all (a ship
    that goes astern, of the Esso Osaka). Where many are lost it is the model that is wrong.
    """
    question = system.question
    alone = replace(question, stretches=tuple(item.free for item in question.stretches))
    lost = set(alone.lost(np.zeros(len(question.numbers.every))))
    if not 0 < len(lost) < FEW * len(system.records):
        return system
    kept = [record for number, record in enumerate(system.records) if number not in lost]
    names = [system.records[number].name for number in sorted(lost)]
    system.tell(f"Left out: {', '.join(names)}")
    return replace(system, records=tuple(kept), lost=tuple(names))


ALONE: Final = "noise alone"
"""Row of errors: what is left of records that were left out if nothing is missing."""
DRAWS: Final = 4000
"""Records that are drawn for the chance: of one in a hundred it is known to .16 %."""
LONGEST: Final = 6
"""A group of more sets names nothing."""
MOVED: Final = PRICE
"""ln evidence from which the values of the base are others than those of the model as it is given:
as much as an effect has to bring."""


def diagnose_free(
    model: Model,
    records: Sequence[FreeRecord] | Campaign,
    *,
    prior: Prior | None = None,
    spread: float = SPREAD,
    floor: float = FLOOR,
    window: float | None = None,
    held_out: Sequence[FreeRecord] = (),
    held_out_window: float | None = None,
    candidates: Sequence[FreeCandidate | Effect | str] | None = None,
    own: Sequence[Effect] = (),
    windage: tuple[float, float] | None = None,
    sensors: Mapping[str, float] | None = None,
    most: int = MOST,
    extrapolate: bool = False,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
    executor: Workers = None,
) -> Diagnosis:
    """Name what a model lacks that free-running records show.

    window [s]; held_out_window [s]; windage [m²].

    Notes
    -----
    Each record is cut into windows that do not overlap. Through each the model sails with the
    measured inputs, from a start of its own. Position, heading, velocities and yaw rate are
    compared with what is measured, averaged over short blocks, by ``eᵀV⁻¹e + ln|V|``: V holds the
    noise of the sensors, the start (any start is as good as another), and unknown forces that hang
    together over time, carried through the equations to what they do to the track. So a constant
    push grows into metres, and a current shows by its drift.

    The unknown forces have, for each set of effects, the size that makes the records most probable:
    what no effect explains has to be paid by them. The values of the base may move by a share of
    their usual sizes; the records are averaged over several such shares, none of it among them.
    Sets of up to `most` effects are compared by the probability that is left (Laplace), those in
    front after a fit through the equations. Nothing is named unless the records are more probable
    by more than e after the price, records left out one after another are too, what these are
    missed by above the noise falls, and chance gives such evidence in less than 1 % of campaigns
    without any effect.
    """
    system = free_system(
        model,
        records,
        prior=prior,
        spread=spread,
        floor=floor,
        window=window,
        candidates=candidates,
        own=own,
        windage=windage,
        sensors=sensors,
        extrapolate=extrapolate,
        progress=progress,
        executor=executor,
    )
    system = sailing(system)
    return answer(system, held_out=held_out, held_out_window=held_out_window, most=most, seed=seed)


def answer(
    system: FreeSystem,
    given: Sequence[str] = (),
    *,
    held_out: Sequence[FreeRecord] = (),
    held_out_window: float | None = None,
    most: int = MOST,
    seed: int = 0,
    contest: Contest | None = None,
) -> Diagnosis:
    """The verdict on records and a base that has some of the candidates already."""
    records, speed = system.records, system.speed
    model, every = with_given(system, given)
    if contest is None:
        contest = contest_about(system, given, most=most)
    question = contest.zero.question
    null, settled = contest.null, contest.settled
    best = settled[0] if settled else None
    seen = screen(null.known, question.numbers, null.spread)
    found = best.gain + price_of(best.names, every) if best else -math.inf
    groups = [[at] for at in seen.columns.values()]
    chance = seen.normal.chance_of(found, groups, draws=DRAWS, seed=seed)
    named = (
        best is not None
        and chance < CHANCE
        and best.gain > LEAST
        and float(np.sum(log_left_out(best.fit) - log_left_out(null))) > 0.0
        and left_out_squares(best.fit).falls_from(left_out_squares(null.read_by(best.fit.sensors)))
    )
    group = [
        (item.names, math.exp(item.gain - settled[0].gain))
        for item in settled
        if item.gain > settled[0].gain - RIVALS and len(item.names) <= len(settled[0].names)
    ]
    many = named and len(group) > LONGEST
    told = named and not many
    refit = steady(null)
    better = None
    if told and best:
        # Its steady form, if there can be such a ship.
        held = steady(best.fit)
        better = best.fit if why_not(model, every, held, speed) else held
    last = better or refit
    errors = _errors(contest, refit, better)
    misfit = left_out_squares(last).misfit
    left = misfit.chance < CHANCE
    is_moved = _gained(refit) > MOVED
    apart = Disagreement.telling(
        disagreements(last, null), best.gain if told and best else math.inf
    )
    verdict: Verdict = "missing_effect" if told else "refit" if is_moved else "noise"
    if many or (not told and apart) or (left and not named):
        verdict = "unexplained"
    made = model_of(model, every, last, speed)
    refitted = model_of(model, every, refit, speed)
    change = moved(last)
    corrections = {name: x for name, x in change.items() if name in OUTSIDE}
    if held_out:
        system.tell("Errors of the records held out")
        errors |= system.held_out_errors(
            held_out, held_out_window, {"base refitted": refitted}, (made, last) if told else None
        )
    fewer = [
        screen(null.known.without([j]), question.numbers, null.spread) for j in range(len(records))
    ]
    absent = _absent(system)
    covered = (*coverage_of(seen, fewer, every), *absent)
    return Diagnosis(
        verdict=verdict,
        group=tuple(group) if told else (),
        flags=_flags(
            many,
            [*map(str, apart), *(_reasons(contest, every, last, misfit) if told or left else ())],
        ),
        findings=_findings(
            replace(best, fit=last), contest, every, covered, errors[f"left out, {ALONE}"]
        )
        if told and best
        else (),
        chance=chance,
        covered=covered,
        entries=contest.entries,
        floor=system.floor,
        base=MappingProxyType(_values(question, last)),
        given=tuple(given),
        errors=MappingProxyType({name: MappingProxyType(row) for name, row in errors.items()}),
        model=made,
        refitted=refitted,
        corrections=MappingProxyType(corrections),
        notes=(*_notes(model, question, last), *_lost(system), *_refused(contest)),
        disagreements=apart,
        not_asked=MappingProxyType(_not_asked(system, absent)),
        transfers=_transfers(best, contest) if told and best else (),
        nearest=_nearest(best, refit, misfit) if best and verdict == "unexplained" else None,
    )


def _absent(system: FreeSystem) -> tuple[Visible, ...]:
    """Effects for which the records lack what they must hold."""
    model, records, asked = system.model, system.records, {item.name for item in system.every}
    return tuple(
        not_held(effect.name, effect.family.replace("_", " "), lacks)
        for effect in CATALOGUE.values()
        if effect.name not in asked and effect.asked_in_free_running
        if (lacks := lacking(effect, model, records))
    )


def _not_asked(system: FreeSystem, absent: Sequence[Visible]) -> dict[str, str]:
    """The rest of the catalogue, and why records are not asked for it."""
    why = {
        name: why_not_asked(effect, system.model, system.records)
        for name, effect in CATALOGUE.items()
    }
    # What records could be asked for is left out because somebody chose the candidates.
    chosen = {name for name, reason in why.items() if not reason}
    asked = {item.name for item in system.every} | {item.name for item in absent}
    return not_asked(asked | chosen, lambda effect: why[effect.name])


def contest_about(system: FreeSystem, given: Sequence[str] = (), *, most: int = MOST) -> Contest:
    """All sets of effects against a base that has some of the candidates already."""
    model, every = with_given(system, given)
    if given:
        system.tell("The base alone")
    zero, null = base_alone(having(system.place, given)) if given else system.alone
    return contest_of(
        zero,
        null,
        model,
        every,
        system.speed,
        most=most,
        tell=system.tell,
        executor=system.executor,
    )


def with_given(system: FreeSystem, given: Sequence[str]) -> tuple[Model, tuple[FreeCandidate, ...]]:
    """The model with some of the candidates, and the others."""
    model = system.model
    for item in system.every:
        if item.name in given:
            model = item.added_to(model)
    return model, tuple(item for item in system.every if item.name not in given)


def _errors(contest: Contest, refit: SetFit, best: SetFit | None) -> dict[str, dict[str, float]]:
    """Errors over windows of what is left out in turn: each record, each kind of record.

    The noise of the sensors that is taken off is that of the fit with most in it.
    """
    zero = contest.zero
    records = [item.record for item in zero.question.stretches]
    sensors = (best or refit).sensors
    given, refit = zero.question.read_by(sensors), refit.read_by(sensors)
    errors = {"model as given": pooled(missed(given.followed(zero.z), zero.z, range(len(records))))}
    for name, left_out in (
        ("left out", each(records)),
        *((f"{kind} left out", [numbers]) for kind, numbers in kinds(records).items()),
    ):
        errors[f"{name}, base refitted"] = pooled(predicted(refit, left_out))
        if best is not None:
            errors[f"{name}, with the effects"] = pooled(predicted(best, left_out))
        if name == "left out":
            errors[f"{name}, {ALONE}"] = noise_level(best or refit)
    return errors


def _gained(refit: SetFit) -> float:
    """ln of how much more probable the records are by a base that moves than by one that stands."""
    question = refit.place.question
    numbers = replace(question.numbers, base=question.numbers.base.held)
    still = replace(refit.place, question=replace(question, numbers=numbers))
    held = at_place(still, refit.names, refit.forces, fine=True)
    return refit.log_probability - held.log_probability


def _flags(many: bool, reasons: Sequence[str]) -> tuple[str, ...]:
    """What to warn of."""
    found = ["not_the_whole_story", *reasons] if reasons else []
    return (*(["no_short_group"] if many else []), *found)


def _reasons(
    contest: Contest, every: Sequence[FreeCandidate], last: SetFit, misfit: LeftOutMisfit
) -> list[str]:
    """Why an answer is not the whole story, in words."""
    found = [str(misfit)] if misfit.chance < CHANCE else []
    found += odd_sizes(last, every)
    if last.names and contest.refused:
        names, _, _ = contest.refused[0]
        found.append(f"{' + '.join(names)} would explain more, with values that no model can have")
    return found


def _nearest(best: NamedSet, refit: SetFit, misfit: LeftOutMisfit) -> Nearest:
    """The best set where none is named."""
    fit = steady(best.fit)
    after = left_out_squares(fit)
    name = misfit.where
    records = each([item.record for item in refit.place.question.stretches])
    before, then = (pooled(predicted(own.read_by(fit.sensors), records)) for own in (refit, fit))
    return Nearest(
        effects=best.names,
        error_before=before[name],
        error_after=then[name],
        error_level=math.nan,
        channel=name,
        ratio=after.misfit.ratio,
    )


def _transfers(best: NamedSet, contest: Contest) -> tuple[Transfer, ...]:
    """What each effect of the best set does to kinds of records that are left out, the strongest
    first."""
    known = {frozenset(item.names): item.fit for item in contest.settled}
    known[frozenset()] = contest.null

    def fit(names: frozenset[str]) -> SetFit:
        order = tuple(name for name in best.names if name in names)
        return known.get(names) or fitted(best.fit.place, order, best.fit.forces)

    rest = {name: contest.without(best.names, name).gain for name in best.names}
    return transfers_of(sorted(best.names, key=lambda name: rest[name]), fit)


def _values(question: RecordQuestion, fit: SetFit) -> dict[str, float]:
    """Values of the base of a fit."""
    base = question.numbers.base
    start = dict(
        zip(
            question.stretches[0].binding.names,
            question.stretches[0].binding.mean.tolist(),
            strict=True,
        )
    )
    change = dict(zip(question.numbers.values, (question.numbers.T @ fit.z).tolist(), strict=True))
    return {name: start[name] + change[name] for name in base.names}


def _findings(
    best: NamedSet,
    contest: Contest,
    every: Sequence[FreeCandidate],
    covered: Sequence[Visible],
    levels: Mapping[str, float],
) -> tuple[Finding, ...]:
    """The effects of the best set, each beside the others."""
    records = [item.record for item in contest.zero.question.stretches]
    after = pooled(predicted(best.fit, each(records)))
    odds, errors = {}, {}
    for name in best.names:
        rest = contest.without(best.names, name)
        odds[name] = best.gain - rest.gain
        without = rest.fit.read_by(best.fit.sensors)
        errors[name] = (pooled(predicted(without, each(records))), after)
    return findings_of(best, every, covered, odds, errors, levels)


def _refused(contest: Contest) -> tuple[str, ...]:
    """What was in front but for values that no ship can have."""
    return tuple(
        f"{' + '.join(names)} would have had {gain:.1f} of ln evidence with values that "
        f"no model can have: {why}"
        for names, gain, why in contest.refused
    )


def _lost(system: FreeSystem) -> tuple[str, ...]:
    """Records that were left out, and the way back to them."""
    if not system.lost:
        return ()
    return (
        f"left out: {', '.join(system.lost)}, where the model as it is given turns another way by "
        "more than 86°; begin with a model that sails there, or cut what it cannot (trim)",
    )


def _notes(model: Model, question: RecordQuestion, last: SetFit) -> tuple[str, ...]:
    """What a reader must know of how it was found."""
    windows = sum(len(item.begins) - 1 for item in question.stretches)
    shares = ", ".join(
        f"{word} {100 * share:.2g} %"
        for word, share in zip("XYNK", last.forces.shares.tolist(), strict=False)
    )
    notes = [
        f"{windows} windows of {len(question.stretches)} records",
        moved_most(last),
        f"unknown forces of {shares} of ½ρLdU² (½ρL²dU²) are left",
    ]
    if question.outliers:
        notes.append(f"{question.outliers} averages left out that no motion explains")
    records = [item.record for item in question.stretches]
    notes += sea_notes(question.model, records)
    named = filter(None, map(CATALOGUE.get, last.names))  # those of users have no such role
    felt = bool(model.in_role("depth")) or any("depth" in item.roles for item in named)
    if np.any(last.z) and not felt and "depth" in excited(model, records):
        least = min(item.depth or math.inf for item in records) / model.ship.d
        notes.append(
            f"the water is {least:.3g} draughts deep: what moved may be the bottom's, which need "
            "not grow as the formulas of the catalogue say; the values are those of this depth"
        )
    return tuple(notes)
