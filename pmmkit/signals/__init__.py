"""Signals: steady windows, noise of autocorrelated records, whole cycles and harmonics."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.signals.cycles import Cycles, whole_cycles
    from pmmkit.signals.fourier import (
        CycleSums,
        FourierBasis,
        Harmonics,
        design_matrix,
        harmonics,
        trapezoid_projector,
    )
    from pmmkit.signals.frequency import estimate_frequency
    from pmmkit.signals.noise import (
        FEWEST,
        autoregressive_noise,
        head_rest,
        steady_mean,
        time_weights,
        white_noise,
    )
    from pmmkit.signals.periodic import between_harmonics, fit_noise, phase_cells
    from pmmkit.signals.shift import shifts_within
    from pmmkit.signals.steady import Window, steady_window
    from pmmkit.signals.travel import Travel, at_size, at_speed, in_step

__all__ = [
    "FEWEST",
    "CycleSums",
    "Cycles",
    "FourierBasis",
    "Harmonics",
    "Travel",
    "Window",
    "at_size",
    "at_speed",
    "autoregressive_noise",
    "between_harmonics",
    "design_matrix",
    "estimate_frequency",
    "fit_noise",
    "harmonics",
    "head_rest",
    "in_step",
    "phase_cells",
    "shifts_within",
    "steady_mean",
    "steady_window",
    "time_weights",
    "trapezoid_projector",
    "white_noise",
    "whole_cycles",
]

lazy(__name__)
