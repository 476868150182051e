"""All runs as one whitened linear system: base projected off, candidates as blocks of columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.base import Base
from pmmkit.diagnosis.candidate import Candidate
from pmmkit.diagnosis.views import View

Array = NDArray[np.float64]
WIDER: Final = 1.5
"""Prior standard deviation of a coefficient over its typical size."""
FEATURES: Final = 96
"""Random features of the smooth floor, per channel."""
SMOOTH: Final = 0.8
"""Length scale of the floor over the range of each variable."""
TRANSIENT: Final = (0.7, 1.5, 3.0)
TYPICAL_TRANSIENT: Final = 0.08
OFFSETS: Final = (0.0, 0.001, 0.002, 0.003, 0.005, 0.008, 0.013, 0.02, 0.03)
GAINS: Final = (0.0, 0.002, 0.004, 0.006, 0.01, 0.02)
SETTINGS: Final = (0.0, 0.015, 0.03, 0.06)
"""Run scatter that is tried: offset over the channel's scale, gain, drift setting [deg]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """Rows of one channel.

    Parameters
    ----------
    name : str
        X, Y, N or K.
    views : tuple of int
        Views that have it.
    rows : tuple of slice
        Their rows.
    y : array (n,)
        Forces.
    design : array (n, p)
        Base.
    scale : float
        Root mean square over the views of the force over U² [N/(m/s)²].
    """

    name: str
    views: tuple[int, ...]
    rows: tuple[slice, ...]
    y: Array
    design: Array
    scale: float


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """What differs from run to run: offset over the scale, gain, drift setting [deg]."""

    offset: float
    gain: float
    drift: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Block:
    """One candidate at one grid point: its columns, whitened and projected, over prior sizes."""

    candidate: Candidate
    value: float
    columns: slice


@dataclass(frozen=True, kw_only=True, eq=False)
class System:
    """Everything the contest needs.

    Parameters
    ----------
    views : tuple of View
        Runs.
    base : Base
        With fitted values.
    channels : tuple of Channel
        Rows.
    scatter : Scatter
        Estimated.
    blocks : tuple of Block
        Candidates; columns in units of their prior standard deviation.
    gram : array (q, q)
        Products of all columns.
    score : array (q,)
        Products of the columns with the data.
    square : float
        Of the data.
    rows : int
        Rows less base coefficients.
    floor_columns : slice
        Where the features of the smooth floor stand, at the size of the floor.
    prior : array (q,)
        Prior standard deviation of each column, to give coefficients back.
    centre : array (q,)
        Expected value of each column's coefficient, in those.
    """

    views: tuple[View, ...]
    base: Base
    channels: tuple[Channel, ...]
    scatter: Scatter
    blocks: tuple[Block, ...]
    gram: Array
    score: Array
    square: float
    rows: int
    floor_columns: slice
    prior: Array
    centre: Array


def channels_of(views: Sequence[View], base: Base) -> tuple[Channel, ...]:
    """Rows of every channel, in the order of the views."""
    found = []
    for name, names in base.names.items():
        having = [i for i, view in enumerate(views) if name in view.force]
        if not having:
            continue
        rows, begin = [], 0
        for i in having:
            rows.append(slice(begin, begin + views[i].rows))
            begin += views[i].rows
        y = np.concatenate([views[i].force[name] for i in having])
        design = (
            np.concatenate([base.design(views[i], name) for i in having])
            if names else np.zeros((len(y), 0))
        )  # fmt: skip
        sizes = [float(np.linalg.norm(views[i].force[name])) / views[i].speed ** 2 for i in having]
        scale = float(np.sqrt(np.mean(np.square(sizes))))
        found.append(
            Channel(
                name=name, views=tuple(having), rows=tuple(rows), y=y, design=design, scale=scale
            )
        )
    return tuple(found)


def noise(channel: Channel, views: Sequence[View]) -> Array:
    """Covariance of the noise of a channel (n, n), a block per view."""
    V = np.zeros((len(channel.y), len(channel.y)))
    for i, rows in zip(channel.views, channel.rows, strict=True):
        V[rows, rows] = views[i].covariance[channel.name]
    return V


def random_effects(
    channel: Channel, views: Sequence[View], base: Base, predicted: Array
) -> dict[str, Array]:
    """Columns of what each run draws for itself: offset, gain, drift setting (n, runs)."""
    ids = list(dict.fromkeys(views[i].run.id for i in channel.views))
    n = len(channel.y)
    offset, gain, drift = (np.zeros((n, len(ids))) for _ in range(3))
    for i, rows in zip(channel.views, channel.rows, strict=True):
        view = views[i]
        column = ids.index(view.run.id)
        offset[rows.start, column] = channel.scale * base.reference**2
        gain[rows, column] = predicted[rows]
        if view.run.settings.drift and not view.run.dynamic:
            drift[rows, column] = _by_drift(view, base, channel.name)
    return {"offset": offset, "gain": gain, "drift": drift}


def _by_drift(view: View, base: Base, channel: str) -> Array:
    """Change of a static force per degree of drift."""
    m, step = view.motion, 1e-4
    c, s = math.cos(step), math.sin(step)
    moved = m.with_(u=c * m.u + s * m.v, v=c * m.v - s * m.u)
    before, after = base.forces(m, view.speed)[channel], base.forces(moved, view.speed)[channel]
    return view.project((after - before) / math.degrees(step))


def floor_features(channel: Channel, views: Sequence[View], base: Base, seed: int = 12345) -> Array:
    """A smooth function of the motion as random features, of unit size over the scale (n, D)."""
    variables = [_variables(views[i], base) for i in channel.views]
    ranges = np.max([np.max(np.abs(x), axis=0) for x in variables], axis=0)
    live = ranges > 1e-9
    rng = np.random.default_rng([seed, ord(channel.name)])
    omega = rng.normal(size=(int(live.sum()), FEATURES)) / SMOOTH
    phase = rng.uniform(0, 2 * math.pi, FEATURES)
    rows = []
    for i, x in zip(channel.views, variables, strict=True):
        view = views[i]
        features = math.sqrt(2.0 / FEATURES) * np.cos((x[:, live] / ranges[live]) @ omega + phase)
        unit = channel.scale * view.motion.speed**2
        rows.append(view.project(features * unit[:, None]))
    return np.concatenate(rows)


def _variables(view: View, base: Base) -> Array:
    m, L = view.motion, base.ship.L
    U = m.speed
    return np.stack(
        [m.v / U, m.r * L / U, m.vdot * L / U**2, m.rdot * L**2 / U**2, m.delta, m.phi,
         np.full_like(U, base.law(view.speed))],
        axis=1,
    )  # fmt: skip


def transient_columns(
    channel: Channel, views: Sequence[View], base: Base, predicted: Array, decay: float
) -> Array:
    """A share of each run's force that dies away, one column per oscillating run (n, runs)."""
    ids = list(dict.fromkeys(views[i].run.id for i in channel.views if views[i].run.dynamic))
    found = np.zeros((len(channel.y), len(ids)))
    sizes: dict[str, float] = {}
    for i, rows in zip(channel.views, channel.rows, strict=True):
        if views[i].run.dynamic and not views[i].early:
            sizes[views[i].run.id] = float(np.linalg.norm(predicted[rows]))
    for i, rows in zip(channel.views, channel.rows, strict=True):
        view = views[i]
        if view.run.dynamic:
            fading = np.exp(-view.t * view.speed / (decay * base.ship.L))
            size = sizes.get(view.run.id, float(np.linalg.norm(predicted[rows])))
            found[rows, ids.index(view.run.id)] = size * view.project(fading)
    return found


