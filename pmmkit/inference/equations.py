"""Least squares with scaled columns: what rows determine, the values, and how sure they are."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

Flags = NDArray[np.bool_]
RANK_TOLERANCE: Final = 1e-9
"""Singular values of columns of one length below this share of the largest are zero.

Columns that depend on each other but for rounding have 2e-15 to 4e-15 (one drift angle and two
terms, two angles and three), the most alike columns of libraries that captive runs tell apart
1e-2; any tolerance between gives the same.
"""
INVOLVED: Final = 1e-6
"""Part in a mixture without effect from which a column is not determined."""
EXCITED: Final = 0.05
"""Rms of a column in some runs, over that in all, below which these do not excite it."""


def _rank(s: Array) -> int:
    """How many singular values of columns of one length are not zero."""
    return int(np.sum(s > RANK_TOLERANCE * max(s.max(initial=0.0), 1e-300)))


def _involved(s: Array, Vt: Array) -> Flags:
    """Columns with a part in a mixture that has no effect, from a singular value decomposition."""
    return np.asarray((np.abs(Vt[_rank(s) :]) > INVOLVED).any(axis=0))


def unit_columns(X: Array) -> tuple[Array, Array]:
    """Columns of unit length, and what they were divided by: one of a column of zeros."""
    length = np.linalg.norm(X, axis=0)
    scale = np.where(length > 0, length, 1.0)
    return X / scale, scale


def unit_covariance(X: Array) -> Array:
    """Covariance (X'X)⁻¹ of least squares on rows of unit variance.

    Parameters
    ----------
    X : array (n, p)
        What each coefficient multiplies in each row, over the standard deviation of the row.

    Returns
    -------
    array (p, p)
        NaN in rows and columns of coefficients that the rows do not determine: those with a part
        of more than 1e-6 in a mixture of columns of unit length that has no effect.

    Notes
    -----
    By singular values of the columns scaled to unit length, of which those below 1e-9 of the
    largest are zero. The normal equations would square the condition number.

    Examples
    --------
    >>> v = np.array([-.2, -.1, .1, .2])
    >>> unit_covariance(np.stack([v, v**3, 0 * v], axis=1)).round()
    array([[   90., -2361.,    nan],
           [-2361., 69444.,    nan],
           [   nan,    nan,    nan]])
    """
    unit, scale = unit_columns(X)
    _, s, Vt = np.linalg.svd(unit, full_matrices=len(X) < X.shape[1])
    rank = _rank(s)
    root = Vt[:rank].T / s[:rank] / scale[:, None]
    covariance = np.asarray(root @ root.T)
    lost = _involved(s, Vt)
    covariance[lost, :] = covariance[:, lost] = np.nan
    return covariance


class Triangle(NamedTuple):
    """R of [X y] = Q R: fewer equations of one channel that have the same least squares.

    Parameters
    ----------
    both : array (at most p + 1, p + 1)
        X and y side by side.
    rows : int
        Rows that it stands for.
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
        _, s, Vt = np.linalg.svd(self.scaled[0])
        return _involved(s, Vt)

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
        inverse = unit_covariance(np.concatenate(parts))
        gains = [
            math.sqrt(size) * X @ inverse for X, size in zip(parts, variance.tolist(), strict=True)
        ]
        return np.asarray(sum((A.T @ A for A in gains), np.zeros_like(inverse)))

    def squares(self, theta: Array) -> Array:
        """Sum of squares that θ leaves in each channel, array (c,)."""
        turned = np.append(theta, -1.0)
        return np.array([np.sum((part.both @ turned) ** 2) for part in self.channels])


def _triangle(both: Array) -> Array:
    if len(both) <= both.shape[1]:
        return both
    return np.asarray(np.linalg.qr(both, mode="r"))
