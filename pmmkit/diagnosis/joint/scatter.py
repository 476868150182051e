"""Values of several laboratories at once: what they share, by what they differ, what is next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.inference import Normal
from pmmkit.numerics import Array

Places = NDArray[np.intp]

POINTS: Final = 2048
"""Sets of scatters over which is averaged."""
TOGETHER: Final = 64
"""Sets whose matrices are factorised together."""
LOGS: Final = np.linspace(-14.0, 2.0, 129)
"""Where the density of the scatter of a group is asked, over its scale and in logarithms: from
where none is left (1e-6) to where the prior has fallen by exp(-27)."""
FLATTER: Final = 0.8
"""Power of that density after which sets are drawn, since the others are not where it is asked."""
STEPS: Final = 200
"""Points over the logarithm of how far records lie from the tests; 100 give 1e-9 already."""
FALLEN: Final = 40.0
"""By how much the logarithm of the density has fallen where that integral ends: 4e-18."""
FARTHEST: Final = 600.0
"""Ends of the same in ln w are looked for up to here, short of where exp overflows."""
CONVERGED: Final = 1e-6
"""Share by which neither root mean square changes when the directions are doubled."""
FLAT: Final = 10.0
"""Standard deviation of the shared values of a base before any test, over their sizes: flat."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Learned:
    """What a laboratory says of values: ln of their probability is ``sᵀx - ½ xᵀIx``.

    `moves`: whether the values of its base are its own; otherwise they are those of the first.
    `offset`: whether what its kind of test gives may be off for a ship that sails free.
    """

    laboratory: str
    information: Array
    score: Array
    moves: bool = True
    offset: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class Groups:
    """Values that scatter alike between laboratories.

    `names`: of the groups; the first is the base. `base`: scatter of the base. `of`: group of
    each value. `usual`: by what a scatter of 1 makes each value differ. `scales (g - 1,)`: of
    the half-normal priors of the scatters of the others. `shared`: standard deviation before
    any test of what all laboratories have in common. `offset`: standard deviation of what
    captive tests are off for a ship that sails free.
    """

    names: tuple[str, ...]
    base: float
    of: Places
    usual: Array
    scales: Array
    shared: Array
    offset: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Next:
    """Values of a laboratory that has not tested yet.

    `scatter (g,)`: by what laboratories differ, root mean square, a number for each group.
    `between (n,)`: variance of each value by that, which the covariance holds too.
    """

    values: Array
    covariance: Array
    scatter: Array
    between: Array


