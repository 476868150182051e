"""One criterion of IMO MSC.137(76) applied to the numbers of a manoeuvre."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final, Literal

from pmmkit.bibliography import cite
from pmmkit.metrics import (
    HARD_OVER,
    Criterion,
    Metric,
    criteria,
    first_overshoot_limit,
    second_overshoot_limit,
)
from pmmkit.presentation import ABSENT, Described, Grid, Group, Section, fixed
from pmmkit.simulation.imo.conditions import approach_condition, length_condition
from pmmkit.simulation.machinery import FullAstern
from pmmkit.simulation.track import Track

SOURCE: Final = cite("msc137")
Side = Literal["port", "starboard", ""]
UNSETTLED: Final = "not settled"
"""What is said of a criterion where what the number stands on is no ground for a verdict."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Verdict(Described):
    """One criterion applied to one manoeuvre.

    Parameters
    ----------
    criterion : str
        What is limited.
    limit, value : float
        In `unit`.
    margin : float
        Limit less value: positive where the criterion is met.
    passed : bool or None
        None where the track does not reach that far, or the criterion cannot be judged.
    conditions : tuple of str
        Conditions of the standard that this track does not meet, or does not show.
    scale : str
        At which scale and propulsion point the track is.
    unit : str
        ``L`` or ``deg``.
    manoeuvre : str
        In words, with the side.
    probability : float or None
        Share of ships drawn from the uncertainty of the model that meet it.
    side : {"port", "starboard", ""}
        Of the first order; none for a stop.
    full_astern : FullAstern or None
        Of a stop: what is assumed, or was measured, of the engine.
    unsettled : tuple of str
        Why nothing is met or failed by such a number: the model was made by force, sails by
        estimates, or far from where it was tested.
    """

    criterion: str
    limit: float
    value: float
    margin: float
    passed: bool | None
    conditions: tuple[str, ...]
    scale: str
    unit: str = "L"
    manoeuvre: str = ""
    probability: float | None = None
    side: Side = ""
    full_astern: FullAstern | None = None
    unsettled: tuple[str, ...] = ()

    @property
    def settled(self) -> bool:
        """Whether what the number stands on is ground for a verdict."""
        return not self.unsettled

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {**asdict(self), "settled": self.settled}

    @property
    def words(self) -> str:
        """What follows."""
        return (
            {True: "met", False: "NOT met", None: "not judged"}[self.passed]
            if self.settled
            else UNSETTLED
        )

    @property
    def metric(self) -> str:
        """Name of the number that is judged."""
        return next(m.judged(item) for m, item in criteria() if item.name == self.criterion)

    def row(self) -> list[str]:
        """Criterion, manoeuvre, value, limit, margin, what follows, and how probable that is."""
        unit = " L" if self.unit == "L" else "°"
        return [
            self.criterion.replace("_", " "),
            self.manoeuvre,
            f"{fixed(self.value, 2)}{unit}" if math.isfinite(self.value) else ABSENT,
            f"{self.limit:.4g}{unit}",
            fixed(self.margin, 2, signed=True),
            self.words,
            ABSENT if self.probability is None else f"{100 * self.probability:.1f} %",
        ]

    def _headline(self) -> str:
        criterion, manoeuvre, value, limit, _, word, _ = self.row()
        return f"{criterion}, {manoeuvre}: {value}, at most {limit}: {word}"

    def _sections(self) -> Sequence[Section]:
        return verdict_sections([self])


def verdict_sections(verdicts: Sequence[Verdict]) -> list[Section]:
    """Verdicts as a table, and the conditions that stand beside them.

    Parameters
    ----------
    verdicts : sequence of Verdict
        Of one ship.
    """
    head = ["criterion", "manoeuvre", "value", "limit", "margin", "", "probability"]
    rows = [item.row() for item in verdicts]
    scales = dict.fromkeys(f"Scale: {item.scale}" for item in verdicts if item.scale)
    why = dict.fromkeys(text for item in verdicts for text in item.unsettled)
    said = dict.fromkeys(text for item in verdicts for text in item.conditions if text not in why)
    engines = dict.fromkeys(item.full_astern.words for item in verdicts if item.full_astern)
    return [
        Section(paragraphs=[f"Criteria of {SOURCE}", *scales, *why]),
        Section(tables=[Grid(head=head, groups=[Group(rows=rows)], texts=(1,))]),
        *([Section(title="Full astern", points=list(engines))] if engines else []),
        *([Section(title="Conditions", points=list(said))] if said else []),
    ]


