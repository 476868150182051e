"""How the errors of records left out fall with each effect that is added."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING

from pmmkit.diagnosis.findings import UNITS
from pmmkit.diagnosis.free_running.left_out import ERRORS
from pmmkit.loop.evidence import FALLS
from pmmkit.presentation import Described, Grid, Group, Section, counted

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class RecordError:
    """How well records left out are predicted after a step.

    Parameters
    ----------
    step : str
        ``base``, or the effect that was added.
    position, heading, speed, yaw_rate : float
        Root mean square errors over windows with the measured rudder [m, deg, m/s, deg/s]; NaN of
        what was not measured.
    """

    step: str
    position: float = math.nan
    heading: float = math.nan
    speed: float = math.nan
    yaw_rate: float = math.nan

    def of(self, name: str) -> float:
        """The error of one of `left_out.ERRORS`."""
        found: float = getattr(self, name)
        return found


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class RecordFall(Described):
    """How the errors of records left out fall with each step.

    Parameters
    ----------
    errors : tuple of RecordError
        Of the base fitted to the others, and after each effect.
    levels : mapping of str to float
        What noise alone gives: the same errors if nothing were missing after the last step, of
        starts, sensors, values and the unknown forces that are left.
    """

    errors: tuple[RecordError, ...]
    levels: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def steps(self) -> tuple[str, ...]:
        """``base``, then the effects in the order in which they were added."""
        return tuple(item.step for item in self.errors)

    @property
    def measured(self) -> tuple[str, ...]:
        """The errors that the records can tell."""
        return tuple(name for name in ERRORS if not math.isnan(self.errors[0].of(name)))

    @property
    def totals(self) -> tuple[float, ...]:
        """Error of heading [deg]."""
        return tuple(item.heading for item in self.errors)

    @property
    def unit(self) -> str:
        """Of `totals`."""
        return UNITS["heading"]

    @property
    def of(self) -> str:
        """What `totals` are errors of."""
        return "heading"

    @property
    def useless(self) -> tuple[str, ...]:
        """Steps after which nothing is predicted better."""
        return tuple(
            after.step
            for before, after in pairwise(self.errors)
            if not any(after.of(name) <= FALLS * before.of(name) for name in self.measured)
        )

    @property
    def how(self) -> str:
        """What was left out, and what the numbers are, in a sentence."""
        return (
            "Each record was left out of the fit in turn and sailed by what all others say, over "
            "windows with its measured rudder: root mean square error, the noise of the sensors "
            "taken off, beside what a model would leave that lacks nothing."
        )

    def plot(self) -> Figure:
        """Error of left-out records after each step, a panel for each of its kinds."""
        from pmmkit.plotting.records import waterfall

        panels = {name: (name.replace("_", " "), UNITS[name]) for name in self.measured}
        return waterfall(
            self.steps,
            {panel: [item.of(name) for item in self.errors] for name, panel in panels.items()},
            {panels[name]: x for name, x in self.levels.items() if name in panels},
        )

    def table(self) -> Grid:
        """A row per step: errors of position [m], heading [deg], speed [m/s], yaw rate [deg/s]; a
        last row of what noise alone gives."""
        rows = [
            [
                f"+ {item.step}" if place else item.step,
                *(f"{item.of(name):.3g}" for name in self.measured),
            ]
            for place, item in enumerate(self.errors)
        ]
        if self.levels:
            rows.append(["noise alone", *(f"{self.levels[name]:.3g}" for name in self.measured)])
        head = [f"{name.replace('_', ' ')} [{UNITS[name]}]" for name in self.measured]
        return Grid(head=["after", *head], groups=[Group(rows=rows)])

    def remarks(self) -> list[str]:
        """What each step makes better, and which lower no error."""
        said = []
        for before, after in pairwise(self.errors):
            falls = [
                f"{name.replace('_', ' ')} {100 * (after.of(name) / before.of(name) - 1):+.0f} %"
                for name in self.measured
                if before.of(name) > 0.0
            ]
            said.append(f"{after.step}: {', '.join(falls)}.")
        return said + [f"{step} lowers no error of left-out records." for step in self.useless]

    def _headline(self) -> str:
        ends = [f"{item.heading:.3g}°" for item in (self.errors[0], self.errors[-1])]
        return (
            f"heading {' to '.join(dict.fromkeys(ends))} after "
            f"{counted(len(self.errors) - 1, 'step')}"
        )

    def _sections(self) -> Sequence[Section]:
        said = [Section(points=self.remarks())] if self.remarks() else []
        return [Section(title="Error of records left out of the fit", tables=[self.table()]), *said]

    def to_pandas(self) -> pd.DataFrame:
        """A row per step: its errors of records left out [m, deg, m/s, deg/s], and what noise alone
        gives of them after the last (`position_level` …)."""
        import pandas as pd

        levels = {f"{name}_level": self.levels.get(name, math.nan) for name in ERRORS}
        return pd.DataFrame([{**asdict(item), **levels} for item in self.errors])