def whitened(V: Array, *parts: Array) -> list[Array]:
    """Parts multiplied by the inverse root of a covariance."""
    from scipy.linalg import cholesky, solve_triangular

    root = cholesky(V, lower=True, check_finite=False)
    return [solve_triangular(root, part, lower=True, check_finite=False) for part in parts]


def log_likelihood(V: Array, design: Array, y: Array) -> float:
    """Restricted likelihood of rows with covariance V, the design projected off."""
    from scipy.linalg import cholesky, solve_triangular

    try:
        root = cholesky(V, lower=True, check_finite=False)
    except np.linalg.LinAlgError:
        return -math.inf
    X, z = (solve_triangular(root, part, lower=True, check_finite=False) for part in (design, y))
    Q, R = np.linalg.qr(X)
    left = z - Q @ (Q.T @ z)
    diagonal = np.abs(np.diagonal(R))
    log_det = 2.0 * np.sum(np.log(np.diagonal(root))) + 2.0 * np.sum(
        np.log(diagonal[diagonal > 1e-12 * diagonal.max(initial=1.0)])
    )
    return float(-0.5 * (log_det + left @ left))


def candidate_columns(
    candidate: Candidate, value: float, channels: Sequence[Channel], views: Sequence[View],
    base: Base,
) -> dict[str, Array]:  # fmt: skip
    """Columns of a candidate by channel (n, q)."""
    by_view = [candidate.columns(view, base, value) for view in views]
    found = {}
    for channel in channels:
        block = np.zeros((len(channel.y), candidate.size))
        for i, rows in zip(channel.views, channel.rows, strict=True):
            if channel.name in by_view[i]:
                block[rows] = by_view[i][channel.name]
        if np.any(block):
            found[channel.name] = block
    return found