def judge(
    metric: Metric,
    criterion: Criterion,
    metrics: Mapping[str, float],
    *,
    L: float,
    speed: float,
    manoeuvre: str,
    scale: str,
    conditions: tuple[str, ...] = (),
    side: Side = "",
    unsettled: tuple[str, ...] = (),
) -> Verdict:
    """A criterion applied to the numbers of a manoeuvre.

    Parameters
    ----------
    metric, criterion : Metric, Criterion
        What is asked of what.
    metrics : mapping of str to float
        Numbers of the manoeuvre.
    L, speed : float
        Ship length [m], test speed [m/s].
    manoeuvre, scale, conditions, side
        As in `Verdict`.
    unsettled : tuple of str
        As in `Verdict`; they are among its conditions.
    """
    limit = criterion.limit_for(L, speed)
    value = metrics.get(metric.judged(criterion), math.nan)
    return Verdict(
        criterion=criterion.name,
        limit=limit,
        value=value,
        margin=limit - value,
        passed=None if math.isnan(value) or unsettled else value <= limit,
        conditions=tuple(dict.fromkeys((*unsettled, *conditions))),
        scale=scale,
        unit="L" if metric.length else metric.unit,
        manoeuvre=manoeuvre,
        side=side,
        unsettled=unsettled,
    )


def zigzag_limits(L: float, speed: float) -> tuple[float, float]:
    """Limits of the first and the second overshoot of a 10/10 zigzag [deg].

    Parameters
    ----------
    L : float
        Ship length [m].
    speed : float
        Test speed [m/s].

    Examples
    --------
    >>> zigzag_limits(175.0, 17.6), zigzag_limits(200.0, 10.0), zigzag_limits(320.0, 7.97)
    ((10.0, 25.0), (15.0, 32.5), (20.0, 40.0))
    """
    time = L / speed
    return first_overshoot_limit(time), second_overshoot_limit(time)


def turning_conditions(
    rudder_deg: float, others: tuple[str, ...], digits: str = "g"
) -> tuple[str, ...]:
    """What one turning circle does not show of the two that the standard asks for."""
    rudder = (
        f"The standard asks for {HARD_OVER:g}° of rudder or the largest permissible; this is "
        f"{abs(rudder_deg):{digits}}°."
    )
    side = "starboard" if rudder_deg > 0 else "port"
    return (
        *([rudder] if abs(abs(rudder_deg) - HARD_OVER) > 0.5 else []),
        *others,
        f"The standard asks for turns to both sides; this is the one to {side}.",
    )


def verdict_of(
    metric: Metric, criterion: Criterion, track: Track, conditions: tuple[str, ...]
) -> Verdict:
    """A criterion applied to a simulated manoeuvre.

    Parameters
    ----------
    metric, criterion : Metric, Criterion
        What is asked of what.
    track : Track
        The manoeuvre.
    conditions : tuple of str
        As in `Verdict`.
    """
    return judge(
        metric,
        criterion,
        track.metrics,
        L=track.L,
        speed=track.speed,
        scale=track.scale,
        conditions=conditions,
        manoeuvre=_sailed(track),
        side=side_of(track.rudder_deg),
        unsettled=track.standing.unsettled,
    )


def side_of(rudder_deg: float) -> Side:
    """The side of a first order; none for rudder amidships."""
    return "" if not rudder_deg else "port" if rudder_deg < 0 else "starboard"


def _sailed(track: Track) -> str:
    """The manoeuvre in words, with the side."""
    to = side_of(track.rudder_deg)
    side = f", to {to}" if to else ""
    angle = f" {abs(track.rudder_deg):g}°" if to else ""
    return f"{track.manoeuvre.replace('_', ' ')}{angle}{side}"


def track_conditions(track: Track, full_speed: float | None = None) -> tuple[str, ...]:
    """Conditions of the standard that a simulated manoeuvre does not meet, or does not show.

    Parameters
    ----------
    track : Track
        The manoeuvre.
    full_speed : float, optional
        Speed at 85 % of the engine's output [m/s].
    """
    ship = length_condition(track.L)
    approach = approach_condition(track.speed, full_speed)
    found = [] if ship.met else [ship.words]
    if not approach.met:
        found.append(approach.words)
    if track.tested and track.tested.below + track.tested.above > 0.0:
        found.append(f"{_sailed(track)}: {track.tested.words}")
    return tuple(found)
