"""Covariances of a filter: over an interval, their factors; runs below a structure's equations.

As `estimators`, this file is written into a module in which NS is that of one structure.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pmmkit.equations.stand_ins import NS

Array = NDArray[np.float64]


def scatter(A: Array, diffusion: Array, time: float, Q: Array) -> None:
    """Covariance that white noise in the states makes of an interval whose slopes are A.

    ∫ Φ(s) D Φ(s)ᵀ ds (Van Loan 1978) by Simpson's rule; Φ over half the interval is the root of A,
    by its series in A - I, which keeps Q positive and needs no slopes of its own.
    """
    G = A.copy()
    for i in range(NS):
        G[i, i] -= 1.0
        for j in range(NS):
            Q[i, j] = 0.0
    half = np.zeros(NS)
    for l in range(NS):
        if diffusion[l] == 0.0:
            continue
        share = diffusion[l] * time / 6.0
        for i in range(NS):
            half[i] = 0.5 * G[i, l]
            for j in range(NS):
                half[i] -= 0.125 * G[i, j] * G[j, l]
        half[l] += 1.0
        Q[l, l] += share
        for i in range(NS):
            for j in range(NS):
                Q[i, j] += share * (4.0 * half[i] * half[j] + A[i, l] * A[j, l])


def predict(P: Array, A: Array, B: Array, keep: Array, Q: Array, noise: Array) -> None:
    """Carry a covariance over an interval: states by A and B, parameters by `keep`.

    Q is what is added to the states, `noise` to the variances of the parameters.
    """
    n, m = len(P), len(keep)
    W, new = np.zeros((NS, n)), np.zeros((NS, NS))
    for i in range(NS):
        for j in range(n):
            for l in range(NS):
                W[i, j] += A[i, l] * P[l, j]
            for l in range(m):
                W[i, j] += B[i, l] * P[NS + l, j]
    for i in range(NS):
        for j in range(NS):
            for l in range(NS):
                new[i, j] += W[i, l] * A[j, l]
            for l in range(m):
                new[i, j] += W[i, NS + l] * B[j, l]
    for i in range(NS):
        for j in range(NS):
            P[i, j] = 0.5 * (new[i, j] + new[j, i]) + Q[i, j]
        for j in range(m):
            P[i, NS + j] = W[i, NS + j] * keep[j]
            P[NS + j, i] = P[i, NS + j]
    for i in range(m):
        for j in range(m):
            P[NS + i, NS + j] *= keep[i] * keep[j]
        P[NS + i, NS + i] += noise[i]


def grown(diffusion: float, fading: float, time: float) -> float:
    """Variance that process noise adds over an interval to a value that may forget."""
    if fading > 0.0:
        rate = 2.0 * fading
        return diffusion * (1.0 - math.exp(-rate * time)) / rate
    return diffusion * time


def divided(S: Array, C: Array) -> None:
    """Solve S x = C in place of C, by Cholesky's factor in place of S, whose diagonal is about one.

    S is symmetric and positive but for rounding: a pivot that is no larger is taken as that.
    """
    n = len(S)
    for j in range(n):
        for i in range(j, n):
            total = S[i, j]
            for l in range(j):
                total -= S[i, l] * S[j, l]
            S[i, j] = math.sqrt(max(total, 1e-15)) if i == j else total / S[j, j]
    for c in range(C.shape[1]):
        for i in range(n):
            for l in range(i):
                C[i, c] -= S[i, l] * C[l, c]
            C[i, c] /= S[i, i]
        for i in range(n - 1, -1, -1):
            for l in range(i + 1, n):
                C[i, c] -= S[l, i] * C[l, c]
            C[i, c] /= S[i, i]


def line_through(points: Array, scale: Array, L: Array, A: Array) -> None:
    """Slopes of the straight line through the points of `unscented`, less their mean.

    Before, they lay at distances of √n times the columns of L, each row times its scale.
    """
    n = len(scale)
    far = 2.0 * math.sqrt(float(n))
    for i in range(NS):
        for p in range(n - 1, -1, -1):
            A[i, p] = (points[2 * p, i] - points[2 * p + 1, i]) / far
            for j in range(p + 1, n):
                A[i, p] -= A[i, j] * L[j, p]
            A[i, p] /= L[p, p]
        for j in range(n):
            A[i, j] /= scale[j]
