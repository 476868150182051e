"""Histories with the band in which other ships of the same tests lie."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Protocol

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import style
from pmmkit.plotting.figure import Figure

# What is drawn of a free-running history, whatever holds it.


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
    def forces(self) -> Mapping[str, Array]:
        """X, Y [N] and N [N m] (3, m) of each effect; empty where they are not kept."""

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


PALE: Final = "#d3d9e6"
"""Fill of a band; opaque, so that it may lie over itself."""


class Band(Protocol):
    """What is drawn of `Bands`."""

    @property
    def track(self) -> TrackLike:
        """The ship as it is."""

    @property
    def low(self) -> Mapping[str, Array]:
        """Lower ends of the band of each channel over time."""

    @property
    def high(self) -> Mapping[str, Array]:
        """Upper ends."""

    @property
    def inner(self) -> Array:
        """One edge of the band of the path, x and y [m]."""

    @property
    def outer(self) -> Array:
        """The other edge."""

    @property
    def measures(self) -> Mapping[str, tuple[float, float]]:
        """Central 95 % of the metrics."""

    @property
    def ships(self) -> int:
        """How many."""


def band_histories(band: Band) -> Figure:
    """Heading, rudder, yaw rate and speed over time, each with its band of 95 %.

    Parameters
    ----------
    band : Bands
        From `bands_of`.

    Returns
    -------
    Figure
        A panel a quantity; dotted lines stand at the orders where these are few.
    """
    track = band.track
    panels = (
        ("heading ψ [deg]", "psi", np.degrees(track.psi), np.degrees(1.0)),
        ("rudder δ [deg]", "delta", np.degrees(track.delta), np.degrees(1.0)),
        ("yaw rate r [deg/s]", "r", np.degrees(track.r), np.degrees(1.0)),
        ("surge velocity u [m/s]", "u", track.u, 1.0),
        ("sway velocity v [m/s]", "v", track.v, 1.0),
    )
    figure = Figure(height=1.35 * len(panels) + 0.6)
    axes = figure.subplots(len(panels), 1, sharex=True)
    for axis, (title, channel, values, factor) in zip(axes, panels, strict=True):
        axis.fill_between(
            track.t,
            factor * band.low[channel],
            factor * band.high[channel],
            color=PALE,
            label=f"95 % of {band.ships} ships",
        )
        axis.plot(track.t, values, color=style.colour(0), label="as it is")
        for instant in track.orders if len(track.orders) <= style.FEW else ():
            axis.axvline(instant, color=style.REFERENCE, lw=0.8, ls=":", label="order", zorder=1.6)
        style.widened(axis)
        axis.set_title(title)
    axes[-1].set_xlabel("time from the first order [s]")
    figure.legend_below(list(axes))
    return figure
