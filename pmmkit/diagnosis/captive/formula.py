"""What fits the forces that no effect of the catalogue explains: a sum of few monomials.

A monomial is a product of the motion in one channel, ``Yv|r|``, asked as a candidate with one
coefficient. Sets of them are weighed by evidence, as sets of effects are; what is offered is a
formula with its errors on left-out conditions, and no cause (docs/theory/evidence.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Final

import numpy as np

from pmmkit.conventions import CHANNELS, Structure, parse_derivative
from pmmkit.diagnosis.captive.adequacy import blocks_of
from pmmkit.diagnosis.captive.build import build, prior_sizes
from pmmkit.diagnosis.captive.candidate import Candidate, of_terms
from pmmkit.diagnosis.captive.evidence import gains_without, taken_with
from pmmkit.diagnosis.captive.held_out import CHANGED, HeldOut, held_out
from pmmkit.diagnosis.captive.least_squares import effect_columns, joint_fit, labels, refined
from pmmkit.diagnosis.captive.refit import DerivativePlaces
from pmmkit.diagnosis.captive.system import CandidateColumns, System, term_columns
from pmmkit.diagnosis.captive.verdict import ROUNDS, RankedSets, ranked, told
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.diagnosis.empirical import (
    FAMILY,
    EmpiricalFormula,
    EmpiricalTerm,
    FormulaLength,
    is_symmetric,
)
from pmmkit.diagnosis.evidence import LEAST, RIVALS, SHOWS
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.effects import BY_SPEED, AddedMass
from pmmkit.inference import Normal
from pmmkit.models import Model
from pmmkit.numerics import Array, one_thread
from pmmkit.presentation import listed

# Which products these runs can be asked for.


ORDER: Final = 3
"""Order of the products of all variables."""
HIGH: Final = 5
"""Order of the products of sway and yaw alone."""


TENTH: Final = 0.1
"""Usual size of a term: its rms force over that of its channel in these tests, as an effect of the
user has it of usual forces."""


def monomials(system: System, home: DerivativePlaces) -> tuple[Candidate, ...]:
    """Products of the motion that the base has not, and the change with the speed of those that it
    has.

    Accelerations stand where the equations of motion have a place for them, rudder and heel where
    the model has one. What a ship that is alike to port and starboard has not is asked up to
    `ORDER` alone.
    """
    channels = [c.name for c in system.channels]
    known = [name for names in system.base.names.values() for name in names]
    steered = ["d"] * any(np.any(view.motion.delta) for view in system.views)
    heeled = ["phi"] * any(np.any(view.motion.phi) for view in system.views)
    names = [
        *(channel + (term or "0") for channel in channels for term in _terms([*steered, *heeled])),
        *(
            place + term
            for place in AddedMass.places()
            if place[0] in channels and place[1:] != "pdot"
            for term in _terms((), high=ORDER - 1)
        ),
    ]
    made = [parse_derivative(name) for name in names]
    asked = [
        x.name
        for x in dict.fromkeys(made)
        if x.name not in known
        and (is_symmetric(x) or len(x.factors) <= ORDER)
        and home.hold(x.name)
    ]
    if "several speeds" in system.base.excited(system.views):
        mine = [x for x in known if home.hold(x) and not parse_derivative(x).count("T")]
        asked += [f"{x}{BY_SPEED}" for x in mine]
    return tuple(map(_candidate, asked))


def _terms(more: Sequence[str], *, high: int = HIGH) -> Iterator[str]:
    """Products of sway, yaw and more variables in all their forms: one factor of each may be a
    modulus."""
    variables = ("v", "r", *more)
    for powers in product(range(high + 1), repeat=len(variables)):
        if sum(powers) > (ORDER if any(powers[2:]) else high):
            continue
        there = [(name, power) for name, power in zip(variables, powers, strict=True) if power]
        ends = [(name,) if name == "phi" else (name, f"|{name}|") for name, _ in there]
        for last in product(*ends):
            pairs = zip(there, last, strict=True)
            yield "".join(name * (power - 1) + end for (name, power), end in pairs)


def _candidate(name: str) -> Candidate:
    terms = ({name: 1.0},)
    return Candidate(
        name=name,
        family=FAMILY,
        kind="physics",
        summary="",
        coefficients=(name,),
        typical=(1.0,),
        columns=of_terms(terms),
        terms=terms,
    )


def _blocks(system: System, home: DerivativePlaces) -> tuple[CandidateColumns, ...]:
    """Monomials that these runs show beside base and floor, with their columns."""
    asked = monomials(system, home)
    rms = {c.name: float(np.linalg.norm(c.y)) for c in system.channels}
    blocks = []
    for item, made in zip(
        asked, term_columns(asked, system.channels, system.views, system.base), strict=True
    ):
        for channel, own in made.items():
            size = TENTH * rms[channel] / float(np.linalg.norm(own))
            known = replace(item, typical=(size,))
            block = CandidateColumns(candidate=known, value=0.0, columns=slice(0, 1))
            blocks.append(replace(block, made={channel: own * prior_sizes(known)}))
    signal = np.zeros(len(blocks))
    for columns, at in _projected(system, blocks):
        signal[at] += np.sum(columns**2, axis=0)
    return tuple(x for x, shown in zip(blocks, signal > SHOWS, strict=True) if shown)


def _projected(
    system: System, blocks: Sequence[CandidateColumns]
) -> Iterator[tuple[Array, Places]]:
    """Columns of blocks by channel, base and floor projected off, and which of all they are."""
    edges = np.cumsum([0, *(block.count for block in blocks)])
    made = [effect_columns(system, block) for block in blocks]
    for piece in system.pieces:
        channel = piece.projection.channel.name
        acting = [k for k, own in enumerate(made) if channel in own]
        raw = [np.zeros((len(piece.projection.channel.y), 0)), *(made[k][channel] for k in acting)]
        places = [np.zeros(0, np.intp), *(np.arange(edges[k], edges[k + 1]) for k in acting)]
        yield piece.projection.left(np.concatenate(raw, axis=1)), np.concatenate(places)


# Which sets of them the forces ask for.


LONGEST: Final = 4
"""Terms of a formula: with more of them its parts stand for each other."""
BEAM: Final = 100
"""Sets of each length, those of the greatest evidence, that are made longer."""
WINDOW: Final = math.log(1e6)
"""Sets of less probability, over the best of their length, are not kept."""
TRIED: Final = 8
"""Sets, the best first, of whose terms it is asked whether they hang on one run."""
BELOW: Final = 0.85
"""Share of their noise level below which errors say that the run scatter is less than was thought.
Of formulas that are the truth they stand at .9 of it: the smooth floor is seldom as large as it may
be."""
HALF: Final = 0.5
"""Share of the mean square error above noise that a formula must take away. Of twenty truths in no
catalogue (scripts/studies/beyond_catalogue.py) those that are products of the motion lose all of
it, hysteresis, lost motion and delays less than a third."""
ALIKE: Final = 0.5
"""Share of the evidence for a product that is left beside one that stands in its place, at most."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MonomialSets:
    """Sets of monomials with their posterior odds, beside a base and some effects.

    `system`: about which base. `known`: effects beside it. `blocks`: monomials. `columns`: of what
    is known, of the monomials, and last the data, by channel (n + D, k + M + 1). `normal`: what
    the data say of the monomials beside what is known. `price (M,)`: ln of the odds before any
    test against each. `value`: ln of the odds for each set, by places, of all that were looked at.
    """

    system: System
    known: tuple[CandidateColumns, ...]
    blocks: tuple[CandidateColumns, ...]
    columns: tuple[Array, ...]
    normal: Normal
    price: Array
    value: Mapping[Sequence[int], float]

    @classmethod
    def instead(cls, ranking: RankedSets, home: DerivativePlaces) -> MonomialSets | None:
        """In the place of what a ranking names; None where these runs show no product."""
        first = ranking.less or ranking  # no fault acts on what is named
        blocks = _blocks(first.system, home)
        if not blocks:
            return None
        return cls.of(first.system, refined(first.system, first.known), blocks)

    @classmethod
    def of(
        cls,
        system: System,
        known: tuple[CandidateColumns, ...],
        blocks: tuple[CandidateColumns, ...],
    ) -> MonomialSets:
        """All single monomials, all pairs, and longer sets that begin with the best."""
        count = sum(block.count for block in known)
        width = count + len(blocks)
        columns = []
        for piece, (own, at) in zip(
            system.pieces, _projected(system, [*known, *blocks]), strict=True
        ):
            whole = np.zeros((len(piece.data), width + 1))
            whole[:, at] = own
            whole[:, -1] = piece.data
            columns.append(whole)
        normal = _products(columns)
        expected = [x for b in known for x in b.candidate.centre or (0.0,) * b.count]
        sizes = [x for b in known for x in _prior(b)]
        centre = np.zeros(width)
        centre[:count] = np.array(expected) / np.array(sizes)
        normal = replace(normal, centre=centre)
        if count:
            normal = normal.given(normal.taken(np.arange(count)))
        plain = [parse_derivative(b.candidate.name.removesuffix(BY_SPEED)) for b in blocks]
        made = cls(
            system=system,
            known=known,
            blocks=blocks,
            columns=tuple(columns),
            normal=normal.only(np.arange(count, width)),
            price=math.log(len(blocks)) + RIVALS * ~np.array([is_symmetric(x) for x in plain]),
            value={},
        )
        return replace(made, value=made._looked_at())

    def _looked_at(self) -> dict[Sequence[int], float]:
        level: dict[Sequence[int], float] = {(): 0.0}
        value = dict(level)
        for length in range(LONGEST):
            parents = sorted(level, key=lambda x: -level[x])
            level, top = {}, -math.inf
            for parent in parents if length < 2 else parents[:BEAM]:
                longer = value[parent] + self.added(parent)
                longer[list(parent)] = -math.inf
                top = max(top, float(longer.max()))
                near = np.flatnonzero(longer > top - WINDOW) if length else range(len(longer))
                level |= {tuple(sorted((*parent, int(k)))): float(longer[k]) for k in near}
            value |= level
        return value

    def added(self, places: Sequence[int]) -> Array:
        """ln odds that each monomial adds to a set (M,)."""
        size, score = np.diagonal(self.normal.information), self.normal.score
        if places:
            taken = self.normal.taken(np.array(places, np.intp))
            size = np.maximum(size - np.sum(taken.across**2, axis=0), 0.0)
            score = score - taken.across.T @ taken.explained
        found: Array = 0.5 * (score**2 / (1.0 + size) - np.log1p(size)) - self.price
        return found

    @cached_property
    def best(self) -> Sequence[int]:
        """The set of the greatest odds whose terms do not hang on one run each; empty where none
        pays."""
        hanging: set[int] = set()
        tried = 0
        for places in sorted(self.value, key=lambda x: -self.value[x]):
            if not places or self.value[places] <= LEAST or tried == TRIED:
                return ()
            if hanging.isdisjoint(places):
                pays = self.least_gains(places) >= self.price[list(places)] + LEAST
                if pays.all():
                    return places
                hanging |= {
                    k for k, enough in zip(places, pays.tolist(), strict=True) if not enough
                }
                tried += 1
        return ()

    @property
    def odds(self) -> float:
        """ln of the odds for the best."""
        return self.value[self.best]

    def least_gains(self, places: Sequence[int]) -> Array:
        """ln evidence that each term of a set adds without the run that helps it most."""
        count = sum(block.count for block in self.known)
        at = [*range(count), *(count + k for k in places)]
        columns = [own[:, [*at, -1]] for own in self.columns]
        taken = list(taken_with(self.system, columns).values())
        parts = [slice(count + k, count + k + 1) for k in range(len(places))]
        return np.array([own.min() for own in gains_without(_products(columns), taken, parts)])

    @cached_property
    def shares(self) -> Array:
        """Posterior probability that each monomial belongs to the formula (M,): over all sets that
        were looked at (Madigan and Raftery 1994)."""
        values = np.array([*self.value.values()])
        weights = np.exp(values - values.max())
        found = np.zeros(len(self.blocks))
        for places, weight in zip(self.value, (weights / weights.sum()).tolist(), strict=True):
            found[list(places)] += weight
        return found

    def like(self, places: Sequence[int], place: int) -> dict[str, float]:
        """Monomials that can take the place of one of a set, within `RIVALS`, with their shares:
        beside it they would add less than `ALIKE` of that."""
        others = [k for k in places if k != place]
        added, beside = self.added(others), self.added(places)
        near = [
            k
            for k in np.argsort(-added).tolist()
            if k not in places
            and added[k] >= added[place] - RIVALS
            and beside[k] + self.price[k] < ALIKE * (added[k] + self.price[k])
        ]
        return {self.blocks[k].candidate.name: float(self.shares[k]) for k in near}

    def of_length(self, length: int) -> Sequence[int]:
        """The best set of some length."""
        return max((x for x in self.value if len(x) == length), key=lambda x: self.value[x])

    def with_less_scatter(self) -> MonomialSets:
        """The sets with the run scatter that is left beside that of the greatest odds, where errors
        say that it is less.

        What no effect explains is taken for scatter of the runs, and so for noise; what a formula
        explains of it is none.
        """
        places = max(self.value, key=lambda x: self.value[x])
        left = self.left_out(places, with_level=True)
        if left.share() >= BELOW * left.share(kind="level"):
            return self
        mine, system = [self.blocks[k] for k in places], self.system
        asked = [replace(x.candidate, grid=(x.value,)) for x in (*self.known, *mine)]
        made = build(system.views, system.base, asked, floor=system.floor, like=system)
        total = [sum(np.sum(x[:2] ** 2) for x in own.scatter.values()) for own in (made, system)]
        return self if total[0] >= total[1] else MonomialSets.of(made, self.known, self.blocks)

    def left_out(self, places: Sequence[int], *, with_level: bool = False) -> HeldOut:
        """Errors of left-out conditions with a set."""
        mine = [self.blocks[k] for k in places]
        every = [*self.known, *mine]
        return held_out(self.system, every, with_level=with_level, with_spread=False)


