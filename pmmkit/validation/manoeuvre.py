"""Manoeuvres beside measured ones: turning circles, zigzags, stops."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pmmkit.campaigns import Run
from pmmkit.conventions import metric_of
from pmmkit.identification import Trial
from pmmkit.inference import COVERAGE
from pmmkit.simulation import Track


@dataclass(frozen=True, kw_only=True, eq=False)
class ManoeuvreComparison:
    """One manoeuvre of a trial beside the same one predicted.

    Parameters
    ----------
    run : Run
        The run.
    trial : Trial
        Measured.
    track : Track
        Predicted: simulated by a model with the ship's own steering, or the trial of a submission.
    executed : Track, optional
        Simulated with each execute of a zigzag at the heading of the run, late as it was.
    """

    run: Run
    trial: Trial
    track: Track
    executed: Track | None = None

    @property
    def submitted_run(self) -> str:
        """Id of the run of a submission; empty of a model."""
        return self.track.run if isinstance(self.track, Trial) else ""

    def rows(self) -> list[dict[str, Any]]:
        """A row a measure that both have: measured, predicted, error (predicted less measured),
        expanded uncertainty (of the measured, and of what is submitted)."""
        found = []
        for name, measured in self.trial.metrics.items():
            predicted = self.track.metrics.get(name, math.nan)
            if math.isnan(measured) or math.isnan(predicted):
                continue
            doubt = COVERAGE * math.hypot(self.trial.std.get(name, math.nan), self._std(name))
            error = predicted - measured
            late = math.nan if self.executed is None else self.executed.metrics.get(name, math.nan)
            found.append(
                {
                    "run": self.run.id,
                    "test": self.run.test,
                    "speed": self.run.settings.speed,
                    "measure": name,
                    "unit": metric_of(name).unit_of(name),
                    "measured": measured,
                    "predicted": predicted,
                    "error": error,
                    "relative": error / measured if measured else math.nan,
                    "uncertainty": doubt,
                    "ratio": abs(error) / doubt if doubt else math.nan,
                    "as_executed": late,
                    "error_as_executed": late - measured,
                }
            )
        return found

    def _std(self, name: str) -> float:
        """Standard uncertainty of a predicted measure: a model states none."""
        return self.track.std.get(name, math.nan) if isinstance(self.track, Trial) else 0.0
