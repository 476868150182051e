"""Inference that knows nothing of ships: evidence, errors, filters, propagation, sparsity."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.inference.equations import Equations
    from pmmkit.inference.innovations import Consistency, Innovations
    from pmmkit.inference.linear_fit import RANK_TOLERANCE, LeastSquares, dependent, of_others
    from pmmkit.inference.normal import InformationRoot, Normal, Taken, log_normal
    from pmmkit.inference.propagation import COVERAGE, Propagated, Stencil, root, std_along
    from pmmkit.inference.random_effects import Restricted, RunEffects
    from pmmkit.inference.sparse import (
        EffectiveSample,
        Resampling,
        Selection,
        SelectionMethod,
        SparseProblem,
        ThresholdPath,
    )
    from pmmkit.inference.system import FILTERS

__all__ = [
    "COVERAGE",
    "FILTERS",
    "RANK_TOLERANCE",
    "Consistency",
    "EffectiveSample",
    "Equations",
    "InformationRoot",
    "Innovations",
    "LeastSquares",
    "Normal",
    "Propagated",
    "Resampling",
    "Restricted",
    "RunEffects",
    "Selection",
    "SelectionMethod",
    "SparseProblem",
    "Stencil",
    "Taken",
    "ThresholdPath",
    "dependent",
    "log_normal",
    "of_others",
    "root",
    "std_along",
]

lazy(__name__)
