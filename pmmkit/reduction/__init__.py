"""From forces to derivatives: means, harmonics, balance, regression, uncertainty."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.reduction.budgets.budget import Budget
    from pmmkit.reduction.budgets.derivatives import contributions, derivative_budget
    from pmmkit.reduction.budgets.grids import GridStudy, grid_study, grid_uncertainty, with_grids
    from pmmkit.reduction.budgets.manoeuvres import imo_budget, manoeuvre_budget
    from pmmkit.reduction.depths import Felt, Growth
    from pmmkit.reduction.derivatives import columns_of
    from pmmkit.reduction.observations.equations import Rows
    from pmmkit.reduction.observations.prepare import PreparedRun, RunResult, one_cycle
    from pmmkit.reduction.observations.stated import altered, idle
    from pmmkit.reduction.observations.views import FLOOR, RunViews, View
    from pmmkit.reduction.parts import Parts
    from pmmkit.reduction.reading.resume import resumable
    from pmmkit.reduction.reduce import Reduction, reduce_campaign

__all__ = [
    "FLOOR",
    "Budget",
    "Felt",
    "GridStudy",
    "Growth",
    "Parts",
    "PreparedRun",
    "Reduction",
    "Rows",
    "RunResult",
    "RunViews",
    "View",
    "altered",
    "columns_of",
    "contributions",
    "derivative_budget",
    "grid_study",
    "grid_uncertainty",
    "idle",
    "imo_budget",
    "manoeuvre_budget",
    "one_cycle",
    "reduce_campaign",
    "resumable",
    "with_grids",
]

lazy(__name__)