def next_laboratory(learned: Sequence[Learned], groups: Groups) -> Next:
    """What a laboratory that has not tested yet has, from what others have found.

    Notes
    -----
    Laboratory i has ``x_i = m + δ + η_i``: m what the ship has, m ~ N(0, shared²); δ by what
    captive tests are off for a ship that sails free, δ ~ N(0, offset²), none in free running; η_i
    by what the laboratory is, η_i ~ N(0, τ² usual²), all of it independent for each value. The
    next one, of a ship that sails free, is ``m + η``. Its mean and covariance are averaged over τ
    of the groups beside the base, each with a half-normal prior, by how probable the others are
    with them. The scatter of the base is given: a linear problem says too much of a base that goes
    far. Sets of τ are drawn evenly where the density of each group's own is, and where the mean of
    τ² is made: within 1e-3 of brute force, 1e-2 where two groups are hardly told apart.

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
    ...     offset=np.zeros(1),
    ... )
    >>> found = next_laboratory([known, known], groups)
    >>> found.values.round(3), found.covariance.round(3)  # 0.01/2 + 0.2²/2 + 0.2²
    (array([1.]), array([[0.065]]))
    """
    kinds, size = groups.of, len(groups.usual)
    whole, score = _whole(learned, groups)
    moves = np.concatenate([np.zeros(2 * size, bool), np.tile(kinds > 0, len(learned))])
    # What no scatter that is averaged over moves: taken out once.
    base = np.tile(groups.base * groups.usual, len(learned))
    root = np.concatenate([groups.shared, groups.offset, base])[~moves]
    H = np.eye(len(root)) + root[:, None] * whole[np.ix_(~moves, ~moves)] * root
    known = root[:, None] * np.linalg.solve(H, np.diag(root))
    along = known @ whole[np.ix_(~moves, moves)]
    rest = _Rest(
        information=whole[np.ix_(moves, moves)] - whole[np.ix_(moves, ~moves)] @ along,
        score=score[moves] - along.T @ score[~moves],
        of=np.tile(kinds[kinds > 0] - 1, len(learned)),
        usual=np.tile(groups.usual[kinds > 0], len(learned)),
        scales=groups.scales,
    )
    drawn, drawn_by = _drawn(_densities(rest))
    parts = np.array_split(drawn, -(-len(drawn) // TOGETHER))
    log, means, covariances = map(np.concatenate, zip(*map(rest.given, parts), strict=True))
    log = log - drawn_by
    share = np.exp(log - log.max())
    share = share / share.sum()
    mean = share @ means
    moved = np.tensordot(share, covariances, 1) + (means - mean).T @ (
        share[:, None] * (means - mean)
    )
    square = np.append(groups.base**2, share @ (groups.scales * np.exp(drawn)) ** 2)
    covariance = known[:size, :size] + along[:size] @ moved @ along[:size].T
    between = square[kinds] * groups.usual**2
    return Next(
        values=known[:size] @ score[~moves] - along[:size] @ mean,
        covariance=covariance + np.diag(between),
        scatter=np.sqrt(square),
        between=between,
    )


def _whole(learned: Sequence[Learned], groups: Groups) -> tuple[Array, Array]:
    """Information and score of all that the values of all laboratories are made of."""
    size = len(groups.usual) * (len(learned) + 2)
    whole, score = np.zeros((size, size)), np.zeros(size)
    for number, item in enumerate(learned):
        parts = _parts(number, item, groups, len(learned))
        whole += parts.T @ item.information @ parts
        score += parts.T @ item.score
    return whole, score


@dataclass(frozen=True, kw_only=True, eq=False)
class _Rest:
    """What is said of the k values by which laboratories differ beside their bases: information
    (k, k) and score (k,), with the group of each, its usual size, and the scales of the groups."""

    information: Array
    score: Array
    of: Places
    usual: Array
    scales: Array

    def given(self, logs: Array, *, alone: bool = False) -> tuple[Array, Array, Array]:
        """Log density (m,) of sets (m, g) of logarithms of scatters over their scales, with mean
        (m, k) and covariance (m, k, k) of the values; none of these where it is asked alone."""
        root = (self.scales * np.exp(logs))[:, self.of] * self.usual
        known = Normal(
            information=root[:, :, None] * self.information * root[:, None],
            score=root * self.score,
            centre=np.zeros(len(self.score)),
        )
        log = known.log_evidences + np.sum(logs - 0.5 * np.exp(2.0 * logs), axis=1)
        if alone:
            return log, np.zeros((len(log), 0)), np.zeros((len(log), 0, 0))
        mean, covariance = known.posterior
        return log, root * mean, root[:, :, None] * covariance * root[:, None]


def _densities(rest: _Rest) -> list[Array]:
    """Density at `LOGS` of each group's scatter and of what it adds to the mean square, where the
    others are most probable."""
    densities = [np.zeros(0) for _ in rest.scales]
    at = np.full(len(densities), -1.0)
    for group in [*range(len(densities))] * 2:
        asked = np.tile(at, (len(LOGS), 1))
        asked[:, group] = LOGS
        log, _, _ = rest.given(asked, alone=True)
        own = np.exp(FLATTER * (log - log.max())) + 1e-12
        square = own * np.exp(2.0 * LOGS)
        densities[group] = own / own.sum() + square / square.sum()
        at[group] = LOGS[np.argmax(log)]
    return densities


def _drawn(densities: Sequence[Array]) -> tuple[Array, Array]:
    """Sets (m, g - 1) of logarithms of scatters, and the log density by which they are drawn."""
    even, weight = _even(len(densities))
    sets, log = np.zeros_like(even), -np.log(weight)
    for k, density in enumerate(densities):
        cells = 0.5 * (density[1:] + density[:-1])
        below = np.concatenate([[0.0], np.cumsum(cells)]) / cells.sum()
        place = np.clip(np.searchsorted(below, even[:, k], side="right") - 1, 0, len(cells) - 1)
        low, rise = density[place], np.diff(density)[place]
        left = (even[:, k] - below[place]) * cells.sum()
        share = 2.0 * left / (low + np.sqrt(low**2 + 2.0 * rise * left))
        sets[:, k] = LOGS[place] + share * (LOGS[1] - LOGS[0])
        log += np.log(low + share * rise)
    return sets, log


def scatter_of_base(
    moved: Sequence[tuple[float, float]], scale: float, offset: float
) -> tuple[float, float]:
    """By what the bases of laboratories differ, and those of kinds of tests, over usual sizes.

    Examples
    --------
    >>> [round(x, 3) for x in scatter_of_base([(0.1, 1000.0)], 0.05, 0.15)]
    [0.045, 0.077]
    >>> [round(x, 3) for x in scatter_of_base([], 0.05, 0.15)]
    [0.05, 0.0]

    Notes
    -----
    In polar coordinates √2 τ = r cos θ, σ = r sin θ the likelihood is of r alone. The integral over
    r² is that of a generalised inverse Gaussian, made anew for each θ about its own mode; over θ
    the integrand is even about both ends, so that the trapezoidal rule converges faster than any
    power of its step.
    """
    if not moved:
        return scale, 0.0
    directions = sum(count for _, count in moved)
    power, square = 1.0 - 0.5 * directions, sum(count * size**2 for size, count in moved)
    before = np.zeros(2)
    for angles in (2**k for k in range(5, 15)):
        angle = np.linspace(0.0, 0.5 * np.pi, angles + 1)
        shares = np.stack([0.5 * np.cos(angle) ** 2, np.sin(angle) ** 2])
        log, apart = _how_far(power, np.array([scale, offset]) ** -2.0 @ shares, square)
        weight = np.exp(log - log.max())
        weight[[0, -1]] *= 0.5
        sizes = np.sqrt(shares @ (weight * apart) / weight.sum())
        if np.all(np.abs(sizes - before) <= CONVERGED * sizes):
            break
        before = sizes
    return float(sizes[0]), float(sizes[1])


def _how_far(power: float, rate: Array, square: float) -> tuple[Array, Array]:
    """Logarithms of ∫ w^(p-1) exp(-½(c w + s/w)) dw, a generalised inverse Gaussian, and the means
    of w, for rates c (n,): a sum over ln w about the mode of w^p, to where it has fallen."""
    root = np.sqrt(power**2 + rate * square)
    mode = np.where(power > 0, (power + root) / rate, square / (root - power))
    up, down = 0.5 * rate * mode, 0.5 * square / mode
    x = np.linspace(-_where_fallen(down, up), _where_fallen(up, down), STEPS)
    density = np.exp(-_fallen(up, down, x))
    total = density.sum(axis=0)
    log = power * np.log(mode) - up - down + np.log(total * (x[1] - x[0]))
    return log, mode * (density * np.exp(x)).sum(axis=0) / total


def _fallen(up: Array, down: Array, x: Array) -> Array:
    """By how much the logarithm of that integrand has fallen, x in ln w above the mode."""
    fallen: Array = up * (np.expm1(x) - x) + down * (np.expm1(-x) + x)
    return fallen


def _where_fallen(up: Array, down: Array) -> Array:
    """How far above the mode that reaches `FALLEN`: by bisection, since it only grows."""
    low, high = np.zeros_like(up), np.full_like(up, FARTHEST)
    for _ in range(50):
        middle = 0.5 * (low + high)
        beyond = _fallen(up, down, middle) > FALLEN
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return high


def _parts(number: int, item: Learned, groups: Groups, count: int) -> Array:
    """What the values (n) of a laboratory are made of: what all share, what captive tests are off,
    and what each laboratory has of its own. A base that does not move is that of the first."""
    base = (groups.of == 0) & (not item.moves)
    none = np.zeros((len(base), len(base)))
    own = [np.diag((~base).astype(float)) if i == number else none for i in range(count)]
    own[0] = own[0] + np.diag(base.astype(float))
    off = np.diag((base | item.offset).astype(float))
    return np.concatenate([np.eye(len(base)), off, *own], axis=1)


def _even(count: int) -> tuple[Array, Array]:
    """Sets (n, count) of numbers from 0 to 1 that fill their space evenly (Roberts 2018: multiples
    of powers of the generalised golden ratio, there and back), and weights that fall to both ends,
    so that the mean of what is smooth settles sooner than by equal ones."""
    if not count:
        return np.zeros((1, 0)), np.ones(1)
    ratio = 2.0
    for _ in range(50):
        ratio = (1.0 + ratio) ** (1.0 / (count + 1))
    steps = ratio ** -np.arange(1.0, count + 1)
    number = np.arange(1, POINTS + 1)
    even = np.abs(2.0 * ((0.5 + number[:, None] * steps) % 1.0) - 1.0)
    return even, 1.0 - np.abs((2.0 * number - 1.0) / POINTS - 1.0)
