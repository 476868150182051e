"""Metrics of manoeuvres: what each number is, its unit, and what the IMO asks of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import ClassVar, Final, Literal

from pmmkit.base import Registry, UnknownNameError

Place = Literal["turn", "comparison", "trial"]
"""Where some metrics stand, of all that there are: the turning circle of a reduction's report, a
model beside measured manoeuvres, a sea trial."""
COUNTED: Final = 3
"""How many are told of a metric that is counted."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Criterion:
    """What IMO resolution MSC.137(76) asks of a metric.

    Parameters
    ----------
    name : str
        Name of the criterion.
    paragraph : str
        Of the annex of the resolution.
    limit : float or callable
        Largest value that meets it, in ship lengths or in the unit of the metric; or a function
        of the ship length over the test speed [s] that gives it.
    manoeuvre : str
        By which it is judged.
    settings : mapping of str to float
        Of that manoeuvre, to starboard; without ``rudder_deg`` there is one run and no side.
    shown_by : tuple of str
        Other manoeuvres whose record shows the metric as well.
    number : int
        Which of several, of a metric that is counted.
    """

    HARD_OVER: ClassVar[float] = 35.0
    """Rudder of the turning circle of the standard, where the ship permits as much [deg]."""

    name: str
    paragraph: str
    limit: float | Callable[[float], float]
    manoeuvre: str
    settings: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    shown_by: tuple[str, ...] = ()
    number: int = 1

    def limit_for(self, L: float, speed: float) -> float:
        """The limit for a ship of a length [m] at a test speed [m/s]."""
        return self.limit(L / speed) if callable(self.limit) else self.limit


@dataclass(frozen=True, kw_only=True, eq=False)
class Metric:
    """A number that a manoeuvre gives.

    Parameters
    ----------
    name : str
        As in ``metrics.json``. A metric that is counted, or that there is for each rudder angle,
        has ``{}`` in the place of the count: ``overshoot_{}_deg``.
    symbol : str
        As in the list of symbols of the ITTC, where that has one.
    title : str
        The long name.
    unit : str
        ``m``, ``s``, ``deg``, ``deg/s``, ``m/s`` or ``-``. Metres are also given in ship lengths,
        under the name with ``_L``.
    rolls : bool
        Whether only a ship that rolls has it.
    starboard : bool
        Whether it is positive to starboard; the others count towards the side of the first order,
        and a symmetric ship has the same to either side.
    criteria : tuple of Criterion
        What the IMO asks of it.
    told : tuple of {"turn", "comparison", "trial"}
        Where it is told; files and JSON have all.

    Examples
    --------
    >>> advance = Metric.of("advance")
    >>> advance.symbol, advance.unit, advance.criteria[0].limit, advance.criteria[0].paragraph
    ('x090', 'm', 4.5, '5.3.1')
    """

    IN_LENGTHS: ClassVar[str] = "_L"
    """Ending of the name of a length that is given in ship lengths."""

    name: str
    symbol: str
    title: str
    unit: str
    rolls: bool = False
    starboard: bool = False
    criteria: tuple[Criterion, ...] = ()
    told: tuple[Place, ...] = ()

    @staticmethod
    def of(name: str, known: tuple[Metric, ...] | None = None) -> Metric:
        """The metric of a number, by the name that the number has.

        Parameters
        ----------
        name : str
            As in ``metrics.json``; with ``_L`` for a length in ship lengths.
        known : tuple of Metric, optional
            Among which it is looked for; by default pmmkit's own.

        Raises
        ------
        UnknownNameError
            With the nearest name there is.

        Examples
        --------
        >>> Metric.of("tactical_diameter_L").name, Metric.of("overshoot_3_deg").title
        ('tactical_diameter', 'overshoot angle')
        """
        return _metric_of(name, _METRICS if known is None else known)

    @staticmethod
    def in_words(name: str) -> str:
        """What a number is called where its unit stands beside it.

        Parameters
        ----------
        name : str
            The name that the number has.

        Examples
        --------
        >>> Metric.in_words("overshoot_1_deg"), Metric.in_words("tactical_diameter_L")
        ('overshoot 1', 'tactical diameter')
        """
        return name.removesuffix("_deg").removesuffix(Metric.IN_LENGTHS).replace("_", " ")

    @property
    def length(self) -> bool:
        """Whether it is a length, which is given in ship lengths as well."""
        return self.unit == "m"

    def count(self, name: str) -> str | None:
        """What stands in the place of the count; None if the name is not of this metric.

        Examples
        --------
        >>> Metric.of("overshoot_2_deg").count("overshoot_2_deg"), Metric.of("reach").count("reach")
        ('2', '')
        """
        head, _, tail = self.name.partition("{}")
        if name == self.name:
            return ""
        there = name.startswith(head) and name.endswith(tail) and "{}" in self.name
        return name[len(head) : len(name) - len(tail)] or None if there else None

    def unit_of(self, name: str, *, lengths: str = "L") -> str:
        """Unit of one of its numbers; `lengths` where that is in ship lengths.

        Examples
        --------
        >>> [Metric.of(name).unit_of(name) for name in ("advance", "advance_L", "time_90")]
        ['m', 'L', 's']
        """
        return lengths if self.length and name.endswith(self.IN_LENGTHS) else self.unit

    def judged(self, criterion: Criterion) -> str:
        """Name of the number that a criterion is about, in ship lengths where that is the limit."""
        return self.name.format(criterion.number) + (self.IN_LENGTHS if self.length else "")


