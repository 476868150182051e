"""Rows of a channel, and what differs from run to run."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

Places = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """Rows of one channel: the means and harmonics of all views that have it.

    Parameters
    ----------
    name : str
        X, Y, N or K.
    views : tuple of int
        Views that have it.
    rows : tuple of slice
        Their rows.
    runs : tuple of array
        Rows of each run.
    y : array (n,)
        Forces.
    design : array (n, p)
        Base.
    noise : tuple of array (m, m)
        Covariance of the noise of each run's rows.
    scale : float
        Root mean square over the views of the force over U² [N/(m/s)²].
    """

    name: str
    views: tuple[int, ...]
    rows: tuple[slice, ...]
    runs: tuple[Places, ...]
    y: Array
    design: Array
    noise: tuple[Array, ...]
    scale: float


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """What differs from run to run: offset over the scale, gain, drift setting [deg]."""

    offset: float = 0.003
    gain: float = 0.004
    drift: float = 0.0

    @property
    def sizes(self) -> Array:
        """The three, in the order of the columns of what each run draws."""
        return np.array([getattr(self, name) for name in self.names()])

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """What a run may draw, in that order."""
        return tuple(field.name for field in fields(cls))
