"""Simulation: equations of motion, manoeuvres, their numbers, sweeps and criteria."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.simulation.bands import SHIPS, Bands, bands_of
    from pmmkit.simulation.ensemble import SHOWN, Ensemble, monte_carlo
    from pmmkit.simulation.equations.code_generation import (
        CARRYING,
        ESTIMATING,
        GIVEN,
        module_text,
        told,
    )
    from pmmkit.simulation.equations.compilation import compiled, interpreted
    from pmmkit.simulation.equations.histories import repeating_states, rigid_body, water_forces
    from pmmkit.simulation.equations.layouts import (
        NO_SEA,
        Constant,
        Control,
        GearField,
        InputField,
        OverGround,
        State,
        Status,
    )
    from pmmkit.simulation.equations.prepared import (
        CALM,
        Conditions,
        Numbers,
        Prepared,
        feels_depth,
        missing_parts,
        packed,
        prepare,
        values_at,
    )
    from pmmkit.simulation.equations.structure import (
        ACCELERATIONS,
        FORCES,
        POLYNOMIALS,
        EquationStructure,
        Used,
    )
    from pmmkit.simulation.figures import measures_over_froude, metrics_over
    from pmmkit.simulation.imo.conditions import (
        LOADED,
        Condition,
        approach_condition,
        current_condition,
        depth_condition,
        draught_condition,
        length_condition,
        rudder_condition,
        said,
        sea_condition,
        simulated_conditions,
        wind_condition,
    )
    from pmmkit.simulation.imo.judged import LARGE, imo_turning, imo_verdicts, sided_tests
    from pmmkit.simulation.imo.verdict import (
        SOURCE,
        UNSETTLED,
        Side,
        Verdict,
        in_unit,
        judge,
        manoeuvre_words,
        side_of,
        turning_conditions,
        verdict_sections,
        what_follows,
    )
    from pmmkit.simulation.kinds.catalogue import MANOEUVRES, manoeuvre_of
    from pmmkit.simulation.kinds.manoeuvre import Manoeuvre, Setting
    from pmmkit.simulation.kinds.turning import LENGTHS
    from pmmkit.simulation.kinds.zigzag import executed_at
    from pmmkit.simulation.linear import stability
    from pmmkit.simulation.machinery import FullAstern, measured_astern
    from pmmkit.simulation.run import LONGEST_STEP
    from pmmkit.simulation.sensitivity import Sensitivities, sensitivities, sobol
    from pmmkit.simulation.single import RTOL, simulate, steering
    from pmmkit.simulation.spiral import spiral_curve
    from pmmkit.simulation.spread import Draws, Spread, is_uncertain, spread_of
    from pmmkit.simulation.sweeps import (
        SHARES,
        froude_sweep,
        metrics_of,
        sweep,
        sweep_frame,
        told_metric,
        told_metrics,
        track_files,
    )
    from pmmkit.simulation.track import CHANNELS, Track, scaled

__all__ = [
    "ACCELERATIONS",
    "CALM",
    "CARRYING",
    "CHANNELS",
    "ESTIMATING",
    "FORCES",
    "GIVEN",
    "LARGE",
    "LENGTHS",
    "LOADED",
    "LONGEST_STEP",
    "MANOEUVRES",
    "NO_SEA",
    "POLYNOMIALS",
    "RTOL",
    "SHARES",
    "SHIPS",
    "SHOWN",
    "SOURCE",
    "UNSETTLED",
    "Bands",
    "Condition",
    "Conditions",
    "Constant",
    "Control",
    "Draws",
    "Ensemble",
    "EquationStructure",
    "FullAstern",
    "GearField",
    "InputField",
    "Manoeuvre",
    "Numbers",
    "OverGround",
    "Prepared",
    "Sensitivities",
    "Setting",
    "Side",
    "Spread",
    "State",
    "Status",
    "Track",
    "Used",
    "Verdict",
    "approach_condition",
    "bands_of",
    "compiled",
    "current_condition",
    "depth_condition",
    "draught_condition",
    "executed_at",
    "feels_depth",
    "froude_sweep",
    "imo_turning",
    "imo_verdicts",
    "in_unit",
    "interpreted",
    "is_uncertain",
    "judge",
    "length_condition",
    "manoeuvre_of",
    "manoeuvre_words",
    "measured_astern",
    "measures_over_froude",
    "metrics_of",
    "metrics_over",
    "missing_parts",
    "module_text",
    "monte_carlo",
    "packed",
    "prepare",
    "repeating_states",
    "rigid_body",
    "rudder_condition",
    "said",
    "scaled",
    "sea_condition",
    "sensitivities",
    "side_of",
    "sided_tests",
    "simulate",
    "simulated_conditions",
    "sobol",
    "spiral_curve",
    "spread_of",
    "stability",
    "steering",
    "sweep",
    "sweep_frame",
    "told",
    "told_metric",
    "told_metrics",
    "track_files",
    "turning_conditions",
    "values_at",
    "verdict_sections",
    "water_forces",
    "what_follows",
    "wind_condition",
]

lazy(__name__)
