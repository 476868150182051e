"""The evidence of free-running records for what a model may lack, one candidate or several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.free_running.candidates import FreeCandidate
from pmmkit.diagnosis.free_running.system import (
    FreeSystem,
    Linear,
    held,
    linearised,
    log_likelihood,
    misfit,
)
from pmmkit.identification.prior import Prior
from pmmkit.numerics import Array

Names = tuple[str, ...]
WIDER: Final = 1.5
"""Standard deviation of a coefficient before, over its usual size."""
STEPS: Final = 30
SETTLED: Final = 0.01
"""A fit ends when it promises to become no more probable than by this, in ln."""
LEAST: Final = 1e-3
"""A step is taken if it keeps so much of what it promises."""
STIFF: Final = 1e3
"""A fit ends where no step helps that is damped by so much: at a bend of the forces."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Basis:
    """All that may move as numbers z that are standard normal before: ``θ = start + T z``.

    Parameters
    ----------
    T : array (m, k)
        The base first, then the coefficients of every candidate.
    base : int
        Columns of the base.
    columns : mapping of str to array of int
        Those of each candidate.
    """

    T: Array
    base: int
    columns: Mapping[str, NDArray[np.intp]]

    def of(self, names: Sequence[str]) -> NDArray[np.intp]:
        """Columns of the base and of some candidates."""
        own = [self.columns[name] for name in names]
        return np.concatenate([np.arange(self.base), *own])


def basis_of(system: FreeSystem, prior: Prior, candidates: Sequence[FreeCandidate]) -> Basis:
    """The basis of a prior and of candidates with usual sizes."""
    at = {name: i for i, name in enumerate(system.names)}
    size = np.sqrt(np.diagonal(prior.covariance))
    correlation = prior.covariance / np.outer(size, size)
    root = size[:, None] * np.linalg.cholesky(correlation + 1e-9 * np.eye(len(size)))
    rows = np.array([at[name] for name in prior.names])
    parts = np.zeros((len(system.names), len(size)))
    parts[rows] = root
    blocks, columns, begin = [parts], {}, len(size)
    for item in candidates:
        block = np.zeros((len(system.names), len(item.moves)))
        for j, (label, own) in enumerate(item.moves.items()):
            for name, amount in own.items():
                block[at[name], j] = WIDER * item.typical[label] * amount
        blocks.append(block)
        columns[item.name] = np.arange(begin, begin + block.shape[1])
        begin += block.shape[1]
    return Basis(T=np.concatenate(blocks, axis=1), base=len(size), columns=columns)


@dataclass(frozen=True, kw_only=True, eq=False)
class Point:
    """Residuals about a fit, in the numbers of the basis.

    Parameters
    ----------
    z : array (k,)
        The fit.
    G : array (n, k)
        Slopes.
    y : array (n,)
        Residuals as if all numbers were zero.
    linear : Linear
        Where that comes from.
    """

    z: Array
    G: Array
    y: Array
    linear: Linear


def point_at(
    system: FreeSystem, basis: Basis, z: Array, *, used: NDArray[np.intp] | None = None
) -> Point:
    """The linear problem about some numbers."""
    T = basis.T if used is None else basis.T[:, used]
    touched = np.flatnonzero(np.any(T != 0.0, axis=1))
    steps = 1e-3 * np.max(np.abs(basis.T), axis=1)
    linear = linearised(system, system.start + basis.T @ z, steps, only=touched.tolist())
    G = linear.slopes @ basis.T
    if used is not None:
        kept = np.zeros(G.shape[1], bool)
        kept[used] = True
        G = np.where(kept, G, 0.0)
    return Point(z=z, G=G, y=linear.e + G @ z, linear=linear)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """The most probable numbers of a set of candidates, fitted through the equations.

    Parameters
    ----------
    names : tuple of str
        The set.
    z : array (k,)
        Numbers, zero where they take no part.
    covariance : array (j, j)
        Of those that do.
    used : array (j,) of int
        Which.
    log_width : float
        ln of the prior at these numbers times the volume that the records leave (Laplace).
    here : Point
        The linear problem there.
    """

    names: Names
    z: Array
    covariance: Array
    used: NDArray[np.intp]
    log_width: float
    here: Point


