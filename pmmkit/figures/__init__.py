"""What people look at: each function gives a matplotlib Figure and changes nothing global."""

from pmmkit.figures.derivatives import beside_reference, derivatives_over_froude
from pmmkit.figures.forces import Cycle, DriftPoints, forces_over_drift, over_a_cycle
from pmmkit.figures.manoeuvres import (
    distributions,
    histories,
    importance,
    manoeuvre,
    metrics_over,
    path,
    spiral,
    steady_turns,
    zigzag,
)
from pmmkit.figures.turns import measures_over_froude, trajectory, turn_histories
from pmmkit.plotting.style import save, svg

__all__ = [
    "Cycle",
    "DriftPoints",
    "beside_reference",
    "derivatives_over_froude",
    "distributions",
    "forces_over_drift",
    "histories",
    "importance",
    "manoeuvre",
    "measures_over_froude",
    "metrics_over",
    "over_a_cycle",
    "path",
    "save",
    "spiral",
    "steady_turns",
    "svg",
    "trajectory",
    "turn_histories",
    "zigzag",
]
