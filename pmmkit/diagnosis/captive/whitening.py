"""Rows of a channel, whitened run by run by the noise of the records and what each run draws.

A run's rows have the covariance V = C + Z diag(s²) Z', C the noise of the record and Z what the run
draws for itself at size one; whitening multiplies by the inverse of its lower root.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.inference import RunEffects, Taken, of_others
from pmmkit.numerics import Array

Places = NDArray[np.intp]
RIDGE: Final = 1e-12
"""Least variance of a row, over the mean of all."""
HELD: Final = 2**17
"""Numbers that are whitened at once: a megabyte stays in the processor's cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """Rows of one channel: the means and harmonics of all views that have it.

    `name`: X, Y, N or K. `views`: views that have it. `runs`: rows of each run. `noise (m, m)`:
    covariance of the noise of each run's rows. `scale`: root mean square over the views of the
    force over U² [N/(m/s)²].
    """

    name: str
    views: tuple[int, ...]
    rows: tuple[slice, ...]
    runs: tuple[Places, ...]
    y: Array
    design: Array
    noise: tuple[Array, ...]
    scale: float


def whitened(channel: Channel, columns: Array, own: Array, scatter: Array) -> Array:
    """Columns multiplied by the inverse root of the covariance of noise and run scatter.

    columns (n, q); own (n, 3 + k); scatter (4,).
    """
    return _applied(_inverse_roots(channel, sized(own, scatter)), columns)


def sized(own: Array, scatter: Array) -> Array:
    """What each run draws (n, 3 + k), per standard deviation."""
    return own * RunEffects.per_column(scatter, own.shape[1] - len(scatter) + 1)


def noise_whitened(channel: Channel, columns: Array) -> Array:
    """Columns (n, q) multiplied by the inverse root of the covariance of the noise alone."""
    return _applied(_inverse_roots(channel, None), columns)


@dataclass(frozen=True, kw_only=True, eq=False)
class Projection:
    """Whitening of one channel, and what base and floor explain of it.

    `own (n, 3 + k)`: what each run draws for itself, at size one. `floor (n, D)`: features of
    the smooth floor at its size, whitened. `span (n + D, k)`: orthonormal basis of base and
    floor, the rows of the floor's prior below. `freedom`: rows less base coefficients.
    """

    channel: Channel
    own: Array
    scatter: Array
    floor: Array
    span: Array
    freedom: int

    @cached_property
    def alone(self) -> tuple[Array, ...]:
        """What a fit without a run makes of its rows (`of_others`), run by run."""
        inverses: list[Array] = [np.zeros((0, 0))] * len(self.channel.runs)
        for numbers in _alike(self.channel):
            inverse, _ = of_others(self.span[_rows(self.channel, numbers)])
            for number, one in zip(numbers, inverse, strict=True):
                inverses[number] = one
        return tuple(inverses)

    def without(self, numbers: Sequence[int]) -> Array:
        """As `alone`, of some runs together."""
        if len(numbers) == 1:
            return self.alone[numbers[0]]
        rows = np.concatenate([self.channel.runs[number] for number in numbers])
        return of_others(self.span[rows])[0]

    @cached_property
    def run_of_row(self) -> Places:
        """Number of the run that each row belongs to (n,)."""
        run = np.zeros(len(self.channel.y), np.intp)
        for number, rows in enumerate(self.channel.runs):
            run[rows] = number
        return run

    def runs_of(self, rows: Places) -> tuple[int, ...]:
        """Numbers of the runs that some rows belong to; rows of other channels are left out."""
        inside = rows[(rows >= 0) & (rows < len(self.channel.y))]
        return tuple(dict.fromkeys(self.run_of_row[inside].tolist()))

    @cached_property
    def roots(self) -> tuple[Array, ...]:
        """Lower roots of the covariance of each run's rows: what whitening takes off."""
        lower: list[Array] = [np.zeros((0, 0))] * len(self.channel.runs)
        for numbers, root in _roots(self.channel, sized(self.own, self.scatter)):
            for number, one in zip(numbers, root, strict=True):
                lower[number] = one
        return tuple(lower)

    @cached_property
    def _inverse_roots(self) -> list[tuple[Places, Array]]:
        return _inverse_roots(self.channel, sized(self.own, self.scatter))

    def whitened(self, columns: Array) -> Array:
        """Columns (n, q) over the root of the covariance (`whitened`)."""
        return _applied(self._inverse_roots, columns)

    def whitened_runs(self, numbers: Sequence[int], columns: Array) -> Array:
        """Columns (m, q) in the rows of some runs, one after another, whitened."""
        found, begin = np.empty_like(columns), 0
        for number in numbers:
            end = begin + len(self.roots[number])
            found[begin:end] = np.linalg.inv(self.roots[number]) @ columns[begin:end]
            begin = end
        return found

    def left(self, columns: Array) -> Array:
        """Columns (n, q) whitened, with what base and floor explain taken off (n + D, q)."""
        return self.outside(self.whitened(columns))

    def outside(self, white: Array) -> Array:
        """Of whitened columns (n, q) what base and floor do not explain (n + D, q)."""
        n = len(white)
        found = self.span @ -(self.span[:n].T @ white)
        found[:n] += white
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """One channel of a system: whitened, with what base and floor explain taken off.

    `projection`: how that is done to any column. `columns (n + D, q)`: those of the system that
    act in this channel, but for the floor. `places (q,)`: their places in the system.
    """

    projection: Projection
    columns: Array
    places: Places
    data: Array


