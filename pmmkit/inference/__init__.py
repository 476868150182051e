"""Inference that knows nothing of ships: random effects, mixtures, propagation of uncertainty."""

from pmmkit.inference.mixture import half_width
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

__all__ = [
    "COVERAGE",
    "KINDS",
    "Propagated",
    "RepeatedRuns",
    "Restricted",
    "RunEffects",
    "axes",
    "by_kind",
    "differences",
    "displaced",
    "half_width",
    "per_column",
    "repeatability",
    "root",
    "run_effects",
    "std_along",
]
