"""Harmonics of periodic records with their covariance."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmmkit.base import DataError
from pmmkit.numerics import Array, projector, resolution
from pmmkit.signals.noise import as_record
from pmmkit.signals.periodic import (
    TURN,
    between_harmonics,
    fit_noise,
    phase_cells,
    weighted_covariance,
)

Ints = NDArray[np.intp]


ROUNDED: Final = 2.0
"""Rms of what harmonics leave, over that of rounding, up to which rounding explains it. Flanders
Hydraulics' cycles of KCS (24 points, written to 1e-4) lie at 0.9 to 1.1."""
STANDS: Final = 5.0
"""Amplitude of a harmonic, over the standard deviation that rounding gives it, from which it was
fitted."""


@dataclass(frozen=True)
class Harmonics:
    """Harmonics of the channels of one record, f = C0 + sum Cn cos nθ + Sn sin nθ.

    Attributes
    ----------
    order : int
        Highest harmonic.
    coefficients : (c, 2 order + 1) array
        C0, C1, S1, C2, S2, …; Cn is in phase with the velocity, Sn with the displacement.
    covariance : (c, 2 order + 1, 2 order + 1) array
        Covariance of each channel's coefficients; honours autocorrelation of the noise.
    scatter : (c, 2 order + 1) array or None
        Standard deviation over the cycles of the coefficients of single cycles; None for one
        cycle.
    dof : (c,) array
        Degrees of freedom of the variances of the harmonics from the first on, for Student's t.
    residual : (c,) array
        Root mean square of what the harmonics leave.
    count : int
        Whole cycles used.
    coefficient_dof : (c, 2 order + 1) array
        Degrees of freedom of each variance. That of C0 is lower where the noise is slow, since
        its spectrum at frequency zero is known from one side only.
    """

    order: int
    coefficients: Array
    covariance: Array
    scatter: Array | None
    dof: Array
    residual: Array
    count: int
    coefficient_dof: Array

    @property
    def std(self) -> Array:
        """Standard uncertainty of each coefficient, (c, 2 order + 1)."""
        return np.asarray(np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1)))

    def fitted_order(self, values: ArrayLike) -> int | None:
        """The highest harmonic to which a record was fitted before it was written.

        Parameters
        ----------
        values : array (c, n)
            Channels of whole cycles, of which these are the harmonics.

        Returns
        -------
        int or None
            None for a record in which something is left between the harmonics, or too few samples
            to tell: it has noise of its own.

        Examples
        --------
        >>> from pmmkit.signals.fourier import harmonics
        >>> theta = 2 * np.pi * np.arange(24) / 24
        >>> cycle = np.round([3 * np.cos(theta) + np.sin(2 * theta)], 4)
        >>> harmonics(theta, cycle).fitted_order(cycle)
        2
        >>> noisy = cycle + 0.01 * np.cos(8 * theta)
        >>> harmonics(theta, noisy).fitted_order(noisy) is None
        True
        """
        x = np.asarray(values, float)
        n = x.shape[1]
        if n <= 2 * (2 * self.order + 1):
            return None
        rounding = resolution(x) / np.sqrt(12.0)
        if np.any(self.residual > ROUNDED * rounding):
            return None
        pairs = self.coefficients[:, 1:].reshape(len(x), self.order, 2)
        amplitude = np.linalg.norm(pairs, axis=2)
        there = np.any(amplitude > STANDS * (rounding * np.sqrt(2.0 / n))[:, None], axis=0)
        return int(np.max(np.flatnonzero(there), initial=-1)) + 1


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierBasis:
    """1, cos θ, sin θ, cos 2θ, sin 2θ, … at the samples of a record, for all that is fitted there.

    Attributes
    ----------
    phase : (n,) array
        θ [rad].
    rows : (2 order + 1, n) array
        The functions.
    """

    phase: Array
    rows: Array

    @classmethod
    def at(cls, phase: Array, order: int) -> FourierBasis:
        """Up to some harmonic.

        Examples
        --------
        >>> FourierBasis.at(np.zeros(1), 2).rows.T
        array([[1., 1., 0., 1., 0.]])
        """
        return cls(phase=phase, rows=_rows(phase, order))

    @property
    def order(self) -> int:
        """Highest harmonic."""
        return len(self.rows) // 2

    @property
    def cycles(self) -> int:
        """Whole cycles covered."""
        return cycle_count(self.phase)

    def within(self, part: slice | NDArray[np.bool_]) -> FourierBasis:
        """At some of the samples."""
        return FourierBasis(phase=self.phase[part], rows=self.rows[:, part])

    def up_to(self, order: int) -> FourierBasis:
        """Without the harmonics above `order`."""
        if order == self.order:
            return self
        return FourierBasis(phase=self.phase, rows=self.rows[: 2 * order + 1])

    def ahead(self, lead: float) -> FourierBasis:
        """At phases that all lie further on by a lead [rad].

        Examples
        --------
        >>> FourierBasis.at(np.zeros(1), 2).ahead(np.pi / 2).rows.T.round(12) + 0.0
        array([[ 1.,  0.,  1., -1.,  0.]])
        """
        rows = np.empty_like(self.rows)
        rows[0] = 1.0
        if self.order:
            cosine, sine = math.cos(lead), math.sin(lead)
            rows[1] = cosine * self.rows[1] - sine * self.rows[2]
            rows[2] = sine * self.rows[1] + cosine * self.rows[2]
        return FourierBasis(phase=self.phase + lead, rows=_with_multiples(rows))

    @cached_property
    def gram(self) -> Array:
        """Products of the functions, (2 order + 1, 2 order + 1)."""
        return self.rows @ self.rows.T

    @cached_property
    def projector(self) -> Array:
        """The least-squares map (2 order + 1, n) from samples to coefficients."""
        return projector(self.rows.T, self.gram)