def first_overshoot_limit(time: float) -> float:
    """Largest first overshoot of a 10/10 zigzag [deg], for the ship length over the speed [s]."""
    return 10.0 if time < 10.0 else 5.0 + 0.5 * time if time < 30.0 else 20.0


def second_overshoot_limit(time: float) -> float:
    """Largest second overshoot of a 10/10 zigzag [deg], for the ship length over the speed [s]."""
    return 25.0 if time < 10.0 else 17.5 + 0.75 * time if time < 30.0 else 40.0


def _turning(name: str, limit: float) -> tuple[Criterion, ...]:
    settings = MappingProxyType({"rudder_deg": Criterion.HARD_OVER})
    return (
        Criterion(
            name=name, paragraph="5.3.1", limit=limit, manoeuvre="turning", settings=settings
        ),
    )


def _overshoot(
    name: str,
    paragraph: str,
    limit: float | Callable[[float], float],
    *,
    angle: float,
    executes: int,
    number: int = 1,
) -> Criterion:
    settings = {"rudder_deg": angle, "switch_deg": angle, "executes": executes}
    return Criterion(
        name=name,
        paragraph=paragraph,
        limit=limit,
        manoeuvre="zigzag",
        settings=MappingProxyType(settings),
        number=number,
    )


INITIAL_TURNING: Final = Criterion(
    name="initial_turning",
    paragraph="5.3.2",
    limit=2.5,
    manoeuvre="initial_turning",
    settings=MappingProxyType({"rudder_deg": 10.0, "heading_deg": 10.0}),
    shown_by=("zigzag",),
)
OVERSHOOTS: Final = (
    _overshoot("first_overshoot_10_10", "5.3.3.1", first_overshoot_limit, angle=10.0, executes=3),
    _overshoot(
        "second_overshoot_10_10",
        "5.3.3.2",
        second_overshoot_limit,
        angle=10.0,
        executes=3,
        number=2,
    ),
    _overshoot("first_overshoot_20_20", "5.3.3.3", 25.0, angle=20.0, executes=2),
)
TRACK_REACH: Final = Criterion(
    name="track_reach", paragraph="5.3.4", limit=15.0, manoeuvre="stopping"
)


def _metric(
    name: str,
    symbol: str,
    title: str,
    unit: str,
    *criteria: Criterion,
    rolls: bool = False,
    starboard: bool = False,
    told: tuple[Place, ...] = (),
) -> Metric:
    return Metric(
        name=name,
        symbol=symbol,
        title=title,
        unit=unit,
        criteria=criteria,
        rolls=rolls,
        starboard=starboard,
        told=told,
    )


