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
    from pmmkit.reduction.observations.prepare import (
        ORDER,
        CycleChoice,
        PreparedRun,
        RunResult,
        one_cycle,
        places_of,
        prepare,
    )
    from pmmkit.reduction.observations.seen import RunView, times_factors
    from pmmkit.reduction.observations.stated import altered, idle, nominal_path
    from pmmkit.reduction.observations.views import (
        Repeatability,
        View,
        repeat_scatter,
        repeatability_of,
        scale_of,
        views_of,
    )
    from pmmkit.reduction.observations.whitening import (
        FLOOR,
        Channel,
        Places,
        Projection,
        WhitenedChannel,
        alike,
        noise_whitened,
        whitened,
    )
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
    "ORDER",
    "Budget",
    "Channel",
    "CycleChoice",
    "Estimate",
    "GridStudy",
    "Growth",
    "Parts",
    "Places",
    "PreparedRun",
    "Projection",
    "Reduction",
    "Repeatability",
    "Rows",
    "RunResult",
    "RunView",
    "View",
    "WhitenedChannel",
    "alike",
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
    "noise_whitened",
    "nominal_path",
    "one_cycle",
    "parts_of",
    "places_of",
    "prepare",
    "reduce_campaign",
    "repeat_scatter",
    "repeatability_of",
    "resume_folder",
    "scale_of",
    "speed_increase",
    "squat",
    "squat_frame",
    "thrust_inside",
    "times_factors",
    "views_of",
    "whitened",
    "with_grids",
    "worst",
]

lazy(__name__)
