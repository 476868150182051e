"""What an effect sees of a run and of a vessel, and what it may say of both.

An effect knows nothing of runs and models: it is asked through these.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from pmmkit.conventions import Ship, Water
from pmmkit.effects.state import State
from pmmkit.numerics import Array

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


Forces = Mapping[str, Array]
"""By channel, in a form of which sums and multiples have a meaning: harmonics, histories, or the
histories that each derivative multiplies."""


Factor = Callable[[Array, Array], NDArray[np.complex128]]
"""From the numbers n of harmonics and ω [rad/s] to what multiplies them; e^(-iφ) delays by φ."""


class Observed(Protocol):
    """Captive records and the forces of the water on the model, as faults see them.

    Several runs one after another: what is told of a run is told of each sample (n,).
    """

    @property
    def ship(self) -> Ship:
        """The model that was tested."""

    @property
    def water(self) -> Water:
        """The water of the tank."""

    @property
    def motion(self) -> State:
        """Motion of midship at n samples, as it is stated or was recorded."""

    @property
    def heading(self) -> Array:
        """Heading in the tank at the samples [rad]."""

    @property
    def drift(self) -> Array:
        """Heading about which the model is swung [rad]."""

    @property
    def t(self) -> Array:
        """Time of the samples [s]."""

    @property
    def speed(self) -> Array:
        """Speed of the carriage [m/s]."""

    @property
    def omega(self) -> Array:
        """Angular frequency of the oscillation [rad/s]; 0 for a steady run."""

    @property
    def sways(self) -> Array:
        """Whether the rig oscillates the model across the tank."""

    @property
    def yaws(self) -> Array:
        """Whether the rig oscillates the heading."""

    @property
    def day(self) -> Array:
        """Where the run stands between the first (0) and the last (1) of the campaign."""

    @property
    def forces(self) -> Forces:
        """The forces of the water along the motion, by channel [N, N m]."""

    def along(self, motion: State, *, speed: float | Array | None = None) -> Forces:
        """The forces of the water if the model, or its carriage, went otherwise."""

    def means(self, history: Array) -> Array:
        """Mean of a history (n,) over each run, at its samples (n,)."""

    def project(self, history: Array) -> Array:
        """A history (n,) in the form of the forces."""

    def shaped(self, force: Array, shape: Callable[[Array], Array]) -> Array:
        """A force of which each instant is changed by itself: from samples to samples."""

    def times(self, force: Array, history: Array) -> Array:
        """A force times a history (n,)."""

    def filtered(self, factor: Factor, *channels: str) -> dict[str, Array]:
        """The forces of some channels, or of all, with each harmonic times a factor."""


Acts = Callable[[Observed, Mapping[str, float]], Forces]
"""What the gauges show in the channels that a fault changes, from the records and the values of its
parameters [N, N m]."""