_OF_A_TURN: Final[tuple[Place, ...]] = ("turn", "comparison", "trial")
_METRICS: Final = (
    _metric("advance", "x090", "advance", "m", *_turning("advance", 4.5), told=_OF_A_TURN),
    _metric("transfer", "y090", "transfer", "m", told=_OF_A_TURN),
    _metric(
        "tactical_diameter",
        "y0180",
        "tactical diameter",
        "m",
        *_turning("tactical_diameter", 5.0),
        told=_OF_A_TURN,
    ),
    _metric("steady_diameter", "DC", "steady diameter", "m", told=_OF_A_TURN),
    _metric("time_90", "t90", "time to 90° of heading", "s", told=("trial",)),
    _metric("time_180", "t180", "time to 180° of heading", "s", told=("trial",)),
    _metric("steady_drift_deg", "βC", "steady drift angle", "deg", told=("turn", "comparison")),
    _metric("speed_ratio", "UC/U0", "steady speed over approach", "-", told=("turn", "comparison")),
    _metric("speed_loss", "1 - UC/U0", "loss of speed over approach", "-", told=("trial",)),
    _metric("steady_yaw_rate_deg_s", "rC", "steady yaw rate", "deg/s", told=("turn",)),
    _metric("heel_max_deg", "φmax", "largest heel", "deg", rolls=True, told=("turn", "trial")),
    _metric("heel_steady_deg", "φC", "steady heel, outwards", "deg", rolls=True, told=("trial",)),
    _metric(
        "initial_turning_distance",
        "s",
        "way of initial turning",
        "m",
        INITIAL_TURNING,
        told=("trial",),
    ),
    _metric("time_to_heading", "t", "time to the heading", "s"),
    _metric("yaw_rate_deg_s", "r", "yaw rate at the heading", "deg/s"),
    _metric(
        "overshoot_{}_deg",
        "ψO",
        "overshoot angle",
        "deg",
        *OVERSHOOTS,
        told=("comparison", "trial"),
    ),
    _metric("time_execute_{}", "t", "time of an execute", "s", told=("trial",)),
    _metric("reach", "tR", "reach: time to the approach heading again", "s", told=("trial",)),
    _metric("period", "thc", "period of the changes of heading", "s", told=("trial",)),
    _metric("initial_turning_time", "tA", "time to the second execute", "s"),
    _metric("speed_ratio_end", "U/U0", "speed at the last overshoot over approach", "-"),
    _metric("loop_height_deg_s", "lr", "height of the loop", "deg/s"),
    _metric("loop_width_deg", "lδ", "width of the loop", "deg"),
    _metric(
        "yaw_rate_deg_s_at_{}_first",
        "r(δ)",
        "steady yaw rate at a rudder angle, first way",
        "deg/s",
        starboard=True,
    ),
    _metric(
        "yaw_rate_deg_s_at_{}_back",
        "r(δ)",
        "steady yaw rate at a rudder angle, way back",
        "deg/s",
        starboard=True,
    ),
    _metric("residual_yaw_rate_deg_s", "r", "yaw rate that stays with rudder amidships", "deg/s"),
    _metric("residual_share", "r/rC", "the same over the yaw rate of the turn", "-"),
    _metric("time_turn", "t", "time to rudder amidships", "s"),
    _metric("time_end", "t", "time of the manoeuvre", "s"),
    _metric("head_reach", "x0F", "head reach", "m", told=("comparison", "trial")),
    _metric("track_reach", "sF", "track reach", "m", TRACK_REACH, told=("comparison", "trial")),
    _metric("lateral_deviation", "y0F", "lateral deviation", "m", starboard=True, told=("trial",)),
    _metric("time_to_stop", "tF", "time to stop", "s", told=("trial",)),
    _metric("heading_at_stop_deg", "ψ", "heading at stop", "deg", starboard=True),
    _metric("astern_speed", "UA", "steady speed astern", "m/s"),
    _metric("astern_reach", "xA", "way astern from the order ahead until the ship stops", "m"),
    _metric("time_to_speed", "t", "time from the order ahead to the speed asked for", "s"),
    _metric("way_ahead", "x0", "way from the stop to the speed asked for", "m"),
    _metric("final_speed", "U", "final speed", "m/s"),
    _metric("time", "t", "time until the speed stays", "s"),
    _metric("distance", "x0", "way until the speed stays", "m"),
    _metric("time_counter", "t", "time of the counter rudder", "s"),
    _metric("heading_end_deg", "ψ", "heading at the end", "deg"),
    _metric("overshoot_deg", "ψO", "heading beyond the one asked for", "deg"),
    _metric("offset", "y0", "offset from the old track", "m"),
    _metric("time_shift", "t", "time of the shift of the rudder", "s"),
    _metric("time_ease", "t", "time of rudder amidships", "s"),
)


