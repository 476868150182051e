"""Rows of a channel, and what differs from run to run."""

from __future__ import annotations

from dataclasses import dataclass

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
