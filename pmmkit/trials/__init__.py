"""Sea trials: measures of turning circles, zigzags and stops from positions and heading."""

from pmmkit.trials.circle import Circle, fit_circle
from pmmkit.trials.current import Current
from pmmkit.trials.evaluate import evaluate, evaluate_trials
from pmmkit.trials.noise import PositionNoise
from pmmkit.trials.record import Record, read_record
from pmmkit.trials.table import Trial, Wind

__all__ = [
    "Circle",
    "Current",
    "PositionNoise",
    "Record",
    "Trial",
    "Wind",
    "evaluate",
    "evaluate_trials",
    "fit_circle",
    "read_record",
]
