"""Simulation: manoeuvres of models, their numbers, sweeps and uncertainty."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.simulation.bands import Bands
    from pmmkit.simulation.ensemble import Ensemble, monte_carlo
    from pmmkit.simulation.figures import measures_over_froude, metrics_over
    from pmmkit.simulation.kinds.catalogue import MANOEUVRES
    from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting
    from pmmkit.simulation.kinds.zigzag import executed_at
    from pmmkit.simulation.linear import stability
    from pmmkit.simulation.sensitivity import Sensitivities, sensitivities, sobol
    from pmmkit.simulation.single import simulate, stopping_ship, wave_height_of
    from pmmkit.simulation.spiral import spiral_curve
    from pmmkit.simulation.spread import Draws, Spread
    from pmmkit.simulation.sweeps import SHARES, froude_sweep, sweep
    from pmmkit.simulation.track import Track

__all__ = [
    "MANOEUVRES",
    "SHARES",
    "Bands",
    "Draws",
    "Ensemble",
    "Manoeuvre",
    "Sensitivities",
    "Setting",
    "Spread",
    "Track",
    "executed_at",
    "froude_sweep",
    "measures_over_froude",
    "metrics_over",
    "monte_carlo",
    "sensitivities",
    "simulate",
    "sobol",
    "spiral_curve",
    "stability",
    "stopping_ship",
    "sweep",
    "wave_height_of",
]

lazy(__name__)
