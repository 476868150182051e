"""One criterion of IMO MSC.137(76) applied to the numbers of a manoeuvre."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Final, Literal, Self

import numpy as np

from pmmkit.conventions import METRICS, Criterion, Metric, cite
from pmmkit.imo.conditions import Condition
from pmmkit.numerics import Array
from pmmkit.presentation import ABSENT, Described, Grid, Group, Section, fixed, number
from pmmkit.simulation import Track

# The engine in a full astern stop: what of it is assumed, and what a trial showed.


THERE: Final = 0.02
"""Revolutions this near those ordered, as a share of the approach's, count as reached."""


@dataclass(frozen=True, kw_only=True)
class FullAstern:
    """The engine in a full astern stop, which the standard does not say.

    Parameters
    ----------
    turns : float
        Revolutions astern over those of the approach, negative: as ordered, or as measured.
    reversal_s : float
        Time from the order until they are reached, or the bucket is down [s]; NaN where they
        never are.
    most : float
        The farthest astern that the revolutions went, over those of the approach.
    torque : float, optional
        Largest torque astern over that of the approach, where somebody states it.
    measured : bool
        Whether a trial shows it; else it is stated or assumed.
    assumed : str
        What is assumed of the engine and of the propeller astern, in sentences.
    low, high : float
        95 % band of the track reach [L] of ships that differ as far as is known; NaN where it was
        not asked for.
    bucket : bool
        Whether a bucket turns the thrust: then the size of the revolutions counts.
    """

    turns: float
    reversal_s: float
    most: float = math.nan
    torque: float | None = None
    measured: bool = False
    assumed: str = ""
    low: float = math.nan
    high: float = math.nan
    bucket: bool = False

    @classmethod
    def of_a_stop(cls, t: Array, n: Array, ahead: float) -> Self | None:
        """What the engine did in a measured stop; None where the propeller never turns astern.

        Parameters
        ----------
        t, n, ahead
            As for `reached`, until the ship stops.

        Notes
        -----
        The revolutions are the median of the second half of the time in which they are astern.
        """
        astern = np.flatnonzero(n < 0.0)
        if not len(astern):
            return None
        turns = float(np.median(n[astern[len(astern) // 2 :]])) / ahead
        return cls(turns=turns, reversal_s=reached(t, n, ahead, turns), measured=True)

    @property
    def words(self) -> str:
        """What the engine did, what of it is assumed, and what that leaves open.

        Examples
        --------
        >>> print(FullAstern(turns=-0.62, reversal_s=44.6, measured=True).words)
        Full astern was -0.62 of the approach's revolutions, reached 45 s after the order.
        """
        when = (
            f"reached {self.reversal_s:.0f} s after the order"
            if math.isfinite(self.reversal_s)
            else f"never reached (at most {self.most:.2g})"
        )
        if self.measured:
            return f"Full astern was {self.turns:.2g} of the approach's revolutions, {when}."
        done = (
            f"the bucket down, {self.reversal_s:.0f} s after the order, and pumps at "
            f"{abs(self.turns):g} of the approach's revolutions"
            if self.bucket
            else f"{self.turns:g} of the approach's revolutions, {when}"
        )
        said = [f"Full astern is {done}; the standard does not say it.", self.assumed, self._band]
        return " ".join(text for text in said if text)

    @property
    def _band(self) -> str:
        """The track reach of ships that differ as far as is known."""
        if math.isnan(self.low):
            return ""
        return (
            f"Track reach of 95 % of such ships: {number(self.low, 3)} to {number(self.high, 3)} L."
        )


def reached(t: Array, n: Array, ahead: float, turns: float) -> float:
    """When revolutions astern are reached [s]; NaN where they never are.

    t, n (m,); t, n [s]; ahead [1/s].

    Examples
    --------
    >>> t = np.arange(0.0, 200.0)
    >>> reached(t, np.clip(1.5 - 0.05 * t, -0.9, 1.5), 1.5, -0.6)
    48.0
    """
    there = n <= (turns + THERE) * ahead
    return float(t[int(np.argmax(there))]) if there.any() else math.nan


Side = Literal["port", "starboard", ""]


@dataclass(frozen=True, kw_only=True, repr=False)
class Verdict(Described):
    """One criterion applied to one manoeuvre.

    Parameters
    ----------
    criterion : str
        What is limited.
    limit, value : float
        In `unit`; the value NaN where the track does not reach that far.
    conditions : tuple of str
        Conditions of the standard that this track does not meet, or does not show.
    scale : str
        At which scale and propulsion point the track is.
    unit : str
        ``L`` or ``deg``.
    manoeuvre : str
        In words, with the side.
    probability : float or None
        Share of ships drawn from the uncertainty of the model that meet it; of a trial that of
        values within the standard uncertainty of what was measured.
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
    conditions: tuple[str, ...]
    scale: str
    unit: str = "L"
    manoeuvre: str = ""
    probability: float | None = None
    side: Side = ""
    full_astern: FullAstern | None = None
    unsettled: tuple[str, ...] = ()
    UNSETTLED: ClassVar[str] = "not settled"
    """What is said where what the number stands on is no ground for a verdict."""
    LARGE: ClassVar[str] = (
        "The administration may allow up to 20 L for ships of large displacement."
    )
    """What stands beside the track reach of a stop."""

    @property
    def margin(self) -> float:
        """Limit less value: positive where the criterion is met."""
        return self.limit - self.value

    @property
    def passed(self) -> bool | None:
        """Whether it is met; None where there is no value, or no ground for a verdict."""
        return None if math.isnan(self.value) or self.unsettled else self.value <= self.limit

    @property
    def settled(self) -> bool:
        """Whether what the number stands on is ground for a verdict."""
        return not self.unsettled

    def carried(self, factor: float, std: float, unsettled: tuple[str, ...] = ()) -> Verdict:
        """The verdict on the value times a factor.

        Parameters
        ----------
        factor : float
            By which the value is multiplied.
        std : float
            Standard uncertainty of the value before [L or deg].
        unsettled : tuple of str
            Why the factor is no ground for a verdict.
        """
        value = self.value * factor
        return replace(
            self,
            value=value,
            probability=probability_within(self.limit - value, std * factor),
            conditions=tuple(dict.fromkeys((*unsettled, *self.conditions))),
            unsettled=(*self.unsettled, *unsettled),
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        judged = {
            name: getattr(self, name)
            for name in ("criterion", "limit", "value", "margin", "passed")
        }
        return judged | asdict(self) | {"settled": self.settled}

    @property
    def words(self) -> str:
        """What follows."""
        return self.what_follows(self.passed, settled=self.settled)

    @classmethod
    def what_follows(cls, passed: bool | None, *, settled: bool) -> str:
        """What is said of a criterion that is met, failed or not judged, on such ground."""
        words = {True: "met", False: "NOT met", None: "not judged"}
        return words[passed] if settled else cls.UNSETTLED

    @staticmethod
    def in_unit(text: str, unit: str) -> str:
        """A number of a criterion with its unit, ``L`` or ``deg``."""
        return f"{text}{' L' if unit == 'L' else '°'}"

    @property
    def metric(self) -> str:
        """Name of the number that is judged."""
        return next(m.judged(item) for m, item in METRICS.criteria if item.name == self.criterion)

    def row(self) -> list[str]:
        """Criterion, manoeuvre, value, limit, margin, what follows, and how probable that is."""
        return [
            self.criterion.replace("_", " "),
            self.manoeuvre,
            self.in_unit(fixed(self.value, 2), self.unit) if math.isfinite(self.value) else ABSENT,
            self.in_unit(f"{self.limit:.4g}", self.unit),
            fixed(self.margin, 2, signed=True),
            self.words,
            ABSENT if self.probability is None else f"{100 * self.probability:.1f} %",
        ]

    def _headline(self) -> str:
        criterion, manoeuvre, value, limit, _, word, _ = self.row()
        return f"{criterion}, {manoeuvre}: {value}, at most {limit}: {word}"

    def _sections(self) -> Sequence[Section]:
        return verdict_sections([self])


def probability_within(margin: float, std: float) -> float | None:
    """Probability that a normal value with that margin to its limit is within it.

    Examples
    --------
    >>> probability_within(0.0, 1.0), round(probability_within(1.959964, 1.0), 4)
    (0.5, 0.975)
    >>> probability_within(1.0, 0.0)
    """
    if not (math.isfinite(margin) and std > 0.0):
        return None
    return 0.5 * (1.0 + math.erf(margin / std / math.sqrt(2.0)))


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
        Section(paragraphs=[f"Criteria of {cite('msc137')}", *scales, *why]),
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
    rudder_deg: float = 0.0,
    switch_deg: float | None = None,
    std: Mapping[str, float] | None = None,
    conditions: tuple[str, ...] = (),
    unsettled: tuple[str, ...] = (),
    alone: bool = False,
    measured: bool = False,
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
    manoeuvre : str
        Its name.
    scale, conditions
        As in `Verdict`.
    rudder_deg : float
        Positive to starboard, 0 where the rudder is not laid [deg].
    switch_deg : float, optional
        Heading at which a zigzag switches [deg].
    std : mapping of str to float, optional
        Standard uncertainties of numbers that were measured.
    unsettled : tuple of str
        As in `Verdict`; they are among its conditions.
    alone : bool
        Whether a turning circle stands without that to the other side.
    measured : bool
        Whether the angles were measured: then they are rounded in words.
    """
    limit = criterion.limit_for(L, speed)
    name = metric.judged(criterion)
    value = metrics.get(name, math.nan)
    if alone:
        conditions = _turning_conditions(rudder_deg, conditions, ".1f" if measured else "g")
    if measured:
        rudder = float(round(rudder_deg))
        switch_deg = None if switch_deg is None else float(round(switch_deg))
    else:
        rudder = rudder_deg
    return Verdict(
        criterion=criterion.name,
        limit=limit,
        value=value,
        conditions=tuple(dict.fromkeys((*unsettled, *conditions))),
        scale=scale,
        unit="L" if metric.length else metric.unit,
        manoeuvre=manoeuvre_words(manoeuvre, rudder, switch_deg),
        probability=probability_within(limit - value, (std or {}).get(name, math.nan)),
        side=_side_of(rudder_deg),
        unsettled=unsettled,
    )


def _turning_conditions(rudder_deg: float, others: tuple[str, ...], digits: str) -> tuple[str, ...]:
    """What one turning circle does not show of the two that the standard asks for."""
    rudder = (
        f"The standard asks for {Criterion.HARD_OVER:g}° of rudder or the largest permissible; "
        f"this is {abs(rudder_deg):{digits}}°."
    )
    side = "starboard" if rudder_deg > 0 else "port"
    return (
        *([rudder] if abs(abs(rudder_deg) - Criterion.HARD_OVER) > 0.5 else []),
        *others,
        f"The standard asks for turns to both sides; this is the one to {side}.",
    )


def verdict_of(
    metric: Metric,
    criterion: Criterion,
    track: Track,
    conditions: tuple[str, ...],
    *,
    alone: bool = False,
) -> Verdict:
    """A criterion applied to a simulated manoeuvre."""
    return judge(
        metric,
        criterion,
        track.metrics,
        L=track.L,
        speed=track.speed,
        scale=track.scale,
        conditions=conditions,
        manoeuvre=track.manoeuvre,
        rudder_deg=track.rudder_deg,
        switch_deg=track.settings.get("switch_deg"),
        unsettled=track.standing.unsettled,
        alone=alone,
    )


def _side_of(rudder_deg: float) -> Side:
    """The side of a first order; none for rudder amidships."""
    return "" if not rudder_deg else "port" if rudder_deg < 0 else "starboard"


def manoeuvre_words(manoeuvre: str, rudder_deg: float, switch_deg: float | None = None) -> str:
    """A manoeuvre with its angles and the side of the first order.

    Parameters
    ----------
    manoeuvre : str
        Its name.
    rudder_deg : float
        Of the first order, positive to starboard; 0 where the rudder is not laid [deg].
    switch_deg : float, optional
        Heading at which a zigzag switches [deg].

    Examples
    --------
    >>> manoeuvre_words("turning", -35.0), manoeuvre_words("zigzag", 10.0, 10.0)
    ('turning 35°, to port', 'zigzag 10/10, to starboard')
    """
    words = manoeuvre.replace("_", " ")
    if not rudder_deg:
        return words
    angles = f"{abs(rudder_deg):g}" + ("°" if switch_deg is None else f"/{switch_deg:g}")
    return f"{words} {angles}, to {_side_of(rudder_deg)}"


def _sailed(track: Track) -> str:
    return manoeuvre_words(track.manoeuvre, track.rudder_deg, track.settings.get("switch_deg"))


def track_conditions(
    track: Track, conditions: Iterable[Condition] | None = None
) -> tuple[str, ...]:
    """Conditions of the standard that a simulated manoeuvre does not meet, or does not show."""
    if conditions is None:
        conditions = (Condition.of_length(track.L), Condition.of_approach(track.speed, None))
    found = [item.words for item in conditions if item.words and not item.met]
    if track.tested and track.tested.below + track.tested.above > 0.0:
        found.append(f"{_sailed(track)}: {track.tested.words}")
    return tuple(found)
