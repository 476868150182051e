"""Who is in front: sets of effects by linear problems, the best ones through the equations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Final

from pmmkit.base import ModelError, Workers, each, opened
from pmmkit.diagnosis.evidence import RankedSet
from pmmkit.diagnosis.free_running.findings import NamedSet, model_of
from pmmkit.diagnosis.free_running.fits import Linearised, SetFit, at_place, fitted, place_at
from pmmkit.diagnosis.free_running.hypotheses import FreeCandidate, Names
from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.left_out import judged, left_out_error
from pmmkit.models import Model
from pmmkit.numerics import one_thread
from pmmkit.presentation import counted

PAID: Final = 6
"""Sets in front that are given unknown forces of their own."""
REFITTED: Final = 2
"""Of those, sets that are fitted through the equations."""
LIKELY: Final = 1
"""Sets in front that are fitted anyway."""
MOST: Final = 6
"""Effects in a set; the search ends before where one more is not worth its price."""
FALL: Final = 0.2
"""Mean fall of ln of the errors of records left out from which it stands above the evidence: a slow
push, as an asymmetry is, hides behind unknown forces that are quick (docs/diagnose.md)."""
BLIND: Final = 10.0
"""ln by which the evidence may speak against an effect that makes them fall so: a slow push hides
behind unknown forces that are quick."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contest:
    """Sets of effects in the order of their evidence.

    `null`: without any effect, with the slopes of all. `zero`: the linear problem about the
    model as it is given. `settled`: sets that were fitted through the equations, the best
    first. `refused`: sets that were in front where they were asked, but for values that no
    model can have: ln of their odds against none, the value, and the least or the most that
    there is.
    """

    null: SetFit
    zero: Linearised
    settled: list[NamedSet]
    entries: tuple[RankedSet, ...]
    refused: tuple[tuple[Names, float, str], ...] = ()
    every: tuple[FreeCandidate, ...] = ()

    def without(self, names: Names, left_out: str) -> NamedSet:
        """A set of effects without one of them."""
        rest = tuple(name for name in names if name != left_out)
        if not rest:
            return NamedSet(names=(), gain=0.0, fit=self.null)
        known = {item.names: item for item in self.settled}
        if rest in known:
            return known[rest]
        best = self.settled[0].fit
        return _named(fitted(best.place, rest, best.forces), self.null, self.every)


def base_alone(zero: Linearised) -> tuple[Linearised, SetFit]:
    """The base as far as it may move for the good of records left out.

    A spread that makes these worse is none for any set: with it the values take over, by the
    linear problem, what they do not explain.
    """
    count = len(zero.question.numbers.base.spreads)
    place = within(zero, 1)
    null = fitted(place, (), whole=True)
    missed = left_out_error(null)
    for number in range(2, count + 1):
        wider = within(zero, number)
        other = fitted(wider, (), whole=True)
        if other.spread < wider.question.numbers.base.spreads[-1]:
            break
        error = left_out_error(other)
        if error >= missed:
            break
        place, null, missed = wider, other, error
    return place, null


def contest_of(
    zero: Linearised,
    null: SetFit,
    model: Model,
    every: Sequence[FreeCandidate],
    speed: float,
    *,
    most: int,
    tell: Callable[[str], None],
    executor: Workers = None,
) -> Contest:
    """All sets of effects against none.

    speed [m/s].
    """
    names = [item.name for item in every]
    settled: list[NamedSet] = []
    refused: list[tuple[Names, float, str]] = []
    place, first = null.place.whole, null.weighed()
    ahead = NamedSet(names=(), gain=0.0, fit=replace(null, place=place))
    with opened(executor, rounds=True) as crew:
        for count in range(min(most, len(names))):
            tell(f"Sets of {counted(count + 1, 'effect')} out of {len(names)}")
            found: list[NamedSet] = []
            barred: list[tuple[Names, float, str]] = []
            larger = _larger(ahead.names, names)
            front = _front(larger, place, ahead.fit, [x.name for x in every if not x.price])
            for (chosen, _), fit in zip(front, _fits(place, front, crew, tell), strict=True):
                item = _named(fit, null, every)
                # The linear problem may promise what the equations, far from there, do not keep.
                why = why_not(model, every, fit, speed)
                if why:
                    barred.append((chosen, item.gain, why))
                    continue
                # A base that moves by much may predict as well as an effect: where no error matters
                # the evidence alone decides.
                if item.error <= ahead.error or item.predicts:
                    found.append(item)
            settled += found
            best = _next(found, ahead)
            refused += [item for item in barred if item[1] > (best or ahead).gain]
            if best is None:
                break
            ahead = best
            place = place_at(best.fit.place.question, best.fit.z)
    order = _by_gain([item for item in settled if item.error < ahead.error + FALL])

    def can_be(item: NamedSet) -> bool:
        return not why_not(model, every, item.fit, speed)

    order = _thinned(order, null, every, can_be)
    gains = {
        chosen: first(chosen) - first(()) - price_of(chosen, every)
        for chosen in (*combinations(names, 1), *combinations(names, min(most, 2)))
    }
    gains |= {item.names: item.gain for item in order}
    entries = sorted(gains.items(), key=lambda item: -item[1])
    return Contest(
        null=null,
        zero=zero,
        settled=order,
        entries=tuple(RankedSet(names=n, log_evidence=gain, values=()) for n, gain in entries),
        refused=tuple(sorted(refused, key=lambda item: -item[1])),
        every=tuple(every),
    )


