"""Intervals of mixtures of normal distributions."""

from __future__ import annotations

from typing import Final

import numpy as np

from pmmkit.numerics import Array

STEPS: Final = 60
"""Steps by which a half width is found at most: Newton's, or a bisection where those leave it."""


def half_width(
    value: Array, variance: Array, weight: Array, centre: Array, confidence: float
) -> Array:
    """Half width of the symmetric interval about a centre that holds a mixture of normals.

    Parameters
    ----------
    value, variance : array (g, p)
        Of each coefficient at each node.
    weight : array (g,)
        Of the nodes.
    centre : array (p,)
        Middle of the interval.
    confidence : float
        What it holds.

    Examples
    --------
    >>> one = np.ones((1, 1))
    >>> half_width(0 * one, one, np.ones(1), np.zeros(1), 0.95).round(3)
    array([1.96])
    """
    from scipy.special import ndtr

    std = np.sqrt(variance)
    away = value - centre
    low = np.zeros_like(centre)
    high: Array = np.max(np.abs(away) + 10.0 * std, axis=0)
    half: Array = 2.0 * np.sqrt(weight @ (variance + away**2))
    for _ in range(STEPS):
        right, left = (half - away) / std, (-half - away) / std
        short = weight @ (ndtr(right) - ndtr(left)) - confidence
        density = weight @ ((np.exp(-0.5 * right**2) + np.exp(-0.5 * left**2)) / std)
        low, high = np.where(short < 0, half, low), np.where(short < 0, high, half)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = half - short / density * np.sqrt(2.0 * np.pi)
        before = half
        half = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
        if np.all(np.abs(half - before) <= 1e-14 * half):
            break
    return half
