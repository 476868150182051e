"""Manoeuvres that a free-running ship could make next, and what they take."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Final

from pmmkit.campaigns import Settings
from pmmkit.diagnosis.planning.options import Limits, Option

RUN_UP: Final = 10.0
"""Ship lengths of steady approach before each manoeuvre."""
TURN: Final = 25.0
"""Ship lengths over the speed that a turn lasts: about a full circle with much rudder."""
TURNS: Final = (35.0, 20.0, 10.0)
"""Rudder angles of turns [deg]."""
ZIGZAGS: Final = (20.0, 10.0)
"""Angles of zigzags, of rudder and heading alike [deg]."""
PULL_OUT: Final = 15.0
"""Rudder angle of a pull-out [deg]."""
WEAVES: Final = ((15.0, 12.0), (15.0, 5.0))
"""Rudder angles [deg] and periods in ship lengths over the speed."""
REVOLUTIONS: Final = (0.6, 1.3)
"""Revolutions over those of the approach at which a ship runs straight."""
COURSES: Final = (0.0, 90.0, 180.0, 270.0)
"""Approaches from that of the records [deg], where wind or current tell them apart."""


@dataclass(frozen=True, kw_only=True)
class FreeOption(Option):
    """A manoeuvre that could be made.

    `course`: by which its approach is turned from that of the records [rad]. `turns`:
    revolutions over those of the approach once it begins. `asked`: settings of the manoeuvre as
    `simulate` takes them.
    """

    course: float = 0.0
    turns: float = 1.0
    asked: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def id(self) -> str:
        """A name from the settings, such as ``ZZ_7_d+20_s20_c180``."""
        turns = f"_n{self.turns:g}" if self.turns != 1.0 else ""
        course = f"_c{math.degrees(self.course):.0f}" if self.course else ""
        return f"{super().id}{turns}{course}"

    @property
    def words(self) -> str:
        """The manoeuvre in words."""
        parts = [super().words]
        if self.turns != 1.0:
            parts.append(f"revolutions times {self.turns:g}")
        if self.course:
            parts.append(f"approach turned by {math.degrees(self.course):.0f}°")
        return ", ".join(parts)

    def lasting(self, seconds: float, wait: float, pace: float) -> FreeOption:
        """The same with the time it takes: record, run-up and the wait before the next."""
        hours = (seconds + RUN_UP / pace + wait) / 3600.0
        return replace(self, record=seconds, hours=hours)


def free_options(
    limits: Limits, L: float, *, courses: Sequence[float] = (0.0,)
) -> tuple[FreeOption, ...]:
    """Manoeuvres within limits, to both sides.

    L [m].

    Examples
    --------
    >>> found = free_options(Limits(speeds=(7.0,), rudder=0.4), 175.0)
    >>> [item.id for item in found if item.test == "zigzag"]
    ['ZZ_7_d+20_s20', 'ZZ_7_d-20_s20', 'ZZ_7_d+10_s10', 'ZZ_7_d-10_s10']
    """
    made = [
        replace(option, course=math.radians(course))
        for speed in limits.speeds
        for option in _at(speed, speed / L)
        for course in courses
        if abs(option.settings.rudder) <= limits.rudder * (1.0 + 1e-9)
    ]
    return tuple(made)


def _at(speed: float, pace: float) -> Iterator[FreeOption]:
    yield _option("straight", speed)
    for turns in REVOLUTIONS:
        yield replace(_option("accelerating", speed, turns=turns), turns=turns)
    for angle in _both(TURNS):
        yield _option("turning", speed, rudder_deg=angle, duration=TURN / pace)
    for angle in _both(ZIGZAGS):
        yield _option("zigzag", speed, rudder_deg=angle, switch_deg=abs(angle))
    for angle in _both((PULL_OUT,)):
        yield _option("pull_out", speed, rudder_deg=angle)
    for angle, period in WEAVES:
        yield _option("weave", speed, rudder_deg=angle, period=period / pace)


def _both(angles: Sequence[float]) -> list[float]:
    return [sign * angle for angle in angles for sign in (1.0, -1.0)]


def _option(test: str, speed: float, **asked: float) -> FreeOption:
    switch = asked.get("switch_deg")
    settings = Settings(
        speed=speed,
        rudder=math.radians(asked.get("rudder_deg", 0.0)),
        period=asked.get("period"),
        switch=None if switch is None else math.radians(switch),
    )
    return FreeOption(
        test=test, settings=settings, cycles=0, record=0.0, hours=0.0, asked=MappingProxyType(asked)
    )
