"""Figures of sea trials, drawn where the trials are: see `pmmkit.trials.drawing`."""

from pmmkit.trials.drawing import trial_figure, trial_path, trial_zigzag

__all__ = ["trial_figure", "trial_path", "trial_zigzag"]
