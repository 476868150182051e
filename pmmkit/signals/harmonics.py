"""Harmonics of periodic records with their covariance."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmmkit.errors import DataError
from pmmkit.signals.record import as_record

Array = NDArray[np.float64]
TURN = 2.0 * np.pi


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
        Standard deviation over the cycles of the coefficients of single cycles; None for one cycle.
    dof : (c,) array
        Degrees of freedom of the variances, for Student's t.
    residual : (c,) array
        Root mean square of what the harmonics leave.
    count : int
        Whole cycles used.
    """

    order: int
    coefficients: Array
    covariance: Array
    scatter: Array | None
    dof: Array
    residual: Array
    count: int

    @property
    def std(self) -> Array:
        """Standard uncertainty of each coefficient, (c, 2 order + 1)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))


def design_matrix(theta: Array, order: int) -> Array:
    """Columns 1, cos θ, sin θ, cos 2θ, sin 2θ, … at each phase, (n, 2 order + 1)."""
    phase = np.asarray(theta, dtype=float)
    turn = np.exp(1j * phase)
    power = np.cumprod(np.broadcast_to(turn[:, None], (phase.size, order)), axis=1)
    columns = np.empty((phase.size, 2 * order + 1))
    columns[:, 0] = 1.0
    columns[:, 1::2] = power.real
    columns[:, 2::2] = power.imag
    return columns


def harmonics(theta: Array, y: Array, *, order: int = 5) -> Harmonics:
    """Harmonics by least squares on the actual phase, with covariance."""
    phase, values = as_record(theta, y, name="theta", least=2 * order + 2)
    count = cycle_count(phase)
    if count < 1:
        raise DataError(
            f"The record covers {(phase[-1] - phase[0]) / TURN:.2f} cycles; "
            "harmonics need at least one whole cycle."
        )
    q, r = np.linalg.qr(design_matrix(phase, order))
    inverse = np.linalg.inv(r)
    coefficients = (values @ q) @ inverse.T
    rest = values - (values @ q) @ q.T
    residual = np.sqrt(np.mean(rest**2, axis=-1))
    dof = np.full(values.shape[0], phase.size - q.shape[1], dtype=float)
    variance = np.sum(rest**2, axis=-1) / dof
    covariance = variance[:, None, None] * (inverse @ inverse.T)
    scatter = None
    if count > 1:
        edges = np.searchsorted(phase, phase[0] + TURN * np.arange(count + 1) - 1e-9)
        single = []
        for i, j in itertools.pairwise(edges):
            columns = design_matrix(phase[i:j], order)
            single.append(np.linalg.lstsq(columns, values[:, i:j].T, rcond=None)[0].T)
        scatter = np.std(np.stack(single), axis=0, ddof=1)
    return Harmonics(order, coefficients, covariance, scatter, dof, residual, count)


def cycle_count(phase: Array) -> int:
    """Whole cycles covered; the last sample stands for one step beyond itself."""
    step = float(np.median(np.diff(phase)))
    return int(np.floor((phase[-1] - phase[0] + 1.25 * step) / TURN))


def trapezoid_harmonics(theta: Array, y: Array, *, order: int = 5) -> Array:
    """Harmonics by trapezoidal integration over whole cycles, (c, 2 order + 1)."""
    phase, values = as_record(theta, y, name="theta", least=2 * order + 2)
    count = cycle_count(phase)
    gap = TURN * count - (phase[-1] - phase[0])
    step = np.diff(phase)
    weight = 0.5 * (np.concatenate(([gap], step)) + np.concatenate((step, [gap])))
    out = (values * weight) @ design_matrix(phase, order) / (np.pi * count)
    out[:, 0] *= 0.5
    return out
