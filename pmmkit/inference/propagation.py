"""Propagation of uncertainty to first order, V(y) = J C Jᵀ, told source by source."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from pmmkit.numerics import Array

COVERAGE: Final = 2.0
"""Coverage factor k of an expanded uncertainty U = k u, some 95 % (JCGM 100:2008, 6.3.3). ASME V&V
20 and ITTC 7.5-03-01-01 take 2; the 1.96 of `coverage_factor` is of intervals of a normal law."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Propagated:
    """What each source of uncertainty does to results y that are linear in its errors.

    Parameters
    ----------
    factors : tuple of array (q, n)
        Of each source s the change of the n results by each of its q independent errors of one
        standard deviation, F_s.
    causes : tuple of str
        Of each source the cause of its errors; sources of one cause share their errors, row by row.
        Empty where a source has its own.

    Notes
    -----
    With T_c the sum of the factors of a cause, C_y = Σ_c T_cᵀ T_c (JCGM 100:2008, 5.1.2 and 5.2.2;
    F.1.2.3 for common causes; of several results JCGM 102:2011, 6.2). A source takes of the
    variance of a result what it has in common with it, Cov(F_sᵀ z, y) = Σ_q F_s T_c: its own square
    and half of twice its product with each other of its cause. The shares sum to 1 whatever is
    correlated; they are the Shapley values of the game whose worth is the variance of what some of
    the sources do (Owen and Prieur 2017). A share is negative where an error takes away from those
    of the others.

    Examples
    --------
    The power of a resistor, P = V²/R, from V = 10.0(1) and R = 5.00(2):

    >>> V, R = 10.0, 5.0
    >>> J, C = np.array([[2 * V / R, -(V**2) / R**2]]), np.diag([0.1, 0.02]) ** 2
    >>> found = Propagated.of(J, C)
    >>> found.std.round(5), found.shares.T.round(4)
    (array([0.40792]), array([[0.9615, 0.0385]]))
    >>> found.expanded().round(4)
    array([0.8158])
    """

    factors: tuple[Array, ...]
    causes: tuple[str, ...]

    @classmethod
    def of(cls, jacobian: Array, covariance: Array) -> Propagated:
        """Of results with slopes (n, m) over m inputs, each a source, of a covariance (m, m)."""
        errors = root(covariance)
        factors = tuple(np.outer(own, slope) for own, slope in zip(errors, jacobian.T, strict=True))
        return cls(factors=factors, causes=("inputs",) * len(factors))

    @property
    def together(self) -> tuple[Array, ...]:
        """For each source the sum T of the factors of its cause, array (q, n)."""
        sums: dict[str, Array] = {}
        for own, cause in zip(self.factors, self.causes, strict=True):
            if cause:
                sums[cause] = sums[cause] + own if cause in sums else own
        return tuple(
            sums[cause] if cause else own
            for own, cause in zip(self.factors, self.causes, strict=True)
        )

    @property
    def errors(self) -> Array:
        """Change of the results by each error of all causes, T (Q, n); C_y = Tᵀ T."""
        first: dict[str, Array] = {}
        for place, (own, cause) in enumerate(zip(self.together, self.causes, strict=True)):
            first.setdefault(cause or f"#{place}", own)
        return np.concatenate([*first.values()]) if first else np.zeros((0, 0))

    @property
    def covariance(self) -> Array:
        """Of the results, array (n, n)."""
        found: Array = self.errors.T @ self.errors
        return found

    @property
    def std(self) -> Array:
        """Combined standard uncertainty of each result, array (n,)."""
        found: Array = np.sqrt(np.sum(self.errors**2, axis=0))
        return found

    @property
    def alone(self) -> Array:
        """Standard uncertainty of each result by each source alone, array (sources, n)."""
        return self._by_source([np.sqrt(np.sum(own**2, axis=0)) for own in self.factors])

    @property
    def variances(self) -> Array:
        """What each source adds to the variance of each result, array (sources, n)."""
        pairs = zip(self.factors, self.together, strict=True)
        return self._by_source([np.sum(own * whole, axis=0) for own, whole in pairs])

    @property
    def shares(self) -> Array:
        """The same over the variance of each result: columns sum to 1 (0 where there is none)."""
        variances = self.variances
        total = variances.sum(axis=0)
        found: Array = variances / np.where(total > 0.0, total, 1.0)
        return found

    @property
    def correlation(self) -> Array:
        """Of the results, array (n, n); 0 with one that is certain."""
        std = self.std
        unit = np.where(std > 0.0, std, 1.0)
        found: Array = self.covariance / np.outer(unit, unit)
        return found

    def expanded(self, k: float = COVERAGE) -> Array:
        """Expanded uncertainty U = k u of each result, array (n,)."""
        found: Array = k * self.std
        return found

    def carried(self, jacobian: Array) -> Propagated:
        """Of results that have slopes (p, n) over these (the chain rule)."""
        return replace(self, factors=tuple(own @ jacobian.T for own in self.factors))

    def _by_source(self, rows: Sequence[Array]) -> Array:
        return np.stack(rows) if rows else np.zeros((0, 0))


