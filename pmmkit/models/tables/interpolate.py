"""Derivatives at Froude numbers between those of a table, with their uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal, get_args

import numpy as np

from pmmkit.base import ExtrapolationError, Problem, Remedy, TableError, Way
from pmmkit.models.tables.points import mapped
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.numerics import Array

Method = Literal["linear", "pchip", "quadratic"]
SAME: Final = 1e-3
"""Relative difference up to which a Froude number counts as that of a row."""


def interpolate(
    table: DerivativeTable,
    Fn: float | Sequence[float] | Array,
    *,
    method: Method = "linear",
    extrapolate: bool = False,
) -> DerivativeTable:
    """The table at other Froude numbers.

    Parameters
    ----------
    table : DerivativeTable
        A table per Froude number; a pooled table holds at any and is returned as it is.
    Fn : float or sequence of float
        Where the derivatives are wanted; sorted, each once, in the result.
    method : {"linear", "pchip", "quadratic"}
        Straight lines; monotone cubics (Fritsch and Butland 1984); or parabolas through three
        neighbours, two of them blended within each interval (Overhauser 1968). Two known values
        are joined by a line with every method, one value holds at its own Froude number.
    extrapolate : bool
        Whether to go on beyond the table: along the line of the last two values (linear), the
        end slope (pchip), the last parabola (quadratic), or the one value that is there. The
        result has a note that says so.

    Returns
    -------
    DerivativeTable
        Values with the covariance that follows from that of the table, across Froude numbers too
        (for pchip by its slopes with respect to each value). A derivative that is not known at
        some Froude number is taken from its other values within their range, and is NaN outside
        of it.

    Raises
    ------
    ExtrapolationError
        If a Froude number lies outside of the table and `extrapolate` is not set.
    TableError
        If the method is not known or a Froude number is not a number.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models.tables.table import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv": [-.01, -.02]}, std={"Yv": .001}, Fn=[.1, .2], ship=ship,
    ...                     water=Water())
    >>> middle = interpolate(table, .15)
    >>> middle["Yv"], middle.std.round(6)
    (array([-0.015]), array([[0.000707]]))
    """
    if method not in get_args(Method):
        raise TableError(f"Method {method!r} is not known: {', '.join(get_args(Method))}.")
    wanted = np.unique(np.atleast_1d(np.asarray(Fn, float)))
    if wanted.size == 0 or not np.isfinite(wanted).all():
        raise TableError(f"Fn = {Fn!r}: a Froude number, or several, is needed.")
    if table.pooled:
        return table
    low, high = float(table.Fn[0]), float(table.Fn[-1])
    place = np.clip(wanted, low, high)
    outside = wanted[np.abs(wanted - place) > SAME * np.abs(place)]
    notes = table.notes
    if outside.size:
        beyond = ", ".join(f"{speed:.4g}" for speed in outside)
        if not extrapolate:
            span = f"at Fn {low:.4g} only" if low == high else f"from Fn {low:.4g} to {high:.4g}"
            raise ExtrapolationError(
                Problem(
                    message=f"Fn {beyond} is outside of the table, which holds {span}.",
                    remedy=Remedy("Measure there, or say {}.", (Way.setting("extrapolate", True),)),
                )
            )
        notes = (
            *notes,
            f"Extrapolated ({method}) to Fn {beyond} from a table of {low:.4g} to {high:.4g}.",
        )
        place = np.where(np.isin(wanted, outside), wanted, place)
    m, (k, n) = len(wanted), table.value.shape
    weights = np.zeros((m, n, k, n))
    lost = np.zeros((m, n), bool)
    for column in range(n):
        known = np.flatnonzero(np.isfinite(table.value[:, column]))
        share, lost[:, column] = _weights(
            table.Fn[known], table.value[known, column], place, method, extrapolate
        )
        weights[:, column, known, column] = share
    result = mapped(table, weights, names=table.names, Fn=wanted).with_(notes=notes)
    covariance = result.covariance.copy()
    covariance[lost] = np.nan
    covariance[:, :, lost] = np.nan
    return result.with_(value=np.where(lost, np.nan, result.value), covariance=covariance)


def _weights(
    x: Array, y: Array, place: Array, method: str, extrapolate: bool
) -> tuple[Array, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
    """Share of each known value in each result, array (m, k), and where there is none."""
    if len(x) == 0:
        return np.zeros((len(place), 0)), np.ones(len(place), bool)
    near = np.clip(place, x[0], x[-1])
    inside = np.abs(place - near) <= SAME * np.abs(near)
    place = np.where(inside, near, place)
    if len(x) == 1:
        share = np.ones((len(place), 1))
    elif len(x) == 2 or method == "linear":
        share = _lines(x, place)
    elif method == "quadratic":
        share = _parabolas(x, place)
    else:
        share = _monotone(x, y, place)
    lost = ~inside if not extrapolate else np.zeros(len(place), bool)
    return np.where(lost[:, None], 0.0, share), lost


def _lines(x: Array, place: Array) -> Array:
    left = np.clip(np.searchsorted(x, place, side="right") - 1, 0, len(x) - 2)
    t = (place - x[left]) / (x[left + 1] - x[left])
    share = np.zeros((len(place), len(x)))
    rows = np.arange(len(place))
    share[rows, left] = 1 - t
    share[rows, left + 1] = t
    return share


def _parabolas(x: Array, place: Array) -> Array:
    left = np.clip(np.searchsorted(x, place, side="right") - 1, 0, len(x) - 2)
    t = np.clip((place - x[left]) / (x[left + 1] - x[left]), 0.0, 1.0)
    share = np.zeros((len(place), len(x)))
    rows = np.arange(len(place))
    for start, blend in ((left - 1, 1 - t), (left, t)):
        first = np.clip(start, 0, len(x) - 3)
        nodes = x[first[:, None] + np.arange(3)]
        for own in range(3):
            others = [other for other in range(3) if other != own]
            basis = np.prod(
                [(place - nodes[:, j]) / (nodes[:, own] - nodes[:, j]) for j in others], axis=0
            )
            share[rows, first + own] += blend * basis
    return share


def _monotone(x: Array, y: Array, place: Array) -> Array:
    """Slopes of the monotone cubic with respect to each value.

    The curve is homogeneous of degree one in the values, so these slopes are shares as well:
    their sum over the values is the interpolated value.
    """
    left = np.clip(np.searchsorted(x, place, side="right") - 1, 0, len(x) - 2)
    h = x[left + 1] - x[left]
    t = np.clip((place - x[left]) / h, 0.0, 1.0)
    slopes = _slopes(x, y)
    here, there = np.eye(len(x))[left], np.eye(len(x))[left + 1]
    parts = (
        ((1 + 2 * t) * (1 - t) ** 2, here),
        (t**2 * (3 - 2 * t), there),
        (h * t * (1 - t) ** 2, slopes[left]),
        (-h * t**2 * (1 - t), slopes[left + 1]),
        (np.minimum(place - x[0], 0.0), slopes[:1]),
        (np.maximum(place - x[-1], 0.0), slopes[-1:]),
    )
    return np.asarray(sum(factor[:, None] * shares for factor, shares in parts), float)


def _slopes(x: Array, y: Array) -> Array:
    """Shares of each value in the slope of the monotone cubic at each node, array (k, k)."""
    h = np.diff(x)
    chord = (np.eye(len(x))[1:] - np.eye(len(x))[:-1]) / h[:, None]
    m = chord @ y
    shares = np.zeros((len(x), len(x)))
    w1, w2 = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    for node in np.flatnonzero(m[:-1] * m[1:] > 0):
        a, b = w1[node], w2[node]
        mean = (a + b) / (a / m[node] + b / m[node + 1])
        before, after = a * (mean / m[node]) ** 2, b * (mean / m[node + 1]) ** 2
        shares[node + 1] = (before * chord[node] + after * chord[node + 1]) / (a + b)
    for end, first, second in ((0, 0, 1), (-1, -1, -2)):
        total = h[first] + h[second]
        row = ((total + h[first]) * chord[first] - h[first] * chord[second]) / total
        slope = row @ y
        if slope * m[first] <= 0:
            row = np.zeros(len(x))
        elif m[first] * m[second] <= 0 and abs(slope) > 3 * abs(m[first]):
            row = 3 * chord[first]
        shares[end] = row
    return shares
