"""Whitening run by run, by the noise of the records and what each run draws for itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.observations.channels import Channel, Places, Scatter

FLOOR: Final = 0.005
"""What is too small to matter in measured forces, over the rms force of a channel."""
RIDGE: Final = 1e-12
"""Least variance of a row, over the mean of all."""


def whitened(channel: Channel, columns: Array, own: Array, scatter: Scatter) -> Array:
    """Columns multiplied by the inverse root of the covariance of noise and run scatter.

    Parameters
    ----------
    channel : Channel
        Rows and the noise of each run.
    columns : array (n, q)
        What is whitened.
    own : array (n, k)
        What each run draws for itself, at size one.
    scatter : Scatter
        Its sizes; runs are independent of each other.

    Returns
    -------
    array (n, q)
    """
    return _by_run(channel, columns, own * scatter.sizes)


def noise_whitened(channel: Channel, columns: Array) -> Array:
    """Columns (n, q) multiplied by the inverse root of the covariance of the noise alone."""
    return _by_run(channel, columns, None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Projection:
    """Whitening of one channel, and what base and floor explain of it.

    Parameters
    ----------
    channel : Channel
        Rows.
    own : array (n, 3)
        What each run draws for itself, at size one.
    scatter : Scatter
        Its sizes.
    span : array (n + D, k)
        Orthonormal basis of base and floor, the rows of the floor's prior below.
    freedom : int
        Rows less base coefficients.
    """

    channel: Channel
    own: Array
    scatter: Scatter
    span: Array
    freedom: int

    @cached_property
    def alone(self) -> tuple[Array, ...]:
        """Of each run's rows with basis S the inverse of I - S S': what a fit without it has."""
        found: list[Array] = [np.zeros((0, 0))] * len(self.channel.runs)
        sizes: dict[int, list[int]] = {}
        for number, rows in enumerate(self.channel.runs):
            sizes.setdefault(len(rows), []).append(number)
        for size, own in sizes.items():
            S = self.span[np.stack([self.channel.runs[number] for number in own])]
            inner = np.eye(size) - S @ np.swapaxes(S, 1, 2)
            inverse = np.linalg.pinv(inner, rcond=1e-8, hermitian=True)
            for number, one in zip(own, inverse, strict=True):
                found[number] = one
        return tuple(found)

    def left(self, columns: Array) -> Array:
        """Columns (n, q) whitened, with what base and floor explain taken off (n + D, q)."""
        white = whitened(self.channel, columns, self.own, self.scatter)
        n = len(white)
        found = -self.span @ (self.span[:n].T @ white)
        found[:n] += white
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """One channel of a system: whitened, with what base and floor explain taken off.

    Parameters
    ----------
    projection : Projection
        How that is done to any column.
    columns : array (n + D, q)
        Those of the system that act in this channel.
    places : array (q,)
        Their places in the system.
    data : array (n + D,)
        Forces.
    """

    projection: Projection
    columns: Array
    places: Places
    data: Array


def _by_run(channel: Channel, columns: Array, own: Array | None) -> Array:
    found = np.empty_like(columns)
    least = RIDGE * float(np.mean(np.concatenate([np.diagonal(x) for x in channel.noise])))
    for at, V in alike(channel):
        covariance = V + least * np.eye(V.shape[1])
        if own is not None:
            covariance = covariance + own[at] @ np.swapaxes(own[at], 1, 2)
        found[at] = np.linalg.solve(np.linalg.cholesky(covariance), columns[at])
    return found


def alike(channel: Channel) -> list[tuple[Places, Array]]:
    """Runs of equal numbers of rows together: their rows (k, m) and covariances (k, m, m)."""
    sizes: dict[int, list[int]] = {}
    for number, rows in enumerate(channel.runs):
        sizes.setdefault(len(rows), []).append(number)
    return [
        (np.stack([channel.runs[i] for i in own]), np.stack([channel.noise[i] for i in own]))
        for own in sizes.values()
    ]


def orthonormal(columns: Array, tolerance: float = 1e-8) -> Array:
    """An orthonormal basis of what columns span, those that depend on others left out."""
    size = np.linalg.norm(columns, axis=0)
    scaled: Array = columns[:, size > 0] / size[size > 0]
    if not scaled.shape[1]:
        return scaled
    U, s, _ = np.linalg.svd(scaled, full_matrices=False)
    basis: Array = U[:, s > tolerance * s[0]]
    return basis