def _products(columns: Sequence[Array]) -> Normal:
    """What the data, the last column, say of the others, of all channels together."""
    return Normal.of_products(np.sum([own.T @ own for own in columns], axis=0))


def _prior(block: CandidateColumns) -> Array:
    sizes = prior_sizes(block.candidate)
    return np.full(block.count, sizes[0]) if block.candidate.each_run else sizes


# What is offered.


Source = Model | str | Sequence[str] | Structure
"""What the base of a diagnosis is of: a model, the name of a structure, derivatives."""


def answer_with_formula(
    system: System,
    given: Sequence[str] = (),
    *,
    floor: float,
    seed: int = 0,
    source: Source,
    offered: bool = True,
) -> Diagnosis:
    """Ask a system which effects the base lacks, and for a formula, `told_with_formula`."""
    ranking = ranked(system, given, seed)
    return told_with_formula(ranking, given, floor=floor, source=source, offered=offered)


def told_with_formula(
    ranking: RankedSets, given: Sequence[str], *, floor: float, source: Source, offered: bool = True
) -> Diagnosis:
    """What a ranking says; where no effect explains it, or products of the motion do better, with a
    formula that the model has a place for, if that is to be `offered`."""
    found = told(ranking, given, floor=floor)
    if not found.findings and found.verdict != "unexplained":
        return found
    if not offered and (found.flags or not found.findings):
        return found
    with one_thread():
        sets = MonomialSets.instead(ranking, DerivativePlaces.of(source))
        if sets is None:
            return found
        if found.findings and not found.flags:
            found = replace(found, flags=_better_products(ranking, found.best, sets))
        if offered and (found.verdict == "unexplained" or found.flags):
            formula = formula_of(ranking, found.best, sets)
            if formula.terms or not found.findings:
                found = replace(found, formula=formula)
    return found


