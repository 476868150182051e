"""The evidence for effects, one or several at once.

With G the products of their whitened columns in units of the prior, base and floor projected off,
and b those with the data, ln E = ½ b'(1 + G)⁻¹b - ½ ln|1 + G| (docs/theory/evidence.md); a set of m
effects pays m times `PRICE`, and is averaged over the grids of its nonlinear parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise, product
from typing import Final

import numpy as np

from pmmkit.campaigns import Run
from pmmkit.diagnosis.captive.candidate import no_such_effect
from pmmkit.diagnosis.captive.system import MANY, CandidateColumns, System
from pmmkit.diagnosis.captive.whitening import Piece, Places, RunEffectColumns
from pmmkit.diagnosis.evidence import PRICE, RankedSet
from pmmkit.effects import is_fault
from pmmkit.inference import Normal
from pmmkit.numerics import Array

# A system beside effects that are known to be there.


def condition_on(system: System, blocks: Sequence[CandidateColumns]) -> System:
    """The system of a base that has some effects, of unknown size within their prior.

    Notes
    -----
    With S the columns of what is known, the covariance of the data grows by S S'; of all products
    the part that S explains, with its unit prior, is taken off.
    """
    if not blocks:
        return system
    names = {block.candidate.name for block in blocks}
    rest = [block for block in system.blocks if block.candidate.name not in names]
    if len(blocks) == 1 and blocks[0].drawn and not any(block.drawn for block in rest):
        return replace(_beside_drawn(system, blocks[0].drawn), blocks=tuple(rest))
    if any(block.drawn for block in blocks):
        system, dense = spread(system, [*blocks, *rest])
        blocks, rest = dense[: len(blocks)], list(dense[len(blocks) :])
    return _beside(replace(system, blocks=tuple(rest)), blocks)


def _beside(system: System, blocks: Sequence[CandidateColumns]) -> System:
    taken = system.normal.taken(np.concatenate([block.places for block in blocks]))
    return replace(
        system,
        normal=system.normal.given(taken),
        blocks=tuple(
            block if block.drawn is None else replace(block, drawn=block.drawn.beside(taken))
            for block in system.blocks
        ),
    )


def _beside_drawn(system: System, drawn: RunEffectColumns) -> System:
    known = drawn.solve(np.column_stack([drawn.across.T, drawn.score]))
    normal = system.normal
    return replace(
        system,
        normal=replace(
            normal,
            information=normal.information - drawn.across @ known[:, :-1],
            score=normal.score - drawn.across @ known[:, -1],
            square=normal.square - float(drawn.score @ known[:, -1]),
        ),
    )


def spread(
    system: System, blocks: Sequence[CandidateColumns]
) -> tuple[System, tuple[CandidateColumns, ...]]:
    """A system that holds the columns of some blocks, and these blocks in it."""
    made = []
    for block in blocks:
        if block.drawn is not None:
            system, block = _written_out(system, block)
        made.append(block)
    return system, tuple(made)


def drawn_in(system: System, asked: CandidateColumns) -> CandidateColumns:
    """A block that each run draws as it stands in a system, beside what that knows."""
    key = (asked.candidate.name, asked.value, asked.count)
    return next(
        block
        for block in system.blocks
        if block.drawn and (block.candidate.name, block.value, block.count) == key
    )


def _written_out(system: System, asked: CandidateColumns) -> tuple[System, CandidateColumns]:
    """A system with the columns of a block that each run draws, and that block."""
    old = drawn_in(system, asked)
    drawn = old.drawn
    assert drawn is not None
    normal = system.normal
    width = len(normal.score)
    new = replace(old, columns=slice(width, width + drawn.count), drawn=None)
    blocks = []
    for block in system.blocks:
        if block.drawn and block is not old:
            across = np.vstack([block.drawn.across, drawn.products(block.drawn)])
            block = replace(block, drawn=replace(block.drawn, across=across))
        blocks.append(new if block is old else block)
    edges = np.cumsum([0, *(part.shape[1] for part in drawn.parts)]).tolist()
    return (
        replace(
            system,
            normal=replace(
                normal,
                information=np.block(
                    [[normal.information, drawn.across], [drawn.across.T, drawn.products(drawn)]]
                ),
                score=np.concatenate([normal.score, drawn.score]),
                centre=np.concatenate([normal.centre, np.zeros(drawn.count)]),
            ),
            prior=np.concatenate([system.prior, np.ones(drawn.count)]),
            blocks=tuple(blocks),
            pieces=tuple(
                replace(
                    piece,
                    columns=np.hstack([piece.columns, piece.projection.outside(part.toarray())]),
                    places=np.concatenate([piece.places, width + np.arange(begin, end)]),
                )
                for piece, part, (begin, end) in zip(
                    system.pieces, drawn.parts, pairwise(edges), strict=True
                )
            ),
        ),
        new,
    )


# What is left of an effect without the one run that shows it best: a run may be wrong.


def columns_at(piece: Piece, at: Places) -> Array:
    """Columns of a piece at places of the system, zeros where it has none (n + D, q)."""
    where = {place: i for i, place in enumerate(piece.places.tolist())}
    columns = np.zeros((len(piece.data), len(at)))
    for k, place in enumerate(at.tolist()):
        if place in where:
            columns[:, k] = piece.columns[:, where[place]]
    return columns


def taken_with(
    system: System, columns: Sequence[Array], named: Callable[[Run], str] = lambda run: run.id
) -> Mapping[str, Array]:
    """Products of columns that go when a run is left out, base and floor fitted without it.

    columns (n + D, q).

    Notes
    -----
    Whitening is run by run: to leave a run out is to leave its rows out. With S the basis of base
    and floor at these rows, B the columns there, it takes B' (I - S S')⁻¹ B of their products
    (`of_others`).
    """
    products: dict[str, Array] = {}
    for piece, columns_here in zip(system.pieces, columns, strict=True):
        projection = piece.projection
        channel = projection.channel
        first = {
            rows.start: system.views[i].run
            for i, rows in zip(channel.views, channel.rows, strict=True)
        }
        together: dict[str, list[int]] = {}
        for number, rows in enumerate(channel.runs):
            together.setdefault(named(first[int(rows[0])]), []).append(number)
        for name, numbers in together.items():
            rows = np.concatenate([projection.channel.runs[number] for number in numbers])
            part = columns_here[rows].T @ projection.without(numbers) @ columns_here[rows]
            products[name] = products[name] + part if name in products else part
    return products


def least_gains(
    system: System, blocks: Sequence[CandidateColumns], given: Sequence[CandidateColumns] = ()
) -> tuple[tuple[float, str], ...]:
    """ln evidence that each effect of a set adds without the run that helps it most, and that
    run."""
    system, every = spread(system, [*blocks, *given])
    at = np.concatenate([block.places for block in every])
    columns = [np.column_stack([columns_at(p, at), p.data]) for p in system.pieces]
    known = system.normal.only(at)
    edges = np.cumsum([0, *(block.count for block in blocks)]).tolist()
    taken = taken_with(system, columns)
    runs = list(taken)
    gained = gains_without(known, list(taken.values()), [slice(*own) for own in pairwise(edges)])
    return tuple((float(own.min()), runs[int(np.argmin(own))]) for own in gained)


def gains_without(known: Normal, taken: Sequence[Array], parts: Sequence[slice]) -> list[Array]:
    """ln evidence that parts of some columns add to the others, without some data (k,).

    taken (q + 1, q + 1): products of columns and data that go, k of them.
    """
    few = max(1, HELD // (len(known.centre) + 1) ** 2)
    found = []
    for begin in range(0, len(taken), few):
        others = known - Normal.of_products(np.stack(taken[begin : begin + few]))
        every = np.arange(len(known.centre))
        rest = [others.only(np.delete(every, part)).log_evidences for part in parts]
        found.append(others.log_evidences - np.stack(rest))
    return list(np.concatenate(found, axis=1))


HELD: Final = 2**17
"""Numbers of products that are weighed at once."""
MOST: Final = 3
"""Effects in a set; three together are more often one that is not in the catalogue."""
NEAR: Final = 2
"""Grid points of an effect, those that explain most alone, that stand in sets of several."""
AHEAD: Final = 8
"""Best single effects that are combined with all others."""


def evidence_of(system: System, block: CandidateColumns) -> float:
    """ln evidence of one effect at one grid point."""
    return block.drawn.log_evidence if block.drawn else _at(system, [block])


@dataclass(frozen=True, kw_only=True, eq=False)
class Sets:
    """Sets of effects of a system, and what is computed once for all of them.

    `system`: runs, base and candidates. `by_name`: each effect at its grid points, and in its
    forms. `near`: those that explain most, which stand in sets of several. `beside`: evidence
    of each wide block, and the system beside it. `acting`: effects on whose force the faults of
    this system act; `less`: the sets of the system where they do not. `ahead`: ln
    evidence that no effect at all has more here than there, as runs may scatter by a share of all
    that acts: evidence is against no effect there, for every set.
    """

    system: System
    by_name: Mapping[str, list[CandidateColumns]]
    near: Mapping[str, list[CandidateColumns]]
    beside: Mapping[int, tuple[float, System]]
    acting: frozenset[str] = frozenset()
    less: Sets | None = None
    ahead: float = 0.0

    def home(self, names: Sequence[str]) -> Sets:
        """Where a set is asked: its faults act on the effects that it names and on no others."""
        if self.less is None or self.acting.issubset(names) or not any(map(is_fault, names)):
            return self
        return self.less

    def value_of(self, blocks: Sequence[CandidateColumns]) -> float:
        """ln evidence of blocks; one with many columns is taken into account once for all sets."""
        if len(blocks) == 1:
            return evidence_of(self.system, blocks[0])
        many = [block for block in blocks if id(block) in self.beside]
        if len(many) != 1:
            system, blocks = spread(self.system, blocks)
            return _at(system, blocks)
        alone, rest = self.beside[id(many[0])]
        return alone + _at(rest, [block for block in blocks if block is not many[0]])

    def entry(self, names: Sequence[str]) -> RankedSet:
        """A set with its evidence, averaged over grids and forms."""
        if (home := self.home(names)) is not self:
            return home.entry(names)
        points = self.by_name if len(names) == 1 else self.near
        tried = [(self.value_of(blocks), blocks) for blocks in product(*(points[x] for x in names))]
        top, best = max(tried, key=lambda item: item[0])
        total = sum(math.exp(value - top) for value, _ in tried)
        share = math.prod(len(self.by_name[name]) for name in names)
        return RankedSet(
            names=tuple(names),
            values=tuple(block.value for block in best),
            terms=tuple(block.candidate.size for block in best),
            log_evidence=self.ahead + top + math.log(total / share) - PRICE * len(names),
        )

    def added(self, entry: RankedSet) -> tuple[float, ...]:
        """ln evidence that each effect of a set adds to the others."""
        if len(entry.names) == 1:
            return (entry.log_evidence,)
        return tuple(
            entry.log_evidence - self.entry([x for x in entry.names if x != name]).log_evidence
            for name in entry.names
        )


def _at(system: System, blocks: Sequence[CandidateColumns]) -> float:
    """ln evidence of blocks whose columns the system holds."""
    return system.normal.only(np.concatenate([block.places for block in blocks])).log_evidence


def sets_of(system: System, acting: frozenset[str] = frozenset(), less: Sets | None = None) -> Sets:
    """Sets that can be asked for."""
    by_name: dict[str, list[CandidateColumns]] = {}
    for block in system.blocks:
        by_name.setdefault(block.candidate.name, []).append(block)
    near = {
        name: sorted(own, key=lambda b: -evidence_of(system, b))[:NEAR]
        for name, own in by_name.items()
    }
    beside = {
        id(block): (evidence_of(system, block), condition_on(system, [block]))
        for own in near.values()
        for block in own
        if wide(block)
    }
    sets = Sets(system=system, by_name=by_name, near=near, beside=beside, acting=acting, less=less)
    if less is None or not acting:
        return sets
    names = sorted(acting)
    return replace(sets, ahead=less.entry(names).log_evidence - sets.entry(names).log_evidence)


def ranked_sets(sets: Sets, *, most: int = MOST) -> list[RankedSet]:
    """All single effects, and the sets that deserve it, best first."""
    entry, by_name = sets.entry, sets.by_name
    singles = sorted((entry([name]) for name in by_name), key=lambda x: -x.log_evidence)
    entries = list(singles)
    best = [x.names[0] for x in singles[:AHEAD]]
    pairs: list[RankedSet] = []
    if most > 1:
        wanted = {tuple(sorted(pair)) for pair in combinations(best, 2)}
        wanted |= {tuple(sorted((a, b))) for a in best[:4] for b in by_name if b != a}
        pairs = sorted((entry(pair) for pair in sorted(wanted)), key=lambda x: -x.log_evidence)
        entries += pairs
    if most > 2 and pairs:
        triples = {
            tuple(sorted((*pair.names, name)))
            for pair in pairs[:3]
            for name in by_name
            if name not in pair.names
        }
        entries += [entry(names) for names in sorted(triples)]
    return sorted(entries, key=lambda x: -x.log_evidence)


def wide(block: CandidateColumns) -> bool:
    """Whether a block has so many columns (one per run) that sets with it need another way."""
    return block.drawn is not None or block.count > MANY


def gate(system: System, best: float, *, draws: int = 400, seed: int = 0) -> float:
    """Probability that no effect at all gives a single effect as good as the best (`chance_of`).

    Blocks of very many columns, which chance hardly ever favours, are left out.
    """
    used = [block for block in system.blocks if not wide(block)]
    at = np.arange(max(block.columns.stop for block in used))
    by_name: dict[str, list[Places]] = {}
    for block in used:
        by_name.setdefault(block.candidate.name, []).append(block.places)
    groups = list(by_name.values())
    return system.normal.only(at).chance_of(best + PRICE, groups, draws=draws, seed=seed)


# The grid points of an effect that explain most.


def best_blocks(system: System, name: str, count: int = 1) -> list[CandidateColumns]:
    """The grid points of an effect that explain most by themselves, the best first."""
    own = [block for block in system.blocks if block.candidate.name == name]
    if not own:
        raise no_such_effect(name, (block.candidate.name for block in system.blocks))
    return sorted(own, key=lambda b: -evidence_of(system, b))[:count]
