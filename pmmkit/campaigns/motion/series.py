"""Fourier series of a measured motion on its actual times."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import CampaignError
from pmmkit.campaigns.stated_run import StatedRun
from pmmkit.numerics import Array, coefficients
from pmmkit.signals import FourierBasis

HARMONICS: Final = 5
"""Highest harmonic of the series through which measured motions are differentiated."""
_WHOLE: Final = 0.95


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierSeries:
    """A trend and a Fourier series: c0 + c1 τ + Σ (a cos nθ + b sin nθ), τ = t - start, θ̇ = ω."""

    omega: float
    start: float
    away: Array
    slope: float
    basis: FourierBasis
    coefficients: Array
    standard_error: float

    @property
    def fundamental(self) -> tuple[float, float]:
        """Cosine and sine amplitude of the first harmonic."""
        return float(self.coefficients[1]), float(self.coefficients[2])

    @property
    def swings(self) -> Array:
        """Amplitudes of the harmonics from the first on."""
        return np.hypot(self.coefficients[1::2], self.coefficients[2::2])

    def derivative(self, order: int) -> Array:
        """The series (order 0) or its first or second time derivative at all samples."""
        rates = self.omega * np.arange(1, self.basis.order + 1)
        turned = (self.coefficients[1::2] - 1j * self.coefficients[2::2]) * (1j * rates) ** order
        weights = np.zeros_like(self.coefficients)
        weights[0] = self.coefficients[0] if order == 0 else 0.0
        weights[1::2], weights[2::2] = turned.real, -turned.imag
        found: Array = weights @ self.basis.rows
        if self.slope and order < 2:
            found += self.slope * (self.away if order == 0 else 1.0)
        return found


def fit_series(
    run: StatedRun, times: Array, values: Array, name: str, basis: FourierBasis | None = None
) -> FourierSeries:
    """Least-squares series of a measured channel at the run's frequency.

    times [s].
    """
    run.require_settings(("period",))
    omega = run.settings.omega or 0.0
    good = np.isfinite(times) & np.isfinite(values)
    count = int(np.count_nonzero(good))
    instants = times[good]
    covered = np.ptp(instants) * count / (count - 1) * omega / (2 * math.pi) if count > 1 else 0.0
    if count and covered >= _WHOLE:
        away = times - instants[0]
        whole = basis or FourierBasis.at(omega * away, HARMONICS)
        trend = away / np.ptp(instants) if name == "x" else None
        for order in range(HARMONICS, 0, -1):
            shared = whole.up_to(order)
            found = _solved(shared, trend, values, good)
            if found is not None:
                return FourierSeries(
                    omega=omega,
                    start=float(instants[0]),
                    away=away,
                    slope=0.0 if trend is None else float(found[0][-1] / np.ptp(instants)),
                    basis=shared,
                    coefficients=found[0][: 2 * order + 1],
                    standard_error=found[1] * math.sqrt(2 / count),
                )
    raise CampaignError(
        f"{count} samples over {covered:.2f} periods are too few for a Fourier series.",
        run=run.id,
        column=name,
        remedy="Give the whole oscillation, or the accelerations as channels.",
    )


def _solved(
    basis: FourierBasis, trend: Array | None, values: Array, good: NDArray[np.bool_]
) -> tuple[Array, float] | None:
    """Coefficients of a series and the scatter about it; None where the samples leave them open."""
    rows = basis.rows if trend is None else np.vstack([basis.rows, trend])
    if not good.all():
        rows, values = rows[:, good], values[good]
    size, count = rows.shape
    if count < size:
        return None
    gram = basis.gram if rows is basis.rows else rows @ rows.T
    if np.linalg.matrix_rank(gram, tol=1e-9 * count) < size:
        return None
    solution = coefficients(rows.T, values[None], gram)[0]
    residual = values - solution @ rows
    return solution, math.sqrt(float(residual @ residual) / max(count - size, 1))
