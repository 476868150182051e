"""Sets of effects, and how far the base moves, weighed by what the records make of them.

p(records | set) is the mean over the spreads s of the base of ∫ p(records | z) N(z; 0, K + s² 1) dz
(Laplace): by products of the base first (`screen`), then of the set.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.evidence import integrated_out
from pmmkit.diagnosis.free_running.base import FreeBase
from pmmkit.diagnosis.free_running.candidates import FreeCandidate
from pmmkit.diagnosis.free_running.information import WindowInformation
from pmmkit.inference import Normal
from pmmkit.numerics import Array

Names = tuple[str, ...]
WIDER: Final = 1.5
"""Standard deviation of a coefficient before, over its usual size."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Numbers:
    """All that may move: the values of the base over their sizes, then coefficients.

    `values`: values of the model, and what the records show wrongly. `T (m, q)`: ``values = T
    numbers``; a coefficient of 1 is `WIDER` times its usual size. `columns`: those of each
    candidate.
    """

    values: tuple[str, ...]
    T: Array
    base: FreeBase
    columns: Mapping[str, NDArray[np.intp]]

    @property
    def width(self) -> int:
        """Number of columns of the base."""
        return len(self.base.known)

    def at(self, names: Sequence[str]) -> NDArray[np.intp]:
        """Columns of candidates."""
        found = [self.columns[name] for name in names]
        return np.concatenate([np.zeros(0, np.intp), *found])

    def used(self, names: Sequence[str]) -> NDArray[np.intp]:
        """Columns of the base and of candidates."""
        return np.concatenate([np.arange(self.width), self.at(names)])

    def only(self, names: Sequence[str]) -> Numbers:
        """Those of the base and of candidates alone, in the order of `used`."""
        columns, begin = {}, self.width
        for name in names:
            count = len(self.columns[name])
            columns[name] = np.arange(begin, begin + count)
            begin += count
        return replace(self, T=self.T[:, self.used(names)], columns=columns)

    def having(self, names: Sequence[str]) -> tuple[Numbers, NDArray[np.intp]]:
        """Those of a base that has some of the candidates, and where each was."""
        rest = [name for name in self.columns if name not in names]
        order = self.used((*names, *rest))
        moved = self.only((*names, *rest))
        columns = {name: moved.columns[name] for name in rest}
        base = self.base.having(len(self.at(names)))
        return replace(moved, base=base, columns=columns), order

    def steps(self, columns: NDArray[np.intp]) -> dict[int, float]:
        """The values that some columns move, and by how much for a slope."""
        size = np.max(np.abs(self.T[:, columns]), axis=1, initial=0.0)
        return {int(i): 1e-3 * float(size[i]) for i in np.flatnonzero(size)}

    @cached_property
    def every(self) -> NDArray[np.intp]:
        """All columns."""
        return np.arange(self.T.shape[1])


def numbers_of(base: FreeBase, candidates: Sequence[FreeCandidate]) -> Numbers:
    """The numbers of a base and of candidates."""
    values = tuple(
        dict.fromkeys((*base.names, *(name for item in candidates for name in item.values)))
    )
    place = {name: i for i, name in enumerate(values)}
    blocks = [np.zeros((len(values), len(base.names)))]
    for j, (name, size) in enumerate(zip(base.names, base.sizes.tolist(), strict=True)):
        blocks[0][place[name], j] = size
    columns, begin = {}, len(base.names)
    for item in candidates:
        block = np.zeros((len(values), len(item.moves)))
        for j, (label, own) in enumerate(item.moves.items()):
            for name, amount in own.items():
                block[place[name], j] = WIDER * item.typical[label] * amount
        blocks.append(block)
        columns[item.name] = np.arange(begin, begin + block.shape[1])
        begin += block.shape[1]
    return Numbers(values=values, T=np.concatenate(blocks, axis=1), base=base, columns=columns)


