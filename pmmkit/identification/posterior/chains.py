"""Whether chains of draws have converged: R-hat by ranks, and effective sample sizes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.numerics import Array

R_HAT: Final = 1.01
"""R-hat below which chains count as converged."""
DRAWS: Final = 100.0
"""Effective draws per chain from which quantiles are trusted."""
TAILS: Final = (0.05, 0.95)
"""Quantiles whose effective sample size is that of the tails."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Convergence:
    """How well chains agree, and how much they say.

    `r_hat (m,)`: rank-normalised split R-hat, the larger of bulk and folded. `ess_bulk,
    ess_tail (m,)`: effective sample sizes of the bulk and of the 5 % and 95 % quantiles.
    `chains`: that are independent of each other.
    """

    names: tuple[str, ...]
    r_hat: Array
    ess_bulk: Array
    ess_tail: Array
    chains: int

    @property
    def least(self) -> float:
        """The smallest effective sample size."""
        return float(np.min([self.ess_bulk, self.ess_tail]))

    @property
    def reached(self) -> bool:
        """Whether every R-hat is below 1.01 and every chain has 100 effective draws."""
        return bool(np.all(self.r_hat < R_HAT)) and self.least >= self.asked

    @property
    def asked(self) -> float:
        """The least effective sample size that counts as enough."""
        return DRAWS * self.chains

    def words(self) -> str:
        """The worst of it."""
        worst = int(np.argmax(self.r_hat))
        fewest = int(np.argmin(np.minimum(self.ess_bulk, self.ess_tail)))
        return (
            f"R-hat at most {self.r_hat[worst]:.3f} ({self.names[worst]}), effective sample size "
            f"at least {self.least:.0f} ({self.names[fewest]})"
        )


def convergence(draws: Array, names: Sequence[str]) -> Convergence:
    """R-hat and effective sample sizes of several numbers.

    draws (chains, steps, walkers, m).
    """
    own = [draws[..., i] for i in range(draws.shape[-1])]
    return Convergence(
        names=tuple(names),
        r_hat=np.array([r_hat(x) for x in own]),
        ess_bulk=np.array([ess_bulk(x) for x in own]),
        ess_tail=np.array([ess_tail(x) for x in own]),
        chains=len(draws),
    )


def r_hat(draws: Array) -> float:
    """Rank-normalised split R-hat, the larger of bulk and folded.

    draws (chains, steps).

    References
    ----------
    Vehtari et al. (2021).

    Examples
    --------
    >>> apart = np.random.default_rng(0).normal(size=(4, 500))
    >>> round(r_hat(apart), 3), round(r_hat(apart + np.arange(4)[:, None]), 1)
    (1.001, 1.5)
    """
    halves = _halves(draws)
    folded = np.abs(halves - np.median(halves))
    return max(_between_over_within(_by_rank(item)) for item in (halves, folded))


def ess_bulk(draws: Array) -> float:
    """Effective sample size of the bulk: that of the mean of the draws' ranks.

    draws (chains, steps).

    Notes
    -----
    Each walker is a chain here, as it is for ArviZ: its autocorrelation is told well by the many of
    them. That they depend on each other a little is not counted; R-hat, which sets whole ensembles
    against each other, would show it.

    References
    ----------
    Vehtari et al. (2021).
    """
    return _effective(_by_rank(_halves(draws)))


def ess_tail(draws: Array) -> float:
    """Effective sample size of the tails: the smaller of those of the 5 % and 95 % quantiles.

    draws (chains, steps).
    """
    halves = _halves(draws)
    ends = np.quantile(halves, TAILS)
    return min(_effective((halves <= end).astype(float)) for end in ends)


def _halves(draws: Array) -> Array:
    """Chains cut in two (2 chains, steps / 2, walkers); the middle step of an odd number is out."""
    walked = draws[..., None] if draws.ndim == 2 else draws
    half = walked.shape[1] // 2
    return np.concatenate([walked[:, :half], walked[:, -half:]])


def _by_rank(draws: Array) -> Array:
    """Normal scores of the ranks among all draws."""
    from scipy.special import ndtri
    from scipy.stats import rankdata

    ranks = rankdata(draws, method="average").reshape(draws.shape)
    scores: Array = ndtri((ranks - 0.375) / (draws.size + 0.25))
    return scores


def _spread(chains: Array) -> tuple[float, float]:
    """Variance within chains (c, n), and that of the whole, which allows for their distance."""
    within = float(np.mean(np.var(chains, axis=1, ddof=1)))
    n = chains.shape[1]
    return within, within * (n - 1) / n + float(np.var(np.mean(chains, axis=1), ddof=1))


def _between_over_within(halves: Array) -> float:
    within, whole = _spread(halves.reshape(len(halves), -1))
    return float(np.sqrt(whole / within)) if within > 0.0 else np.nan


def _effective(halves: Array) -> float:
    """Number of independent draws whose mean would be as sure as that of these."""
    chains = np.swapaxes(halves, 1, 2).reshape(-1, halves.shape[1])
    within, whole = _spread(chains)
    if within <= 0.0:
        return np.nan
    centred = chains - np.mean(chains, axis=1, keepdims=True)
    n = centred.shape[1]
    spectrum = np.fft.rfft(centred, 2 * n, axis=1)
    products = np.fft.irfft(np.mean(np.abs(spectrum) ** 2, axis=0))[:n] / n
    correlation = 1.0 - (within - products) / whole
    correlation[0] = 1.0
    return float(chains.size / max(_time(correlation), 1.0 / np.log10(chains.size)))


def _time(correlation: Array) -> float:
    """Integrated autocorrelation time by the initial monotone sequence of Geyer 1992."""
    pairs = correlation[: len(correlation) // 2 * 2].reshape(-1, 2).sum(axis=1)
    below = np.flatnonzero(pairs < 0.0)
    count = int(below[0]) if len(below) else len(pairs)
    falling = np.minimum.accumulate(pairs[:count])
    after = correlation[2 * count] if 2 * count < len(correlation) else 0.0
    return float(2.0 * np.sum(falling) - 1.0 + max(after, 0.0))
