"""Inference that knows nothing of ships: linear Gaussian evidence, random effects, mixtures."""

from pmmkit.inference.left_out import of_others, of_others_by_hat
from pmmkit.inference.mixture import half_width
from pmmkit.inference.normal import Normal, Taken, chance_of, integrated_out, log_normal
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
    "Normal",
    "RepeatedRuns",
    "Restricted",
    "RunEffects",
    "Taken",
    "by_kind",
    "chance_of",
    "half_width",
    "integrated_out",
    "log_normal",
    "of_others",
    "of_others_by_hat",
    "per_column",
    "repeatability",
    "run_effects",
]
