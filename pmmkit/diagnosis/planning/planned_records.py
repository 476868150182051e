"""Manoeuvres that are not made yet, as records of them would be: simulated, without noise."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.base import ModelError
from pmmkit.campaigns import Settings
from pmmkit.diagnosis.free_running.diagnose import FreeSystem
from pmmkit.diagnosis.free_running.findings import model_of, moved
from pmmkit.diagnosis.free_running.fits import SetFit
from pmmkit.diagnosis.planning.options import Limits, Option
from pmmkit.effects import CURRENT
from pmmkit.identification import FreeRecord
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.simulation import Track, simulate

# Manoeuvres that a free-running ship could make next, and what they take.


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


LONGEST: Final = 60.0
"""A planned record is no longer than this, in ship lengths over the speed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PlannedConditions:
    """What planned manoeuvres have in common with the records that are made.

    `model`: the ship as she is fitted best. `records`: made, at the instants at which they are
    asked. `change`: what the fit finds beside the values of the model: current, zero of the
    rudder. `extrapolate`: allow a speed outside the range of the model's values. `heel`: heel
    over the product of speed and yaw rate [s²/m], where heel is an input.
    """

    model: Model
    records: tuple[FreeRecord, ...]
    change: Mapping[str, float]
    extrapolate: bool
    heel: float

    def like(self, speed: float) -> FreeRecord:
        """The record whose approach is nearest in speed, the last of them."""
        return min(reversed(self.records), key=lambda item: abs(item.speed - speed))


def sea_of(system: FreeSystem, fit: SetFit) -> PlannedConditions:
    """The ship and her surroundings by a fit to records."""
    try:
        model = model_of(system.model, system.every, fit, system.speed)
    except ModelError:
        model = system.model
    records = tuple(item.record for item in system.question.stretches)
    return PlannedConditions(
        model=model,
        records=records,
        change=MappingProxyType(moved(fit)),
        extrapolate=system.extrapolate,
        heel=_heel(records),
    )


def _heel(records: Sequence[FreeRecord]) -> float:
    """Heel over U r by least squares: what a ship leans in a turn."""
    over, under = 0.0, 0.0
    for item in records:
        r = item.measured.get("r")
        if item.roll is None or r is None:
            continue
        turn = item.speed * np.nan_to_num(r)
        over, under = over + float(turn @ item.roll), under + float(turn @ turn)
    return over / under if under else 0.0


def planned_record(sea: PlannedConditions, option: FreeOption) -> FreeRecord:
    """The record of a manoeuvre, with the channels and the sampling of those that are made."""
    speed, like = option.settings.speed, sea.like(option.settings.speed)
    course = _approach(like) + option.course
    track = simulate(
        _in_waves(sea.model, like, course),
        option.test,
        speed=speed,
        dt=float(np.median(np.diff(like.t))),
        extrapolate=sea.extrapolate,
        **_around(sea, like, course),
        **option.asked,
    )
    kept = track.t <= LONGEST * track.L / speed
    t = track.t[kept]
    shown = {name: x[kept] for name, x in _channels(track, course).items()}
    roll = None if like.roll is None else sea.heel * speed * shown["r"]
    rate = None if roll is None or like.roll_rate is None else np.gradient(roll, t)
    still = np.ones(len(t))
    return FreeRecord(
        name=option.id,
        t=t,
        delta=track.delta[kept] - sea.change.get("rudder_zero", 0.0),
        turns=track.n[kept],
        measured=MappingProxyType({name: shown[name] for name in like.measured}),
        speed=speed,
        wind_speed=None if like.wind_speed is None else np.mean(like.wind_speed) * still,
        wind_direction=None
        if like.wind_direction is None
        else _middle(like.wind_direction) * still,
        wave_height=None if like.wave_height is None else np.mean(like.wave_height) * still,
        wave_direction=None
        if like.wave_direction is None
        else _middle(like.wave_direction) * still,
        wave_period=like.wave_period,
        depth=like.depth,
        roll=roll,
        roll_rate=rate,
        roll_acceleration=(
            None if rate is None or like.roll_acceleration is None else np.gradient(rate, t)
        ),
    )


def _approach(record: FreeRecord) -> float:
    """Heading of the approach [rad]."""
    psi = record.measured["psi"]
    return float(psi[np.isfinite(psi)][0])


def _in_waves(model: Model, like: FreeRecord, course: float) -> Model:
    """The ship in the sea that a record states, as `simulate` takes it."""
    if like.wave_height is None or like.wave_direction is None or "wave_drift" not in model.parts:
        return model
    angle = math.degrees(_middle(like.wave_direction) - course)
    return model.with_values("wave_drift", Hs=float(np.mean(like.wave_height)), from_deg=angle)


def _middle(way: Array | None) -> float:
    """Where wind or waves come from in the mean, from north [rad]."""
    if way is None:
        return 0.0
    return math.atan2(float(np.mean(np.sin(way))), float(np.mean(np.cos(way))))


def _around(sea: PlannedConditions, like: FreeRecord, course: float) -> dict[str, Any]:
    """Wind and current from the heading of the approach, as `simulate` takes them."""
    north, east = (sea.change.get(name, 0.0) for name in CURRENT)
    found = {
        "current_speed": math.hypot(north, east),
        "current_direction_deg": math.degrees(math.atan2(east, north) - course),
    }
    if like.depth is not None and sea.model.feels("depth"):
        found["depth"] = like.depth
    if like.wind_speed is not None:
        found["wind_speed"] = float(np.mean(like.wind_speed))
        found["wind_direction_deg"] = math.degrees(_middle(like.wind_direction) - course)
    return found


def _channels(track: Track, course: float) -> dict[str, Array]:
    """All that may be measured, the approach turned to its course."""
    ahead, aside = math.cos(course), math.sin(course)
    x, y = track.x * ahead - track.y * aside, track.x * aside + track.y * ahead
    north, east = np.gradient(x, track.t), np.gradient(y, track.t)
    own = {name: getattr(track, name) for name in ("u", "v", "r", "p", "phi")}
    over_ground = {"xdot": north, "ydot": east, "sog": np.hypot(north, east)}
    return own | over_ground | {"x": x, "y": y, "psi": track.psi + course}
