"""Values of several laboratories at once: what they share, by what they differ, what is next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

Places = NDArray[np.intp]

POINTS: Final = 512
"""Sets of scatters over which is averaged."""
STEPS: Final = 400
"""Points of the integral over the scatter of the base."""
FURTHEST: Final = 4.0
"""End of that integral, over the scale of the prior."""
FLAT: Final = 10.0
"""Standard deviation of the shared values of a base before any test, over their sizes: flat."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Learned:
    """What a laboratory says of values: ln of their probability is ``sᵀx - ½ xᵀIx``.

    Parameters
    ----------
    laboratory : str
        Who.
    information : array (n, n)
        I.
    score : array (n,)
        s.
    moves : bool
        Whether the values of its base are its own; otherwise they are those of the first.
    """

    laboratory: str
    information: Array
    score: Array
    moves: bool = True


@dataclass(frozen=True, kw_only=True, eq=False)
class Groups:
    """Values that scatter alike between laboratories.

    Parameters
    ----------
    names : tuple of str
        Of the groups; the first is the base.
    base : float
        Scatter of the base.
    of : array of int (n,)
        Group of each value.
    usual : array (n,)
        By what a scatter of 1 makes each value differ.
    scales : array (g - 1,)
        Of the half-normal priors of the scatters of the others.
    shared : array (n,)
        Standard deviation before any test of what all laboratories have in common.
    """

    names: tuple[str, ...]
    base: float
    of: Places
    usual: Array
    scales: Array
    shared: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Next:
    """Values of a laboratory that has not tested yet.

    Parameters
    ----------
    values, covariance : array (n,), array (n, n)
        Of them.
    scatter : array (g,)
        By what laboratories differ, root mean square, a number for each group.
    """

    values: Array
    covariance: Array
    scatter: Array


def next_laboratory(learned: Sequence[Learned], groups: Groups) -> Next:
    """What a laboratory that has not tested yet has, from what others have found.

    Parameters
    ----------
    learned : sequence of Learned
        One laboratory or more.
    groups : Groups
        How values scatter.

    Notes
    -----
    Laboratory i has ``x_i = m + η_i``, η_i ~ N(0, τ² usual²) independent for each value, m ~ N(0,
    shared²); the next one is ``m + η``. Its mean and covariance are averaged over τ of the groups
    beside the base, each with a half-normal prior, by how probable the others are with them. The
    scatter of the base is given: a linear problem says too much of a base that goes far.

    Examples
    --------
    >>> known = Learned(laboratory="", information=np.eye(1) * 100.0, score=np.array([100.0]))
    >>> groups = Groups(
    ...     names=("base",),
    ...     base=0.2,
    ...     of=np.array([0]),
    ...     usual=np.ones(1),
    ...     scales=np.zeros(0),
    ...     shared=np.array([10.0]),
    ... )
    >>> found = next_laboratory([known, known], groups)
    >>> found.values.round(3), found.covariance.round(3)  # 0.01/2 + 0.2²/2 + 0.2²
    (array([0.999]), array([[0.065]]))
    """
    n, count = len(groups.usual), len(learned)
    places = [_places(i, item.moves, groups) for i, item in enumerate(learned)]
    whole, score = np.zeros((n * (count + 1),) * 2), np.zeros(n * (count + 1))
    for item, (first, second) in zip(learned, places, strict=True):
        for rows in (first, second):
            score[rows] += item.score
            for columns in (first, second):
                whole[np.ix_(rows, columns)] += item.information
    logs, means, covariances = [], [], []
    drawn = groups.scales * _half_normal(len(groups.scales))
    scatters = np.concatenate([np.full((len(drawn), 1), groups.base), drawn], axis=1)
    for tau in scatters:
        apart = tau[groups.of] * groups.usual
        root = np.concatenate([groups.shared, np.tile(apart, count)])
        H = np.eye(len(root)) + root[:, None] * whole * root
        lower = np.linalg.cholesky(H)
        y = np.linalg.solve(lower, root * score)
        logs.append(0.5 * float(y @ y) - float(np.log(np.diagonal(lower)).sum()))
        inverse = np.linalg.solve(lower, np.diag(root))
        means.append((inverse.T @ y)[:n])
        covariances.append((inverse.T @ inverse)[:n, :n] + np.diag(apart**2))
    share = np.exp(np.array(logs) - max(logs))
    share = share / share.sum()
    mean = share @ np.stack(means)
    away = np.stack(means) - mean
    covariance = np.einsum("t,tij->ij", share, np.stack(covariances))
    covariance += np.einsum("t,ti,tj->ij", share, away, away)
    return Next(values=mean, covariance=covariance, scatter=np.sqrt(share @ scatters**2))


def scatter_of_base(moved: Sequence[tuple[float, float]], scale: float) -> float:
    """By what the bases of laboratories differ, root mean square over usual sizes.

    Parameters
    ----------
    moved : sequence of (float, float)
        By how much records move the base of another laboratory, and in how many directions.
    scale : float
        Of the half-normal prior of the scatter τ. Two laboratories are 2τ² apart.

    Examples
    --------
    >>> round(scatter_of_base([], 0.05), 3), round(scatter_of_base([(0.1, 1000.0)], 0.05), 3)
    (0.05, 0.071)
    """
    taus = scale * FURTHEST * (np.arange(STEPS) + 0.5) / STEPS
    log = -0.5 * (taus / scale) ** 2
    for size, directions in moved:
        log = log - 0.5 * directions * (np.log(2.0 * taus**2) + size**2 / (2.0 * taus**2))
    share = np.exp(log - log.max())
    return float(np.sqrt(share @ taus**2 / share.sum()))


def _places(number: int, moves: bool, groups: Groups) -> tuple[Places, Places]:
    """Where what all share stands, and what a laboratory has of its own."""
    n = len(groups.usual)
    own = np.arange(n) + n * (number + 1)
    return np.arange(n), own if moves else np.where(groups.of == 0, np.arange(n) + n, own)


def _half_normal(count: int) -> Array:
    """Sets (n, count) of half-normal numbers that fill their space evenly (Roberts 2018: the
    multiples of powers of the generalised golden ratio)."""
    from scipy.special import ndtri

    if not count:
        return np.zeros((1, 0))
    ratio = 2.0
    for _ in range(50):
        ratio = (1.0 + ratio) ** (1.0 / (count + 1))
    steps = ratio ** -np.arange(1.0, count + 1)
    even = (0.5 + np.arange(1, POINTS + 1)[:, None] * steps) % 1.0
    found: Array = ndtri(0.5 + 0.5 * even)
    return found
