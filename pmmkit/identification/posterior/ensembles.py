"""Ensembles of walkers that draw from a density, until they agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
from emcee.moves import RedBlueMove

from pmmkit.base import DataError, Workers, each, opened
from pmmkit.numerics import Array

# Whether chains of draws have converged: R-hat by ranks, and effective sample sizes.


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


# A move of walkers that emcee does not have; imported only where emcee is there.


FREEDOM: Final = 5.0
"""Degrees of freedom of the t: its tails are longer than those of most posteriors."""


class FittedMove(RedBlueMove):  # type: ignore[misc]  # emcee has no types
    """Proposals from a multivariate t with mean and covariance of the other half of the ensemble.

    They do not depend on where a walker is, so that a walker forgets that at once; where the
    posterior is nearly normal most are accepted. The half that is moved takes no part in the fit,
    which keeps the balance (as in emcee's move by kernel densities).
    """

    def get_proposal(
        self, sample: Array, complement: Sequence[Array], random: Any
    ) -> tuple[Array, Array]:
        """Places (n, d) for the walkers (n, d), and ln of the ratio of proposing them back."""
        others = np.concatenate(complement)
        middle = others.mean(axis=0)
        away = others - middle
        scale = np.sqrt(np.mean(away**2, axis=0))
        correlation = away.T @ away / np.outer(scale, scale) / (len(others) - 1)
        correlation[np.diag_indices_from(correlation)] += 1e-9
        root = scale[:, None] * np.linalg.cholesky(correlation)
        count, width = sample.shape
        chance = np.sqrt(FREEDOM / random.chisquare(FREEDOM, (count, 1)))
        proposed = middle + chance * random.standard_normal((count, width)) @ root.T

        def density(places: Array) -> Array:
            squares = np.sum(np.linalg.solve(root, (places - middle).T) ** 2, axis=0)
            found: Array = -0.5 * (FREEDOM + width) * np.log1p(squares / FREEDOM)
            return found

        return proposed, density(sample) - density(proposed)


ENSEMBLES: Final = 4
"""Least number that can be set against each other."""
BEGINNING: Final = 1 / 3
"""Share of the steps that is left out, on the way from the starts."""
FIRST: Final = (60, 6)
"""Steps before agreement is looked at: these, or so many a dimension."""
MORE: Final = 1.25
"""Growth of the number of steps from one look to the next."""
MOVES: Final = {"fitted": 0.7, "differential": 0.2, "stretch": 0.1}
"""Shares of the moves."""

LogDensity = Callable[[Array], tuple[float, ...]]
"""ln of a density, and further numbers that are kept beside each draw."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EnsembleDraws:
    """What ensembles drew.

    `draws (e, t, w, d)`: numbers of each ensemble, step and walker, without the beginning.
    `more (e, t, w, b)`: what the density gave beside it. `accepted (e,)`: share of the moves
    that were accepted. `steps, left_out`: steps of each walker, and those of them that are left
    out as the beginning.
    """

    draws: Array
    log_density: Array
    more: Array
    accepted: Array
    steps: int
    left_out: int
    convergence: Convergence

    @property
    def time(self) -> int:
        """Steps after which a walker has forgotten where it was: the draws over the effective."""
        least = self.convergence.least
        kept = self.log_density.size
        longest = int(self.draws.shape[1])
        return min(math.ceil(kept / least), longest) if least > 0.0 else longest


def walkers_of(dimensions: int) -> int:
    """Walkers of an ensemble: six a dimension, twelve at least."""
    return 6 * max(dimensions, 2)


def drawn_from(
    density: LogDensity,
    starts: Array,
    names: Sequence[str],
    *,
    seed: int,
    steps: int,
    executor: Workers = None,
    tell: Callable[[int, str], None] | None = None,
) -> EnsembleDraws:
    """Draw from a density by independent ensembles, until they agree or the steps are used up.

    starts (e, w, d).

    Notes
    -----
    Of ten moves, seven propose from a t that is fitted to the other half of the ensemble, two are
    of differential evolution (ter Braak 2006), one is a stretch (Goodman and Weare 2010), as emcee
    has them (Foreman-Mackey et al. 2013); these help where the density is far from normal. A
    third of the steps is left out. The ensembles agree when rank-normalised split R-hat (Vehtari
    et al. 2021) is below 1.01 for every number and the effective sample size, in the bulk and
    in the tails, 100 times the number of ensembles. The snooker move of emcee 3.1.6 is not used: it
    draws from too narrow a density (a normal one in five dimensions with 0.7 of its variance).
    """
    check_emcee()
    work = partial(_moved, density)
    states: list[Any] = [(item, _generator(seed, i), None) for i, item in enumerate(starts)]
    called = [f"ensemble {i + 1}" for i in range(len(starts))]
    pieces: list[list[tuple[Array, Array, Array, Array]]] = [[] for _ in starts]
    done, goal = 0, min(max(FIRST[0], FIRST[1] * starts.shape[2]), steps)
    with opened(executor, rounds=True) as crew:
        while True:
            asked = [(*state, goal - done) for state in states]
            for place, (state, piece) in each(work, asked, crew, names=called):
                states[place] = state
                pieces[place].append(piece)
            done = goal
            found = _joined(pieces, done, names)
            if tell is not None:
                tell(done, found.convergence.words())
            if found.convergence.reached or done >= steps:
                return found
            goal = min(math.ceil(MORE * done), steps)


def check_emcee() -> None:
    """Raise where the sampler is not there."""
    try:
        import emcee  # noqa: F401
    except ImportError as error:
        raise DataError(
            "Sampling a posterior needs emcee, which is not installed: pip install "
            "'pmmkit[posterior]'."
        ) from error


def _generator(seed: int, number: int) -> Any:
    """State of the generator of an ensemble, as emcee takes it."""
    bits = np.random.MT19937(np.random.SeedSequence([seed, number]))
    return np.random.RandomState(bits).get_state()


def _moved(density: LogDensity, asked: tuple[Any, Any, Any, int]) -> tuple[Any, Any]:
    """An ensemble moved by so many steps: where it is then, and the steps."""
    from emcee import EnsembleSampler, State
    from emcee.moves import DEMove, StretchMove

    moves = {"fitted": FittedMove(), "differential": DEMove(), "stretch": StretchMove()}
    places, generator, known, count = asked
    sampler = EnsembleSampler(
        *places.shape, density, moves=[(moves[name], share) for name, share in MOVES.items()]
    )
    log_density, more = known or (None, None)
    begin = State(places, log_prob=log_density, blobs=more, random_state=generator)
    end = sampler.run_mcmc(begin, count, skip_initial_state_check=known is not None)
    told = sampler.get_log_prob()
    steps = (
        sampler.get_chain(),
        told,
        np.asarray(sampler.get_blobs(), float).reshape(*told.shape, -1),
        sampler.acceptance_fraction * count,
    )
    return (end.coords, end.random_state, (end.log_prob, end.blobs)), steps


def _joined(
    pieces: Sequence[Sequence[tuple[Array, Array, Array, Array]]], done: int, names: Sequence[str]
) -> EnsembleDraws:
    """The draws of all steps but the first."""
    left_out = int(done * BEGINNING)
    draws, log_density, more = (
        np.stack([np.concatenate([piece[i] for piece in own])[left_out:] for own in pieces])
        for i in range(3)
    )
    accepted = [sum(float(np.mean(piece[3])) for piece in own) / done for own in pieces]
    return EnsembleDraws(
        draws=draws,
        log_density=log_density,
        more=more,
        accepted=np.array(accepted),
        steps=done,
        left_out=left_out,
        convergence=convergence(draws, names),
    )
