"""Velocities over ground and in ship axes, and the true wind, of a free-running record."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array, unwrapped
from pmmkit.signals.local import local

SMOOTHED: Final = 0.15
"""Half of the window of local fits in ship lengths over the approach speed, at least 3 samples."""


def half_window(t: Array, L: float, speed: float) -> float:
    """Half of the window in which places and headings of a record are smoothed [s].

    Parameters
    ----------
    t : array (n,)
        Increasing times [s].
    L, speed : float
        Ship length [m] and speed of the approach [m/s].

    Examples
    --------
    >>> half_window(np.arange(60.0), 320.0, 8.0), half_window(np.arange(60.0), 7.0, 1.2)
    (6.0, 3.0)
    """
    return max(SMOOTHED * L / speed, 3.0 * float(np.median(np.diff(t))))


def velocity(t: Array, x: Array, y: Array, at: ArrayLike, half: float) -> tuple[Any, Any]:
    """Velocity along x and y at an instant or at several, from the positions about it.

    Parameters
    ----------
    t, x, y : array (n,)
        Increasing times [s] and positions [m].
    at : float or array (m,)
        The instants [s].
    half : float
        Half of the window in which places are smoothed [s]; slopes take one twice as wide.

    Returns
    -------
    float or array (m,), float or array (m,)
        [m/s]

    Examples
    --------
    >>> t = np.arange(0.0, 60.0)
    >>> ahead, aside = velocity(t, 5.0 * t, 0.01 * t**2, [10.0, 30.0], 3.0)
    >>> ahead.round(6).tolist(), aside.round(6).tolist()
    ([5.0, 5.0], [0.2, 0.6])
    """
    window = 2.0 * half
    return local(t, x, at, window).slope, local(t, y, at, window).slope


def over_ground(u: Array, v: Array, psi: Array, phi: Array | float = 0.0) -> tuple[Array, Array]:
    """Velocities of a ship along x (north) and y (east) from those in her axes.

    Parameters
    ----------
    u, v : array (n,)
        Surge and sway velocity [m/s]; those through the water give the way through the water.
    psi : array (n,)
        Heading [rad].
    phi : array (n,), optional
        Heel [rad], by which the sway leans out of the horizontal plane.

    Examples
    --------
    >>> north, east = over_ground(np.array([2.0]), np.array([-1.0]), np.array([np.pi / 2]))
    >>> north.round(9).tolist(), east.round(9).tolist()
    ([1.0], [2.0])
    """
    ahead, aside = np.cos(psi), np.sin(psi)
    level = v * np.cos(phi)
    return u * ahead - level * aside, u * aside + level * ahead


def in_ship_axes(
    north: Array, east: Array, psi: Array, phi: Array | float = 0.0
) -> tuple[Array, Array]:
    """Surge and sway velocity of a ship from those along x (north) and y (east).

    Parameters
    ----------
    north, east : array (n,)
        [m/s]
    psi, phi
        As for `over_ground`, of which this is the inverse.

    Examples
    --------
    >>> u, v = in_ship_axes(np.array([1.0]), np.array([2.0]), np.array([np.pi / 2]))
    >>> u.round(9).tolist(), v.round(9).tolist()
    ([2.0], [-1.0])
    """
    ahead, aside = np.cos(psi), np.sin(psi)
    return north * ahead + east * aside, (east * ahead - north * aside) / np.cos(phi)


def true_wind(
    psi: Array, speed: Array, direction: Array, north: Array, east: Array
) -> tuple[Array, Array]:
    """True wind over ground from that which a ship feels.

    Parameters
    ----------
    psi : array (n,)
        Heading [rad].
    speed, direction : array (n,)
        Of the relative wind [m/s] and where it comes from, from the bow to starboard [rad].
    north, east : array (n,)
        Velocity of the ship over ground [m/s]. That through the water makes a wind that is off by
        the current.

    Returns
    -------
    array (n,), array (n,)
        Speed [m/s] and where it comes from, from north, without jumps of 2π [rad]; NaN where
        something is not known.

    Examples
    --------
    A ship at 4 m/s to the east in a calm feels her own way from ahead:

    >>> still, four = np.zeros(1), np.array([4.0])
    >>> true_wind(np.array([np.pi / 2]), four, still, still, four)[0].round(9)
    array([0.])
    >>> blows, comes_from = true_wind(still, np.array([10.0]), still, four, still)
    >>> blows.tolist(), comes_from.tolist()
    ([6.0], [0.0])
    """
    way = direction + psi
    along, across = speed * np.cos(way) - north, speed * np.sin(way) - east
    return np.hypot(along, across), unwrapped(np.arctan2(across, along))