def _better_products(
    ranking: RankedSets, named: tuple[str, ...], sets: MonomialSets
) -> tuple[str, ...]:
    """The flags of an answer in whose place products of the motion have `RIVALS` more.

    A product is a rival as thin as a name: of 61 right names none has one, of six forces |v| r that
    are called a coupling five (docs/theory/evidence.md).
    """
    if ranking.best is None or sets.odds <= ranking.best.log_evidence + RIVALS:
        return ()
    told = listed([sets.blocks[k].candidate.name for k in sets.best])
    return ("not_the_whole_story", f"{told} fit better in the place of {listed(named)}")


def formula_of(ranking: RankedSets, named: tuple[str, ...], sets: MonomialSets) -> EmpiricalFormula:
    """The formula of the greatest odds, beside the effects that are named or in their place."""
    blocks, beside = sets.blocks, False
    if named and ranking.best:
        known = [*ranking.known, *blocks_of(ranking.beside, ranking.best)]
        both = MonomialSets.of(ranking.system, refined(ranking.system, known), blocks)
        if both.odds + ranking.best.log_evidence >= sets.odds:
            sets, beside = both, True
    for _ in range(ROUNDS):
        old, sets = sets, sets.with_less_scatter()
        if sets is old:
            break
    with_it = sets.left_out(sets.best, with_level=True)
    best, before = sets.best, sets.left_out(()).share()
    after, noise = with_it.share(), with_it.share(kind="level")
    above = [max(x**2 - noise**2, 0.0) for x in (before, after)]
    falls = after < (1.0 - CHANGED) * before and above[1] <= HALF * above[0]
    best = best if falls else ()
    between = [sets.of_length(length) for length in range(1, len(best))]
    errors = [before, *(sets.left_out(x).share() for x in between), *([after] if best else [])]
    return EmpiricalFormula(
        terms=_fitted(sets, best),
        beside=named if beside and best else (),
        instead=() if beside or not best else named,
        asked=len(blocks),
        log_odds=sets.value[best],
        error_before=before,
        error_after=errors[-1],
        error_level=noise,
        lengths=tuple(
            FormulaLength(terms=tuple(blocks[k].candidate.name for k in places), error=error)
            for places, error in zip([(), *between, best], errors, strict=False)
        ),
    )


def _fitted(sets: MonomialSets, places: Sequence[int]) -> tuple[EmpiricalTerm, ...]:
    """Terms with their coefficients, fitted together with the base and what is known."""
    if not places:
        return ()
    system, mine = sets.system, [sets.blocks[k] for k in places]
    fit = joint_fit(system, [*sets.known, *mine], floor=system.floor)
    base = system.base
    Fn0 = base.ship.froude(base.reference, base.water.g)
    terms = []
    for place, block in zip(places, mine, strict=True):
        name = block.candidate.name
        (value,), (std,) = fit.of(labels(block.candidate))
        terms.append(
            EmpiricalTerm(
                name=name,
                value=float(value),
                std=float(std),
                typical=block.candidate.typical[0],
                share=float(sets.shares[place]),
                like=sets.like(places, place),
                Fn0=Fn0,
            )
        )
    return tuple(sorted(terms, key=lambda x: (CHANNELS.index(x.name[0]), -abs(x.value) / x.std)))
