"""What is drawn of a free-running history, whatever holds it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from pmmkit.numerics import Array


class TrackLike(Protocol):
    """A free-running history: arrays over the time, SI and radians, and what they are of.

    A `Track` has this shape, and so has anything else with these attributes, whatever `args` and
    `kwargs` it was made of.
    """

    def __len__(self) -> int: ...

    @property
    def t(self) -> Array:
        """Time [s]."""

    @property
    def x(self) -> Array:
        """Path in the direction of the approach [m]."""

    @property
    def y(self) -> Array:
        """Path to starboard of the approach [m]."""

    @property
    def psi(self) -> Array:
        """Heading without jumps of 2π [rad]."""

    @property
    def u(self) -> Array:
        """Surge velocity [m/s]."""

    @property
    def v(self) -> Array:
        """Sway velocity [m/s]."""

    @property
    def r(self) -> Array:
        """Yaw rate [rad/s]."""

    @property
    def phi(self) -> Array:
        """Heel [rad]."""

    @property
    def delta(self) -> Array:
        """Rudder angle [rad]."""

    @property
    def n(self) -> Array:
        """Revolutions of the propeller [1/s]."""

    @property
    def name(self) -> str:
        """Of the ship or model."""

    @property
    def L(self) -> float:
        """Ship length [m]."""

    @property
    def speed(self) -> float:
        """Approach speed [m/s]."""

    @property
    def Fn(self) -> float:
        """Its Froude number."""

    @property
    def rudder_deg(self) -> float:
        """Ordered rudder angle [deg]."""

    @property
    def metrics(self) -> Mapping[str, float]:
        """Numbers of the manoeuvre."""

    @property
    def orders(self) -> tuple[float, ...]:
        """Instants of the orders [s]."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """Of the manoeuvre, as they were given."""
