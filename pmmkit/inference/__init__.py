"""Inference that knows nothing of ships: evidence, errors, filters, propagation, sparsity."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.inference.chains import R_HAT, Convergence, convergence
    from pmmkit.inference.collinear import Collinearity
    from pmmkit.inference.equations import Equations
    from pmmkit.inference.estimators import room
    from pmmkit.inference.information_filter import InformationRoot
    from pmmkit.inference.innovations import (
        LAGS,
        Consistency,
        Innovations,
        autocorrelation,
        innovation_tests,
    )
    from pmmkit.inference.left_out import of_others, of_others_by_hat
    from pmmkit.inference.linear_fit import (
        RANK_TOLERANCE,
        LeastSquares,
        dependent,
        least_squares,
        optional_columns,
    )
    from pmmkit.inference.mixture import half_width
    from pmmkit.inference.normal import Normal, Taken, chance_of, integrated_out, log_normal
    from pmmkit.inference.propagation import (
        COVERAGE,
        Propagated,
        axes,
        differences,
        displaced,
        root,
        std_along,
    )
    from pmmkit.inference.random_effects import (
        KINDS,
        RepeatedRuns,
        RunEffects,
        by_kind,
        per_column,
        repeatability,
        run_effects,
    )
    from pmmkit.inference.restricted import Restricted
    from pmmkit.inference.sparse import (
        EffectiveSample,
        Resampling,
        Selection,
        SelectionMethod,
        SparseProblem,
        ThresholdPath,
        select_terms,
    )
    from pmmkit.inference.system import FILTERS

__all__ = [
    "COVERAGE",
    "FILTERS",
    "KINDS",
    "LAGS",
    "RANK_TOLERANCE",
    "R_HAT",
    "Collinearity",
    "Consistency",
    "Convergence",
    "EffectiveSample",
    "Equations",
    "InformationRoot",
    "Innovations",
    "LeastSquares",
    "Normal",
    "Propagated",
    "RepeatedRuns",
    "Resampling",
    "Restricted",
    "RunEffects",
    "Selection",
    "SelectionMethod",
    "SparseProblem",
    "Taken",
    "ThresholdPath",
    "autocorrelation",
    "axes",
    "by_kind",
    "chance_of",
    "convergence",
    "dependent",
    "differences",
    "displaced",
    "half_width",
    "innovation_tests",
    "integrated_out",
    "least_squares",
    "log_normal",
    "of_others",
    "of_others_by_hat",
    "optional_columns",
    "per_column",
    "repeatability",
    "room",
    "root",
    "run_effects",
    "select_terms",
    "std_along",
]

lazy(__name__)
