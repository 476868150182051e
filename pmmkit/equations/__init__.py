"""Equations of motion: written for a model, compiled, and integrated through orders."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.equations.code_generation import GIVEN
    from pmmkit.equations.following import packed_following, prepare_following
    from pmmkit.equations.layouts import Ask, End, InputField, OverGround, State, Status
    from pmmkit.equations.plan import Phase, Plan, Probe, ProbeResults
    from pmmkit.equations.prepared import Conditions, Prepared, prepare
    from pmmkit.equations.run import DenseHistory, Gear, Revolutions, run_plan, run_ships
    from pmmkit.equations.structure import ACCELERATIONS, POLYNOMIALS, EquationStructure, Used

__all__ = [
    "ACCELERATIONS",
    "GIVEN",
    "POLYNOMIALS",
    "Ask",
    "Conditions",
    "DenseHistory",
    "End",
    "EquationStructure",
    "Gear",
    "InputField",
    "OverGround",
    "Phase",
    "Plan",
    "Prepared",
    "Probe",
    "ProbeResults",
    "Revolutions",
    "State",
    "Status",
    "Used",
    "packed_following",
    "prepare",
    "prepare_following",
    "run_plan",
    "run_ships",
]

lazy(__name__)