def _inverse_roots(channel: Channel, own: Array | None) -> list[tuple[Places, Array]]:
    """Rows of runs of equal numbers of rows (k, m), and what whitens them (k, m, m).

    A product with the inverse of these few rows takes a third of a solution for each run.
    """
    return [
        (_rows(channel, numbers), np.asarray(np.linalg.inv(root), float))
        for numbers, root in _roots(channel, own)
    ]


def _applied(inverse_roots: Sequence[tuple[Places, Array]], columns: Array) -> Array:
    """Columns (n, q) whitened, a few runs at a time."""
    white = np.empty_like(columns)
    for rows, inverse in inverse_roots:
        few = max(1, HELD // (rows.shape[1] * max(1, columns.shape[1])))
        for begin in range(0, len(rows), few):
            at = rows[begin : begin + few]
            white[at] = inverse[begin : begin + few] @ columns[at]
    return white


def _roots(channel: Channel, own: Array | None) -> list[tuple[list[int], Array]]:
    """Runs of equal numbers of rows with the lower roots of their covariance (k, m, m)."""
    least = RIDGE * float(np.mean(np.concatenate([np.diagonal(x) for x in channel.noise])))
    roots = []
    for numbers in _alike(channel):
        V = np.stack([channel.noise[i] for i in numbers])
        covariance = V + least * np.eye(V.shape[1])
        if own is not None:
            drawn = own[_rows(channel, numbers)]
            covariance = covariance + drawn @ np.swapaxes(drawn, 1, 2)
        roots.append((numbers, np.asarray(np.linalg.cholesky(covariance), float)))
    return roots


def _alike(channel: Channel) -> list[list[int]]:
    """Runs of equal numbers of rows together."""
    sizes: dict[int, list[int]] = {}
    for number, rows in enumerate(channel.runs):
        sizes.setdefault(len(rows), []).append(number)
    return list(sizes.values())


def _rows(channel: Channel, numbers: Sequence[int]) -> Places:
    """Rows of runs of equal numbers of rows (k, m)."""
    return np.stack([channel.runs[i] for i in numbers])


def alike(channel: Channel) -> list[Places]:
    """Rows of runs of equal numbers of rows together, arrays (k, m)."""
    return [_rows(channel, numbers) for numbers in _alike(channel)]


# What each of very many runs draws for itself: a column that is zero but in its own rows.
#
# Their products are D - L'L, D diagonal and L thin: all that is asked of them goes by Woodbury's
# identity, without the square matrix.


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
