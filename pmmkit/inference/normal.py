"""What data say of coefficients with a normal prior: evidence, posterior, what is left.

Data y of unit covariance, columns A in units of the standard deviations that their coefficients
have before, and means c: ``y = A z + e``, ``z ~ N(c, 1)``, ``e ~ N(0, 1)``. All that y says of z
is in the products ``G = A'A`` (information), ``b = A'y`` (score) and ``y'y`` (square).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

# The square-root information filter: a normal vector as a triangle that takes in whitened rows.


@dataclass(frozen=True, kw_only=True, eq=False)
class InformationRoot:
    """A normal vector θ by the root R of its information (Bierman 1977): R θ = d + e, e ~ N(0, 1).

    Parameters
    ----------
    root : array (…, p, p + 1)
        R and, last, d; several vectors side by side have leading dimensions.

    Notes
    -----
    Rows of equations, whitened by their own noise (which may be correlated), are taken in by an
    orthogonal triangularisation, so that nothing is squared and a vague prior costs no digits.
    `Normal` holds the same knowledge as products, which add up and come apart again, where columns
    are in units of their prior.

    Examples
    --------
    >>> prior = InformationRoot.of(np.array([0.0, 0.0]), np.array([1e3, 1e3]))
    >>> line = np.stack([np.ones(3), np.arange(3.0)], axis=1)
    >>> prior.with_rows(line, np.array([1.0, 3.0, 5.0])).mean.round(4)
    array([1., 2.])
    """

    root: Array

    @classmethod
    def of(cls, mean: Array, std: Array) -> InformationRoot:
        """Independent values with means and standard deviations, arrays (p,)."""
        return cls(root=np.column_stack([np.diag(1.0 / std), mean / std]))

    def with_rows(self, design: Array, rows: Array) -> InformationRoot:
        """What is known with whitened equations ``rows = design θ + e`` too, (…, k, p) and (…, k).

        What was known before may be the same of all.
        """
        before = np.broadcast_to(self.root, (*design.shape[:-2], *self.root.shape[-2:]))
        more = np.concatenate([design, rows[..., None]], axis=-1)
        whole = np.concatenate([before, more], axis=-2)
        return InformationRoot(root=triangle(whole)[..., : before.shape[-2], :])

    @cached_property
    def _inverse(self) -> Array:
        """R⁻¹ (…, p, p)."""
        return np.asarray(np.linalg.inv(self.root[..., :-1]))

    @property
    def mean(self) -> Array:
        """Array (…, p)."""
        return np.asarray((self._inverse @ self.root[..., -1:])[..., 0])

    @property
    def covariance(self) -> Array:
        """Array (p, p)."""
        inverse = self._inverse
        return np.asarray(inverse @ inverse.T)

    def spread(self, design: Array) -> Array:
        """Variances of ``design θ``, array (…, k)."""
        return np.asarray(np.sum((design @ self._inverse) ** 2, axis=-1))

    def innovations(self, design: Array, rows: Array) -> tuple[Array, Array]:
        """What rows, one after another, are off by from what is known before each.

        Returns
        -------
        array (k,)
            Innovations over their standard deviations.
        array (k,)
            Their variances over those of the rows' own noise.

        Notes
        -----
        The covariance of the rows is 1 + A Aᵀ with A = design R⁻¹; its Cholesky factor, by QR from
        1 and A, gives all of them at once (prediction error decomposition; Harvey 1989).
        """
        inverse = self._inverse
        lower = triangle(np.hstack([np.eye(len(rows)), design @ inverse]).T).T
        lower = lower * np.sign(np.diagonal(lower))
        left = rows - design @ (inverse @ self.root[:, -1])
        return np.asarray(np.linalg.solve(lower, left)), np.diagonal(lower) ** 2


def triangle(rows: Array) -> Array:
    """R with RᵀR = rowsᵀ rows."""
    return np.asarray(np.linalg.qr(rows, mode="r"))


Places = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class Normal:
    r"""Products of columns and data, and what the coefficients are expected to be.

    Parameters
    ----------
    information : array (…, q, q)
        G, of the columns; several systems side by side have leading dimensions.
    score : array (…, q)
        b, of the columns with the data.
    centre : array (q,)
        c, the expected coefficients.
    square : float or array (…)
        Of the data.
    volume : float or array (…)
        ln det of the covariance that the data had before they were whitened.

    Notes
    -----
    With ``L L' = 1 + G`` the coefficients that the data leave are normal with covariance
    ``(1 + G)⁻¹`` about ``c + (1 + G)⁻¹ (b - G c)``, and the data are more probable than without
    columns by

    .. math:: \ln E = b'c - \tfrac12 c'Gc + \tfrac12 |L^{-1}(b - Gc)|^2 - \sum_i \ln L_{ii}

    (MacKay 1992, for this model). Data that are independent add up: so do their
    products, and data that are left out are taken off.

    Examples
    --------
    One column of ones, four readings about 2 that scatter by 1, a coefficient of 0 ± 1 before:

    >>> ones, y = np.ones((4, 1)), np.array([1.0, 3.0, 2.0, 2.0])
    >>> known = Normal.of(ones, y)
    >>> mean, covariance = known.posterior
    >>> mean, covariance
    (array([1.6]), array([[0.2]]))
    >>> round(known.log_evidence, 4)  # 8²/(2·5) - ½ ln 5
    5.5953
    """

    information: Array
    score: Array
    centre: Array
    square: float | Array = 0.0
    volume: float | Array = 0.0

    @classmethod
    def of(cls, columns: Array, data: Array, centre: Array | None = None) -> Normal:
        """From columns (n, q) and data (n,) of unit covariance.

        Parameters
        ----------
        columns : array (n, q)
            Over the root of the covariance of the data, in units of the prior.
        data : array (n,)
            Over the same root.
        centre : array (q,), optional
            Expected coefficients; zero by default.
        """
        return cls(
            information=columns.T @ columns,
            score=columns.T @ data,
            centre=np.zeros(columns.shape[1]) if centre is None else centre,
            square=float(data @ data),
        )

    @classmethod
    def of_products(cls, products: Array, volume: float | Array = 0.0) -> Normal:
        """From products (…, q + 1, q + 1) of columns and, last, the data; centre zero."""
        return cls(
            information=products[..., :-1, :-1],
            score=products[..., :-1, -1],
            centre=np.zeros(products.shape[-1] - 1),
            square=products[..., -1, -1],
            volume=volume,
        )

    def __add__(self, other: Normal) -> Normal:
        return replace(
            self,
            information=self.information + other.information,
            score=self.score + other.score,
            square=self.square + other.square,
            volume=self.volume + other.volume,
        )

    def __sub__(self, other: Normal) -> Normal:
        """Without data that are part of it."""
        return replace(
            self,
            information=self.information - other.information,
            score=self.score - other.score,
            square=self.square - other.square,
            volume=self.volume - other.volume,
        )

    def only(self, at: Places, size: Array | None = None) -> Normal:
        """Some columns alone, of other prior sizes (q,) where asked for."""
        information, score = self.information[..., at[:, None], at], self.score[..., at]
        centre = self.centre[at]
        if size is not None:
            information, score = information * np.outer(size, size), score * size
            centre = centre / size
        return replace(self, information=information, score=score, centre=centre)

    def in_terms_of(self, root: Array) -> Normal:
        """For coefficients ``root x`` with x ~ N(0, 1): of a prior covariance ``root root'``.

        Parameters
        ----------
        root : array (q, p)
            Of the covariance; p < q where some do not move.
        """
        return replace(
            self,
            information=root.T @ self.information @ root,
            score=self.score @ root,
            centre=np.zeros(root.shape[1]),
        )

    @property
    def root(self) -> Array:
        """Lower root L of the precision ``1 + G`` (…, q, q)."""
        return np.asarray(np.linalg.cholesky(self.information + np.eye(len(self.centre))), float)

    @property
    def log_evidence(self) -> float:
        """ln of how much more probable the data are with the columns than without."""
        return float(self.log_evidences)

    @property
    def log_evidences(self) -> Array:
        """`log_evidence` of several systems side by side (…)."""
        c = self.centre
        expected = self.information @ c
        lower = self.root
        if lower.ndim == 2:  # one factor for all scores
            half = np.linalg.solve(lower, (self.score - expected).T).T
        else:
            half = np.linalg.solve(lower, (self.score - expected)[..., None])[..., 0]
        logs = np.log(np.diagonal(lower, axis1=-2, axis2=-1)).sum(axis=-1)
        gained = self.score @ c - 0.5 * expected @ c
        return np.asarray(gained + 0.5 * np.sum(half**2, axis=-1) - logs, float)

    @property
    def log_density(self) -> float:
        """ln of how probable the data are, but for ``-½ n ln 2π``."""
        return self.log_evidence - 0.5 * float(self.square) - 0.5 * float(self.volume)

    def log_density_at(self, z: Array) -> float:
        """ln of how probable the data are with some coefficients (q,), but for ``-½ n ln 2π``."""
        square = self.square - 2.0 * (self.score @ z) + self.information @ z @ z
        return -0.5 * float(square) - 0.5 * float(self.volume)

    @property
    def mean(self) -> Array:
        """Of the coefficients as the data leave them, array (q,)."""
        away = self.score - self.information @ self.centre
        moved = np.linalg.solve(self.information + np.eye(len(self.centre)), away)
        return np.asarray(self.centre + moved, float)

    @cached_property
    def posterior(self) -> tuple[Array, Array]:
        """Mean (…, q) and covariance (…, q, q) of the coefficients as the data leave them."""
        covariance = np.linalg.inv(self.information + np.eye(len(self.centre)))
        away = self.score - self.information @ self.centre
        mean = self.centre + (covariance @ away[..., None])[..., 0]
        return mean, np.asarray(covariance, float)

    def added(
        self, inner: Array, score: Array, cross: Array, sizes: Sequence[float]
    ) -> tuple[float, Array]:
        """ln evidence that further columns add, averaged over prior sizes, and their coefficients.

        The coefficients are those at the most probable size.

        Parameters
        ----------
        inner : array (p, p)
            Products of the further columns at size one.
        score : array (p,)
            Of these with the data.
        cross : array (q, p)
            Of those that are here with these.
        sizes : sequence of float
            Prior standard deviations that are tried.

        Examples
        --------
        >>> none = Normal.of(np.ones((4, 0)), np.array([1.0, 3.0, 2.0, 2.0]))
        >>> gain, value = none.added(np.array([[4.0]]), np.array([8.0]), np.ones((0, 1)), [1.0])
        >>> round(gain, 4), value
        (5.5953, array([1.6]))
        """
        mean, covariance = self.posterior
        squares, turn = np.linalg.eigh(inner - cross.T @ covariance @ cross)
        along = (score - cross.T @ mean) @ turn
        square = np.square(sizes)[:, None]
        grown = 1.0 + square * squares
        tried = 0.5 * np.sum(square * along**2 / grown - np.log(grown), axis=1)
        best = int(np.argmax(tried))
        total = float(np.logaddexp.reduce(tried))
        return total - math.log(len(sizes)), turn @ (square * along / grown)[best]

    def chance_of(
        self, best: float, groups: Sequence[Sequence[Places]], *, draws: int, seed: int = 0
    ) -> float:
        """Probability that noise alone gives a group of columns so much evidence.

        Scores of the null are drawn from their own covariance, the information; the largest
        evidence over all groups is kept of each draw (Westfall and Young 1993), so that what
        resembles each other counts once.

        Parameters
        ----------
        best : float
            ln evidence of what is in front.
        groups : sequence of sequence of array of int
            Alternatives of each group, over which its evidence is averaged.
        draws, seed : int
            Number of drawn data, and of the draws.

        Examples
        --------
        One column that tells little: its evidence reaches its largest value in a tail of χ².

        >>> one = Normal(information=np.eye(1), score=np.zeros(1), centre=np.zeros(1))
        >>> best = 0.25 * 1.96**2 - 0.5 * np.log(2.0)
        >>> round(one.chance_of(best, [[np.array([0])]], draws=20_000), 2)
        0.05
        """
        sizes, vectors = np.linalg.eigh(self.information)
        root = vectors * np.sqrt(np.maximum(sizes, 0.0))
        drawn = replace(
            self, score=np.random.default_rng(seed).normal(size=(draws, len(sizes))) @ root.T
        )
        largest = np.full(draws, -np.inf)
        for alternatives in groups:
            values = np.stack([drawn.only(at).log_evidences for at in alternatives])
            top = values.max(axis=0)
            largest = np.maximum(largest, top + np.log(np.mean(np.exp(values - top), axis=0)))
        return float((1 + np.sum(largest >= best)) / (draws + 1))

    def taken(self, at: Places) -> Taken:
        """What some columns explain of all and of the data."""
        own = self.only(at)
        root, away = own.root, own.score - own.information @ own.centre
        return Taken(
            at=at,
            root=root,
            centre=own.centre,
            across=np.asarray(np.linalg.solve(root, self.information[at]), float),
            explained=np.asarray(np.linalg.solve(root, away), float),
        )

    def given(self, taken: Taken) -> Normal:
        """All columns beside some that are there, of unknown size within their prior.

        The covariance of the data grows by the columns' own; what they explain, with their prior,
        goes from all products (a Schur complement). Evidence is then evidence beside them.
        """
        at, c, across, explained = taken.at, taken.centre, taken.across, taken.explained
        return replace(
            self,
            information=self.information - across.T @ across,
            score=self.score - self.information[:, at] @ c - across.T @ explained,
            square=self.square
            - 2.0 * float(c @ self.score[at])
            + float(c @ self.information[np.ix_(at, at)] @ c)
            - float(explained @ explained),
            volume=self.volume + 2.0 * float(np.log(np.diagonal(taken.root)).sum()),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Taken:
    """What some columns of a `Normal` explain of all of them.

    Parameters
    ----------
    at : array of int (o,)
        Their places.
    root : array (o, o)
        Lower root of their precision.
    centre : array (o,)
        Their expected coefficients.
    across : array (o, q)
        Their products with all columns, over that root.
    explained : array (o,)
        Their products with the data less what is expected, over that root.
    """

    at: Places
    root: Array
    centre: Array
    across: Array
    explained: Array


def log_normal(away: Array, covariance: Array) -> float:
    """ln of the density of a normal distribution.

    Parameters
    ----------
    away : array (n,)
        From the mean.
    covariance : array (n, n)
        Correlations are factorised: the values may differ by orders of magnitude.

    Examples
    --------
    >>> round(log_normal(np.array([1.0]), np.eye(1)), 6)  # -½ - ½ ln 2π
    -1.418939
    """
    size = np.sqrt(np.diagonal(covariance))
    lower = np.linalg.cholesky(covariance / np.outer(size, size))
    white = np.linalg.solve(lower, away / size)
    volume = float(np.sum(np.log(np.diagonal(lower))) + np.sum(np.log(size)))
    return -0.5 * float(white @ white) - volume - 0.5 * len(away) * math.log(2.0 * math.pi)
