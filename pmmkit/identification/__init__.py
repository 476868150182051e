"""Parameters of a model from measurements other than the programmes that `reduction` takes."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.identification.as_tested import RecordOffsets
    from pmmkit.identification.binding import Binding, places
    from pmmkit.identification.chosen import Chosen
    from pmmkit.identification.comparing import MethodComparison, PredictedWindow, compare_methods
    from pmmkit.identification.filters import Filtered
    from pmmkit.identification.forces import fit_to_forces
    from pmmkit.identification.from_run import free_records
    from pmmkit.identification.known import known_before
    from pmmkit.identification.methods import identify
    from pmmkit.identification.posterior.posterior import Posterior
    from pmmkit.identification.prediction import Prediction
    from pmmkit.identification.prior import Prior
    from pmmkit.identification.record import ONE_SEA, FreeRecord, other_period, sea_notes
    from pmmkit.identification.roll import with_roll
    from pmmkit.identification.smoother import Smoothed
    from pmmkit.identification.trials.evaluate import evaluate_trials
    from pmmkit.identification.trials.loading import Corrected, LoadingPrediction
    from pmmkit.identification.trials.table import Trial

__all__ = [
    "ONE_SEA",
    "Binding",
    "Chosen",
    "Corrected",
    "Filtered",
    "FreeRecord",
    "LoadingPrediction",
    "MethodComparison",
    "Posterior",
    "PredictedWindow",
    "Prediction",
    "Prior",
    "RecordOffsets",
    "Smoothed",
    "Trial",
    "compare_methods",
    "evaluate_trials",
    "fit_to_forces",
    "free_records",
    "identify",
    "known_before",
    "other_period",
    "places",
    "sea_notes",
    "with_roll",
]

lazy(__name__)
