"""Fourier series of a measured motion on its actual times."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.campaigns.motion.nominal import check_settings
from pmmkit.campaigns.run import Run
from pmmkit.errors import CampaignError, Problem
from pmmkit.numerics import Array, coefficients
from pmmkit.signals import design_matrix

HARMONICS: Final = 5
"""Highest harmonic of the series through which measured motions are differentiated."""
_WHOLE: Final = 0.95


@dataclass(frozen=True, kw_only=True)
class Series:
    """A trend and a Fourier series: c0 + c1 τ + Σ (a cos nωτ + b sin nωτ), τ = t - start."""

    omega: float
    start: float
    slope: float
    cosines: Array
    sines: Array
    standard_error: float

    @property
    def fundamental(self) -> tuple[float, float]:
        """Cosine and sine amplitude of the first harmonic."""
        return float(self.cosines[1]), float(self.sines[1])

    def derivative(self, times: Array, order: int) -> Array:
        """The series (order 0) or its first or second time derivative."""
        away = times - self.start
        rates = self.omega * np.arange(len(self.cosines))
        amplitudes = (self.cosines - 1j * self.sines) * (1j * rates) ** order
        angle = self.omega * away
        turn = np.cos(angle) + 1j * np.sin(angle)
        # Horner's rule in e^iωτ: one sine and cosine for all harmonics.
        waves = np.zeros_like(turn)
        for own in amplitudes[::-1]:
            waves = waves * turn + own
        trend = {0: self.slope * away, 1: np.full_like(away, self.slope)}.get(order, 0.0)
        found: Array = waves.real + trend
        return found


def fit_series(run: Run, times: Array, values: Array, name: str) -> Series:
    """Least-squares series of a measured channel at the run's frequency."""
    check_settings(run, ("period",))
    omega = run.settings.omega or 0.0
    good = np.isfinite(times) & np.isfinite(values)
    instants, samples = times[good], values[good]
    count = len(instants)
    covered = np.ptp(instants) * count / (count - 1) * omega / (2 * math.pi) if count > 1 else 0.0
    trend = name == "x"
    for order in range(HARMONICS, 0, -1):
        size = 2 * order + 1 + trend
        if covered < _WHOLE or count < size:
            continue
        start = float(instants[0])
        matrix = design_matrix(omega * (instants - start), order)
        if trend:
            matrix = np.column_stack([matrix, (instants - start) / np.ptp(instants)])
        if np.linalg.matrix_rank(matrix.T @ matrix, tol=1e-9 * count) < size:
            continue
        solution = coefficients(matrix, samples[None])[0]
        residual = samples - matrix @ solution
        scatter = math.sqrt(float(residual @ residual) / max(count - size, 1))
        return Series(
            omega=omega,
            start=start,
            slope=float(solution[-1] / np.ptp(instants)) if trend else 0.0,
            cosines=np.concatenate([solution[:1], solution[1 : 2 * order : 2]]),
            sines=np.concatenate([[0.0], solution[2 : 2 * order + 1 : 2]]),
            standard_error=scatter * math.sqrt(2 / count),
        )
    raise CampaignError(
        Problem(
            message=f"{count} samples over {covered:.2f} periods are too few for a Fourier series.",
            run=run.id,
            column=name,
            remedy="Give the whole oscillation, or the accelerations as channels.",
        )
    )
