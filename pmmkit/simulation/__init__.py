"""Simulation: manoeuvres of a model, their numbers, sweeps and criteria."""

from pmmkit.simulation.ensemble import Ensemble, monte_carlo
from pmmkit.simulation.imo import Verdict, imo_turning
from pmmkit.simulation.manoeuvres import MANOEUVRES
from pmmkit.simulation.sensitivity import Sensitivities, SobolIndices, sensitivities, sobol
from pmmkit.simulation.simulate import simulate
from pmmkit.simulation.sweeps import froude_sweep, sweep
from pmmkit.simulation.track import Track

__all__ = [
    "MANOEUVRES", "Ensemble", "Sensitivities", "SobolIndices", "Track", "Verdict",
    "froude_sweep", "imo_turning", "monte_carlo", "sensitivities", "simulate", "sobol", "sweep",
]  # fmt: skip
