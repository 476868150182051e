"""From forces to derivatives: means, harmonics, balance, regression, uncertainty."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.reduction.agreement import differences, worst
    from pmmkit.reduction.between_runs import in_words
    from pmmkit.reduction.budgets.budget import Budget
    from pmmkit.reduction.budgets.derivatives import contributions, derivative_budget
    from pmmkit.reduction.budgets.grids import GridStudy, grid_study, grid_uncertainty, with_grids
    from pmmkit.reduction.budgets.manoeuvres import imo_budget, manoeuvre_budget
    from pmmkit.reduction.choice import AUTO
    from pmmkit.reduction.depths import Growth, felt, growth
    from pmmkit.reduction.derivatives import columns_of
    from pmmkit.reduction.methods.method import Estimate
    from pmmkit.reduction.methods.registry import METHODS
    from pmmkit.reduction.observations.equations import Rows
    from pmmkit.reduction.observations.prepare import PreparedRun, RunResult, one_cycle, prepare
    from pmmkit.reduction.observations.seen import RunView
    from pmmkit.reduction.observations.stated import altered, idle
    from pmmkit.reduction.observations.views import FLOOR, View, views_of
    from pmmkit.reduction.parts import Parts, hull_alone, parts_of
    from pmmkit.reduction.reading.resume import forget, resume_folder
    from pmmkit.reduction.reading.run import speed_increase
    from pmmkit.reduction.reduce import Reduction, reduce_campaign
    from pmmkit.reduction.sinkage import squat, squat_frame
    from pmmkit.reduction.thrust import thrust_inside

__all__ = [
    "AUTO",
    "FLOOR",
    "METHODS",
    "Budget",
    "Estimate",
    "GridStudy",
    "Growth",
    "Parts",
    "PreparedRun",
    "Reduction",
    "Rows",
    "RunResult",
    "RunView",
    "View",
    "altered",
    "columns_of",
    "contributions",
    "derivative_budget",
    "differences",
    "felt",
    "forget",
    "grid_study",
    "grid_uncertainty",
    "growth",
    "hull_alone",
    "idle",
    "imo_budget",
    "in_words",
    "manoeuvre_budget",
    "one_cycle",
    "parts_of",
    "prepare",
    "reduce_campaign",
    "resume_folder",
    "speed_increase",
    "squat",
    "squat_frame",
    "thrust_inside",
    "views_of",
    "with_grids",
    "worst",
]

lazy(__name__)