def design_matrix(theta: ArrayLike, order: int) -> Array:
    """Columns 1, cos θ, sin θ, cos 2θ, sin 2θ, … at each phase.

    Parameters
    ----------
    theta : (n,) array
        Phase [rad].
    order : int
        Highest harmonic.

    Returns
    -------
    (n, 2 order + 1) array

    Examples
    --------
    >>> design_matrix([0.0], 2)
    array([[1., 1., 0., 1., 0.]])
    """
    return _rows(np.asarray(theta, dtype=float), order).T


def _rows(phase: Array, order: int) -> Array:
    rows = np.empty((2 * order + 1, phase.size))
    rows[0] = 1.0
    if order:
        np.cos(phase, out=rows[1])
        np.sin(phase, out=rows[2])
    return _with_multiples(rows)


def _with_multiples(rows: Array) -> Array:
    """The rows, of which the first three hold 1, cos θ, sin θ, filled by their addition."""
    cosine, sine = rows[1:2].ravel(), rows[2:3].ravel()
    beside = np.empty(rows.shape[1])
    for n in range(2, len(rows) // 2 + 1):
        (c, s), (before, aside) = rows[2 * n - 1 : 2 * n + 1], rows[2 * n - 3 : 2 * n - 1]
        np.multiply(before, cosine, out=c)
        c -= np.multiply(aside, sine, out=beside)
        np.multiply(before, sine, out=s)
        s += np.multiply(aside, cosine, out=beside)
    return rows


def cycle_count(phase: Array) -> int:
    """Whole cycles covered; the last sample stands for one step, of half a step's tolerance."""
    covered = float(phase[-1] - phase[0])
    beyond = max(covered / (phase.size - 1), phase[1] - phase[0], phase[-1] - phase[-2])
    return int((covered + 1.5 * beyond) / TURN)


def cycle_edges(phase: Array, count: int) -> Ints:
    """First sample of each of `count` cycles counted from the first sample, and the end."""
    step = (phase[-1] - phase[0]) / (phase.size - 1)
    edges: Ints = np.searchsorted(phase, phase[0] + TURN * np.arange(count + 1) - 0.25 * step)
    return edges


def basis_of(phase: Array, theta: ArrayLike | FourierBasis, order: int) -> FourierBasis:
    """The Fourier basis of some order, from one that is given or at the phases."""
    if isinstance(theta, FourierBasis):
        return theta.up_to(order)
    return FourierBasis.at(phase, order)


def harmonics(
    theta: ArrayLike | FourierBasis, y: ArrayLike, *, order: int = 5, sums: CycleSums | None = None
) -> Harmonics:
    """Harmonics by least squares on the actual phase, with their covariance.

    Parameters
    ----------
    theta : (n,) array or FourierBasis
        Phase of the motion, increasing by 2π a cycle; steps may differ [rad]. A basis that is
        there already, of this order or above, saves its computation.
    y : (c, n) array
        Channels, over at least one whole cycle.
    order : int
        Highest harmonic.
    sums : CycleSums, optional
        Over its cycles, of this order or above, where they are there already.

    Returns
    -------
    Harmonics

    Raises
    ------
    DataError
        If there is less than one cycle, if samples are too few for the order, if values are not
        finite or the phase does not increase.

    Notes
    -----
    The covariance is that of the least-squares weights applied to noise whose autocovariances
    come from the frequencies between the harmonics (from those above the highest harmonic where
    there is only one cycle), see `pmmkit.signals.periodic.fit_noise`.

    Examples
    --------
    >>> import numpy as np
    >>> theta = np.linspace(0.0, 6 * np.pi, 300, endpoint=False)
    >>> found = harmonics(theta, [2.0 + 3.0 * np.cos(theta) - np.sin(2 * theta)], order=2)
    >>> np.round(found.coefficients, 12) + 0.0
    array([[ 2.,  3.,  0.,  0., -1.]])
    >>> bool(np.all(found.std < 1e-12))
    True
    """
    given = theta.phase if isinstance(theta, FourierBasis) else theta
    phase, values = as_record(given, y, name="theta", least=2 * order + 2)
    count = cycle_count(phase)
    if count < 1:
        raise DataError(
            f"The record covers {(phase[-1] - phase[0]) / TURN:.2f} cycles: "
            "harmonics need at least one whole cycle."
        )
    basis = basis_of(phase, theta, order)
    rows, inverse = basis.rows, _inverse(basis.gram)
    coefficients = values @ rows.T @ inverse
    coefficients = coefficients + (values - coefficients @ rows) @ rows.T @ inverse
    rest = values - coefficients @ rows
    size = np.max(np.abs(values), axis=-1)
    covariance, dof = _uncertainty(phase, rest, size, rows, inverse, count)
    pooled = 2 * order / np.sum(1.0 / dof[:, 1:], axis=-1) if order else dof[:, 0]
    return Harmonics(
        order=order,
        coefficients=coefficients,
        covariance=covariance,
        scatter=_scatter(sums or CycleSums.of(values, rows, cycle_edges(phase, count)), order),
        dof=pooled,
        residual=np.sqrt(np.mean(rest**2, axis=-1)),
        count=count,
        coefficient_dof=dof,
    )


def _inverse(gram: Array) -> Array:
    """Inverse of the normal matrix; refused where the samples cannot tell the columns apart."""
    n = gram[0, 0]
    if np.linalg.cond(gram) > 1e8:
        raise DataError(
            f"The phases of the {int(n)} samples do not determine {gram.shape[0]} coefficients: "
            "they leave parts of the cycle out. Lower the order."
        )
    return np.asarray(np.linalg.inv(gram))


def _uncertainty(
    phase: Array, rest: Array, size: Array, rows: Array, inverse: Array, count: int
) -> tuple[Array, Array]:
    """Covariance (c, p, p) and degrees of freedom (c, p) of the coefficients."""
    p, n = rows.shape
    order = p // 2
    start, a_cycle = phase_cells(phase, count)
    cells = np.add.reduceat(rest, start, axis=-1) / np.diff(start, append=n)
    weights = inverse @ np.add.reduceat(rows, start, axis=-1)
    whole = a_cycle * count
    if start.size < whole:
        cells = np.pad(cells, ((0, 0), (0, whole - start.size)))
    squares = np.sum(rest**2, axis=-1) / (n - p)
    rounding = (np.finfo(float).eps * size) ** 2
    covariance = np.maximum(squares, rounding)[:, None, None] * inverse
    dof = np.full((rest.shape[0], p), float(n - p))
    noisy = squares > 1e4 * rounding
    if noisy.any() and between_harmonics(whole, count, order).sum() > 3:
        unit = np.sqrt(squares[noisy])
        gamma, found = fit_noise(cells[noisy, :whole] / unit[:, None], count, order, start.size)
        turn = np.pi * np.repeat(np.arange(order + 1), 2)[1:] / a_cycle
        inside = n / start.size
        # weights vary within a stretch: the mean over it sees a little less of each harmonic
        seen = np.sinc(turn / np.pi) / np.sinc(turn / np.pi / inside)
        slow = weighted_covariance(weights / seen[:, None], gamma)
        covariance[noisy] = unit[:, None, None] ** 2 * slow
        dof[noisy] = np.maximum(np.repeat(found, 2, axis=-1)[:, 1:], 1.0)
    return covariance, dof


def _scatter(sums: CycleSums, order: int) -> Array | None:
    if len(sums.gram) < 2:
        return None
    return np.asarray(np.std(sums.up_to(order).single, axis=0, ddof=1))


@dataclass(frozen=True, kw_only=True, eq=False)
class CycleSums:
    """What least squares need of each of k cycles.

    Attributes
    ----------
    edges : (k + 1,) array of int
        First sample of each cycle, and the end.
    gram : (k, p, p) array
        Products of the functions of the basis.
    right : (k, p, c) array
        Products with the channels.
    """

    edges: Ints
    gram: Array
    right: Array

    @classmethod
    def over(cls, times: Array, basis: FourierBasis, record: Array) -> CycleSums:
        """Over each whole cycle of a record (c, n), counted from its first sample."""
        _, values = as_record(times, record)
        return cls.of(values, basis.rows, cycle_edges(basis.phase, basis.cycles))

    @classmethod
    def of(cls, values: Array, rows: Array, edges: Ints) -> CycleSums:
        """From channels (c, n), the rows (p, n) of a basis, and the k + 1 edges of the cycles."""
        parts = [slice(i, j) for i, j in itertools.pairwise(edges)]
        gram = [rows[:, part] @ rows[:, part].T for part in parts]
        right = [rows[:, part] @ values[:, part].T for part in parts]
        return cls(
            edges=edges,
            gram=np.reshape(gram, (-1, len(rows), len(rows))),
            right=np.reshape(right, (-1, len(rows), len(values))),
        )

    def up_to(self, order: int) -> CycleSums:
        """Without the harmonics above `order`."""
        p = 2 * order + 1
        return replace(self, gram=self.gram[:, :p, :p], right=self.right[:, :p])

    def within(self, first: int, last: int) -> CycleSums:
        """Of the cycles [first, last)."""
        return CycleSums(
            edges=self.edges[first : last + 1],
            gram=self.gram[first:last],
            right=self.right[first:last],
        )

    @property
    def single(self) -> Array:
        """Coefficients of the single cycles, (k, c, p)."""
        single = np.linalg.solve(self.gram, self.right).transpose(0, 2, 1)
        return np.asarray(single, np.float64)

    def together(self, first: int, last: int) -> Array:
        """Coefficients (c, p) of the cycles [first, last) taken as one record."""
        part = slice(first, last)
        gram, right = self.gram[part].sum(axis=0), self.right[part].sum(axis=0)
        return np.asarray(np.linalg.solve(gram, right).T, np.float64)


def trapezoid_harmonics(theta: ArrayLike, y: ArrayLike, *, order: int = 5) -> Array:
    """Harmonics by trapezoidal integration over whole cycles.

    y (c, n).

    Notes
    -----
    The record is closed by its own first sample, as a periodic record is. On equal steps this
    is the least-squares result.

    Examples
    --------
    >>> import numpy as np
    >>> theta = np.linspace(0.0, 2 * np.pi, 65)
    >>> np.round(trapezoid_harmonics(theta, 3.0 * np.sin(theta), order=1), 12) + 0.0
    array([[0., 0., 3.]])
    """
    phase, values = as_record(theta, y, name="theta", least=2 * order + 2)
    return np.asarray(values @ trapezoid_projector(phase, order).T)


def trapezoid_projector(phase: Array, order: int) -> Array:
    """The map (2 order + 1, n) from samples to harmonics by trapezoidal integration.

    Parameters
    ----------
    phase : (n,) array
        As `theta` of `trapezoid_harmonics` [rad].
    order : int
        Highest harmonic.

    Raises
    ------
    DataError
        If the phase does not cover whole cycles.

    Examples
    --------
    >>> theta = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
    >>> np.round(trapezoid_projector(theta, 1) @ (2.0 + np.cos(theta)), 12) + 0.0
    array([2., 1., 0.])
    """
    step = np.diff(phase)
    count = max(1, round((phase[-1] - phase[0]) / TURN))
    gap = TURN * count - (phase[-1] - phase[0])
    if not -1e-9 <= gap <= 2.0 * step.max():
        raise DataError(
            f"The record covers {(phase[-1] - phase[0]) / TURN:.4f} cycles: "
            "integration needs whole cycles. Choose them first, or use least squares."
        )
    weight = 0.5 * (np.append(step, gap) + np.insert(step, 0, gap))
    found = _rows(phase, order) * weight / (np.pi * count)
    found[0] *= 0.5
    return np.asarray(found)
