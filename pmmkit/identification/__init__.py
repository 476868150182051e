"""Parameters of a model from measurements other than the programmes that `reduction` takes."""

from pmmkit.identification.forces import Fitted, ForceRecord, fit_to_forces
from pmmkit.identification.from_run import free_records
from pmmkit.identification.methods import Identified, identify
from pmmkit.identification.predict import Prediction, predict, reference
from pmmkit.identification.prior import Prior, prior_of
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.roll import with_roll
from pmmkit.identification.smoother import Smoothed, implied_forces, smooth

__all__ = [
    "Fitted",
    "ForceRecord",
    "FreeRecord",
    "Identified",
    "Prediction",
    "Prior",
    "Smoothed",
    "fit_to_forces",
    "free_records",
    "identify",
    "implied_forces",
    "predict",
    "prior_of",
    "reference",
    "smooth",
    "with_roll",
]
