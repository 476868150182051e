"""A manoeuvre as data: orders with what ends them, and what is asked of the history."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from pmmkit.conventions import METRICS, Metric
from pmmkit.equations.layouts import Ask, End, PhaseField, ProbeField, State
from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class Phase:
    """Orders, held until something happens.

    Parameters
    ----------
    rudder : float
        Ordered angle [rad]; NaN leaves the order as it is.
    revolutions : float
        Ordered, over those of the approach; NaN as above.
    bucket : float
        Ordered, of a waterjet, 0 ahead to 1 astern; NaN as above.
    until : End
        ``time``; ``heading`` [rad], ``yaw_rate`` [rad/s] or ``surge`` [m/s] pass `level` in the
        direction `side`; ``steady_turn``: the heading passes `level` and the turn is steady, or
        will be after more circles; ``steady``: accelerations over U²/L and (U/L)² below `level`.
    level, side : float
        What is passed, and in which direction.
    shortest, longest : float
        Least and greatest length of the phase [s].
    """

    rudder: float = math.nan
    revolutions: float = math.nan
    bucket: float = math.nan
    until: End = End.time
    level: float = 0.0
    side: float = 1.0
    shortest: float = 0.0
    longest: float
    LONGEST: ClassVar[float] = 2000.0
    """No phase lasts longer, in ship lengths over the approach speed."""
    STEADY: ClassVar[float] = 2e-5
    """Accelerations over U²/L and (U/L)² below which a motion counts as steady."""

    @property
    def numbers(self) -> tuple[float, ...]:
        """As the engine takes it."""
        return tuple(float(getattr(self, place.name)) for place in PhaseField)


@dataclass(frozen=True, kw_only=True)
class Probe:
    """A question to a history, answered by an instant and the states at it.

    Parameters
    ----------
    ask : Ask
        ``crossing``: first passage of a state through `level` in the direction `side`;
        ``extreme``: where a state is largest (`side` 1) or least (-1); ``begin`` and ``end`` of the
        phases; ``reached``: the end of a phase that came to what it waited for; ``path``: its
        length, in place of the instant [m]; ``steady``: the motion without accelerations next to
        the end, NaN if there is none.
    state : State
        That is looked at.
    level, side : float
        As above.
    first, last : int
        Phases in which it is looked for.
    """

    ask: Ask
    state: State = State.x
    level: float = 0.0
    side: float = 1.0
    first: int = 0
    last: int = 0

    @property
    def numbers(self) -> tuple[float, ...]:
        """As the engine takes it."""
        return tuple(float(getattr(self, place.name)) for place in ProbeField)


@dataclass(frozen=True, kw_only=True)
class ProbeResults:
    """What the probes of a plan found for one ship, or for many at once.

    Parameters
    ----------
    places : mapping of str to int
        Place of each probe.
    states : tuple of str
        States in their order.
    values : sequence
        Of each probe the instant and the states, one ship's or arrays.
    speed, L : float
        Approach speed [m/s] and ship length [m].
    """

    places: Mapping[str, int]
    states: tuple[str, ...]
    values: Any
    speed: float
    L: float

    def t(self, probe: str) -> Any:
        """Instant [s] (or length of the path [m])."""
        return self.values[self.places[probe]][0]

    def at(self, probe: str, state: str) -> Any:
        """A state."""
        return self.values[self.places[probe]][1 + self.states.index(state)]


@dataclass(frozen=True, kw_only=True)
class Plan:
    """The plan of a manoeuvre for one ship.

    Parameters
    ----------
    phases : tuple of Phase
        Orders one after another.
    probes : mapping of str to Probe
        What is asked of the history.
    measure : callable
        From the results of the probes to numbers by name, lengths in metres.
    rudder : float
        Largest ordered angle with its sign [rad].
    settles : bool
        Whether the end is to be steady.
    revolutions_rate : float, optional
        Rate at which the revolutions go to their order, over those of the approach [1/s]; by
        default what is usual, or what a part ``shaft`` gives.
    bucket_rate : float, optional
        Rate at which the bucket of a waterjet goes to its order [1/s]; by default what is usual.
    name : str
        Of the manoeuvre, which fills it in.
    metrics : tuple of Metric
        What the numbers are; filled in too.
    """

    phases: tuple[Phase, ...]
    probes: Mapping[str, Probe]
    measure: Callable[[ProbeResults], Mapping[str, Any]] = field(compare=False)
    rudder: float = 0.0
    settles: bool = False
    revolutions_rate: float | None = None
    bucket_rate: float | None = None
    name: str = ""
    metrics: tuple[Metric, ...] = tuple(METRICS.values())

    def metrics_of(self, results: ProbeResults) -> dict[str, Any]:
        """The metrics by name, each length also in ship lengths."""
        return _in_both(results.L, self.measure(results), self.metrics)

    @cached_property
    def orders(self) -> list[float]:
        """The phases as the engine takes them."""
        return [number for phase in self.phases for number in phase.numbers]

    @cached_property
    def orders_array(self) -> Array:
        """The phases as the compiled engine takes them."""
        return np.array(self.orders)

    @cached_property
    def questions_array(self) -> Array:
        """The probes as the compiled engine takes them."""
        return np.array(self.questions)

    @cached_property
    def questions(self) -> list[float]:
        """The probes as the engine takes them."""
        return [number for probe in self.probes.values() for number in probe.numbers]

    @cached_property
    def most_rudder(self) -> float:
        """Largest rudder angle that is ordered to either side [rad]."""
        return max((abs(p.rudder) for p in self.phases if not math.isnan(p.rudder)), default=0.0)

    @cached_property
    def places(self) -> dict[str, int]:
        """Place of each probe."""
        return {name: place for place, name in enumerate(self.probes)}


def _in_both(L: float, values: Mapping[str, float], known: tuple[Metric, ...]) -> dict[str, float]:
    """Numbers by name, each length also in ship lengths; L [m]."""
    found: dict[str, float] = {}
    for name, value in values.items():
        found[name] = value
        if Metric.of(name, known).length:
            found[name + Metric.IN_LENGTHS] = value / L
    return found
