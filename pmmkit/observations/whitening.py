"""Noise of runs and what each run draws for itself: whitening run by run, and its estimate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.observations.channels import Channel, Places, Scatter

FLOOR: Final = 0.005
"""What is too small to matter in measured forces, over the rms force of a channel."""
OFFSETS: Final = (0.0, 0.001, 0.002, 0.003, 0.005, 0.008, 0.013, 0.02, 0.03, 0.05)
GAINS: Final = (0.0, 0.002, 0.004, 0.006, 0.01, 0.02)
SETTINGS: Final = (0.0, 0.015, 0.03, 0.06)
"""Run scatter that is tried: offset over the channel's scale, gain, drift setting [deg]."""
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
    for at, V in _alike(channel):
        covariance = V + least * np.eye(V.shape[1])
        if own is not None:
            covariance = covariance + own[at] @ np.swapaxes(own[at], 1, 2)
        found[at] = np.linalg.solve(np.linalg.cholesky(covariance), columns[at])
    return found


def _alike(channel: Channel) -> list[tuple[Places, Array]]:
    """Runs of equal numbers of rows together: their rows (k, m) and covariances (k, m, m)."""
    sizes: dict[int, list[int]] = {}
    for number, rows in enumerate(channel.runs):
        sizes.setdefault(len(rows), []).append(number)
    return [
        (np.stack([channel.runs[i] for i in own]), np.stack([channel.noise[i] for i in own]))
        for own in sizes.values()
    ]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Likelihood:
    """What the restricted likelihood of run scatter needs of one channel, whitened by its noise.

    The columns of `whole` and of the sums are: the largest model, the smooth floor, the data.
    """

    whole: Array
    own: Array
    across: Array
    model: int
    floor: int

    def at(self, scatter: Scatter) -> float:
        """Of one scatter; each run takes its own share off the sums of all."""
        s = scatter.sizes
        inner = np.eye(len(s)) + s[:, None] * self.own * s
        root = np.linalg.cholesky(inner)
        taken = np.linalg.solve(root, s[:, None] * self.across)
        stacked = taken.reshape(-1, taken.shape[2])
        gram = self.whole - stacked.T @ stacked
        diagonal = np.arange(self.model, self.model + self.floor)
        gram[diagonal, diagonal] += 1.0
        order = np.r_[diagonal, : self.model, len(gram) - 1]
        try:
            pivots = np.diagonal(np.linalg.cholesky(gram[np.ix_(order, order)]))
        except np.linalg.LinAlgError:
            return -np.inf
        logs = np.log(np.diagonal(root, axis1=1, axis2=2)).sum() + np.log(pivots[:-1]).sum()
        return float(-logs - 0.5 * pivots[-1] ** 2)


def _likelihood(channel: Channel, own: Array, model: Array, floor: Array) -> _Likelihood:
    white = _by_run(channel, np.column_stack([model, floor, channel.y, own]), None)
    p, q = model.shape[1], floor.shape[1]
    basis = orthonormal(white[:, :p])
    A = np.column_stack([basis, white[:, p : p + q + 1]])
    sums = [
        (np.swapaxes(Z, 1, 2) @ Z, np.swapaxes(Z, 1, 2) @ A[at])
        for at, _ in _alike(channel)
        for Z in [white[at][:, :, p + q + 1 :]]
    ]
    return _Likelihood(
        whole=A.T @ A,
        own=np.concatenate([x for x, _ in sums]),
        across=np.concatenate([x for _, x in sums]),
        model=basis.shape[1],
        floor=q,
    )


def orthonormal(columns: Array, tolerance: float = 1e-8) -> Array:
    """An orthonormal basis of what columns span, those that depend on others left out."""
    size = np.linalg.norm(columns, axis=0)
    scaled: Array = columns[:, size > 0] / size[size > 0]
    if not scaled.shape[1]:
        return scaled
    U, s, _ = np.linalg.svd(scaled, full_matrices=False)
    basis: Array = U[:, s > tolerance * s[0]]
    return basis


def estimated_scatter(
    channels: Sequence[Channel],
    own: Mapping[str, Array],
    models: Mapping[str, Array],
    floors: Mapping[str, Array],
) -> Scatter:
    """Run scatter of the greatest restricted likelihood, one for all channels.

    Parameters
    ----------
    channels : sequence of Channel
        Rows.
    own : mapping of channel to array (n, 3)
        What each run draws for itself, at size one.
    models : mapping of channel to array (n, p)
        The largest model, so that a missing effect is not taken for scatter.
    floors : mapping of channel to array (n, D)
        Features of the smooth floor at its size.

    Returns
    -------
    Scatter
    """
    found = [_likelihood(c, own[c.name], models[c.name], floors[c.name]) for c in channels]
    best = Scatter()
    for field, tried in (
        ("offset", OFFSETS),
        ("gain", GAINS),
        ("drift", SETTINGS),
        ("offset", OFFSETS),
    ):
        options = [replace(best, **{field: x}) for x in tried]
        values = [sum(item.at(option) for item in found) for option in options]
        best = options[int(np.argmax(values))]
    return best
