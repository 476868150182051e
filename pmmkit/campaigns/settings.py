"""What one test was set to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

SETTING_KEYS: Final = {
    "drift": "drift_deg",
    "heel": "heel_deg",
    "rudder": "rudder_deg",
    "switch": "switch_deg",
    "yaw_amplitude": "yaw_amplitude_deg",
    "rudder_amplitude": "rudder_amplitude_deg",
    "amplitude": "amplitude_m",
    "phase": "phase_deg",
    "waves_from": "waves_from_deg",
}
"""Keys of a campaign file that differ from the names in `Settings`, which are SI."""


def setting_key(name: str) -> str:
    """Key of a campaign file that states a setting.

    Examples
    --------
    >>> setting_key("drift"), setting_key("period")
    ('drift_deg', 'period')
    """
    return SETTING_KEYS.get(name, name)


_TOLD: Final = (
    ("drift", "β", "drift", "°", "+.3g"),
    ("rudder", "δ", "rudder", "°", "+.3g"),
    ("heel", "heel", "heel", "°", "+.3g"),
    ("amplitude", "a", "sway", " m", ".4g"),
    ("yaw_amplitude", "ψ", "yaw", "°", ".3g"),
    ("rudder_amplitude", "δ0", "rudder swing", "°", ".3g"),
    ("period", "T", "period", " s", ".4g"),
    ("turn_rate", "r", "yaw rate", "°/s", "+.3g"),
    ("switch", "switch", "switch", "°", ".3g"),
    ("propeller_rps", "n", "propeller", "/s", ".4g"),
    ("depth", "h", "depth", " m", ".4g"),
    ("wave_height", "H", "waves", " m", ".3g"),
    ("wave_period", "Tp", "waves of", " s", ".3g"),
    ("waves_from", "waves from", "waves from", "°", ".3g"),
)
"""Settings in the order in which they are told: name, symbol, word, unit, and how a number is
written beside the symbol."""


class SettingInWords(NamedTuple):
    """A setting as people read it."""

    symbol: str
    word: str
    value: float
    unit: str
    form: str


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
        return tuple(f"{item.symbol} {item.value:{item.form}}{item.unit}" for item in self.told)

    @property
    def told(self) -> tuple[SettingInWords, ...]:
        """What is set besides the speed and is not zero; a circle by its rate."""
        angles = {"°": math.degrees, "°/s": math.degrees}
        return tuple(
            SettingInWords(symbol, word, angles.get(unit, float)(value), unit, form)
            for name, symbol, word, unit, form in _TOLD
            if (value := getattr(self, name))
        )

    @property
    def omega(self) -> float | None:
        """Angular frequency 2π/period [rad/s]."""
        return None if self.period is None else 2 * math.pi / (self.period or math.inf)
