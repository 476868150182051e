"""Filters and sparse regression."""

from __future__ import annotations

from scripts.validation.derivatives import virtual
from scripts.validation.published import Published

FIGURES: tuple[Published, ...] = (
    *virtual(
        "S175 in a virtual tank, by a Kalman filter",
        "ekf",
        "Kalman filter over the histories of all runs",
    ),
    *virtual(
        "S175 in a virtual tank, by sparse regression",
        "sindy",
        "sparse regression over the histories, which chooses its terms",
    ),
)
