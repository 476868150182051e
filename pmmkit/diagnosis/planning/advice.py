"""What to do next: a run, as often as it is to be made, and what is expected of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pmmkit.diagnosis.planning.options import Option
from pmmkit.diagnosis.planning.plan_file import entries_text

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.diagnosis.planning.programme import TestPlan


@dataclass(frozen=True, kw_only=True)
class NextRun:
    """One run that could be made next.

    `gain`: what it is made for: expected gain in ln odds of the true rival over the others; or,
    where effects are to be made visible, how many become so. `gains`: by rival, if it is the
    true one, its expected gain in ln odds over the nearest other; by effect, its squared signal
    over noise after the run. `resolves`: probability that the true rival stands alone
    afterwards; NaN where effects are to be shown. `repeats`: how often the run is to be made.
    `hours`: time of all repeats [h]. `words`: the run and what is expected of it. `after`:
    expected ln odds of the true rival over the nearest other once the run is made; NaN where
    effects are to be shown.
    """

    option: Option
    gain: float
    gains: Mapping[str, float]
    resolves: float
    repeats: int
    hours: float
    words: str
    after: float = math.nan


@dataclass(frozen=True, kw_only=True)
class Advice:
    """What to do next.

    Parameters
    ----------
    rivals : tuple of str
        Sets of effects that the tests cannot tell apart, or what is suspected and nothing; empty
        where effects are to be shown.
    wanted : tuple of str
        Effects that the advice is about.
    runs : tuple of NextRun
        Worth their time, the best first; repeats where no single run is.
    checks : mapping of str to str
        Checks at the bench or on the rig, by effect.
    words : str
        The advice.
    captive : TestPlan, optional
        Where no manoeuvre tells rivals apart: captive tests that do.
    notes : tuple of str
        What is taken for granted: how time is counted, the weather.
    """

    rivals: tuple[str, ...]
    wanted: tuple[str, ...]
    runs: tuple[NextRun, ...]
    checks: Mapping[str, str]
    words: str
    captive: TestPlan | None = None
    notes: tuple[str, ...] = ()

    @property
    def options(self) -> tuple[Option, ...]:
        """The best run, as often as it is to be made; captive tests where no run is worth it."""
        if self.captive is not None:
            return self.captive.options
        return tuple(item.option for item in self.runs[:1] for _ in range(item.repeats))

    @property
    def entries(self) -> str:
        """The runs as ``[[runs]]`` that can be pasted into a campaign file."""
        return entries_text(self.options)

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit plan --json`` prints of the next run."""
        return {
            "words": self.words,
            "rivals": self.rivals,
            "wanted": self.wanted,
            "runs": [
                {
                    **item.option.entry,
                    "repeats": item.repeats,
                    "gain": item.gain,
                    "gains": item.gains,
                    "after": item.after,
                    "resolves": item.resolves,
                    "hours": item.hours,
                    "words": item.words,
                }
                for item in self.runs
            ],
            "checks": self.checks,
            "notes": self.notes,
            **({} if self.captive is None else {"captive": self.captive.to_dict()}),
        }

    def to_pandas(self) -> pd.DataFrame:
        """A row per run: settings, gain, hours, probability that it resolves."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "run": item.option.id,
                    "test": item.option.test,
                    "speed": item.option.settings.speed,
                    "repeats": item.repeats,
                    "gain": item.gain,
                    "after": item.after,
                    "resolves": item.resolves,
                    "hours": item.hours,
                    "words": item.words,
                }
                for item in self.runs
            ]
        )
