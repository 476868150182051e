"""A manoeuvre as an entry: its settings, the function that makes its plan, its metrics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from pmmkit.base import did_you_mean
from pmmkit.conventions import Metric
from pmmkit.equations import Plan

if TYPE_CHECKING:
    from pmmkit.plotting import Drawn


# Functions of one number or of an array of them: the plain ones are ten times as fast for one.


def hypot(a: Any, b: Any) -> Any:
    """sqrt(a² + b²)."""
    return math.hypot(a, b) if isinstance(a, float) else np.hypot(a, b)


def cos(angle: Any) -> Any:
    """Cosine."""
    return math.cos(angle) if isinstance(angle, float) else np.cos(angle)


def arctan2(y: Any, x: Any) -> Any:
    """Angle of (x, y)."""
    return math.atan2(y, x) if isinstance(y, float) else np.arctan2(y, x)


def degrees(angle: Any) -> Any:
    """From radians."""
    return math.degrees(angle) if isinstance(angle, float) else np.degrees(angle)


def larger(a: Any, b: Any) -> Any:
    """The larger of two, NaN where one is NaN."""
    if isinstance(a, float):
        return math.nan if math.isnan(a) or math.isnan(b) else max(a, b)
    return np.maximum(a, b)


def chosen(condition: Any, yes: Any, no: Any) -> Any:
    """One of two."""
    if isinstance(condition, (bool, np.bool_)):
        return yes if condition else no
    return np.where(condition, yes, no)


STEEPEST: Final = 90.0
"""Largest angle of a rudder that is taken [deg]."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A setting of a manoeuvre.

    Parameters
    ----------
    name : str
        As `simulate` and the command line take it.
    text : str
        What it is.
    unit : str
        ``deg``, ``s`` or ``-``.
    default : float, optional
        Value where none is given; None leaves it to the manoeuvre.
    required : bool
        Whether it must be given.
    takes : {"positive", "side", "angle", "any"}
        Positive numbers; angles up to 90° to either side but 0; the same with 0; any number.
    below : float
        What it must stay below.
    whole : bool
        Whether it is a whole number.
    std : float
        How ships differ in it where nobody states it, about the default.
    engine : bool
        Whether it is of the ship's engine, and none of the orders.

    Examples
    --------
    >>> heading = Setting(name="heading_deg", text="heading", unit="deg", default=10.0)
    >>> heading.problem(-3.0), heading.problem(20)
    ('heading_deg = -3.0 must be positive.', None)
    """

    name: str
    text: str
    unit: str
    default: float | None = None
    required: bool = False
    takes: Literal["positive", "side", "angle", "any"] = "positive"
    below: float = math.inf
    whole: bool = False
    std: float = 0.0
    engine: bool = False

    def problem(self, value: Any) -> str | None:
        """What is wrong with a value; None where nothing is."""
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return f"{self.name} = {value!r} must be a number."
        if self.takes in ("side", "angle"):
            good = abs(value) <= STEEPEST and (value != 0 or self.takes == "angle")
            but = ", not 0" if self.takes == "side" else ""
            wants = f"an angle up to {STEEPEST:g}° to either side{but}"
        elif self.takes == "any":
            good, wants = math.isfinite(value), "a finite number"
        elif not (math.isfinite(value) and value > 0):
            good, wants = False, "positive"
        elif value >= self.below:
            good, wants = False, f"below {self.below:g}"
        else:
            good, wants = not self.whole or value == int(value), "a whole number"
        return None if good else f"{self.name} = {value} must be {wants}."


def rudder_setting(default: float) -> Setting:
    """The rudder angle of the first order, with its usual value [deg]."""
    return Setting(
        name="rudder_deg",
        text="rudder, positive to starboard",
        unit="deg",
        default=default,
        takes="side",
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Manoeuvre:
    """A manoeuvre.

    Parameters
    ----------
    name : str
        As `simulate` and the command line take it.
    title : str
        The long name.
    settings : tuple of Setting
        What can be set.
    orders : callable
        From the approach speed over the ship length [1/s] and each setting, as a keyword, to the
        `Plan`.
    metrics : tuple of Metric
        What it gives.
    drawn : {"turning circle", "zigzag", "spiral", "path"}
        The figure that shows it.
    asks_for_wind : bool
        Whether `orders` takes the keyword ``wind`` too: whether there is wind.
    asks_for_bucket : bool
        The same of ``bucket``: whether a bucket turns the ship's thrust astern.
    asks_for_speed : bool
        The same of ``speed``: the approach speed [m/s].
    reverses : bool
        Whether the engine is reversed: what it does is assumed where the model does not say it
        (`pmmkit.simulation.machinery`).
    held_straight : bool
        Whether the ship is held straight, with a hull that resists astern as ahead
        (`pmmkit.simulation.straight`): of a manoeuvre in which she moves astern.
    """

    name: str
    title: str
    settings: tuple[Setting, ...]
    orders: Callable[..., Plan]
    metrics: tuple[Metric, ...]
    drawn: Drawn = "path"
    asks_for_wind: bool = False
    asks_for_bucket: bool = False
    asks_for_speed: bool = False
    reverses: bool = False
    held_straight: bool = False

    def problems(self, given: Mapping[str, Any]) -> list[str]:
        """What is wrong with settings, all of it."""
        known = {setting.name: setting for setting in self.settings}
        found = [
            f"{self.name} needs {name}: {setting.text} [{setting.unit}]."
            for name, setting in known.items()
            if setting.required and given.get(name) is None
        ]
        for name, value in given.items():
            if name not in known:
                guess = did_you_mean(name, known) or "."
                found.append(f"{self.name} has no {name}{guess} It has {', '.join(known)}.")
            elif value is not None and (wrong := known[name].problem(value)):
                found.append(wrong)
        return found

    def plan(
        self,
        pace: float,
        *,
        speed: float = math.nan,
        wind: bool = False,
        bucket: bool = False,
        **settings: Any,
    ) -> Plan:
        """The plan for a ship.

        Parameters
        ----------
        pace : float
            Approach speed over the ship length [1/s].
        speed : float
            Approach speed [m/s], for a manoeuvre that asks for it.
        wind : bool
            Whether there is wind.
        bucket : bool
            Whether a bucket turns the ship's thrust astern.
        **settings
            Of the manoeuvre; the others have their defaults.

        Raises
        ------
        DataError
            If settings do not go together.
        """
        around = tuple(self.around(speed=speed, wind=wind, bucket=bucket).items())
        return _planned(self, pace, around, tuple(settings.items()))

    def around(
        self, *, speed: float = 1.0, wind: bool = False, bucket: bool = False
    ) -> dict[str, float]:
        """What `orders` asks for beside the settings, with its answers."""
        asked = {
            "speed": (self.asks_for_speed, speed),
            "wind": (self.asks_for_wind, wind),
            "bucket": (self.asks_for_bucket, bucket),
        }
        return {name: answer for name, (asks, answer) in asked.items() if asks}

    def filled(self, given: Mapping[str, Any], *, engine: bool = True) -> dict[str, Any]:
        """All settings, or the orders alone, those that are not given with their defaults."""
        found: dict[str, Any] = {}
        for setting in self.settings:
            if setting.engine and not engine:
                continue
            value = given.get(setting.name)
            value = setting.default if value is None else value
            found[setting.name] = int(value) if setting.whole and value is not None else value
        return found


@lru_cache(maxsize=256)
def _planned(
    manoeuvre: Manoeuvre,
    pace: float,
    around: tuple[tuple[str, float], ...],
    given: tuple[tuple[str, Any], ...],
) -> Plan:
    settings = manoeuvre.filled(dict(given), engine=False)
    plan = manoeuvre.orders(pace, **settings, **dict(around))
    return replace(plan, name=manoeuvre.name, metrics=manoeuvre.metrics)
