"""What a sea trial gives: measures with their uncertainties and the limits beside them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pmmkit.conventions import METRICS, Metric
from pmmkit.identification.trials.current import Current, mean_current
from pmmkit.identification.trials.path import PositionNoise
from pmmkit.imo import Condition, Verdict
from pmmkit.numerics import Array
from pmmkit.presentation import ABSENT, WIDE, Grid, Group, Section, number, plus_minus
from pmmkit.simulation import Track

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure


@dataclass(frozen=True, kw_only=True)
class Wind:
    """Mean true wind of a run.

    `speed`: speed of the mean wind [m/s]. `direction_deg`: where it comes from, from the x axis
    of the record (north) towards y (east) [deg]. `spread`: standard deviation of the speed
    [m/s].
    """

    speed: float
    direction_deg: float
    spread: float

    def __str__(self) -> str:
        spread = f"(standard deviation {self.spread:.1f} m/s)"
        return f"{self.speed:.1f} m/s from {self.direction_deg:03.0f}° {spread}"


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Trial(Track):
    """A turning circle, zigzag or stop as it was measured: a `Track` with its uncertainties.

    Parameters
    ----------
    t, x, y, psi : array (n,)
        Time from the order, negative in the approach [s]; path of midship along and to starboard
        of the approach without the current [m], heading from that of the approach [rad].
    u, v, r : array (n,)
        Velocities through the water, by parabolas through the fixes [m/s, rad/s].
    p, phi, delta, n : array (n,)
        Of a `Track`; NaN where they were not recorded.
    speed : float
        Of the approach through the water, as far as the current is known [m/s].
    rudder_deg : float
        Ordered rudder as it was reached, positive to starboard [deg].
    metrics : mapping of str to float
        Numbers by the names that `simulate` gives them; NaN where the record does not show them.
    name, manoeuvre, L, Fn, scale, notes, orders, settings, tested, standing, forces
        Of a `Track`.
    run : str
        Id of the run.
    speed_std : float
        Standard uncertainty of the approach speed [m/s].
    heading_deg : float
        Of the approach [deg].
    order : float
        Instant of the order on the clock of the record [s].
    rudder_rate_deg : float
        At which the rudder was laid [deg/s]; NaN where the record holds orders and no angles.
    reversals : tuple of float
        Heading at each reversal of a zigzag, to the side that the ship turned to [deg].
    std : mapping of str to float
        Standard uncertainties of the metrics.
    verdicts : tuple of Verdict
        Criteria of IMO MSC.137(76) that the run is judged by.
    conditions : tuple of Condition
        What the standard asks of a trial, and what this one was.
    revolutions : float
        Of the approach [1/s]; NaN where they were not recorded.
    current : Current or None
        The current that was removed.
    equal_headings : Current or None
        The same by the drift between equal headings of a turn of 540° or more, to compare with.
    turned_deg : float
        Change of heading of a turning circle [deg].
    wind : Wind or None
        Mean true wind.
    noise : PositionNoise
        Of the fixes.
    x_ground, y_ground : array (n,)
        The path as measured [m].
    """

    FULL_TURN: ClassVar[float] = 720.0
    """Change of heading of a turning circle that MSC/Circ.1053 asks for [deg]."""

    run: str
    speed_std: float
    heading_deg: float
    order: float
    std: Mapping[str, float]
    rudder_rate_deg: float = math.nan
    reversals: tuple[float, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    conditions: tuple[Condition, ...] = ()
    revolutions: float = math.nan
    current: Current | None = None
    equal_headings: Current | None = None
    turned_deg: float = math.nan
    wind: Wind | None = None
    noise: PositionNoise = field(default_factory=lambda: PositionNoise(fast=0.0))
    x_ground: Array
    y_ground: Array

    @staticmethod
    def mean_current(trials: Iterable[Trial]) -> Current | None:
        """Weighted mean of the currents of turning circles in the same axes; None of none."""
        return mean_current({x.run: x.current for x in trials if x.current is not None})

    def resized(self, L: float, speed: float) -> Self:
        """As of a track, with the uncertainties and the path as measured."""
        length, pace = L / self.L, speed / self.speed
        time = length / pace
        return replace(
            super().resized(L, speed),
            speed_std=self.speed_std * pace,
            order=self.order * time,
            rudder_rate_deg=self.rudder_rate_deg / time,
            std=self.scaled(self.std, length, pace),
            x_ground=self.x_ground * length,
            y_ground=self.y_ground * length,
        )

    def plot(self) -> Figure:
        """The path with its measures; of a zigzag the heading and the rudder over time.

        Raises
        ------
        DataError
            If the record holds nothing after the order.
        """
        from pmmkit.identification.trials.drawing import trial_figure

        return trial_figure(self)

    def rows(self) -> list[dict[str, Any]]:
        """A row a measure: run, measure, value, std, unit, limit and whether it is met."""
        limits = {verdict.metric: verdict for verdict in self.verdicts}
        found = []
        for name, value in self.metrics.items():
            verdict = limits.get(name)
            found.append(
                {
                    "run": self.run,
                    "test": self.manoeuvre,
                    "measure": name,
                    "value": value,
                    "std": self.std.get(name, math.nan),
                    "unit": Metric.of(name).unit_of(name),
                    "limit": math.nan if verdict is None else verdict.limit,
                    "passed": None if verdict is None else verdict.passed,
                    "probability": None if verdict is None else verdict.probability,
                }
            )
        return found

    def _headline(self) -> str:
        rudder = "" if self.manoeuvre == "stopping" else f", rudder {self.rudder_deg:+.1f}°"
        approach = f"{self.speed:.2f}"
        if math.isfinite(self.speed_std) and self.speed_std > 0.0:
            approach = plus_minus(self.speed, WIDE * self.speed_std)
        on = f"{self.heading_deg:05.1f}°"
        return f"{self.run}: {self.manoeuvre}{rudder}, approach {approach} m/s on {on}"

    def _sections(self) -> Sequence[Section]:
        words = [f"{self.name}, L = {self.L:g} m; order at t = {self.order:.1f} s"]
        if self.current is not None:
            half = WIDE * self.current.speed_std
            words.append(
                f"Current {plus_minus(self.current.speed, half)} m/s to "
                f"{self.current.direction_deg:03.0f}° ({self.current.origin})"
            )
        if self.equal_headings is not None:
            words.append(
                f"By the drift of equal headings {self.equal_headings.speed:.3f} m/s to "
                f"{self.equal_headings.direction_deg:03.0f}°"
            )
        if self.wind is not None:
            words.append(f"Wind {self.wind}")
        words += [item.full_astern.words for item in self.verdicts if item.full_astern]
        conditions = dict.fromkeys(text for item in self.verdicts for text in item.conditions)
        notes = [*self.notes, *conditions]
        return [
            Section(paragraphs=words),
            Section(title="Measures", tables=[self._measures()]),
            *([Section(title="Notes", points=notes)] if notes else []),
        ]

    def _measures(self) -> Grid:
        """The measures that a trial tells beside their limits; `rows` has all."""
        limits = {verdict.metric: verdict for verdict in self.verdicts}
        rows = [
            [*self._cells(name), *_limit(limits.get(f"{name}_L", limits.get(name)))]
            for name in METRICS.told("trial", self.metrics)
        ]
        head = ["measure", "value", "std", "in L", "limit", ""]
        return Grid(head=head, groups=[Group(rows=rows)])

    def _cells(self, name: str) -> list[str]:
        value, std, unit = self.metrics[name], self.std[name], Metric.of(name).unit_of(name)
        digits = 3 if unit == "-" else 1
        shown = "°" if unit == "deg" else "" if unit == "-" else f" {unit}"
        label = Metric.in_words(name)
        if not math.isfinite(value):
            return [label, ABSENT, ABSENT, ABSENT]
        length = self.metrics.get(f"{name}_L")
        return [
            label,
            f"{value:.{digits}f}{shown}",
            f"{number(std, 2)}{shown}",
            "" if length is None else f"{length:.2f} L",
        ]

    def to_pandas(self) -> pd.DataFrame:
        """The rows as a table."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit trial --json`` prints of a run."""
        return {
            "run": self.run,
            "test": self.manoeuvre,
            "L": self.L,
            "speed": self.speed,
            "speed_std": self.speed_std,
            "heading_deg": self.heading_deg,
            "rudder_deg": self.rudder_deg,
            "order": self.order,
            "orders": list(self.orders),
            "metrics": dict(self.metrics),
            "std": dict(self.std),
            "revolutions": self.revolutions,
            "current": None if self.current is None else self.current.to_dict(),
            "equal_headings": (
                None if self.equal_headings is None else self.equal_headings.to_dict()
            ),
            "turned_deg": self.turned_deg,
            "conditions": [asdict(item) for item in self.conditions],
            "wind": None if self.wind is None else asdict(self.wind),
            "noise": asdict(self.noise),
            "imo": [verdict.to_dict() for verdict in self.verdicts],
            "notes": list(self.notes),
        }

    def path(self) -> pd.DataFrame:
        """The path, the heading and the rudder over time."""
        import pandas as pd

        names = ("t", "x", "y", "psi", "x_ground", "y_ground", "delta")
        return pd.DataFrame({name: getattr(self, name) for name in names})


def _limit(verdict: Verdict | None) -> list[str]:
    return ["", ""] if verdict is None else [verdict.row()[3], verdict.words]


class Measures:
    """Numbers with their standard uncertainties, as they are collected."""

    def __init__(self, L: float) -> None:
        self.L = L
        self.values: dict[str, float] = {}
        self.stds: dict[str, float] = {}

    def add(self, name: str, value: float, std: float) -> None:
        """A number; a length also in ship lengths."""
        self.values[name], self.stds[name] = float(value), float(std)
        if Metric.of(name).length:
            self.values[name + Metric.IN_LENGTHS] = float(value / self.L)
            self.stds[name + Metric.IN_LENGTHS] = float(std / self.L)

    def frozen(self) -> tuple[Mapping[str, float], Mapping[str, float]]:
        """The numbers and their uncertainties, read-only."""
        return MappingProxyType(self.values), MappingProxyType(self.stds)