class Metrics(Registry[Metric]):
    """All metrics by name, and what is told of the numbers of a manoeuvre."""

    @property
    def criteria(self) -> tuple[tuple[Metric, Criterion], ...]:
        """All that the IMO asks for, with the metric it is asked of.

        Examples
        --------
        >>> [criterion.name for _, criterion in METRICS.criteria][:3]
        ['advance', 'tactical_diameter', 'initial_turning']
        """
        return tuple((metric, item) for metric in self.values() for item in metric.criteria)

    def named(self, *names: str) -> tuple[Metric, ...]:
        """Metrics by their names.

        Examples
        --------
        >>> [metric.unit for metric in METRICS.named("advance", "time_90")]
        ['m', 's']
        """
        return tuple(self[name] for name in names)

    @staticmethod
    def in_lengths(names: Iterable[str]) -> list[str]:
        """Names of numbers, without those that are given in ship lengths as well.

        Examples
        --------
        >>> METRICS.in_lengths(["advance", "advance_L", "time_90"])
        ['advance_L', 'time_90']
        """
        given = list(names)
        return [name for name in given if name + Metric.IN_LENGTHS not in given]

    def main(self, names: Iterable[str]) -> str:
        """The number that is told first: the tactical diameter where there is one.

        Examples
        --------
        >>> METRICS.main(["advance_L", "tactical_diameter_L"])
        'tactical_diameter_L'
        >>> METRICS.main(["overshoot_1_deg", "reach"])
        'overshoot_1_deg'
        """
        given = self.in_lengths(names)
        turning = f"tactical_diameter{Metric.IN_LENGTHS}"
        return turning if turning in given else given[0]

    def told(self, place: Place, names: Iterable[str], *, counted: int = COUNTED) -> list[str]:
        """Names of numbers that are told in a place.

        Parameters
        ----------
        place : {"turn", "comparison", "trial"}
            Where.
        names : iterable of str
            Of all numbers there are; lengths are told in ship lengths of a turn, else in metres.
        counted : int
            How many are told of a metric that is counted.

        Examples
        --------
        >>> METRICS.told("trial", ["advance", "speed_ratio", "overshoot_1_deg", "overshoot_4_deg"])
        ['advance', 'overshoot_1_deg']
        """
        chosen = self.in_lengths(names) if place == "turn" else names
        return [
            name
            for name in chosen
            for metric in [Metric.of(name)]
            if (place == "turn" or not name.endswith(Metric.IN_LENGTHS))
            and place in metric.told
            and int(metric.count(name.removesuffix(Metric.IN_LENGTHS)) or 1) <= counted
        ]


METRICS: Final = Metrics(
    Metric, lambda: _METRICS, what="metric", contract="pmmkit.testing.manoeuvres:check_metric"
)
"""All metrics by name; one of which there are several has a number in it, see `Metric.of`."""


@cache
def _metric_of(name: str, known: tuple[Metric, ...]) -> Metric:
    bare = name.removesuffix(Metric.IN_LENGTHS)
    for metric in known:
        if metric.count(bare) is not None and (bare == name or metric.length):
            return metric
    raise UnknownNameError(Registry(Metric, lambda: known, what="metric").unknown(name))