@dataclass(frozen=True, kw_only=True, eq=False)
class Screen:
    """What is known of candidates when the base is averaged over one spread.

    `normal`: what the records say of their coefficients. `ground`: ln of how probable the
    records are without any. `columns`: places of each candidate.
    """

    normal: Normal
    ground: float
    columns: Mapping[str, NDArray[np.intp]]

    def __call__(self, names: Sequence[str]) -> float:
        """ln of how probable the records are with a set."""
        return self.ground + (self.gain(names) if names else 0.0)

    def gain(self, names: Sequence[str]) -> float:
        """ln evidence of a set against none of it."""
        return self.normal.only(np.concatenate([self.columns[name] for name in names])).log_evidence


def screen(known: WindowInformation, numbers: Numbers, spread: float) -> Screen:
    """The base taken out of what is known."""
    b, P = numbers.width, known.products.sum(axis=0)
    root = numbers.base.root(spread)
    rest, volume = integrated_out(root.T @ P[:b, :b] @ root, root.T @ P[:b, b:], P[b:, b:])
    normal = Normal.of_products(0.5 * (rest + rest.T), known.normal.volume + volume)
    return Screen(
        normal=normal,
        ground=normal.log_density_at(np.zeros(len(rest) - 1)),
        columns={name: at - b for name, at in numbers.columns.items()},
    )


def averaged(values: Sequence[float]) -> float:
    """ln of the mean of probabilities that are given by their logarithms."""
    top = max(values)
    return top + math.log(sum(math.exp(x - top) for x in values) / len(values))


@dataclass(frozen=True, kw_only=True, eq=False)
class WeighedScreens:
    """Screens of one information, one for each spread of the base."""

    screens: tuple[Screen, ...]

    def __call__(self, names: Sequence[str]) -> float:
        """ln of how probable the records are with a set, averaged over the spreads."""
        return averaged([item(names) for item in self.screens])

    def best(self, names: Sequence[str]) -> int:
        """Number of the most probable spread."""
        return int(np.argmax([item(names) for item in self.screens]))


def weighed(known: WindowInformation, numbers: Numbers) -> WeighedScreens:
    """Screens for all spreads of the base."""
    return WeighedScreens(
        screens=tuple(screen(known, numbers, float(x)) for x in numbers.base.spreads)
    )


def probable(
    known: WindowInformation, numbers: Numbers, names: Sequence[str], spread: float
) -> tuple[Array, Array]:
    """The most probable numbers (q,) of a set, zero where they take no part; their covariance."""
    whole = _whole(numbers, names, spread)
    mean, covariance = known.normal.in_terms_of(whole).posterior
    return whole @ mean, whole @ covariance @ whole.T


def damped(
    known: WindowInformation,
    numbers: Numbers,
    names: Sequence[str],
    spread: float,
    begin: Array,
    damping: float,
) -> Array:
    """A step towards the most probable numbers, damped after Levenberg and Marquardt."""
    whole = _whole(numbers, names, spread)
    y = np.linalg.lstsq(whole, begin, rcond=None)[0]
    own = known.normal.in_terms_of(whole)
    H = own.information + np.eye(len(y))
    step = np.linalg.solve(H + damping * np.diag(np.diagonal(H)), own.score - H @ y)
    found: Array = begin + whole @ step
    return found


def _whole(numbers: Numbers, names: Sequence[str], spread: float) -> Array:
    """Numbers of a set over such as are standard normal before."""
    b, at = numbers.width, numbers.at(names)
    root = numbers.base.root(spread)
    whole = np.zeros((len(numbers.every), root.shape[1] + len(at)))
    whole[:b, : root.shape[1]] = root
    whole[at, np.arange(root.shape[1], whole.shape[1])] = 1.0
    return whole


def unlikely(numbers: Numbers, names: Sequence[str], spread: float, z: Array) -> float:
    """Half the sum of squares of some numbers by what is known of them before; infinite where one
    is moved that does not move at this spread."""
    total = float(z[numbers.at(names)] @ z[numbers.at(names)])
    root = numbers.base.root(spread)
    moves = root.any(axis=1)
    if np.any(z[: numbers.width][~moves]):
        return math.inf
    if root.shape[1]:
        own = np.linalg.solve(root[moves], z[: numbers.width][moves])
        total += float(own @ own)
    return 0.5 * total
