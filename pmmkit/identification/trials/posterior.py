"""Coefficients of a turning circle, averaged over what is not known of the noise of the fixes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.identification.trials.noise import PositionNoise
from pmmkit.numerics import Array

CELLS: Final = 100
RELAXATIONS: Final = (0.7, 9.0)
"""Between which the velocity may settle, in ship lengths over the approach speed."""
PLACES: Final = 17
"""Relaxations that are tried, evenly in logarithms, in ever shorter ranges."""
SPANNED: Final = 10
"""How many of them shall hold some of the density."""
FALLEN: Final = 12.0
"""By how much its logarithm has fallen where it holds none any more."""
FAST_SHARES: Final = np.interp(np.arange(41) / 8, range(6), (0.0, 0.03, 0.1, 0.3, 0.6, 1.0))
TIMES: Final = 19


def design(t: Array, psi: Array, relaxation: float) -> Array:
    """Rows (8, 2, n) whose combination is the path: place, current, steady and dying velocity."""
    since = t - t[0]
    mid, half, step = 0.5 * (psi[1:] + psi[:-1]), 0.5 * np.diff(psi), np.diff(t)
    chord = np.sinc(half / np.pi) * step
    fading = chord * np.exp(-0.5 * (since[1:] + since[:-1]) / relaxation)
    one, none = np.ones_like(t), np.zeros_like(t)
    rows = [[one, none], [none, one], [since, none], [none, since]]
    for weight in (chord, fading):
        ahead = np.concatenate(([0.0], np.cumsum(np.cos(mid) * weight)))
        across = np.concatenate(([0.0], np.cumsum(np.sin(mid) * weight)))
        rows += [[ahead, across], [-across, ahead]]
    return np.array(rows)


@dataclass(frozen=True)
class _Basis:
    """A design in cells, made orthogonal, and what its plain fit leaves of the values."""

    q: Array
    inverse: Array
    plain: Array
    rest: Array
    log_information: float

    @classmethod
    def of(
        cls, rows: Array, edges: NDArray[np.intp], size: NDArray[np.intp], values: Array
    ) -> _Basis:
        cells = (np.add.reduceat(rows, edges, axis=-1) / size).reshape(8, -1).T
        scale = np.linalg.norm(cells, axis=0)
        q, root = np.linalg.qr(cells / scale)
        plain = q.T @ values.ravel()
        rest = values.ravel() - q @ plain
        information = 2.0 * float(np.log(np.abs(np.diagonal(root)) * scale).sum())
        inverse = np.linalg.inv(root) / scale[:, None]
        return cls(q.T.reshape(8, 2, -1), inverse, plain, rest.reshape(2, -1), information)

    def fits(self, power: Array, turn: Array) -> list[tuple[float, Array, Array, float]]:
        """Restricted log likelihood, coefficients, covariance and variance, by share of noise."""
        share = FAST_SHARES[:, None]
        weight = 1.0 / ((1.0 - share) * np.maximum(power, 0.0) + share + 1e-9)
        q, rest = self.q @ turn, self.rest @ turn
        gram = (weight @ np.einsum("icn,jcn->nij", q, q).reshape(-1, 64)).reshape(-1, 8, 8)
        moved = weight @ np.einsum("icn,cn->ni", q, rest)
        inverse = np.linalg.inv(gram)
        step = np.einsum("fij,fj->fi", inverse, moved)
        free = rest.size - 8
        left = weight @ np.sum(rest**2, axis=0) - np.einsum("fi,fi->f", moved, step)
        variance = np.maximum(left, 1e-18) / free
        score = (
            np.log(weight).sum(axis=1)
            - 0.5 * (np.linalg.slogdet(gram)[1] + self.log_information)
            - 0.5 * free * np.log(variance)
        )
        beta = (self.plain + step) @ self.inverse.T
        covariance = variance[:, None, None] * (self.inverse @ inverse @ self.inverse.T)
        return list(zip(score.tolist(), beta, covariance, variance.tolist(), strict=True))


@dataclass(frozen=True)
class AveragedCoefficients:
    """Coefficients averaged over what is not known of the noise and of the relaxation."""

    beta: Array
    covariance: Array
    noise: PositionNoise
    relaxation: float
    rms: float

    @classmethod
    def of(
        cls, t: Array, x: Array, y: Array, psi: Array, kept: NDArray[np.bool_], pace: float
    ) -> AveragedCoefficients:
        """From times, positions, heading, the fixes to be taken, and L over speed [s]."""
        edges = np.unique(np.linspace(0, int(kept.sum()), CELLS + 1).astype(int))[:-1]
        size = np.diff(np.append(edges, int(kept.sum())))
        when, values = (
            np.add.reduceat(rows[..., kept], edges, axis=-1) / size
            for rows in (t, np.stack([x, y]))
        )
        apart = np.abs(when[:, None] - when)
        cell = float(np.median(np.diff(when)))
        span = max((when[-1] - when[0]) / 3.0, 3.0 * cell)
        times = np.geomspace(1.5 * cell, span, TIMES).tolist()
        noises = [(time, *np.linalg.eigh(np.exp(-apart / time))) for time in times]
        low, high = np.log(RELAXATIONS)
        while True:
            results, log = [], np.linspace(low, high, PLACES)
            for relaxation in np.exp(log).tolist():
                rows = design(t, psi, pace * relaxation)[..., kept]
                basis = _Basis.of(rows, edges, size, values)
                for time, power, turn in noises:
                    for share, fit in zip(FAST_SHARES, basis.fits(power, turn), strict=True):
                        results.append((*fit, time, share, relaxation))
            best = np.array([item[0] for item in results]).reshape(PLACES, -1).max(axis=1)
            there = np.flatnonzero(best > best.max() - FALLEN)
            if len(there) >= SPANNED:
                break
            low, high = log[max(there[0] - 1, 0)], log[min(there[-1] + 1, PLACES - 1)]
        ends = [np.r_[0.5, np.ones(n - 2), 0.5] for n in (PLACES, TIMES, len(FAST_SHARES))]
        halved = np.multiply.outer(np.outer(*ends[:2]), ends[2]).ravel()
        scores = np.array([item[0] for item in results]) + np.log(halved)
        weight = np.exp(scores - scores.max())
        weight /= weight.sum()
        some = [item for item in zip(weight, results, strict=True) if item[0] > 1e-6 * weight.max()]
        beta = sum((w * item[1] for w, item in some), np.zeros(8)) / sum(w for w, _ in some)
        spread = np.zeros((8, 8))
        fast = slow = diffusion = settle = 0.0
        for w, (_, own, covariance, variance, time, share, relaxation) in some:
            spread += w * (covariance + np.outer(own - beta, own - beta))
            fast += w * variance * share * float(size.mean())
            slow += w * variance * (1.0 - share)
            diffusion += w * variance * (1.0 - share) / time
            settle += w * relaxation * pace
        slow_time = float(slow / diffusion) if diffusion > 0 else cell
        best = results[int(np.argmax(scores))]
        path = np.tensordot(best[1], design(t, psi, pace * best[6]), axes=1)
        rms = math.sqrt(0.5 * float(np.mean((x - path[0])[kept] ** 2 + (y - path[1])[kept] ** 2)))
        noise = PositionNoise(
            fast=math.sqrt(fast),
            slow=math.sqrt(slow),
            time=slow_time,
            origin="what the fitted circle leaves",
        )
        return cls(beta, spread, noise, settle, rms)
