"""Inference that knows nothing of ships: random effects, mixtures, Kalman filters and smoother."""

from pmmkit.inference.information_filter import InformationRoot
from pmmkit.inference.innovations import (
    LAGS,
    Consistency,
    Innovations,
    autocorrelation,
    innovation_tests,
)
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

__all__ = [
    "KINDS",
    "LAGS",
    "Consistency",
    "InformationRoot",
    "Innovations",
    "RepeatedRuns",
    "Restricted",
    "RunEffects",
    "autocorrelation",
    "by_kind",
    "half_width",
    "innovation_tests",
    "per_column",
    "repeatability",
    "run_effects",
]
