"""Inference that knows nothing of ships.

Sizes of random effects, intervals of mixtures, least squares and sparse regression.
"""

from pmmkit.inference.collinear import Collinearity
from pmmkit.inference.equations import Equations, unit_covariance
from pmmkit.inference.mixture import half_width
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
    Elimination,
    Resampling,
    Selection,
    SelectionMethod,
    SparseProblem,
    ThresholdPath,
    select_terms,
)

__all__ = [
    "KINDS",
    "Collinearity",
    "EffectiveSample",
    "Elimination",
    "Equations",
    "RepeatedRuns",
    "Resampling",
    "Restricted",
    "RunEffects",
    "Selection",
    "SelectionMethod",
    "SparseProblem",
    "ThresholdPath",
    "by_kind",
    "half_width",
    "per_column",
    "repeatability",
    "run_effects",
    "select_terms",
    "unit_covariance",
]
