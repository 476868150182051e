"""The evidence for effects, one or several at once.

With G the products of their whitened columns in units of the prior, base and floor projected off,
and b those with the data, ln E = ½ b'(1 + G)⁻¹b - ½ ln|1 + G| (docs/theory/evidence.md); a set of m
effects pays m times `PRICE`, and is averaged over the grids of its nonlinear parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.conditioning import condition_on, spread
from pmmkit.diagnosis.captive.system import MANY, CandidateColumns, System
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.diagnosis.evidence import PRICE, RankedSet

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
    of each wide block, and the system beside it.
    """

    system: System
    by_name: Mapping[str, list[CandidateColumns]]
    near: Mapping[str, list[CandidateColumns]]
    beside: Mapping[int, tuple[float, System]]

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
        points = self.by_name if len(names) == 1 else self.near
        tried = [(self.value_of(blocks), blocks) for blocks in product(*(points[x] for x in names))]
        top, best = max(tried, key=lambda item: item[0])
        total = sum(math.exp(value - top) for value, _ in tried)
        share = math.prod(len(self.by_name[name]) for name in names)
        return RankedSet(
            names=tuple(names),
            values=tuple(block.value for block in best),
            terms=tuple(block.candidate.size for block in best),
            log_evidence=top + math.log(total / share) - PRICE * len(names),
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


def sets_of(system: System) -> Sets:
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
    return Sets(system=system, by_name=by_name, near=near, beside=beside)


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
