"""Who is in front: sets of effects by linear problems, the best ones through the equations."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

from pmmkit.diagnosis.evidence import Entry
from pmmkit.diagnosis.free_running.candidates import FreeCandidate
from pmmkit.diagnosis.free_running.findings import Named, model_of
from pmmkit.diagnosis.free_running.fits import Fit, Place, at_place, fitted, place_at
from pmmkit.diagnosis.free_running.hypotheses import Names, Weighed, weighed
from pmmkit.diagnosis.free_running.information import Forces
from pmmkit.diagnosis.free_running.left_out import each, pooled, predicted
from pmmkit.diagnosis.free_running.question import Question
from pmmkit.errors import ModelError
from pmmkit.models import Model

AHEAD: Final = 4
"""Best pairs that are combined with every third."""
PAID: Final = 8
"""Sets in front that are given unknown forces of their own."""
REFITTED: Final = 3
"""Of those, sets that are fitted through the equations."""
TINY: Final = 1e-9
"""Added to errors before their logarithm: some vanish once the noise is taken off."""
TURNS: Final = 2
"""Times that all sets are looked at from where the best one leads."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Contest:
    """Sets of effects in the order of their evidence.

    Parameters
    ----------
    null : Fit
        Without any effect, with the slopes of all.
    zero : Place
        The linear problem about the model as it is given.
    settled : list of Named
        Sets that were fitted through the equations, the best first.
    entries : tuple of Entry
        All sets.
    """

    null: Fit
    zero: Place
    settled: list[Named]
    entries: tuple[Entry, ...]

    def without(self, names: Names, left_out: str) -> Named:
        """A set of effects without one of them."""
        rest = tuple(name for name in names if name != left_out)
        if not rest:
            return Named(names=(), gain=0.0, fit=self.null)
        known = {item.names: item for item in self.settled}
        if rest in known:
            return known[rest]
        fit = fitted(self.settled[0].fit.place, rest, self.settled[0].fit.forces)
        price = self.price * len(rest)
        gain = fit.log_probability - self.null.log_probability - price
        return Named(names=rest, gain=gain, fit=fit)

    @property
    def price(self) -> float:
        """Taken off the evidence for each effect of a set."""
        return price_of(self.null.place.question)


def price_of(question: Question) -> float:
    """ln 2K: one of K candidates was to be found."""
    return math.log(2.0 * max(len(question.numbers.columns), 1))


def contest_of(
    zero: Place,
    model: Model,
    every: Sequence[FreeCandidate],
    speed: float,
    *,
    most: int,
    tell: Callable[[str], None],
) -> Contest:
    """All sets of effects against none.

    Parameters
    ----------
    zero : Place
        The linear problem about the model as it is given.
    model : Model
        Complete, without the candidates.
    every : sequence of FreeCandidate
        Who takes part.
    speed : float
        Speed of the approach [m/s].
    most : int
        Effects in a set.
    tell : callable
        Is told what is being done.
    """
    names = [item.name for item in every]
    question = zero.question
    tell("The base alone")
    null = fitted(zero, (), whole=True)
    if not names:
        return Contest(null=null, zero=zero, settled=[], entries=())
    tell(f"Sets of {len(names)} effects")
    largest = at_place(zero, names)
    views = [null.weighed(), at_place(zero, (), null.forces, fine=True).weighed()]
    views.append(largest.weighed())
    price = price_of(question)
    before = _missed(steady(null))
    settled: dict[Names, Named] = {}
    tried: set[Names] = set()
    sets: list[tuple[Names, float]] = []
    place, forces = zero, largest.forces
    for turn in range(TURNS):
        sets = _sets(names, _gain(views, null, price), most)
        front = _front([item[0] for item in sets[:PAID]], place, forces, REFITTED)
        if turn == 0:
            front = [*_held_front(names, zero, largest.forces), *front]
        for found, own in front:
            if found in tried:
                continue
            tried.add(found)
            tell(f"Fit with {' and '.join(found)}")
            fit = fitted(place, found, own)
            try:
                model_of(model, every, fit, speed)
            except ModelError:
                continue
            if _missed(fit) > before:
                # The linear problem promised what the equations, far from there, do not keep.
                continue
            gain = fit.log_probability - null.log_probability - price * len(found)
            settled[found] = Named(names=found, gain=gain, fit=fit)
        if turn == TURNS - 1 or not settled:
            break
        best = max(settled.values(), key=lambda item: item.gain)
        if best.gain < 0.0:
            break
        tell(f"All sets from where {' and '.join(best.names)} leads")
        there = best.fit.place
        place = place_at(there.question, best.fit.z)
        forces = best.fit.forces
        views.append(at_place(place, best.names, forces, fine=True).weighed())
    order = sorted(settled.values(), key=lambda item: -item.gain)
    gains = dict(sets) | {item.names: item.gain for item in order}
    entries = sorted(gains.items(), key=lambda item: -item[1])
    return Contest(
        null=null,
        zero=zero,
        settled=order,
        entries=tuple(Entry(names=n, log_evidence=gain, values=()) for n, gain in entries),
    )


def steady(fit: Fit) -> Fit:
    """A fit, or that of its set with a base that does not move, if records left out say so."""
    if not fit.spread:
        return fit
    held = fitted(_held(fit.place), fit.names, fit.forces)
    return held if _missed(held) < _missed(fit) else fit


def _held(place: Place) -> Place:
    """The linear problem with a base that does not move."""
    question = place.question
    numbers = replace(question.numbers, base=question.numbers.base.held)
    return replace(place, question=replace(question, numbers=numbers))


def _held_front(names: Sequence[str], zero: Place, sharp: Forces) -> list[tuple[Names, Forces]]:
    """The single effects in front while the base stands as it is given.

    A base that moves can promise, by the linear problem, what no ship does.
    """
    still = _held(zero)
    alone = at_place(still, ())
    views = [alone.weighed(), weighed(zero.information.under(sharp), still.question.numbers)]
    order = sorted(names, key=lambda name: -max(view((name,)) for view in views))
    return _front([(name,) for name in order[:PAID]], still, alone.forces, REFITTED - 1)


def _missed(fit: Fit) -> float:
    """Sum of ln of the errors of records that are left out one after another."""
    records = [item.record for item in fit.place.question.stretches]
    return sum(math.log(x + TINY) for x in pooled(predicted(fit, each(records))).values())


def _gain(views: Sequence[Weighed], null: Fit, price: float) -> Callable[[Names], float]:
    def gain(names: Names) -> float:
        found = max(view(names) for view in views)
        return found - null.log_probability - price * len(names)

    return gain


def _front(
    sets: Sequence[Names], place: Place, forces: Forces, count: int
) -> list[tuple[Names, Forces]]:
    """The sets in front once each has unknown forces of its own, and these."""
    price = price_of(place.question)
    paid = []
    for names in sets:
        fit = at_place(place, names, forces, fine=True)
        paid.append((fit.log_probability - price * len(names), names, fit.forces))
    paid.sort(key=lambda item: -item[0])
    return [(names, own) for _, names, own in paid[:count]]


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
