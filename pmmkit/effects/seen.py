"""What an effect sees of a run and of a vessel, and what it may say of both.

An effect knows nothing of runs and models: it is asked through these.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, Protocol

from pmmkit.effects.state import State
from pmmkit.numerics import Array
from pmmkit.ship import Ship, Water

CURRENT: Final = ("current_x", "current_y")
"""Velocity of the water over ground [m/s]; no values of a model."""
RUDDER_ZERO: Final = "rudder_zero"
"""The angle that a rudder column shows too little [rad]; no value of a model."""
CLOCK_LAG: Final = "clock_lag"
"""By how much the clock of the positions is late [s]."""
ANTENNA: Final = ("antenna_x", "antenna_y")
"""Where the antenna of the positions stands, forward and starboard of midship [m]."""
HEADING_OFFSET: Final = "heading_offset"
"""What the heading shows too much [rad]."""
LOG_GAIN: Final = "log_gain"
"""The share by which a log shows too much."""
SHOWN: Final = (CLOCK_LAG, *ANTENNA, HEADING_OFFSET, LOG_GAIN)
"""What the channels of a free-running record show wrongly."""
OUTSIDE: Final = (*CURRENT, RUDDER_ZERO, *SHOWN)
"""What records may be off by that is no value of a model."""
EXCITES: Final = {
    "several speeds": "runs at two speeds or more",
    "four speeds": "runs at four speeds or more",
    "repeats": "a run that was repeated later",
    "roll": "heel or roll",
    "rudder": "rudder angles",
    "large motion": "drift beyond 17° or a yaw rate r' beyond 0.8",
    "sinkage": "measured sinkage",
    "wind": "measured wind",
    "depth": "a stated depth of less than six draughts",
    "waves": "a stated sea, and a table of its drift in the model",
}
"""What tests must hold to show an effect, and what that means."""


def _none() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Move:
    """How a coefficient moves values.

    Parameters
    ----------
    values : mapping of str to float
        By how much each value moves for a coefficient of 1. Values are named as in `identify`:
        derivatives by their names, others with their part (``rudder_mmg.aH``); beside them
        `CURRENT` and `RUDDER_ZERO`.
    typical : float
        Usual size of the coefficient.
    options : mapping of str to (mapping of str to str)
        By part: the words that it has to be told to use these values.
    begins : mapping of str to float
        What values are where the part did not use them before, as ``rudder_mmg.stall_loss``.
    """

    values: Mapping[str, float]
    typical: float
    options: Mapping[str, Mapping[str, str]] = field(default_factory=_none)
    begins: Mapping[str, float] = field(default_factory=_none)


class Vessel(Protocol):
    """A ship, what its model holds, and how fast it sails."""

    @property
    def ship(self) -> Ship:
        """Particulars."""

    @property
    def water(self) -> Water:
        """The water it sails in."""

    @property
    def speed(self) -> float:
        """Speed of the approach [m/s]."""

    def derivatives(self) -> Mapping[str, float]:
        """Derivatives of hull and added mass by name, in the convention of the model."""

    def holds(self, part: str, value: str) -> bool:
        """Whether a part of the model uses a value, with the options it has."""


class Observed(Protocol):
    """A captive run, and what a fitted base says of it."""

    @property
    def ship(self) -> Ship:
        """The model that was tested."""

    @property
    def water(self) -> Water:
        """The water of the tank."""

    @property
    def motion(self) -> State:
        """Motion of midship at n samples."""

    @property
    def heading(self) -> Array:
        """Heading in the tank at the samples [rad]."""

    @property
    def t(self) -> Array:
        """Time of the samples [s]."""

    @property
    def speed(self) -> float:
        """Speed of the carriage [m/s]."""

    @property
    def omega(self) -> float:
        """Angular frequency of the oscillation [rad/s]; 0 for a steady run."""

    @property
    def sways(self) -> bool:
        """Whether the rig oscillates the model across the tank."""

    @property
    def yaws(self) -> bool:
        """Whether the rig oscillates the heading."""

    @property
    def day(self) -> float:
        """Where the run stands between the first (0) and the last (1) of the campaign."""

    @property
    def expected(self) -> Mapping[str, Array]:
        """Harmonics of the forces of the base, by channel [N, N m]."""

    def project(self, history: Array) -> Array:
        """Harmonics of a history (n,)."""

    def filtered(self, factor: Callable[[int], complex]) -> Mapping[str, Array]:
        """Harmonics of the forces of the base, the n-th multiplied by a complex factor."""

    def changed(
        self, motion: State, step: float, *, speed: float | None = None
    ) -> Mapping[str, Array]:
        """Change of the forces of the base per unit of a step that leads to another motion."""
