"""Simulation: equations of motion, manoeuvres, their numbers, sweeps and criteria."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.simulation.bands import SHIPS, Bands, bands_of
    from pmmkit.simulation.ensemble import SHOWN, Ensemble, monte_carlo
    from pmmkit.simulation.equations.code_generation import GIVEN
    from pmmkit.simulation.equations.layouts import NO_SEA, InputField, OverGround, State, Status
    from pmmkit.simulation.equations.prepared import Conditions, Prepared, prepare
    from pmmkit.simulation.equations.structure import ACCELERATIONS, POLYNOMIALS, Used
    from pmmkit.simulation.figures import measures_over_froude, metrics_over
    from pmmkit.simulation.imo.conditions import LOADED, Condition, simulated_conditions
    from pmmkit.simulation.imo.judged import imo_turning, imo_verdicts, sided_tests
    from pmmkit.simulation.imo.verdict import Verdict, judge, verdict_sections
    from pmmkit.simulation.kinds.catalogue import MANOEUVRES, manoeuvre_of
    from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting
    from pmmkit.simulation.kinds.turning import LENGTHS
    from pmmkit.simulation.kinds.zigzag import executed_at
    from pmmkit.simulation.linear import stability
    from pmmkit.simulation.machinery import FullAstern
    from pmmkit.simulation.sensitivity import Sensitivities, sensitivities, sobol
    from pmmkit.simulation.single import RTOL, simulate, steering
    from pmmkit.simulation.spiral import spiral_curve
    from pmmkit.simulation.spread import Draws, Spread, is_uncertain, spread_of
    from pmmkit.simulation.sweeps import (
        SHARES,
        froude_sweep,
        metrics_of,
        sweep,
        told_metric,
        told_metrics,
        track_files,
    )
    from pmmkit.simulation.track import CHANNELS, Track, scaled

__all__ = [
    "ACCELERATIONS",
    "CHANNELS",
    "GIVEN",
    "LENGTHS",
    "LOADED",
    "MANOEUVRES",
    "NO_SEA",
    "POLYNOMIALS",
    "RTOL",
    "SHARES",
    "SHIPS",
    "SHOWN",
    "Bands",
    "Condition",
    "Conditions",
    "Draws",
    "Ensemble",
    "FullAstern",
    "InputField",
    "Manoeuvre",
    "OverGround",
    "Prepared",
    "Sensitivities",
    "Setting",
    "Spread",
    "State",
    "Status",
    "Track",
    "Used",
    "Verdict",
    "bands_of",
    "executed_at",
    "froude_sweep",
    "imo_turning",
    "imo_verdicts",
    "is_uncertain",
    "judge",
    "manoeuvre_of",
    "measures_over_froude",
    "metrics_of",
    "metrics_over",
    "monte_carlo",
    "prepare",
    "scaled",
    "sensitivities",
    "sided_tests",
    "simulate",
    "simulated_conditions",
    "sobol",
    "spiral_curve",
    "spread_of",
    "stability",
    "steering",
    "sweep",
    "told_metric",
    "told_metrics",
    "track_files",
    "verdict_sections",
]

lazy(__name__)
