"""Linear equations of runs as triangles, and what they determine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmmkit.inference.linear_fit import RANK_TOLERANCE, LeastSquares, dependent
from pmmkit.numerics import Array

Flags = NDArray[np.bool_]
EXCITED: Final = 0.05
"""Rms of a column in some runs, over that in all, below which these do not excite it."""


def unit_columns(X: Array) -> tuple[Array, Array]:
    """Columns of unit length, and what they were divided by: one of a column of zeros."""
    length = np.linalg.norm(X, axis=0)
    scale = np.where(length > 0, length, 1.0)
    return X / scale, scale


class Triangle(NamedTuple):
    """R of [X y] = Q R: fewer equations of one channel that have the same least squares.

    `both (at most p + 1, p + 1)`: x and y side by side. `rows`: rows that it stands for.
    """

    both: Array
    rows: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Equations:
    """Linear equations y ≈ X θ of a run, or of many, channel by channel, as triangles.

    Parameters
    ----------
    channels : tuple of Triangle
        By channel.

    Examples
    --------
    >>> v = np.linspace(-.3, .3, 50)
    >>> run = Equations.of((np.stack([v, v**3], axis=1), -v - 2 * v**3))
    >>> run.channels[0].both.shape, run.least_squares(np.array([True, True])).round(9)
    ((3, 3), array([-1., -2.]))
    """

    channels: tuple[Triangle, ...]

    @classmethod
    def of(cls, *channels: tuple[Array, Array]) -> Equations:
        """From X (n, p) and y (n,) of each channel, over the standard deviations of the rows."""
        return cls(
            channels=tuple(
                Triangle(_triangle(np.column_stack([X, y])), len(y)) for X, y in channels
            )
        )

    @classmethod
    def joined(cls, runs: Iterable[Equations]) -> Equations:
        """Of several runs together; a run may stand more than once."""
        return cls(
            channels=tuple(
                Triangle(
                    _triangle(np.concatenate([part.both for part in parts])),
                    sum(part.rows for part in parts),
                )
                for parts in zip(*(run.channels for run in runs), strict=True)
            )
        )

    @property
    def rows(self) -> NDArray[np.int64]:
        """Rows by channel, array (c,)."""
        return np.array([part.rows for part in self.channels], np.int64)

    def rms(self, theta: Array | None = None) -> Array:
        """Rms of each column in the channel where it is largest; of X θ where θ is given."""
        found = []
        for both, rows in self.channels:
            part = both[:, :-1] if theta is None else both[:, :-1] @ theta
            found.append(np.sqrt(np.sum(part**2, axis=0) / max(rows, 1)))
        return np.asarray(np.max(found, axis=0))

    @cached_property
    def scaled(self) -> tuple[Array, Array, Array]:
        """X with columns of unit rms, y, and what the columns were divided by."""
        both = np.concatenate([part.both for part in self.channels])
        size = self.rms()
        scale = np.where(size > 0, size, 1.0)
        return both[:, :-1] / scale, both[:, -1], scale

    def dependent(self) -> Flags:
        """Coefficients of which a mixture has no effect in any row, array (p,)."""
        X, _, _ = self.scaled
        sizes = np.linalg.svd(X, compute_uv=False)
        if len(X) >= X.shape[1] and sizes[-1] > RANK_TOLERANCE * sizes[0]:
            return np.zeros(X.shape[1], bool)  # no pivot is smaller than the smallest of these
        root = np.linalg.qr(X, mode="r")
        square = np.zeros((X.shape[1],) * 2)
        square[: len(root)] = root
        return dependent(square)

    def excited(self, usual: Array) -> Flags:
        """Columns that these runs excite, array (p,); `usual` (p,) is their rms in all runs."""
        return np.asarray(self.rms() > EXCITED * usual)

    def determined(self, usual: Array) -> Flags:
        """Which coefficients these runs determine.

        Parameters
        ----------
        usual : array (p,)
            Rms of the columns in all runs.
        """
        there = self.excited(usual)
        if not there.any():
            return there
        keep = [*np.flatnonzero(there), -1]
        some = Equations(
            channels=tuple(Triangle(both[:, keep], rows) for both, rows in self.channels)
        )
        there[np.flatnonzero(there)[some.dependent()]] = False
        return there

    def least_squares(self, columns: Flags) -> Array:
        """θ (p,) by least squares on some of the columns; the others are zero."""
        X, y, scale = self.scaled
        theta = np.zeros(X.shape[1])
        if columns.any():
            theta[columns] = np.linalg.lstsq(X[:, columns], y, rcond=RANK_TOLERANCE)[0]
        return np.asarray(theta / scale)

    def over(self, std: Array) -> Equations:
        """With the rows of each channel over a standard deviation (c,)."""
        return Equations(
            channels=tuple(
                Triangle(both / size, rows)
                for (both, rows), size in zip(self.channels, std.tolist(), strict=True)
            )
        )

    def covariance(self, columns: Flags, variance: Array) -> Array:
        """Of least squares on s columns, rows of each channel of a variance (c,), array (s, s)."""
        parts = [both[:, :-1][:, columns] for both, _ in self.channels]
        X, scale = unit_columns(np.concatenate(parts))
        found = LeastSquares.of([""] * len(scale), X, np.zeros(len(X)))
        gain = found.gain / scale[:, None]
        weight = np.repeat(variance, [len(part) for part in parts])
        covariance = np.asarray((gain * weight) @ gain.T)
        covariance[~found.determined, :] = covariance[:, ~found.determined] = np.nan
        return covariance

    def squares(self, theta: Array) -> Array:
        """Sum of squares that θ leaves in each channel, array (c,)."""
        turned = np.append(theta, -1.0)
        return np.array([np.sum((part.both @ turned) ** 2) for part in self.channels])


def _triangle(both: Array) -> Array:
    if len(both) <= both.shape[1]:
        return both
    return np.asarray(np.linalg.qr(both, mode="r"))
