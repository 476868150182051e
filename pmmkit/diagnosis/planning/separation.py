"""How well runs tell effects apart: at their usual sizes, or as data have made them likely.

The gain in ln odds to be expected of a run, if one set of effects is true, is the Kullback-Leibler
divergence of what it predicts from what another predicts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.system import CandidateColumns
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.diagnosis.planning.information import Reduced, WhitenedRows, at_usual_size, known
from pmmkit.numerics import Array

NEAR: Final = 8
"""Choices of grid values of a set that stay in a rivalry."""
UNLIKELY: Final = 1e-3
"""Share below which a choice is left out."""


def blocks_by_name(rows: WhitenedRows) -> dict[str, list[CandidateColumns]]:
    """Grid points of every effect."""
    blocks: dict[str, list[CandidateColumns]] = {}
    for block in rows.blocks:
        blocks.setdefault(block.candidate.name, []).append(block)
    return blocks


@dataclass(frozen=True, kw_only=True, eq=False)
class UsualEffects:
    """All effects at their usual sizes, at grid values where they are neither weak nor strong.

    `groups`: blocks of equal numbers of coefficients with the effect each belongs to.
    """

    names: tuple[str, ...]
    sizes: Array
    groups: tuple[tuple[Places, Places], ...]

    def signals(self, gram: Array) -> Array:
        """Squared signal over noise of each effect (e,)."""
        found: Array = np.einsum("ke,kl,le->e", self.sizes, gram, self.sizes, optimize=True)
        return found

    def separations(self, gram: Array) -> Array:
        """Squared signal of each effect that no size of another explains (e, e).

        Row: the effect that is there; column: the one that is tried in its place, at the best of
        its grid. Infinite on the diagonal.
        """
        cross = gram @ self.sizes
        total = np.einsum("ke,ke->e", self.sizes, cross)
        explained = np.zeros((len(self.names), len(self.names)))
        for places, effects in self.groups:
            inner = gram[places[:, :, None], places[:, None, :]] + np.eye(places.shape[1])
            taken = np.einsum("bqe,bqe->be", cross[places], np.linalg.solve(inner, cross[places]))
            np.maximum.at(explained, effects, taken)
        left = total[:, None] - explained.T
        np.fill_diagonal(left, np.inf)
        found: Array = np.maximum(left, 0.0)
        return found


def usual(rows: WhitenedRows) -> UsualEffects:
    """All effects of some rows at their usual sizes.

    Of the grid values the median counts, as all rows together show them.
    """
    by_name = blocks_by_name(rows)
    gram = known(rows, rows.of_run).reduced().normal.information

    def signal(block: CandidateColumns) -> float:
        size = at_usual_size(block)
        return float(size @ gram[block.columns, block.columns] @ size)

    sizes = np.zeros((rows.width, len(by_name)))
    sorted_by: dict[int, list[tuple[Places, int]]] = {}
    for number, own in enumerate(by_name.values()):
        middle = sorted(own, key=signal)[len(own) // 2]
        sizes[middle.columns, number] = at_usual_size(middle)
        for block in own:
            sorted_by.setdefault(block.candidate.size, []).append((block.places, number))
    groups = tuple(
        (np.stack([places for places, _ in own]), np.array([number for _, number in own]))
        for own in sorted_by.values()
    )
    return UsualEffects(names=tuple(by_name), sizes=sizes, groups=groups)


@dataclass(frozen=True, kw_only=True, eq=False)
class Likely:
    """A set of effects at one choice of grid values, fitted to the runs that are made.

    `share`: of the choice among those of the set. `mean, covariance (q,)`: coefficients in
    units of their prior.
    """

    share: float
    places: Places
    mean: Array
    covariance: Array

    def predicted(self, columns: Array) -> tuple[Array, Array]:
        """Mean and covariance of new rows of unit noise (m,), (m, m)."""
        own = columns[:, self.places]
        return own @ self.mean, np.eye(len(own)) + own @ self.covariance @ own.T


def likely(reduced: Reduced, names: Sequence[str]) -> tuple[Likely, ...]:
    """A set of effects as the data have made it likely, at the likely ones of its grid values.

    An empty set is the base as it is.
    """
    by_name = blocks_by_name(reduced.rows)

    def evidence(blocks: Sequence[CandidateColumns]) -> float:
        return reduced.normal.only(_places(blocks)).log_evidence

    each = NEAR if len(names) == 1 else 3
    near = [sorted(by_name[name], key=lambda b: -evidence([b]))[:each] for name in names]
    tried = [(evidence(blocks), blocks) for blocks in product(*near)]
    top = max(value for value, _ in tried)
    tried = sorted(tried, key=lambda item: -item[0])[:NEAR]
    tried = [item for item in tried if item[0] > top + math.log(UNLIKELY)]
    total = sum(math.exp(value - top) for value, _ in tried)
    made = []
    for value, blocks in tried:
        at = _places(blocks)
        mean, covariance = reduced.normal.only(at).posterior
        made.append(
            Likely(share=math.exp(value - top) / total, places=at, mean=mean, covariance=covariance)
        )
    return tuple(made)


def _places(blocks: Sequence[CandidateColumns]) -> Places:
    return np.concatenate([np.zeros(0, np.intp), *(block.places for block in blocks)])


def expected_odds(columns: Array, rivals: Sequence[Sequence[Likely]]) -> Array:
    """Expected gain in ln odds of each rival over each other, if it is the true one (n, n).

    columns (m, k).

    Notes
    -----
    A set with several choices a of shares w predicts a mixture of normal distributions. Its
    divergence from another is taken as Σ w_a ln(Σ w_a' exp(-D(a, a')) / Σ w_b exp(-D(a, b))) with
    the divergences D of the parts [1]_.

    .. [1] Hershey, J.R., Olsen, P.A., 2007. Approximating the Kullback Leibler divergence between
       Gaussian mixture models. ICASSP 2007. https://doi.org/10.1109/ICASSP.2007.366913
    """
    every = [item for own in rivals for item in own]
    used = np.unique(np.concatenate([item.places for item in every]))
    root = np.linalg.qr(columns[:, used], mode="r")
    short = np.zeros((len(root), columns.shape[1]))
    short[:, used] = root
    apart = _divergences([item.predicted(short) for item in every])
    edges = np.cumsum([0, *(len(own) for own in rivals)])
    share = np.array([item.share for item in every])
    like = np.stack(
        [
            np.logaddexp.reduce(np.log(share[a:b]) - apart[:, a:b], axis=1)
            for a, b in pairwise(edges)
        ],
        axis=1,
    )
    gained = np.stack(
        [share[a:b] @ (like[a:b, [i]] - like[a:b]) for i, (a, b) in enumerate(pairwise(edges))]
    )
    np.fill_diagonal(gained, np.inf)
    found: Array = np.maximum(gained, 0.0)
    return found


def _divergences(predicted: Sequence[tuple[Array, Array]]) -> Array:
    """Kullback-Leibler divergence of each normal distribution from each other (n, n)."""
    means = np.stack([mean for mean, _ in predicted])
    covariances = np.stack([V for _, V in predicted])
    logs = np.linalg.slogdet(covariances)[1]
    found = np.empty((len(predicted), len(predicted)))
    for j, (mean, W) in enumerate(predicted):
        inverse = np.linalg.inv(W)
        away = means - mean
        square = np.einsum("im,mn,in->i", away, inverse, away)
        trace = np.einsum("mn,inm->i", inverse, covariances)
        found[:, j] = 0.5 * (trace - len(mean) + logs[j] - logs + square)
    return found
