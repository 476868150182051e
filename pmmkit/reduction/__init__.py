"""From forces to derivatives: means, harmonics, balance, regression, uncertainty."""

from pmmkit.reduction.prepare import RunResult, prepare
from pmmkit.reduction.reduce import Reduction, reduce_campaign

__all__ = ["Reduction", "RunResult", "prepare", "reduce_campaign"]
