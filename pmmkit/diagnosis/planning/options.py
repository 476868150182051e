"""Runs that a tank could make next: which settings a rig can be given, and what they take."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Campaign, Run, Settings, TestKind
from pmmkit.conventions import Ship, Water
from pmmkit.models import Model

if TYPE_CHECKING:
    from pmmkit.identification import FreeRecord

BREAKING: Final = 0.25
"""ωU/g above which waves no longer leave the model behind."""
LENGTHS: Final = 10.0
"""Ship lengths that a steady record takes."""
FEWEST: Final = 3
"""Whole cycles, the first included, without which an oscillating run tells too little."""
SPEEDS: Final = 5
"""Speeds that are offered of a campaign with more."""
RUDDER: Final = 35.0
"""Largest rudder angle of a ship that states none [deg]."""
FEW_SPEEDS: Final = 3
"""Speeds that are offered of records with more."""
SLOWEST: Final = 0.5
"""Speeds below this share of the median are not those of an approach."""
SLOWER: Final = 2.0 / 3.0
"""What is offered beside the one speed of records, over it."""
USUAL: Final = tuple(
    kind.name
    for kind in sorted(TEST_KINDS.own.values(), key=lambda kind: kind.turns_rudder)
    if kind.usual and kind.shares is not None
)
"""Tests of every planar motion mechanism that are planned, those of the hull before the rudder."""


def offered() -> tuple[str, ...]:
    """Names of the kinds of test that can be planned: the usual ones, then others."""
    known = [kind.name for kind in TEST_KINDS.values() if kind.captive and kind.shares is not None]
    return (*USUAL, *(name for name in known if name not in USUAL))


@dataclass(frozen=True, kw_only=True)
class Option:
    """One run that could be made.

    Parameters
    ----------
    test : str
        Kind of test.
    settings : Settings
        What it is set to.
    cycles : int
        Whole cycles of its record, the first included; 0 for a steady run.
    record : float
        Length of its record [s].
    hours : float
        Time it takes, the wait for still water included [h].
    """

    test: str
    settings: Settings
    cycles: int
    record: float
    hours: float

    @property
    def id(self) -> str:
        """A name from the settings, such as ``SD_1.5_b+06``."""
        s = self.settings
        parts = [TEST_KINDS[self.test].code, f"{s.speed:.4g}"]
        for letter, angle in (("b", s.drift), ("d", s.rudder), ("h", s.heel)):
            if angle:
                parts.append(f"{letter}{math.degrees(angle):+.3g}")
        if s.yaw_rate is not None:
            parts.append(f"r{s.yaw_rate:+.3g}")
        if s.radius is not None:
            parts.append(f"R{s.radius:+.4g}")
        if s.switch is not None:
            parts.append(f"s{math.degrees(s.switch):.3g}")
        if s.period is not None:
            parts.append(f"T{s.period:.4g}")
        if s.amplitude is not None:
            parts.append(f"a{s.amplitude:.3g}")
        if s.yaw_amplitude is not None:
            parts.append(f"y{math.degrees(s.yaw_amplitude):.3g}")
        if s.rudder_amplitude is not None:
            parts.append(f"da{math.degrees(s.rudder_amplitude):.3g}")
        for item in RUN_SETTINGS.brought:
            if item.code and (value := s.value(item.name)) is not None:
                parts.append(f"{item.code}{item.to_file(value):.3g}")
        if s.repeat_of is not None:
            parts.append("again")
        return "_".join(parts)

    @property
    def words(self) -> str:
        """The run in words, as one says it to the people of the tank."""
        s = self.settings
        parts = [f"{self.test.replace('_', ' ')} at {s.speed:.4g} m/s"]
        if s.period is not None:
            parts.append(f"period {s.period:.3g} s")
        if s.amplitude is not None:
            parts.append(f"amplitude {s.amplitude:.3g} m")
        if s.yaw_amplitude is not None:
            parts.append(f"heading amplitude {math.degrees(s.yaw_amplitude):.3g}°")
        if s.rudder_amplitude is not None:
            parts.append(f"rudder amplitude {math.degrees(s.rudder_amplitude):.3g}°")
        for name, angle in (("drift", s.drift), ("rudder", s.rudder), ("heel", s.heel)):
            if angle:
                parts.append(f"{name} {math.degrees(angle):+.3g}°")
        if s.yaw_rate is not None:
            parts.append(f"yaw rate {s.yaw_rate:+.3g} rad/s")
        if s.radius is not None:
            parts.append(f"radius {s.radius:+.4g} m")
        if s.switch is not None:
            parts.append(f"reversed at {math.degrees(s.switch):.3g}°")
        for item in RUN_SETTINGS.brought:
            if (value := s.value(item.name)) is not None:
                parts.append(f"{item.word} {item.to_file(value):.3g} {item.unit}".rstrip())
        return ", ".join(parts)

    @property
    def set_up(self) -> str:
        """What of rig and model must be changed before another run can be made, in words."""
        kind = TEST_KINDS[self.test]
        mount = "rotating arm" if kind.circles else "oscillating" if kind.swings_hull else "held"
        heel = math.degrees(self.settings.heel)
        return f"{mount}, heel {heel:+.3g}" if heel else mount

    @property
    def entry(self) -> dict[str, Any]:
        """The run as an entry of a campaign file; the file of its record is still to be named."""
        s = self.settings
        given: dict[str, Any] = {"id": self.id, "test": self.test, "file": f"runs/{self.id}.csv"}
        given["speed"] = round(s.speed, 6)
        planned = [
            item
            for item in RUN_SETTINGS.values()
            if item.kept and not item.surroundings and item.name != "speed"
        ]
        for item in sorted(planned, key=lambda x: (not x.angle, x.name == "propeller_rps")):
            value = s.value(item.name)
            if value if item.angle else value is not None:
                given[item.in_file] = round(item.to_file(value or 0.0), 4)
        if s.repeat_of is not None:
            given["repeat_of"] = s.repeat_of
        return given

    def run(self, number: int = 0) -> Run:
        """The run without data; `number` tells repeats apart."""
        return Run(
            id=f"planned {self.id} {number}",
            test=self.test,
            kind="history",
            settings=self.settings,
            loader=_nothing,
        )


def _nothing() -> Any:
    raise CampaignError(Problem(message="is planned and has no data yet."))


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What tank and rig allow.

    Parameters
    ----------
    speeds : tuple of float
        Carriage speeds [m/s].
    drift, rudder, heel : float
        Largest angles [rad]; 0 leaves such tests out.
    sway : float
        Largest amplitude of the sway displacement [m].
    yaw : float
        Largest amplitude of the heading [rad].
    sway_velocity, yaw_rate : float
        Largest v/U and rL/U of an oscillation.
    frequencies : tuple of float
        ωL/U of oscillations; those above ωU/g = 1/4 are left out.
    tests : tuple of str
        Kinds of tests.
    cycles : int
        Whole cycles of a record, the first included, where the tank is long enough.
    tank_length, tank_width : float, optional
        Length over which the carriage runs at speed, width [m].
    wait : float
        Time between runs, the way back included [s].
    propeller_rps : float, optional
        Revolutions of all runs.
    """

    speeds: tuple[float, ...]
    drift: float = math.radians(12.0)
    rudder: float = 0.0
    heel: float = 0.0
    sway: float = math.inf
    yaw: float = math.radians(20.0)
    sway_velocity: float = 0.25
    yaw_rate: float = 0.6
    frequencies: tuple[float, ...] = (1.0, 2.0, 3.2, 5.0)
    tests: tuple[str, ...] = field(default=USUAL)
    cycles: int = 4
    tank_length: float = math.inf
    tank_width: float = math.inf
    wait: float = 720.0
    propeller_rps: float | None = None

    @classmethod
    def of(cls, campaign: Campaign) -> Limits:
        """What a campaign has shown that its tank and rig can do.

        Parameters
        ----------
        campaign : Campaign
            Captive tests; the settings count, not the data.

        Returns
        -------
        Limits
            Its speeds (two thirds and four thirds of it beside a single one, five of many), largest
            angles and amplitudes. What it never did, such as rudder angles, is left out; drift,
            sway and yaw are offered at usual sizes where it has none.
        """
        every = [run.settings for run in campaign.runs]
        speeds = sorted({round(s.speed, 6) for s in every})
        if len(speeds) > SPEEDS:
            last = len(speeds) - 1
            speeds = [speeds[round(i * last / (SPEEDS - 1))] for i in range(SPEEDS)]
        if len(speeds) == 1:
            speeds = [round(share * speeds[0], 3) for share in (2 / 3, 1.0, 4 / 3)]
        found = cls(speeds=tuple(speeds))
        largest = {
            "drift": max((abs(s.drift) for s in every), default=0.0),
            "yaw": max((abs(s.yaw_amplitude or 0.0) for s in every), default=0.0),
            "sway": max((abs(s.amplitude or 0.0) for s in every), default=0.0),
            "sway_velocity": max(
                ((s.amplitude or 0.0) * (s.omega or 0.0) / s.speed for s in every), default=0.0
            ),
            "yaw_rate": max(
                (
                    abs(s.yaw_amplitude or 0.0) * (s.omega or 0.0) * campaign.ship.L / s.speed
                    for s in every
                ),
                default=0.0,
            ),
        }
        tests = {run.test for run in campaign.runs}
        revolutions = {s.propeller_rps for s in every}
        return found.with_(
            **{name: value for name, value in largest.items() if value > 0},
            rudder=max((s.largest_rudder for s in every), default=0.0),
            heel=max((abs(s.heel) for s in every), default=0.0),
            tests=(*USUAL, *(name for name in offered()[len(USUAL) :] if name in tests)),
            propeller_rps=revolutions.pop() if len(revolutions) == 1 else None,
        )

    @classmethod
    def of_records(cls, model: Model, records: Sequence[FreeRecord]) -> Limits:
        """Speeds of records, and the rudder that the ship has.

        Parameters
        ----------
        model : Model
            Of the ship.
        records : sequence of FreeRecord
            Made.

        Returns
        -------
        Limits
            Three speeds of many; of one, two thirds of it as well, if the model has values there.
        """
        usual = float(np.median([item.speed for item in records]))
        # A record that begins next to rest says nothing of a speed at which to begin.
        speeds = sorted({round(x.speed, 6) for x in records if x.speed > SLOWEST * usual})
        if len(speeds) > FEW_SPEEDS:
            speeds = [speeds[0], speeds[len(speeds) // 2], speeds[-1]]
        slow = round(SLOWER * speeds[0], 3)
        covered = len(model.Fn) < 2 or model.ship.froude(slow, model.water.g) >= min(model.Fn)
        if len(speeds) == 1 and covered:
            speeds = [slow, *speeds]
        largest = min(model.steering.get("max_deg", RUDDER), RUDDER)
        return cls(speeds=tuple(speeds), rudder=math.radians(largest))

    def with_(self, **changes: Any) -> Limits:
        """A copy with some entries changed.

        Raises
        ------
        CampaignError
            If a name is not known or a number impossible.
        """
        known = {item.name for item in fields(self)}
        wrong = [
            f"{name!r} is no limit: {', '.join(sorted(known))}."
            for name in changes
            if name not in known
        ]
        if wrong:
            raise CampaignError(wrong)
        made = replace(self, **changes)
        wrong += [
            f"{name!r} is no test that can be planned: {', '.join(offered())}."
            for name in made.tests
            if name not in offered()
        ]
        if not made.speeds or min(made.speeds) <= 0:
            wrong.append("speeds must be positive, and at least one.")
        if made.cycles < FEWEST:
            wrong.append(f"cycles must be at least {FEWEST}.")
        for name in ("drift", "rudder", "heel", "sway", "yaw", "wait", "sway_velocity", "yaw_rate"):
            if not getattr(made, name) >= 0:
                wrong.append(f"{name} must not be negative.")
        for name in ("tank_length", "tank_width"):
            if not getattr(made, name) > 0:
                wrong.append(f"{name} must be positive.")
        if wrong:
            raise CampaignError(wrong)
        return made


def options_of(limits: Limits, ship: Ship, water: Water) -> tuple[Option, ...]:
    """All runs that are offered within limits."""
    made: dict[str, Option] = {}
    for speed in limits.speeds:
        for test in limits.tests:
            for given in _grid(TEST_KINDS[test], limits, ship, speed):
                settings = Settings(speed=speed, propeller_rps=limits.propeller_rps, **given)
                option = timed(test, settings, limits, ship)
                if option is not None and _possible(option, limits, ship, water):
                    made.setdefault(option.id, option)
    return tuple(made.values())


def timed(test: str, settings: Settings, limits: Limits, ship: Ship) -> Option | None:
    """A run with the time it takes; None where the tank is too short for it."""
    length = limits.tank_length
    if settings.period is None or not TEST_KINDS[test].oscillates:
        record, cycles = min(LENGTHS * ship.L, length) / settings.speed, 0
    else:
        room = length / settings.speed / settings.period
        cycles = limits.cycles if room >= limits.cycles else int(room)
        record = cycles * settings.period
        if cycles < FEWEST:
            return None
    hours = (record + limits.wait) / 3600.0
    return Option(test=test, settings=settings, cycles=cycles, record=record, hours=hours)


def _possible(option: Option, limits: Limits, ship: Ship, water: Water) -> bool:
    s = option.settings
    omega = s.omega or 0.0
    if omega * s.speed / water.g > BREAKING:
        return False
    if (s.amplitude or 0.0) > limits.sway * 1.001:
        return False
    if abs(s.yaw_amplitude or 0.0) > limits.yaw * 1.001:
        return False
    across = s.amplitude or 0.0
    if s.yaw_amplitude and omega and not TEST_KINDS[option.test].sways:
        across = s.speed * abs(s.yaw_amplitude) / omega
    return across + 1.5 * ship.B <= limits.tank_width / 2.0


Given = Iterator[dict[str, Any]]


def _grid(kind: TestKind, limits: Limits, ship: Ship, speed: float) -> Given:
    """Settings of one kind of test at a speed."""
    for swing in _swings(kind, limits, ship, speed):
        for angles in _angles(kind, limits):
            yield {**swing, **angles}


def _angles(kind: TestKind, limits: Limits) -> Given:
    """Angles that are held, the last of them to both sides: a mirrored test tells the same."""
    found: list[dict[str, float]] = [{}]
    for name in kind.held:
        largest, shares = getattr(limits, name), (kind.shares or {}).get(name, ())
        if name == kind.held[-1]:
            values = list(_sides(largest, shares))
        else:
            values = [share * largest for share in shares]
        found = [{**given, name: value} for given in found for value in values]
    yield from found


def _sides(largest: float, shares: Sequence[float]) -> Iterator[float]:
    if largest > 0:
        for share in shares:
            yield from (share * largest, -share * largest)


def _swings(kind: TestKind, limits: Limits, ship: Ship, speed: float) -> Given:
    """Periods and amplitudes of an oscillation."""
    shares = kind.shares or {}
    if not kind.oscillates:
        yield {}
        return
    for frequency in limits.frequencies:
        omega, period = frequency * speed / ship.L, 2 * math.pi * ship.L / (frequency * speed)
        if kind.yaws and kind.sways:
            # The heading lags sway by a quarter period: v is a ω + U ψ0 at its largest.
            for share in shares["yaw_amplitude"]:
                most = (share * limits.yaw_rate / frequency, share * limits.sway_velocity)
                yaw = min(*most, limits.yaw)
                sway = (limits.sway_velocity - yaw) * ship.L / frequency
                yield {"period": period, "yaw_amplitude": yaw, "amplitude": min(sway, limits.sway)}
        elif kind.yaws:
            largest = min(limits.yaw_rate / frequency, limits.yaw)
            for share in shares["yaw_amplitude"]:
                yield {"period": period, "yaw_amplitude": share * largest}
        else:
            largest = min(limits.sway_velocity * speed / omega, limits.sway)
            for share in shares["amplitude"]:
                yield {"period": 2 * math.pi / omega, "amplitude": share * largest}
