"""Figures of sea trials, drawn where the trials are: see `pmmkit.identification.trials.drawing`."""

from pmmkit.identification import trial_figure, trial_path, trial_zigzag

__all__ = ["trial_figure", "trial_path", "trial_zigzag"]
