"""From a model to the right-hand side of its equations of motion."""

from pmmkit.kernel.program import (
    CALM,
    Conditions,
    Prepared,
    mass_problem,
    packed,
    prepare,
    propulsion_problem,
    stacked,
    values_at,
)

__all__ = [
    "CALM", "Conditions", "Prepared", "mass_problem", "packed", "prepare", "propulsion_problem",
    "stacked", "values_at",
]  # fmt: skip
