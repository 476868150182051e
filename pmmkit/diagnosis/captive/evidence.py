"""The evidence for effects, one or several at once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.conditioning import condition_on, spread
from pmmkit.diagnosis.captive.system import MANY, Block, System
from pmmkit.diagnosis.evidence import Entry
from pmmkit.numerics import Array
from pmmkit.observations.channels import Places

MOST: Final = 3
"""Effects in a set."""
NEAR: Final = 2
"""Grid points of an effect, those that explain most alone, that stand in sets of several."""
AHEAD: Final = 8
"""Best single effects that are combined with all others."""


def log_evidence(gram: Array, score: Array, centre: Array) -> float:
    """ln of how much better the data are explained with columns than without.

    Parameters
    ----------
    gram, score : array (q, q), (q,)
        Of the columns, in units of their prior standard deviation.
    centre : array (q,)
        Expected coefficients, in the same.

    Returns
    -------
    float
        For z ~ N(E c, I + E E') against N(0, I).
    """
    return float(log_evidences(gram, score, centre))


def log_evidences(gram: Array, score: Array, centre: Array) -> Array:
    """`log_evidence` of several systems with as many columns, arrays (…, q, q) and (…, q)."""
    expected = gram @ centre
    root = np.linalg.cholesky(gram + np.eye(len(centre)))
    half = np.linalg.solve(root, (score - expected)[..., None])[..., 0]
    gained = score @ centre - 0.5 * expected @ centre
    logs = np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=-1)
    return np.asarray(gained + 0.5 * np.sum(half**2, axis=-1) - logs, float)


def evidence_at(system: System, at: Places, size: Array | None = None) -> float:
    """`log_evidence` of some columns of a system, of other size where asked for."""
    scale = np.ones(len(at)) if size is None else size
    return log_evidence(
        system.gram[np.ix_(at, at)] * np.outer(scale, scale),
        system.score[at] * scale,
        system.centre[at] / scale,
    )


def evidence_of(system: System, block: Block) -> float:
    """`log_evidence` of one effect at one grid point."""
    return block.drawn.log_evidence if block.drawn else evidence_at(system, block.places)


def price(system: System) -> float:
    """ln evidence that an effect must pay for the size of the catalogue."""
    return math.log(2.0 * len({block.candidate.name for block in system.blocks}))


@dataclass(frozen=True, kw_only=True, eq=False)
class Sets:
    """Sets of effects of a system, and what is computed once for all of them.

    Parameters
    ----------
    system : System
        Runs, base and candidates.
    by_name : mapping of str to list of Block
        Each effect at its grid points, and in its forms.
    near : mapping of str to list of Block
        Those that explain most, which stand in sets of several.
    beside : mapping of int to (float, System)
        Evidence of each wide block, and the system beside it.
    """

    system: System
    by_name: Mapping[str, list[Block]]
    near: Mapping[str, list[Block]]
    beside: Mapping[int, tuple[float, System]]

    def value_of(self, blocks: Sequence[Block]) -> float:
        """ln evidence of blocks; one with many columns is taken into account once for all sets."""
        if len(blocks) == 1:
            return evidence_of(self.system, blocks[0])
        many = [block for block in blocks if id(block) in self.beside]
        if len(many) != 1:
            system, blocks = spread(self.system, blocks)
            return evidence_at(system, np.concatenate([block.places for block in blocks]))
        alone, rest = self.beside[id(many[0])]
        at = np.concatenate([block.places for block in blocks if block is not many[0]])
        return alone + evidence_at(rest, at)

    def entry(self, names: Sequence[str]) -> Entry:
        """A set with its evidence, averaged over grids and forms."""
        own = self.by_name if len(names) == 1 else self.near
        found = [(self.value_of(blocks), blocks) for blocks in product(*(own[x] for x in names))]
        top, best = max(found, key=lambda item: item[0])
        total = sum(math.exp(value - top) for value, _ in found)
        share = math.prod(len(self.by_name[name]) for name in names)
        return Entry(
            names=tuple(names),
            values=tuple(block.value for block in best),
            terms=tuple(block.candidate.size for block in best),
            log_evidence=top + math.log(total / share) - price(self.system) * len(names),
        )

    def added(self, entry: Entry) -> tuple[float, ...]:
        """ln evidence that each effect of a set adds to the others."""
        if len(entry.names) == 1:
            return (entry.log_evidence,)
        return tuple(
            entry.log_evidence - self.entry([x for x in entry.names if x != name]).log_evidence
            for name in entry.names
        )


def sets_of(system: System) -> Sets:
    """Sets that can be asked for.

    Parameters
    ----------
    system : System
        Runs, base and candidates.
    """
    by_name: dict[str, list[Block]] = {}
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


def ranked_sets(sets: Sets, *, most: int = MOST) -> list[Entry]:
    """All single effects, and the sets that deserve it, best first."""
    entry, by_name = sets.entry, sets.by_name
    singles = sorted((entry([name]) for name in by_name), key=lambda x: -x.log_evidence)
    found = list(singles)
    best = [x.names[0] for x in singles[:AHEAD]]
    pairs: list[Entry] = []
    if most > 1:
        wanted = {tuple(sorted(pair)) for pair in combinations(best, 2)}
        wanted |= {tuple(sorted((a, b))) for a in best[:4] for b in by_name if b != a}
        pairs = sorted((entry(pair) for pair in sorted(wanted)), key=lambda x: -x.log_evidence)
        found += pairs
    if most > 2 and pairs:
        triples = {
            tuple(sorted((*pair.names, name)))
            for pair in pairs[:3]
            for name in by_name
            if name not in pair.names
        }
        found += [entry(names) for names in sorted(triples)]
    return sorted(found, key=lambda x: -x.log_evidence)


def wide(block: Block) -> bool:
    """Whether a block has so many columns (one per run) that sets with it need another way."""
    return block.drawn is not None or block.count > MANY


def gate(system: System, best: float, *, draws: int = 400, seed: int = 0) -> float:
    """Probability that no effect at all gives a single effect as good as the best.

    Scores of the null are drawn from their own covariance, the Gram matrix; the largest evidence
    over the whole catalogue and its grids is kept of each draw (Westfall and Young 1993). Blocks of
    very many columns, which chance hardly ever favours, are left out.
    """
    used = [block for block in system.blocks if not wide(block)]
    at = np.arange(max(block.columns.stop for block in used))
    values, vectors = np.linalg.eigh(system.gram[np.ix_(at, at)])
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    drawn = np.random.default_rng(seed).normal(size=(draws, len(at))) @ root.T
    largest = np.full(draws, -np.inf)
    by_name: dict[str, list[Array]] = {}
    for block in used:
        own = np.arange(block.columns.start, block.columns.stop)
        G, c = system.gram[np.ix_(own, own)], system.centre[own]
        L = np.linalg.cholesky(G + np.eye(len(own)))
        half = np.linalg.solve(L, (drawn[:, own] - G @ c).T)
        value = drawn[:, own] @ c - 0.5 * c @ G @ c
        value = value + 0.5 * np.sum(half**2, axis=0) - np.sum(np.log(np.diagonal(L)))
        by_name.setdefault(block.candidate.name, []).append(value)
    paid = price(system)
    for own_values in by_name.values():
        stacked = np.stack(own_values)
        top = stacked.max(axis=0)
        mean = top + np.log(np.mean(np.exp(stacked - top), axis=0))
        largest = np.maximum(largest, mean - paid)
    return float((1 + np.sum(largest >= best)) / (draws + 1))
