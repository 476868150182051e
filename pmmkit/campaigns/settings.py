"""What one test was set to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, Final

from pmmkit.campaigns.run_settings import RUN_SETTINGS
from pmmkit.campaigns.setting import Told


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What the test was set to, SI and radians, our signs.

    Parameters
    ----------
    speed : float
        Carriage speed, or approach speed of a free-running test [m/s].
    drift, heel, rudder : float
        Drift angle beta, heel and rudder angle [rad].
    propeller_rps : float or None
        Propeller revolutions per second; None where unknown.
    period : float, optional
        Period of the oscillation [s].
    amplitude : float, optional
        Amplitude of the sway (surge) displacement [m].
    yaw_amplitude : float, optional
        Amplitude of the heading [rad].
    rudder_amplitude : float, optional
        Amplitude of a rudder that swings about `rudder` [rad].
    phase : float
        Phase of the displacement at t = 0: y = a sin(ωt + phase) [rad].
    yaw_rate, radius : float, optional
        Circular motion: yaw rate [rad/s] or radius [m].
    strut_spacing : float, optional
        Distance along the rails of the two struts that swing the model, negative where the aft
        one is pivoted to it [m]. The motion is then theirs: `amplitude` is that of the point
        midway, `yaw_amplitude` the largest heading of the line of struts.
    strut_centre : float
        That point at rest, forward of the point whose motion is meant [m].
    depth : float, optional
        Depth of the water [m]; that of the campaign's water where it is not stated.
    switch : float, optional
        Heading at which a zigzag switches [rad].
    wave_height, wave_period : float, optional
        Significant height [m] and peak period [s] of the sea.
    waves_from : float, optional
        Direction it comes from, from north [rad].
    repeat_of : str, optional
        The run that this one repeats.
    further : tuple of (str, float)
        Settings that kinds of test bring along, by name.
    """

    speed: float
    drift: float = 0.0
    heel: float = 0.0
    rudder: float = 0.0
    propeller_rps: float | None = None
    period: float | None = None
    amplitude: float | None = None
    yaw_amplitude: float | None = None
    rudder_amplitude: float | None = None
    phase: float = 0.0
    yaw_rate: float | None = None
    radius: float | None = None
    strut_spacing: float | None = None
    strut_centre: float = 0.0
    depth: float | None = None
    switch: float | None = None
    wave_height: float | None = None
    wave_period: float | None = None
    waves_from: float | None = None
    repeat_of: str | None = None
    further: tuple[tuple[str, float], ...] = field(default=(), repr=False)

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Settings:
        """Settings by name, those that kinds of test bring along among them.

        Raises
        ------
        UnknownNameError
            If a name is that of no setting.
        """
        plain = {name: value for name, value in given.items() if name in _OWN}
        more = {name: value for name, value in given.items() if name not in _OWN}
        further = tuple((RUN_SETTINGS[name].name, float(value)) for name, value in more.items())
        return cls(**plain, further=further)

    def with_(self, name: str, value: float) -> Settings:
        """The same with another value of a setting."""
        if name in _OWN:
            changed: dict[str, Any] = {name: value}
            return replace(self, **changed)
        return replace(self, further=tuple({**dict(self.further), name: value}.items()))

    def value(self, name: str) -> float | None:
        """A setting by its name, or by a property such as `turn_rate`; None where unstated."""
        if hasattr(self, name):
            known: float | None = getattr(self, name)
            return known
        return dict(self.further).get(RUN_SETTINGS[name].name)

    def plain(self) -> dict[str, Any]:
        """All by name, for files."""
        found = asdict(self)
        return found | dict(found.pop("further"))

    @property
    def turn_rate(self) -> float:
        """Yaw rate of a steady turn [rad/s]: the stated one before speed/radius; else zero."""
        if self.yaw_rate is not None:
            return self.yaw_rate
        return self.speed / (self.radius or math.inf)

    @property
    def largest_rudder(self) -> float:
        """The largest rudder angle that the test makes, to either side [rad]."""
        return abs(self.rudder) + abs(self.rudder_amplitude or 0.0)

    @property
    def words(self) -> tuple[str, ...]:
        """What is set besides the speed, with units."""
        return tuple(f"{told.symbol} {value:{told.form}}{told.unit}" for told, value in self.told)

    @property
    def told(self) -> tuple[tuple[Told, float], ...]:
        """What is set besides the speed and is not zero; a circle by its rate."""
        angles = {"°": math.degrees, "°/s": math.degrees}
        return tuple(
            (told, angles.get(told.unit, float)(value))
            for item in RUN_SETTINGS.told
            if (told := item.told) and (value := self.value(told.shown or item.name))
        )

    @property
    def omega(self) -> float | None:
        """Angular frequency 2π/period [rad/s]."""
        return None if self.period is None else 2 * math.pi / (self.period or math.inf)


_OWN: Final = frozenset(item.name for item in fields(Settings)) - {"further"}
"""Names of fields of `Settings`; the others stand in `further`."""
