"""Sums along the length: what sections have, times a wave that runs along the hull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

# Kinds of arrays of this room beside `pmmkit.numerics.Array`.


Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]


_SERIES = 0.05
"""Half of the phase over an interval below which a series stands for what cancels."""


def weights(x: Array, along: Array) -> Complex:
    """Weights of stations for ∫ f(x) e^(-iκx) dx and ∫ x f(x) e^(-iκx) dx.

    f runs straight between stations while the wave is taken as it is (Filon 1928), so that waves
    that are short beside the distance of stations are integrated too.

    x (stations,); x [m]; along [1/m].

    Examples
    --------
    >>> weights(np.array([0.0, 1.0, 3.0]), np.zeros(1))[0].real.round(12)
    array([[0.5, 1.5, 1. ]])
    """
    step, wave, even, lean, square = _over_intervals(x, along)
    middle = 0.5 * (x[1:] + x[:-1])
    aft, fore = even + lean, even - lean
    level = _joined(wave * aft, wave * fore)
    # x is its middle and half a step of what grows
    turned = 0.5 * step
    aft, fore = middle * aft - turned * (lean + square), middle * fore - turned * (lean - square)
    return np.stack([level, _joined(wave * aft, wave * fore)])


def level_weights(x: Array, along: Array) -> Complex:
    """The first of `weights` alone.

    x (stations,); x [m]; along [1/m].
    """
    _, wave, even, lean, _ = _over_intervals(x, along)
    return _joined(wave * (even + lean), wave * (even - lean))


def _over_intervals(x: Array, along: Array) -> tuple[Array, Complex, Array, Complex, Array]:
    """Steps, half of them times the wave at their middle, and means over each interval of the wave
    from there times 1, s and s², where s grows from -1 to 1; that of s for its negative."""
    step = np.diff(x)
    sizes, which = np.unique(step.round(9), return_inverse=True)
    phase = 0.5 * np.multiply.outer(along, sizes)
    even, odd, square = (part[..., which] for part in _moments(phase))
    ahead = np.exp(-1j * np.multiply.outer(along, x[:-1])) * np.exp(-1j * phase)[..., which]
    return step, np.asarray(0.5 * step * ahead), even, np.asarray(1j * odd), square


def _joined(aft: Complex, fore: Complex) -> Complex:
    """What intervals give to the stations at their ends."""
    found: Complex = np.zeros((*aft.shape[:-1], aft.shape[-1] + 1), dtype=complex)
    found[..., :-1] = aft
    found[..., 1:] += fore
    return found


def _moments(p: Array) -> tuple[Array, Array, Array]:
    """½∫ of cos ps, s sin ps and s² cos ps over s from -1 to 1."""
    small = np.abs(p) < _SERIES
    q = np.where(small, 1.0, p)
    sine, cosine = np.sin(q), np.cos(q)
    square = p * p
    even = np.where(small, 1 - square / 6 + square**2 / 120, sine / q)
    odd = np.where(small, p * (1 / 3 - square / 30 + square**2 / 840), (sine / q - cosine) / q)
    last = np.where(
        small, 1 / 3 - square / 10 + square**2 / 168, (sine - 2 * (sine / q - cosine) / q) / q
    )
    return even, odd, last


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