def fitted(
    system: FreeSystem,
    basis: Basis,
    names: Sequence[str],
    *,
    wider: float = 1.0,
    begin: Array | None = None,
) -> Fit:
    """Damped Gauss-Newton (Levenberg-Marquardt) through the equations, the prior in the sum.

    Parameters
    ----------
    system, basis
        Records and what may move. A system that holds variances is fitted by the squares of its
        residuals, another one by its likelihood.
    names : sequence of str
        Candidates of the set.
    wider : float
        Variance of the residuals over that of white ones.
    begin : array (k,), optional
        Numbers to begin at.
    """
    used = basis.of(names)
    z = np.zeros(basis.T.shape[1])
    if begin is not None:
        z[used] = begin[used]

    free = not system.variances

    def value(numbers: Array) -> float:
        at = system.start + basis.T @ numbers
        likely = log_likelihood(system, at) if free else -misfit(system, at)
        return likely / wider - 0.5 * float(numbers @ numbers)

    def point(numbers: Array) -> Point:
        fixed = held(system, system.start + basis.T @ numbers) if free else system
        return point_at(fixed, basis, numbers, used=used)

    now, damping = value(z), 1e-3
    here = point(z)
    for _ in range(STEPS):
        G = here.G[:, used]
        H = np.eye(len(used)) + G.T @ G / wider
        slope = G.T @ here.linear.e / wider - z[used]
        if 0.5 * float(slope @ np.linalg.solve(H, slope)) < SETTLED:
            break
        while damping < STIFF:
            move = np.linalg.solve(H + damping * np.diag(np.diagonal(H)), slope)
            promised = float(slope @ move) - 0.5 * float(move @ H @ move)
            there = z.copy()
            there[used] += move
            new = value(there)
            kept = (new - now) / promised
            if kept > LEAST:
                break
            damping *= 4.0
        else:
            break
        z, now = there, new
        damping *= 0.1 if kept > 0.75 else 0.3 if kept > 0.25 else 2.0
        here = point(z)
    H = np.eye(len(used)) + here.G[:, used].T @ here.G[:, used] / wider
    return Fit(
        names=tuple(names),
        z=z,
        covariance=np.array(np.linalg.inv(H), float),
        used=used,
        here=here,
        log_width=-0.5 * float(z @ z) - 0.5 * float(np.linalg.slogdet(H)[1]),
    )


def widened(fit: Fit) -> float:
    """Variance of the scores of stretches of the records over what white residuals would give.

    What the unknown forces do not whiten hangs together within stretches of four ship lengths; all
    evidence is divided by this number (at least 1).
    """
    here = fit.here
    G, e = here.G[:, fit.used], here.linear.e
    scores = np.zeros((int(here.linear.blocks.max()) + 1, len(fit.used)))
    np.add.at(scores, here.linear.blocks, G * e[:, None])
    sizes, vectors = np.linalg.eigh(G.T @ G)
    seen = sizes > 1.0
    if not seen.any():
        return 1.0
    whitened = scores @ vectors[:, seen] / np.sqrt(sizes[seen])
    freedom = max(len(scores) - seen.sum() / 2.0, 1.0) / len(scores)
    return max(1.0, float(np.mean(np.sum(whitened**2, axis=0)) / freedom))


@dataclass(frozen=True, kw_only=True, eq=False)
class Screen:
    """What the linear problem about a fit says of every set, the base averaged over its prior.

    Parameters
    ----------
    basis : Basis
        What may move.
    gram : array (q, q)
        Information on the coefficients of candidates that the base leaves, in their prior's units.
    score : array (q,)
        Their scores.
    columns : mapping of str to array of int
        Places of each candidate.
    """

    basis: Basis
    gram: Array
    score: Array
    columns: Mapping[str, NDArray[np.intp]] = field(default_factory=dict)

    def evidence(self, names: Sequence[str]) -> float:
        """ln evidence of a set against none of it, no price taken off."""
        at = np.concatenate([self.columns[name] for name in names])
        return evidence_of(self.gram[np.ix_(at, at)], self.score[at])


def evidence_of(gram: Array, score: Array) -> float:
    """ln evidence for coefficients that are standard normal before."""
    H = np.eye(len(score)) + gram
    return 0.5 * float(score @ np.linalg.solve(H, score)) - 0.5 * float(np.linalg.slogdet(H)[1])


def screen(here: Point, basis: Basis, wider: float) -> Screen:
    """The linear problem with the base taken out."""
    b = basis.base
    B, C = here.G[:, :b], here.G[:, b:]
    H = np.eye(b) + B.T @ B / wider
    cross = B.T @ C / wider
    gram = C.T @ C / wider - cross.T @ np.linalg.solve(H, cross)
    score = C.T @ here.y / wider - cross.T @ np.linalg.solve(H, B.T @ here.y / wider)
    return Screen(
        basis=basis,
        gram=0.5 * (gram + gram.T),
        score=score,
        columns={name: at - b for name, at in basis.columns.items()},
    )


def chance_of(found: Screen, best: float, *, draws: int = 4000, seed: int = 0) -> float:
    """Probability that records without any effect give a single candidate so good.

    Parameters
    ----------
    found : Screen
        The linear problem.
    best : float
        ln evidence of the best single candidate, no price taken off.
    draws, seed : int
        Number of drawn records, and of the draws.
    """
    sizes, vectors = np.linalg.eigh(found.gram)
    root = vectors * np.sqrt(np.maximum(sizes, 0.0))
    h = np.random.default_rng(seed).normal(size=(draws, len(sizes))) @ root.T
    reached = np.full(draws, -np.inf)
    for at in found.columns.values():
        H = np.eye(len(at)) + found.gram[np.ix_(at, at)]
        own = h[:, at]
        value = 0.5 * np.sum(own * np.linalg.solve(H, own.T).T, axis=1)
        reached = np.maximum(reached, value - 0.5 * float(np.linalg.slogdet(H)[1]))
    return float((np.sum(reached >= best) + 1) / (draws + 1))
