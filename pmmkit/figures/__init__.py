"""What people look at: each function gives a matplotlib Figure and changes nothing global."""

from pmmkit.figures.checking import zeros_at_rest
from pmmkit.figures.correlations import correlations
from pmmkit.figures.cycles_by_froude import CycleForces, cycles_by_froude
from pmmkit.figures.derivatives import beside_reference, derivatives_over_froude
from pmmkit.figures.forces import Cycle, DriftPoints, forces_over_drift, over_a_cycle
from pmmkit.figures.forests import forest
from pmmkit.figures.growth import growth_over_depth
from pmmkit.plotting.bands import band_histories
from pmmkit.plotting.histories import histories, path, spiral, zigzag
from pmmkit.plotting.metrics import measures_over_froude, metrics_over
from pmmkit.plotting.style import save, svg
from pmmkit.plotting.turns import trajectory, turn_histories

__all__ = [
    "Cycle",
    "CycleForces",
    "DriftPoints",
    "band_histories",
    "beside_reference",
    "correlations",
    "cycles_by_froude",
    "derivatives_over_froude",
    "forces_over_drift",
    "forest",
    "growth_over_depth",
    "histories",
    "measures_over_froude",
    "metrics_over",
    "over_a_cycle",
    "path",
    "save",
    "spiral",
    "svg",
    "trajectory",
    "turn_histories",
    "zeros_at_rest",
    "zigzag",
]
