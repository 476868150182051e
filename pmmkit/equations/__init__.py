"""From a model to the right-hand side of its equations of motion."""

from pmmkit.equations.prepared import CALM, Conditions, Prepared, prepare

__all__ = ["CALM", "Conditions", "Prepared", "prepare"]
