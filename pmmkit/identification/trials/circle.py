"""A turning circle and the uniform current under it, from positions and heading alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.identification.trials.current import Current
from pmmkit.identification.trials.path import PositionNoise
from pmmkit.numerics import Array

# Coefficients of a turning circle, averaged over what is not known of the noise of the fixes.


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


SHARE: Final = 0.25
"""Share of the change of heading after which the turn is fitted, at most 180°."""
WHOLE: Final = math.radians(355.0)
"""Change of heading that counts as a full circle [rad]."""
WILD: Final = 6.0
MODEL_CURRENT: Final = 8e-4
MODEL_SPEED: Final = 3e-3
"""What the form in which the velocity dies away leaves in the current and in the steady speed, as
shares of the steady speed: found on simulated turns of tankers, container and cargo ships."""
EXTRAPOLATED: Final = 0.15
"""Standard uncertainty of the steady speed, as a share of what still had to die away at the end."""


@dataclass(frozen=True, kw_only=True)
class Circle:
    """A turning circle fitted to its positions.

    `current`: the current under it. `u, v, r`: steady velocities through the water at midship
    [m/s, rad/s]. `speed_std, r_std`: standard uncertainties of the steady speed and of r.
    `noise`: of the fixes, from what the fit leaves. `relaxation`: time in which the velocity
    settles [s]. `heading_deg`: change of heading that was fitted [deg]. `rms`: what the fit
    leaves in a coordinate [m].
    """

    current: Current
    u: float
    v: float
    r: float
    speed_std: float
    r_std: float
    noise: PositionNoise
    relaxation: float
    heading_deg: float
    rms: float


def fit_circle(t: Array, x: Array, y: Array, psi: Array, *, pace: float) -> Circle:
    """Fit the current and the steady velocity to a turning circle of at least 360°.

    t, x, y, psi [s]; pace [s].

    Notes
    -----
    After a quarter of the turn the velocity over ground is taken as
    c + R(ψ) [b + b₁ exp(-t/τ)] with the current c, the steady velocity b through the water in
    ship axes and a rest b₁ that dies away; its integral is fitted to the positions. Without b₁ a
    ship that still loses speed looks as if it drifted. The noise is a sum of a fast part and a
    drift of the fixes; its shares, its correlation time and τ are averaged over with the weight
    of their restricted likelihood, so that the uncertainty holds theirs. A wind that changes the
    velocity round the circle is taken for a part of the current.

    Examples
    --------
    >>> t = np.arange(0.0, 800.0, 2.0)
    >>> psi = 0.01 * t
    >>> x, y = 500 * np.sin(psi) + 0.3 * t, 500 * (1 - np.cos(psi)) - 0.1 * t
    >>> circle = fit_circle(t, x, y, psi, pace=20.0)
    >>> round(circle.current.x, 3), round(circle.current.y, 3), round(circle.u, 3)
    (0.3, -0.1, 5.0)
    """
    side = 1.0 if psi[-1] >= psi[0] else -1.0
    turned = side * (psi - psi[0])
    span = float(turned.max(initial=0.0))
    if span < WHOLE:
        raise DataError(
            f"The heading changes by {math.degrees(span):.0f}° under the ordered rudder; the "
            f"current shows in a full circle. Hold the rudder for 360° or more, better 540°."
        )
    start = int(np.argmax(turned >= min(SHARE * span, math.pi)))
    t, x, y, psi = (part[start:] for part in (t, x, y, psi))
    if len(t) < 40:
        raise DataError(
            f"The circle has {len(t)} fixes to be fitted; 40 are needed. Record a fix a second."
        )
    kept = _tame(t, x, y, psi, 3.0 * pace)
    found = AveragedCoefficients.of(t, x, y, psi, kept, pace)
    fading = EXTRAPOLATED * math.exp(-float(t[-1] - t[0]) / found.relaxation)
    r, r_std = _rate(t, psi, found.relaxation)
    speed = math.hypot(found.beta[4], found.beta[5])
    model = MODEL_CURRENT * speed
    along = found.beta[4:6] / max(speed, 1e-12)
    return Circle(
        current=Current(
            x=float(found.beta[2]),
            y=float(found.beta[3]),
            covariance=(
                float(found.covariance[2, 2]) + model**2,
                float(found.covariance[3, 3]) + model**2,
                float(found.covariance[2, 3]),
            ),
        ),
        u=float(found.beta[4]),
        v=float(found.beta[5]),
        r=r,
        speed_std=math.hypot(
            math.sqrt(max(float(along @ found.covariance[4:6, 4:6] @ along), 0.0)),
            fading * math.hypot(found.beta[6], found.beta[7]),
            MODEL_SPEED * speed,
        ),
        r_std=r_std,
        noise=found.noise,
        relaxation=found.relaxation,
        heading_deg=math.degrees(float(side * (psi[-1] - psi[0]))),
        rms=found.rms,
    )


def _tame(t: Array, x: Array, y: Array, psi: Array, relaxation: float) -> NDArray[np.bool_]:
    """Fixes that no fit of the circle misses wildly."""
    rows = design(t, psi, relaxation)
    kept = np.ones(len(t), bool)
    for _ in range(4):
        basis = rows[:, :, kept].reshape(8, -1)
        scale = np.linalg.norm(basis, axis=1)
        gram = np.einsum("in,jn->ij", basis, basis) / scale[:, None] / scale
        moved = np.einsum("in,n->i", basis, np.concatenate([x[kept], y[kept]])) / scale
        fitted = np.linalg.solve(gram, moved) / scale
        path = np.tensordot(fitted, rows, axes=1)
        miss = np.hypot(x - path[0], y - path[1])
        now = miss <= WILD * 1.4826 * float(np.median(miss[kept])) + 1e-9
        if np.array_equal(now, kept):
            break
        kept = now
    return kept


def _solved(basis: Array, values: Array) -> tuple[Array, Array, float, float]:
    """Coefficients, inverse of the normal equations, sum of squares left, log determinant."""
    scale = np.linalg.norm(basis, axis=0)
    q, root = np.linalg.qr(basis / scale)
    inverse = np.linalg.inv(root) / scale[:, None]
    beta = inverse @ (q.T @ values)
    rest = values - basis @ beta
    information = 2.0 * float(np.log(np.abs(np.diagonal(root)) * scale).sum())
    return beta, inverse @ inverse.T, max(float(rest @ rest), 1e-18), information


def _rate(t: Array, psi: Array, relaxation: float) -> tuple[float, float]:
    """Steady yaw rate and its standard uncertainty [rad/s]."""
    since = t - t[0]
    best: tuple[float, float, float] | None = None
    for factor in (0.4, 0.7, 1.0, 1.5):
        basis = np.stack([np.ones_like(t), since, np.exp(-since / (factor * relaxation))], axis=1)
        beta, inverse, rest, _ = _solved(basis, psi)
        if best is None or rest < best[0]:
            many = len(t) / max(1.0, 0.2 * relaxation / float(np.median(np.diff(t))))
            power = rest / max(len(t) - 3, 1) * len(t) / max(many, 1.0)
            best = (rest, float(beta[1]), math.sqrt(power * float(inverse[1, 1])))
    assert best is not None
    return best[1], best[2]