def _fits(
    place: Linearised,
    sets: Sequence[tuple[Names, Forces]],
    crew: Executor | int | None,
    tell: Callable[[str], None],
) -> list[SetFit]:
    """Sets fitted from a place, in their order."""
    names = [f"Fit with {' and '.join(chosen)}" for chosen, _ in sets]

    def here(asked: tuple[Names, Forces]) -> SetFit:
        tell(f"Fit with {' and '.join(asked[0])}")
        return _fit(place, asked)

    with one_thread():
        found = dict(each(partial(_fit, place), sets, crew, names=names, here=here))
    return [found[number] for number in range(len(sets))]


def _fit(place: Linearised, asked: tuple[Names, Forces]) -> SetFit:
    return fitted(place, *asked)


def price_of(names: Names, every: Sequence[FreeCandidate]) -> float:
    """ln of the odds before the records against a set of effects."""
    return sum(item.price for item in every if item.name in names)


def _named(fit: SetFit, null: SetFit, every: Sequence[FreeCandidate]) -> NamedSet:
    """A fit with ln of the odds of its set against none, the price of each effect taken off."""
    gain = fit.log_probability - null.log_probability - price_of(fit.names, every)
    return NamedSet(names=fit.names, gain=gain, fit=fit)


def _by_gain(sets: Iterable[NamedSet]) -> list[NamedSet]:
    return sorted(sets, key=lambda item: -item.gain)


def _thinned(
    order: list[NamedSet],
    null: SetFit,
    every: Sequence[FreeCandidate],
    can_be: Callable[[NamedSet], bool],
) -> list[NamedSet]:
    """The order with sets of one effect less than the one in front, until none stands above it.

    An effect that was taken in early may have nothing left to explain; and a set that is fitted
    from where a larger one ended may end higher than from where the search came.
    """
    while order and len(order[0].names) > 1:
        best, known = order[0], {item.names for item in order}
        found = [
            _named(fitted(best.fit.place, rest, best.fit.forces), null, every)
            for rest in combinations(best.names, len(best.names) - 1)
            if rest not in known
        ]
        fair = [item for item in found if item.error < best.error + FALL and can_be(item)]
        order = _by_gain([*order, *fair])
        if order[0] is best:
            break
    return order


def _next(found: Sequence[NamedSet], ahead: NamedSet) -> NamedSet | None:
    """The set of most evidence, unless another one clearly makes the errors of records left out
    fall further; None where none is better than the set that is ahead."""
    better = [item for item in found if item.gain > ahead.gain]
    best = max(better, key=lambda item: item.gain, default=None)
    goal = (ahead if best is None else best).error - FALL
    least = ahead.fit.log_probability - BLIND
    lower = [item for item in found if item.error < goal and item.fit.log_probability > least]
    return min(lower, key=lambda item: item.error, default=best)


def why_not(model: Model, every: Sequence[FreeCandidate], fit: SetFit, speed: float) -> str:
    """What keeps a model from having the values of a fit; empty where it can have them."""
    try:
        model_of(model, every, fit, speed)
    except ModelError as error:
        return str(error)
    return ""


def _larger(chosen: Names, names: Sequence[str]) -> list[Names]:
    """A set with each of the other effects, in the order of the catalogue."""
    return [
        tuple(x for x in names if x in chosen or x == name) for name in names if name not in chosen
    ]


def _front(
    sets: Sequence[Names], place: Linearised, ahead: SetFit, expected: Sequence[str]
) -> list[tuple[Names, Forces]]:
    """Sets that are in front by the linear problem of a place, and forces to begin with.

    They are looked at by the unknown forces of the set that is ahead, with a base that moves and
    one that does not, and by those that each set needs itself: what removes nearly all that is
    missed shows by these, what removes a little by the others. What pushes slowly shows by the
    errors of records left out. What is expected to be there is always among them.
    """
    here = ahead if ahead.place is place else at_place(place, ahead.names)
    held = within(place, 1)
    still = at_place(held, ahead.names, ahead.forces, fine=True)
    found: dict[Names, Forces] = {}
    for fit, by in ((here, place), (still, held)):
        order = sorted(sets, key=fit.weighed(), reverse=True)
        found |= dict.fromkeys(order[:LIKELY], ahead.forces)
        paid = []
        for names in order[:PAID]:
            own = at_place(by, names, still.forces, fine=True)
            paid.append((own.log_probability, names, own.forces))
        paid.sort(key=lambda item: -item[0])
        found |= {names: forces for _, names, forces in paid[:REFITTED]}
    windows = judged(here.followed)

    def left_out(names: Names) -> float:
        return left_out_error(replace(here, names=names), windows)

    foreseen = sorted(sets, key=left_out)[:REFITTED]
    foreseen += [names for names in sets if set(expected) & set(names) - set(ahead.names)]
    return list((dict.fromkeys(foreseen, ahead.forces) | found).items())


def steady(fit: SetFit) -> SetFit:
    """A fit, or that of its set with a base that does not move, if records left out say so; the
    noise of the sensors is told with what it has found."""
    chosen = fit
    if fit.spread:
        held = fitted(within(fit.place, 1), fit.names, fit.forces)
        chosen = held if left_out_error(held) < left_out_error(fit) else fit
    sensors = chosen.place.question.told(chosen.z)
    if sensors is chosen.sensors:
        return chosen
    question = chosen.place.question.read_by(sensors).followed(chosen.z)
    return fitted(place_at(question, chosen.z), chosen.names, chosen.forces)


def within(place: Linearised, count: int) -> Linearised:
    """The linear problem with a base that moves by the smallest spreads alone."""
    question = place.question
    numbers = replace(question.numbers, base=question.numbers.base.within(count))
    return replace(place, question=replace(question, numbers=numbers))
