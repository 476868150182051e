"""Restricted likelihood of the sizes of random effects that act within runs.

The rows of run i are y_i = X_i θ + Σ_j s_j D_ij z_ij + e_i with z_ij ~ N(0, 1) and e_i ~ N(0, V_i).
Whitened by V_i, the covariance of a run is C_i = 1 + Σ_j s_j² G_ij with G_ij = D_ij D_ij'.
Some columns of X may have a unit normal prior: they are random effects that all runs share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.inference.linear_fit import RANK_TOLERANCE
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class EqualRows:
    """Runs of as many rows each, whitened by their noise.

    `columns (r, m, q)`: all columns: model, columns with a prior, data. `kinds (k, r, m, m)`:
    ``D D'`` of each kind of effect at size one.
    """

    columns: Array
    kinds: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class LikelihoodSlope:
    """The restricted log likelihood at logarithms of sizes.

    `value`: minus infinity where the covariance is not positive. `gradient (k,)`: with respect
    to the logarithms. `information (k, k)`: average of observed and expected information.
    """

    value: float
    gradient: Array
    information: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Restricted:
    """Restricted likelihood of the sizes of k kinds of effects in one set of rows.

    Parameters
    ----------
    groups : tuple of EqualRows
        Runs by their number of rows.
    model, shared : int
        How many columns the model has, and how many have a unit prior.
    back : array (p, model)
        From the orthonormal basis of the model to its p coefficients.
    """

    groups: tuple[EqualRows, ...]
    model: int
    shared: int
    back: Array

    @classmethod
    def of(cls, groups: Sequence[tuple[Array, Array]], model: int, shared: int = 0) -> Restricted:
        """From whitened columns (r, m, q) and kinds (k, r, m, m) of runs of equal length.

        Parameters
        ----------
        groups : sequence of (array, array)
            The last column is the data; the first `model` are the model, then `shared` others.
        model, shared : int
            How many columns.
        """
        if not model:
            plain = tuple(EqualRows(columns=x, kinds=G) for x, G in groups)
            return cls(groups=plain, model=0, shared=shared, back=np.zeros((0, 0)))
        rows = np.concatenate([x[..., :model].reshape(-1, model) for x, _ in groups])
        length = np.linalg.norm(rows, axis=0)
        unit = np.where(length > 0, length, 1.0)
        _, s, Vt = np.linalg.svd(np.linalg.qr(rows / unit, mode="r"), full_matrices=False)
        keep = s > RANK_TOLERANCE * (s[0] if len(s) else 1.0)
        turn = (Vt[keep].T / s[keep]) / unit[:, None]
        made = [
            EqualRows(
                columns=np.concatenate([x[..., :model] @ turn, x[..., model:]], axis=2), kinds=G
            )
            for x, G in groups
        ]
        return cls(groups=tuple(made), model=int(keep.sum()), shared=shared, back=turn)

    def given(self, kind: int, size: float) -> Restricted:
        """With one kind of known size, which is noise then."""
        groups = []
        for group in self.groups:
            m = group.columns.shape[1]
            root = np.linalg.cholesky(np.eye(m) + size**2 * group.kinds[kind])
            white = np.linalg.inv(root)
            kinds = white @ group.kinds @ np.swapaxes(white, 1, 2)
            kinds[kind] = 0.0
            groups.append(EqualRows(columns=white @ group.columns, kinds=kinds))
        return replace(self, groups=tuple(groups))

    def informed(self) -> Array:
        """Which kinds act in any row, array of bool (k,)."""
        acts: Array = np.any([np.any(g.kinds != 0.0, axis=(1, 2, 3)) for g in self.groups], axis=0)
        return acts

    def log_likelihood(self, logs: Array) -> float:
        """At logarithms of sizes (k,), without its slope."""
        return self._solved(logs).value

    def slope(self, logs: Array) -> LikelihoodSlope:
        """Value, gradient and average information at logarithms of sizes (k,).

        Notes
        -----
        With P = C⁻¹ - C⁻¹X (X'C⁻¹X)⁻¹ X'C⁻¹ and z = P y the derivative by s_j² is
        (z' G_j z - tr P G_j) / 2, the average information z' G_j P G_k z / 2 (Gilmour, Thompson
        and Cullis 1995, Biometrics 51). By the logarithm of a size the curvature has twice the
        gradient besides, which alone is left where a size is near zero; it is taken where it makes
        the curvature larger.
        """
        at = self._solved(logs)
        k = len(logs)
        if not np.isfinite(at.value):
            return LikelihoodSlope(
                value=at.value, gradient=np.zeros(k), information=np.zeros((k, k))
            )
        gradient, plain = np.zeros(k), np.zeros((k, k))
        across = np.zeros((k, at.inverse.shape[0]))
        for group, (inverse, white) in zip(self.groups, at.parts, strict=True):
            fitted = white[..., :-1]
            z = np.einsum("rnm,rn->rm", inverse, white[..., -1] - fitted @ at.solution)
            B = np.swapaxes(inverse, 1, 2) @ fitted  # C⁻¹ X
            half = B @ at.inverse
            P = np.swapaxes(inverse, 1, 2) @ inverse - half @ np.swapaxes(half, 1, 2)
            pulled = np.einsum("krmn,rn->krm", group.kinds, z)
            gradient += np.einsum("krm,rm->k", pulled, z) - np.einsum("krmn,rmn->k", group.kinds, P)
            own = np.einsum("rnm,krm->krn", inverse, pulled)
            plain += np.einsum("jrn,krn->jk", own, own)
            across += np.einsum("krm,rmp->kp", pulled, half)
        square = np.exp(2.0 * logs)
        gradient = square * gradient
        information = 2.0 * square[:, None] * square * (plain - across @ across.T)
        information += np.diag(np.maximum(-2.0 * gradient, 0.0))
        return LikelihoodSlope(value=at.value, gradient=gradient, information=information)

    def estimates(self, sizes: Array) -> tuple[Array, Array]:
        """Coefficients and their variances by generalised least squares, arrays (g, p) each.

        Parameters
        ----------
        sizes : array (g, k)
            Of the effects, not their logarithms.
        """
        values, variances = [], []
        with np.errstate(divide="ignore"):
            for own in np.log(sizes):
                at = self._solved(own)
                turn = self.back @ at.inverse[: self.model]
                values.append(self.back @ at.solution[: self.model])
                variances.append(np.sum(turn**2, axis=1))
        return np.array(values), np.array(variances)

    def misfits(self, sizes: Array) -> Array:
        """What generalised least squares leave, over the covariance: χ² at sizes (g, k), (g,)."""
        with np.errstate(divide="ignore"):
            return np.array([self._solved(own).misfit for own in np.log(sizes)])

    def _solved(self, logs: Array) -> _Solved:
        """Generalised least squares at sizes."""
        q = self.model + self.shared
        square = np.exp(2.0 * logs)
        gram, determinant = np.zeros((q + 1, q + 1)), 0.0
        parts = []
        for group in self.groups:
            covariance = np.tensordot(square, group.kinds, axes=1) + np.eye(group.kinds.shape[-1])
            try:
                root = np.linalg.cholesky(covariance)
            except np.linalg.LinAlgError:
                return _NOWHERE
            inverse = np.linalg.inv(root)
            white = inverse @ group.columns
            determinant += float(np.log(np.diagonal(root, axis1=1, axis2=2)).sum())
            flat = white.reshape(-1, q + 1)
            gram += flat.T @ flat
            parts.append((inverse, white))
        normal = gram[:q, :q].copy()
        prior = np.arange(self.model, q)
        normal[prior, prior] += 1.0
        try:
            root = np.linalg.cholesky(normal)
        except np.linalg.LinAlgError:
            return _NOWHERE
        back = np.linalg.inv(root)
        pulled = back @ gram[:q, q]
        determinant += float(np.log(np.diagonal(root)).sum())
        misfit = max(float(gram[q, q] - pulled @ pulled), 0.0)
        return _Solved(
            value=-determinant - 0.5 * misfit,
            misfit=misfit,
            solution=back.T @ pulled,
            inverse=back.T,
            parts=tuple(parts),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Solved:
    """Generalised least squares at one set of sizes: R R' of `inverse` is (X'C⁻¹X)⁻¹."""

    value: float
    misfit: float
    solution: Array
    inverse: Array
    parts: tuple[tuple[Array, Array], ...]


_NOWHERE: Final = _Solved(
    value=-np.inf, misfit=np.inf, solution=np.zeros(0), inverse=np.zeros((0, 0)), parts=()
)
