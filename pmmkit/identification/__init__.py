"""Parameters of a model from measurements other than the programmes that `reduction` takes."""

from pmmkit.identification.forces import Fitted, ForceRecord, fit_to_forces

__all__ = ["Fitted", "ForceRecord", "fit_to_forces"]