def root(covariance: Array, *, thin: bool = False) -> Array:
    """The root S of a covariance, S Sᵀ = C, by which errors are drawn and carried.

    Parameters
    ----------
    covariance : array (m, m)
        Of numbers that may differ by orders of magnitude; singular where errors are tied.
    thin : bool
        Whether as few errors are wanted as make the covariance.

    Returns
    -------
    array (m, m), or (m, r) of a thin one
        D √R with the standard deviations D and the principal root √R of the correlation. Unlike
        eigenvectors, which have any sign, and Cholesky factors, which ask for full rank, there is
        one whatever the processor: the same draws are the same everywhere. Of independent numbers
        it is diagonal. What rounding leaves below no variance counts as none. A thin root has the
        principal axes of the correlation, scaled; their number is the rank: those of which the
        variance is rounding are left out.

    Examples
    --------
    >>> S = root(np.array([[4.0, 2e-6], [2e-6, 1e-12]]))
    >>> (S @ S.T).round(12).tolist() == [[4.0, 2e-6], [2e-6, 1e-12]]
    True
    >>> root(np.diag([4.0, 0.0, 1e-12]))
    array([[2.e+00, 0.e+00, 0.e+00],
           [0.e+00, 0.e+00, 0.e+00],
           [0.e+00, 0.e+00, 1.e-06]])
    >>> [root(np.array(C), thin=True).shape[1] for C in ([[4.0, 2e-6], [2e-6, 1e-12]], np.eye(2))]
    [1, 2]
    """
    scale = np.sqrt(np.diagonal(covariance))
    unit = np.where(scale > 0.0, scale, 1.0)
    sizes, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    sizes = np.maximum(sizes, 0.0)
    if thin:
        there = sizes > len(sizes) * np.finfo(float).eps * sizes.max(initial=0.0)
        return np.asarray(scale[:, None] * (vectors[:, there] * np.sqrt(sizes[there])))
    return np.asarray(scale[:, None] * ((vectors * np.sqrt(sizes)) @ vectors.T))


def std_along(jacobian: Array, covariance: Array) -> Array:
    """Standard uncertainties √(J C Jᵀ)ᵢᵢ of results, where no source is asked for.

    Parameters
    ----------
    jacobian : array (n, m)
        Slopes of each result over each input.
    covariance : array (m, m)
        Of the inputs.

    Returns
    -------
    array (n,)

    Examples
    --------
    >>> std_along(np.array([[1.0, 1.0], [1.0, -1.0]]), np.array([[1.0, 0.6], [0.6, 1.0]])) ** 2
    array([3.2, 0.8])
    """
    variance = np.einsum("ij,jk,ik->i", jacobian, covariance, jacobian)
    found: Array = np.sqrt(np.maximum(variance, 0.0))
    return found


@dataclass(frozen=True, eq=False)
class Stencil:
    """Central differences of a function along some steps.

    Parameters
    ----------
    order : {2, 4}
        Of the error, in the size of a step: exact for parabolas and cubics; for quintics too.

    Examples
    --------
    >>> at, steps = np.array([1.0, 2.0]), np.array([[0.1, 0.0], [0.0, 0.1]])
    >>> fine = Stencil(4)
    >>> x, y = fine.points(at, steps).T
    >>> (fine.differences(x**3 * y**2) / 0.1).round(12)
    array([12.,  4.])
    """

    order: Literal[2, 4] = 2

    @property
    def _parts(self) -> tuple[Array, Array]:
        """Places in steps, and weights."""
        if self.order == 2:
            return np.array([-1.0, 1.0]), np.array([-1.0, 1.0]) / 2.0
        return np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / 12.0

    def points(self, at: Array, steps: Array) -> Array:
        """Where the function is asked for, array (k order, m).

        Parameters
        ----------
        at : array (m,)
            The inputs.
        steps : array (k, m)
            Steps; a standard deviation each for what an error does (JCGM 100:2008, 5.1.3, note 2),
            small for a slope.
        """
        places, _ = self._parts
        apart = np.einsum("p,km->kpm", places, steps)
        found: Array = at + apart.reshape(self.order * len(steps), len(at))
        return found

    def differences(self, results: Array) -> Array:
        """The change of results by each step, array (k, ...).

        Parameters
        ----------
        results : array (k order, ...)
            Values of the function at the points.
        """
        _, weights = self._parts
        apart = results.reshape(len(results) // self.order, self.order, *results.shape[1:])
        found: Array = np.tensordot(apart, weights, axes=(1, 0))
        return found
