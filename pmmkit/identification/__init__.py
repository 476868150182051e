"""Parameters of a model from measurements other than the programmes that `reduction` takes."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.identification.as_tested import (
        campaign_without,
        current_of,
        in_words,
        known_faults,
        offsets,
    )
    from pmmkit.identification.binding import FORCES, Binding, bound, driven, places
    from pmmkit.identification.chosen import Chosen, chosen_records, matching
    from pmmkit.identification.comparing import (
        BEFORE,
        UNITS,
        MethodComparison,
        PredictedWindow,
        compare_methods,
        predicted_window,
    )
    from pmmkit.identification.disagreement import disagree
    from pmmkit.identification.figures import parameter_symbol
    from pmmkit.identification.filters import STEP, Filtered, first_state
    from pmmkit.identification.forces import fit_to_forces
    from pmmkit.identification.from_run import free_records
    from pmmkit.identification.known import known_before, parameters_of
    from pmmkit.identification.methods import SECONDS, identify
    from pmmkit.identification.posterior.posterior import Posterior
    from pmmkit.identification.posterior.tree import write_posterior
    from pmmkit.identification.prediction import (
        predict,
        prediction_std,
        reference,
        smoothed_without,
    )
    from pmmkit.identification.prior import Prior, prior_of
    from pmmkit.identification.record import CHANNELS, FreeRecord, title_of
    from pmmkit.identification.roll import with_roll
    from pmmkit.identification.seas import ONE_SEA, other_period, sea_notes
    from pmmkit.identification.smoother import Smoothed, implied_forces, smooth, units
    from pmmkit.identification.trajectory import first_states
    from pmmkit.identification.trials.current import mean_current
    from pmmkit.identification.trials.evaluate import evaluate_trials, mean_draught
    from pmmkit.identification.trials.loading import Corrected, LoadingPrediction
    from pmmkit.identification.trials.table import Trial

__all__ = [
    "BEFORE",
    "CHANNELS",
    "FORCES",
    "ONE_SEA",
    "SECONDS",
    "STEP",
    "UNITS",
    "Binding",
    "Chosen",
    "Corrected",
    "Filtered",
    "FreeRecord",
    "LoadingPrediction",
    "MethodComparison",
    "Posterior",
    "PredictedWindow",
    "Prior",
    "Smoothed",
    "Trial",
    "bound",
    "campaign_without",
    "chosen_records",
    "compare_methods",
    "current_of",
    "disagree",
    "driven",
    "evaluate_trials",
    "first_state",
    "first_states",
    "fit_to_forces",
    "free_records",
    "identify",
    "implied_forces",
    "in_words",
    "known_before",
    "known_faults",
    "matching",
    "mean_current",
    "mean_draught",
    "offsets",
    "other_period",
    "parameter_symbol",
    "parameters_of",
    "places",
    "predict",
    "predicted_window",
    "prediction_std",
    "prior_of",
    "reference",
    "sea_notes",
    "smooth",
    "smoothed_without",
    "title_of",
    "units",
    "with_roll",
    "write_posterior",
]

lazy(__name__)
