"""The square-root information filter: a normal vector as a triangle that takes in whitened rows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class InformationRoot:
    """A normal vector θ by the root R of its information (Bierman 1977): R θ = d + e, e ~ N(0, 1).

    Parameters
    ----------
    root : array (p, p + 1)
        R and, last, d.

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
        """What is known with whitened equations ``rows = design θ + e`` too, (k, p) and (k,)."""
        whole = np.vstack([self.root, np.column_stack([design, rows])])
        return InformationRoot(root=triangle(whole)[: len(self.root)])

    @cached_property
    def _inverse(self) -> Array:
        """R⁻¹ (p, p)."""
        return np.asarray(np.linalg.inv(self.root[:, :-1]))

    @property
    def mean(self) -> Array:
        """Array (p,)."""
        return np.asarray(self._inverse @ self.root[:, -1])

    @property
    def covariance(self) -> Array:
        """Array (p, p)."""
        inverse = self._inverse
        return np.asarray(inverse @ inverse.T)

    def spread(self, design: Array) -> Array:
        """Variances of ``design θ``, array (k,)."""
        return np.asarray(np.sum((design @ self._inverse) ** 2, axis=1))

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
