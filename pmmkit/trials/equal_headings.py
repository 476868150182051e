"""The current by the drift between equal headings of a turn, as the explanatory notes have it."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.trials.current import Current

FROM: Final = math.pi
"""Change of heading from which on data count [rad]: MSC/Circ.1053, 3.4.2.5."""
TURN: Final = 2.0 * math.pi
WHOLE: Final = 720.0
"""Change of heading that the notes ask for [deg]: the same."""
EVERY: Final = math.radians(5.0)
"""Spacing of the headings that are compared [rad]."""


def equal_headings(t: Array, x: Array, y: Array, psi: Array) -> Current | None:
    """The current from places that lie a whole turn apart.

    Parameters
    ----------
    t, x, y, psi : array (n,)
        From the rudder order to the next order: increasing times [s], positions of midship [m],
        heading [rad] without jumps of 2π.

    Returns
    -------
    Current or None
        Mean of the velocities between the places of equal heading, from 180° of the turn on, with
        the scatter of them as uncertainty; None of a turn of less than 540°.

    Notes
    -----
    In a steady turn the ship is back on her circle after 360°, and has moved by the current alone.
    A ship that still loses speed has not: there `fit_circle`, which lets the speed die away, is the
    better one. Neighbouring differences share their fixes, so the scatter is not divided by their
    number.

    References
    ----------
    IMO MSC/Circ.1053, Explanatory notes to the Standards for ship manoeuvrability, 2002, 3.4.2.5.

    Examples
    --------
    >>> t = np.arange(0.0, 1300.0, 2.0)
    >>> psi = 0.01 * t
    >>> x, y = 500 * np.sin(psi) + 0.3 * t, 500 * (1 - np.cos(psi)) - 0.1 * t
    >>> found = equal_headings(t, x, y, psi)
    >>> round(found.x, 3), round(found.y, 3)
    (0.3, -0.1)
    """
    turned = np.abs(psi - psi[0])
    rising = np.maximum.accumulate(turned)
    kept = np.concatenate(([True], np.diff(rising) > 0.0))
    headings = np.arange(FROM, float(rising[-1]) - TURN, EVERY)
    if not len(headings):
        return None

    def at(level: Array, values: Array) -> Array:
        return np.interp(level, rising[kept], values[kept])

    lasted = at(headings + TURN, t) - at(headings, t)
    moved = np.stack([(at(headings + TURN, p) - at(headings, p)) / lasted for p in (x, y)])
    mean, spread = (
        moved.mean(axis=1),
        np.cov(moved, ddof=0) if len(headings) > 1 else np.zeros((2, 2)),
    )
    return Current(
        x=float(mean[0]),
        y=float(mean[1]),
        covariance=(float(spread[0, 0]), float(spread[1, 1]), float(spread[0, 1])),
        origin="drift between equal headings",
    )
