"""Signals: steady windows, noise of autocorrelated records, whole cycles and harmonics."""

from __future__ import annotations

from pmmkit.signals.cycles import Cycles, whole_cycles
from pmmkit.signals.frequency import estimate_frequency
from pmmkit.signals.harmonics import (
    FourierBasis,
    Harmonics,
    design_matrix,
    harmonics,
    trapezoid_harmonics,
)
from pmmkit.signals.noise import Mean, steady_mean
from pmmkit.signals.rest import Rest, head_rest
from pmmkit.signals.smoothing import fitted_order
from pmmkit.signals.steady import Window, steady_window
from pmmkit.signals.travel import Travel, at_speed, in_step

__all__ = [
    "Cycles",
    "FourierBasis",
    "Harmonics",
    "Mean",
    "Rest",
    "Travel",
    "Window",
    "at_speed",
    "design_matrix",
    "estimate_frequency",
    "fitted_order",
    "harmonics",
    "head_rest",
    "in_step",
    "steady_mean",
    "steady_window",
    "trapezoid_harmonics",
    "whole_cycles",
]
