"""From forces to derivatives: means, harmonics, balance, regression, uncertainty."""

from pmmkit.observations.prepare import RunResult, prepare
from pmmkit.reduction.depths import reduce_depths
from pmmkit.reduction.monte_carlo import monte_carlo
from pmmkit.reduction.reduce import Reduction, reduce_campaign
from pmmkit.reduction.shares import contributions

__all__ = [
    "Reduction",
    "RunResult",
    "contributions",
    "monte_carlo",
    "prepare",
    "reduce_campaign",
    "reduce_depths",
]
