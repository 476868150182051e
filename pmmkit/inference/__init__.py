"""Inference that knows nothing of ships: sizes of random effects, and intervals of mixtures."""

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
    "RepeatedRuns",
    "Restricted",
    "RunEffects",
    "by_kind",
    "half_width",
    "per_column",
    "repeatability",
    "run_effects",
]
