"""Sums along the length: what sections have, times a wave that runs along the hull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

# Kinds of arrays of this room beside `pmmkit.numerics.Array`.


Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]


_GAUSS = 4  # per interval: exact to a hundredth of a percent for waves of two intervals


def weights(x: Array, along: Array) -> Complex:
    """Weights of stations for ∫ f(x) e^(-iκx) dx and ∫ x f(x) e^(-iκx) dx.

    f runs straight between stations while the wave is taken as it is, so that waves that are short
    beside the distance of stations are integrated too.

    x (stations,); x [m]; along [1/m].

    Examples
    --------
    >>> weights(np.array([0.0, 1.0, 3.0]), np.zeros(1))[0].real.round(12)
    array([[0.5, 1.5, 1. ]])
    """
    nodes, gauss = np.polynomial.legendre.leggauss(_GAUSS)
    share = 0.5 * (nodes + 1)
    step = np.diff(x)
    places = (x[:-1, None] + step[:, None] * share).ravel()
    sizes = (step[:, None] * 0.5 * gauss).ravel()
    hats = np.array([np.interp(places, x, row) for row in np.eye(x.size)])
    wave = np.exp(-1j * np.multiply.outer(along, places)) * sizes
    return np.asarray(np.stack([wave @ hats.T, (wave * places) @ hats.T]))


def second(x: Array) -> Array:
    """Weights of stations for ∫ x² f(x) dx, f straight between them.

    x (stations,); x [m].
    """
    a, b = x[:-1], x[1:]
    step = b - a
    found = np.zeros_like(x)
    found[:-1] += step * (3 * a**2 + 2 * a * b + b**2) / 12
    found[1:] += step * (3 * b**2 + 2 * a * b + a**2) / 12
    return found
