"""The frequency of an oscillating record, from the record itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pmmkit.signals.harmonics import design_matrix
from pmmkit.signals.record import as_record

Array = NDArray[np.float64]


def estimate_frequency(t: Array, y: Array, omega: float) -> tuple[float, float]:
    """Angular frequency of the record near the nominal one, with its std [rad/s]."""
    time, values = as_record(t, y)
    middle = 0.5 * (time[0] + time[-1])
    w = float(omega)
    error = 0.0
    for _ in range(20):
        basis = design_matrix((time - middle) * w, 3)
        fitted = np.linalg.lstsq(basis, values.T, rcond=None)[0]
        n = np.arange(1, 4)
        slope = (time - middle)[:, None] * (
            (basis[:, 2::2] * -n) @ fitted[1::2] + (basis[:, 1::2] * n) @ fitted[2::2]
        )
        q, _ = np.linalg.qr(basis)
        slope = slope - q @ (q.T @ slope)
        rest = values.T - basis @ fitted
        variance = np.maximum(np.mean(rest**2, axis=0), 1e-300)
        information = float(np.sum(slope**2 / variance))
        if information <= 0:
            return float(omega), np.inf
        move = float(np.sum(slope * rest / variance)) / information
        error = information**-0.5
        w += float(np.clip(move, -0.02 * omega, 0.02 * omega))
        if abs(move) < 1e-12 * omega:
            break
    return w, error
