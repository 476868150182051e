"""Simulation: manoeuvres of a model, their numbers, sweeps and criteria."""

from pmmkit.equations.layouts import Ask, End, State
from pmmkit.simulation.ensemble import Ensemble, monte_carlo
from pmmkit.simulation.froude import FroudeRange
from pmmkit.simulation.imo import Verdict, imo_turning, imo_verdicts, zigzag_limits
from pmmkit.simulation.linear import Stability, stability
from pmmkit.simulation.manoeuvres.catalogue import manoeuvre_of
from pmmkit.simulation.manoeuvres.manoeuvre import Manoeuvre, Setting
from pmmkit.simulation.plan import Phase, Plan, Probe, ProbeResults
from pmmkit.simulation.sensitivity import Sensitivities, SobolIndices, sensitivities, sobol
from pmmkit.simulation.simulate import simulate
from pmmkit.simulation.spiral import SpiralCurve, spiral_curve
from pmmkit.simulation.sweeps import froude_sweep, sweep
from pmmkit.simulation.track import Track

__all__ = [
    "Ask",
    "End",
    "Ensemble",
    "FroudeRange",
    "Manoeuvre",
    "Phase",
    "Plan",
    "Probe",
    "ProbeResults",
    "Sensitivities",
    "Setting",
    "SobolIndices",
    "SpiralCurve",
    "Stability",
    "State",
    "Track",
    "Verdict",
    "froude_sweep",
    "imo_turning",
    "imo_verdicts",
    "manoeuvre_of",
    "monte_carlo",
    "sensitivities",
    "simulate",
    "sobol",
    "spiral_curve",
    "stability",
    "sweep",
    "zigzag_limits",
]
