"""A run over time: means over stretches that are short against the motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Campaign, Counted, Rig, Run
from pmmkit.conventions import Convention
from pmmkit.numerics import Array, projector
from pmmkit.reduction.observations.equations import motion_of_water, regressors_of
from pmmkit.reduction.observations.prepare import PreparedRun
from pmmkit.signals import (
    autoregressive_noise,
    between_harmonics,
    fit_noise,
    phase_cells,
    time_weights,
)

Ints = NDArray[np.intp]
STEADY: Final = 128
"""Stretches into which a steady window is cut at most."""
MEMORY: Final = 3
"""Order of the autoregression of the noise of a steady window."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunHistory:
    """What a run says over time: means over k stretches, the same for forces and regressors.

    `t (k,)`: middle of each stretch [s]. `force (k,)`: force of the water at midship [N, N m].
    `design (k, p)`: what each derivative of the channel multiplies. `names`: the derivatives,
    column by column. `basis (k, m)`: from the run's mean or harmonics to the stretches. `gamma
    (k,)`: autocovariances of the noise beside the harmonics [N², (N m)²].
    """

    t: Array
    force: Mapping[str, Array]
    design: Mapping[str, Array]
    names: Mapping[str, Sequence[str]]
    basis: Array
    gamma: Mapping[str, Array]


def history_of(
    prepared: PreparedRun,
    run: Run,
    campaign: Campaign,
    rig: Rig,
    names: Mapping[str, Sequence[str]],
    convention: Convention,
    *,
    blockage: float = 0.0,
) -> RunHistory:
    """Cut what counts of a run into stretches; a table's harmonics are taken as they are.

    Notes
    -----
    A stretch is a 32nd to a 48th of a cycle, or a 128th of a steady window: means over it lose
    nothing of a quasi-steady motion, and the same mean is taken of forces and regressors, so
    that equations which hold for samples hold for stretches.
    """
    motion, speed = motion_of_water(prepared, rig, blockage)
    columns = regressors_of(names, motion, speed, campaign, convention)
    if run.kind != "history":
        force = prepared.water_force(rig)
        return RunHistory(
            t=np.zeros(len(prepared.projection)),
            force={channel: force[channel] for channel in names},
            design={channel: prepared.projection @ own for channel, own in columns.items()},
            names=names,
            basis=np.eye(len(prepared.projection)),
            gamma={},
        )
    data = run.data
    times = np.asarray(data["t"].values, float)
    first = int(np.searchsorted(times, prepared.t[0]))
    cut = slice(first, first + len(prepared.t))
    read = {
        channel: np.asarray(data[channel].values, float)[cut]
        for channel in prepared.result.measured
    }
    force = rig.force_of_water(read, prepared.result.run, prepared.motion_at_midship(rig))
    order = list(names)
    count = prepared.result.cycles
    if count is None or prepared.phase is None:
        weights = time_weights(prepared.t)
        starts = np.unique(np.linspace(0, len(weights), STEADY, endpoint=False).astype(np.intp))
        basis = np.ones((len(starts), 1))
        whole = len(starts)
    else:
        weights = np.ones(len(prepared.t))
        starts, a_cycle = phase_cells(prepared.phase, count)
        whole = a_cycle * count
        basis = _means(np.asarray(np.linalg.pinv(prepared.projection), float), starts, weights)
    forces = _means(np.stack([force[channel] for channel in order], axis=1), starts, weights)
    return RunHistory(
        t=_means(prepared.t[:, None], starts, weights)[:, 0],
        force=dict(zip(order, forces.T, strict=True)),
        design={channel: _means(own, starts, weights) for channel, own in columns.items()},
        names=names,
        basis=basis,
        gamma=dict(zip(order, _noise(forces, basis, count, whole), strict=True)),
    )


def _means(columns: Array, starts: Ints, weights: Array) -> Array:
    """Weighted means of columns (n, c) over stretches."""
    sums = np.add.reduceat(columns * weights[:, None], starts, axis=0)
    return np.asarray(sums / np.add.reduceat(weights, starts)[:, None])


def _noise(forces: Array, basis: Array, count: int | None, whole: int) -> Array:
    """Autocovariances (c, k) of what mean or harmonics leave of forces (k, c)."""
    k = len(forces)
    rest = (forces - basis @ (projector(basis) @ forces)).T
    power = np.sum(rest**2, axis=1) / max(k - basis.shape[1], 1)
    gamma = np.zeros_like(rest)
    gamma[:, 0] = power
    noisy = power > 1e4 * (np.finfo(float).eps * np.abs(forces).max(axis=0)) ** 2
    if not noisy.any():
        return gamma
    unit = np.sqrt(power[noisy])[:, None]
    if count is None:
        if k > MEMORY * 5:
            gamma[noisy] = autoregressive_noise(rest[noisy] / unit, MEMORY)[2] * unit**2
    elif between_harmonics(whole, count, Counted.ORDER).sum() > 3:
        padded = np.pad(rest[noisy] / unit, ((0, 0), (0, max(whole - k, 0))))[:, :whole]
        gamma[noisy] = fit_noise(padded, count, Counted.ORDER, k)[0] * unit**2
    return gamma
