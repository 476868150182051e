"""The polynomial behind the runs: its posterior, each run against the others, and evidence."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.inference import Normal
from pmmkit.intake.checks.agreement.rows import FORM, GAIN, RunGroup
from pmmkit.numerics import Array

ROUNDS: Final = 3
SLOW: Final = 2.5
"""Factor on the variance that single cycles state: they do not see noise slower than they are."""
MENDED: Final = 1.3
"""Squared misfit over the number of rows up to which a channel has nothing to mend."""
PRICE: Final = 3.0
"""Squared misfit for each row that a run must take with it to be left out …"""
LEAST: Final = 10.0
"""… and beyond that in all."""
SHRINKS: Final = (0.0, 0.5, 1.0)
"""Powers of the misfit beyond the usual that an explanation may leave."""


@dataclass(frozen=True, kw_only=True, eq=False)
class White:
    """Rows over their usual scatter, run by run and channel by channel.

    `whitener (n, 3, 7, 7)`: what whitens; zero in rows that are not known.
    """

    whitener: Array
    rows: Array
    design: Array


def whitened(group: RunGroup, design: Array) -> White:
    """The rows of a group and their design over the scatter that is usual."""
    whitener = _whiteners(group)
    rows = np.nan_to_num(group.rows)
    return White(
        whitener=whitener, rows=np.einsum("nckl,ncl->nck", whitener, rows), design=whitener @ design
    )


def _whiteners(group: RunGroup) -> Array:
    """Inverse Cholesky factors of noise, zero, gain and form of each run and channel."""
    known = group.known
    rows = np.nan_to_num(group.rows)
    level = group.level[None, :, None]
    variance = SLOW * group.noise**2 + (FORM * level) ** 2
    variance[..., 0] += group.zero[None, :] ** 2
    size = np.abs(rows)
    floor = np.maximum(size, 0.1 * level)
    variance = variance + (0.5 * GAIN * floor) ** 2
    covariance = GAIN**2 * rows[..., :, None] * rows[..., None, :]
    diagonal = np.arange(variance.shape[-1])
    covariance[..., diagonal, diagonal] += variance
    both = known[..., :, None] & known[..., None, :]
    covariance = np.where(both, covariance, 0.0)
    covariance[..., diagonal, diagonal] += ~known
    inverse = np.linalg.inv(np.linalg.cholesky(covariance))
    return np.where(known[..., :, None], inverse, 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Agreement:
    """How the runs of a group agree.

    `white`: their rows over the usual scatter. `precision, score (p, p)`: of the posterior with
    runs at odds weighed down. `prior (p, p)`: precision of the prior. `weight (n, 3)`: 1 for
    what counts, 0 for what is left out, run by run and channel by channel. `excess (3,)`: by
    how much the scatter between runs exceeds the usual, variance over variance, at least 1.
    `misfit (n, 3)`: squared misfit of each run against the others, over its expected value.
    """

    group: RunGroup
    white: White
    precision: Array
    score: Array
    prior: Array
    weight: Array
    excess: Array
    misfit: Array

    @property
    def value(self) -> Array:
        """The derivatives, (p,)."""
        return np.asarray(np.linalg.solve(self.precision, self.score))

    def without(self, place: int) -> tuple[Array, Array]:
        """Derivatives and covariance by all runs but one."""
        design, rows = self.white.design[place], self.white.rows[place]
        strength = self.weight[place] / self.excess
        precision = self.precision - np.einsum("ckp,ckq,c->pq", design, design, strength)
        score = self.score - np.einsum("ckp,ck,c->p", design, rows, strength)
        covariance = np.linalg.inv(precision)
        return covariance @ score, covariance


def agreement(group: RunGroup) -> Agreement:
    """The polynomial of a group without the runs at odds with it, and how far each run is off.

    Runs are left out of a channel one by one as long as that mends much of its misfit (a forward
    search: with few runs one bad one makes its sisters look bad, and no weight found from
    residuals tells which it is). Where more than a third would go, none does: then it is not a
    run that is at fault. The scatter beyond the usual is that of the middle run.
    """
    white = whitened(group, group.design(group.histories()))
    prior = np.linalg.inv(group.usual.covariance).astype(np.float64)
    count = group.known.sum(axis=2)
    weight = np.stack([_kept(group, white, prior, count, c) for c in range(3)], axis=1)
    excess = np.ones(3)
    for _ in range(ROUNDS):
        precision, score = _posterior(group, white, prior, weight / excess)
        probe = Agreement(
            group=group,
            white=white,
            precision=precision,
            score=score,
            prior=prior,
            weight=weight,
            excess=excess,
            misfit=np.zeros(count.shape),
        )
        misfit = np.stack([_misfit(probe, place) for place in range(len(count))])
        share = np.where(count > 0, misfit / np.maximum(count, 1), np.nan)
        judged = np.where(weight > 0, share, np.nan)
        level = _middle(np.where(count > 1, judged, np.nan), judged)
        if np.all(level <= 1.0):
            break
        excess = np.maximum(excess * level, 1.0)
    precision, score = _posterior(group, white, prior, weight / excess)
    return replace(
        probe, precision=precision, score=score, excess=excess, misfit=np.nan_to_num(share)
    )


def _middle(dynamic: Array, every: Array) -> Array:
    """Middle share of the misfit: of oscillating runs, which have many rows, before all."""
    out = np.ones(3)
    for c in range(3):
        for values, usual in ((dynamic[:, c], 1.0), (every[:, c], 0.5)):
            known = values[np.isfinite(values)]
            if len(known) >= 3:
                out[c] = float(np.median(known)) / usual
                break
    return out


def _kept(group: RunGroup, white: White, prior: Array, count: Array, c: int) -> Array:
    """Weights (n,) of a channel: 0 for the runs whose absence mends much of its misfit."""
    design, rows = white.design[:, c], white.rows[:, c]
    gram = design.transpose(0, 2, 1) @ design
    score = (rows[:, None, :] @ design)[:, 0]
    square = np.einsum("nk,nk->n", rows, rows)
    mean = group.usual.mean
    start = float(mean @ prior @ mean)
    weight = np.ones(len(rows))

    def left(weights: Array) -> float:
        precision = prior + np.tensordot(weights, gram, 1)
        right = prior @ mean + weights @ score
        return start + float(weights @ square) - float(right @ np.linalg.solve(precision, right))

    now = left(weight)
    for _ in range(len(rows) // 3 + 1):
        if now <= MENDED * float(weight @ count[:, c]):
            return weight
        gains = np.zeros(len(rows))
        for place in np.flatnonzero((weight > 0) & (count[:, c] > 0)):
            without = weight.copy()
            without[place] = 0.0
            gains[place] = now - left(without) - PRICE * count[place, c]
        worst = int(np.argmax(gains))
        if gains[worst] <= LEAST:
            return weight
        weight[worst] = 0.0
        now = left(weight)
    return np.ones(len(rows))


def _posterior(group: RunGroup, white: White, prior: Array, strength: Array) -> tuple[Array, Array]:
    root = np.sqrt(strength)
    design = _flat(white.design * root[:, :, None, None])
    rows = (white.rows * root[:, :, None]).ravel()
    return prior + design.T @ design, prior @ group.usual.mean + rows @ design


def _flat(design: Array) -> Array:
    """All rows of all runs and channels under one another, (rows, p)."""
    return design.reshape(-1, design.shape[-1])


def _misfit(probe: Agreement, place: int) -> Array:
    """Squared misfit of each channel of a run over what is expected of it, (3,)."""
    value, covariance = probe.without(place)
    out = np.zeros(3)
    for c in range(3):
        known = probe.group.known[place, c]
        if not known.any():
            continue
        design = probe.white.design[place, c][known]
        rest = probe.white.rows[place, c][known] - design @ value
        spread = probe.excess[c] * np.eye(len(rest)) + design @ covariance @ design.T
        out[c] = float(rest @ np.linalg.solve(spread, rest))
    return out


def evidence(
    found: Agreement,
    design: Array,
    mean: Array,
    covariance: Array,
    kept: Array,
    scatter: Array | None = None,
) -> tuple[float, float, Array]:
    """Logarithm of the evidence of all runs under a design (n, 3, 7, p) and a prior.

    Scatter beyond the usual may shrink where an explanation removes its cause. `kept` (n,) says
    which runs count; `scatter` (n, 3, 7) is an error that each run and channel draws anew. The
    second number is the squared misfit over the number of rows where scatter is the usual; then
    come the values of the parameters.
    """
    whitener = found.white.whitener[kept]
    rows, own = found.white.rows[kept], whitener @ design[kept]
    count = found.group.known[kept].sum(axis=(0, 2))
    root = np.asarray(np.linalg.cholesky(covariance), float)
    away = rows - own @ mean
    moved = None if scatter is None else np.einsum("nckl,ncl->nck", whitener, scatter[kept])
    logs, left, values = [], [], []
    for power in SHRINKS if np.any(found.excess > 1.0) else (0.0,):
        scale = found.excess**power
        strength = 1 / scale
        half = np.sqrt(strength)[:, None]
        known = Normal.of(_flat(own * half[..., None]), (away * half).ravel())
        if moved is not None:
            size = strength * np.sum(moved**2, axis=2)
            less = strength / np.sqrt(1 + size)
            along = _flat((moved[:, :, None, :] @ own) * less[..., None, None])
            known -= Normal.of(along, (np.sum(away * moved, axis=2) * less).ravel())
            known = replace(known, volume=float(np.log1p(size).sum()))
        known = known.in_terms_of(root)
        z = known.mean
        rest = float(known.square - known.score @ z)
        left.append(rest / max(int(count.sum()), 1))
        values.append(mean + root @ z)
        logs.append(known.log_density - 0.5 * float(count @ np.log(scale)))
    return float(np.logaddexp.reduce(logs)) - math.log(len(logs)), left[0], values[0]
