"""What each of very many runs draws for itself: a column that is zero but in its own rows.

Their products are D - L'L, D diagonal and L thin: all that is asked of them goes by Woodbury's
identity, without the square matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from pmmkit.diagnosis.captive.whitening import Piece, Places, Projection
from pmmkit.inference import Taken
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class OwnColumns:
    """A column for each run that knows a candidate, in one channel.

    `values`: of the rows; each belongs to one run. `column`: which column that is; -1 where the
    run has none. `count`: how many columns there are.
    """

    values: Array
    column: Places
    count: int

    def dense(self) -> Array:
        """As an array (n, count)."""
        found = np.zeros((len(self.values), self.count))
        (rows,) = np.nonzero(self.column >= 0)
        found[rows, self.column[rows]] = self.values[rows]
        return found

    def sparse(self) -> Any:
        """As a sparse array (n, count)."""
        from scipy.sparse import csc_array

        (rows,) = np.nonzero(self.column >= 0)
        held = (self.values[rows], (rows, self.column[rows]))
        return csc_array(held, shape=(len(self.values), self.count))

    def whitened(self, projection: Projection) -> OwnColumns:
        """Over the root of the covariance: rows of a run mix with each other alone."""
        return replace(self, values=projection.whitened(self.values[:, None])[:, 0])

    def times(self, size: float) -> OwnColumns:
        """Of another size."""
        return replace(self, values=size * self.values)


@dataclass(frozen=True, kw_only=True, eq=False)
class RunEffectColumns:
    """Whitened and projected columns of a candidate that each run draws, never written out.

    Their products are ``diag(squares) - low' low``: a thousand runs take a thousand numbers and a
    thin matrix in place of a million.

    `parts (n, m)`: whitened, by channel; the columns of the channels stand one after another.
    `low (k, m)`: what base, floor, and effects that are known explain of them. `across (q, m)`:
    products with the columns of the system. `score (m,)`: products with the data.
    """

    parts: tuple[Any, ...]
    low: Array
    across: Array
    score: Array

    @classmethod
    def of(cls, own: Sequence[OwnColumns], pieces: Sequence[Piece], width: int) -> RunEffectColumns:
        """From whitened columns by channel."""
        parts = tuple(item.sparse() for item in own)
        edges = np.cumsum([0, *(item.count for item in own)]).tolist()
        heights = np.cumsum([0, *(p.projection.span.shape[1] for p in pieces)]).tolist()
        low = np.zeros((heights[-1], edges[-1]))
        across, score = np.zeros((width, edges[-1])), np.zeros(edges[-1])
        for k, (part, piece) in enumerate(zip(parts, pieces, strict=True)):
            mine, n = slice(edges[k], edges[k + 1]), part.shape[0]
            low[heights[k] : heights[k + 1], mine] = (part.T @ piece.projection.span[:n]).T
            across[piece.places, mine] = (part.T @ piece.columns[:n]).T
            score[mine] = part.T @ piece.data[:n]
        return cls(parts=parts, low=low, across=across, score=score)

    @property
    def count(self) -> int:
        """Number of columns."""
        return len(self.score)

    @cached_property
    def squares(self) -> Array:
        """Of the columns, before anything is taken off (m,)."""
        return np.concatenate([np.asarray(part.power(2).sum(axis=0)) for part in self.parts])

    @cached_property
    def _inner(self) -> Array:
        """Lower root of ``I - low (I + diag)⁻¹ low'``."""
        scaled = self.low / np.sqrt(1.0 + self.squares)
        root = np.linalg.cholesky(np.eye(len(self.low)) - scaled @ scaled.T)
        return np.asarray(root, float)

    def solve(self, right: Array) -> Array:
        """Solution of (I + products) x = right, arrays (m,) or (m, p) (Woodbury)."""
        grown = 1.0 + self.squares
        over = right / (grown if right.ndim == 1 else grown[:, None])
        inner = np.linalg.solve(self._inner, self.low @ over)
        more = self.low.T @ np.linalg.solve(self._inner.T, inner)
        found: Array = over + more / (grown if right.ndim == 1 else grown[:, None])
        return found

    @property
    def log_evidence(self) -> float:
        """As `Normal.log_evidence` of the columns, whose expected coefficients are zero."""
        logs = 0.5 * np.sum(np.log1p(self.squares)) + np.sum(np.log(np.diagonal(self._inner)))
        return float(0.5 * self.score @ self.solve(self.score) - logs)

    def square_of(self, coefficients: Array) -> float:
        """Squared length of the columns times coefficients (m,)."""
        return float(self.squares @ coefficients**2 - np.sum((self.low @ coefficients) ** 2))

    def left(self, pieces: Sequence[Piece], coefficients: Array) -> list[Array]:
        """Columns times coefficients (m,) in each channel, base and floor taken off (n + D,)."""
        edges = np.cumsum([0, *(part.shape[1] for part in self.parts)])
        shares = np.split(coefficients, edges[1:-1])
        return [
            piece.projection.outside((part @ own)[:, None])[:, 0]
            for part, own, piece in zip(self.parts, shares, pieces, strict=True)
        ]

    def beside(self, taken: Taken) -> RunEffectColumns:
        """Beside columns of the system that are known (`condition_on`)."""
        products = self.across[taken.at]
        own = np.linalg.solve(taken.root, products)
        return replace(
            self,
            low=np.vstack([self.low, own]),
            across=self.across - taken.across.T @ own,
            score=self.score - products.T @ taken.centre - own.T @ taken.explained,
        )

    def products(self, other: RunEffectColumns) -> Array:
        """With the columns of another candidate, or with its own, written out (m, m')."""
        from scipy.sparse import block_diag

        plain = block_diag([a.T @ b for a, b in zip(self.parts, other.parts, strict=True)])
        found: Array = plain.toarray() - self.low.T @ other.low
        return found
