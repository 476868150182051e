"""Manoeuvres beside measured ones: turning circles, zigzags, stops."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from pmmkit.campaigns.run import Run
from pmmkit.inference import COVERAGE
from pmmkit.metrics import unit_of
from pmmkit.simulation import Track
from pmmkit.trials import Trial


@dataclass(frozen=True, kw_only=True, eq=False)
class Manoeuvre:
    """One manoeuvre of a trial beside the same one predicted.

    Parameters
    ----------
    run : Run
        The run.
    trial : Trial
        Measured.
    track : Track
        Predicted: simulated by a model with the ship's own steering, or submitted.
    executed : Track, optional
        Simulated with each execute of a zigzag at the heading of the run, late as it was.
    submitted_run : str
        Id of the run of a submission; empty of a model.
    std : mapping of str to float
        Standard uncertainties of the measures of a submission; empty of a model, which states none.
    """

    run: Run
    trial: Trial
    track: Track
    executed: Track | None = None
    submitted_run: str = ""
    std: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

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
                    "unit": unit_of(name),
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
        return self.std.get(name, math.nan) if self.submitted_run else 0.0
