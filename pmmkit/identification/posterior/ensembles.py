"""Ensembles of walkers that draw from a density, until they agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np

from pmmkit.errors import DataError
from pmmkit.executors import Workers, crew_of, each
from pmmkit.inference import Convergence, convergence
from pmmkit.numerics import Array

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
class Drawn:
    """What ensembles drew.

    Parameters
    ----------
    draws : array (e, t, w, d)
        Numbers of each ensemble, step and walker, without the beginning.
    log_density : array (e, t, w)
        Of the draws.
    more : array (e, t, w, b)
        What the density gave beside it.
    accepted : array (e,)
        Share of the moves that were accepted.
    steps, left_out : int
        Steps of each walker, and those of them that are left out as the beginning.
    convergence : Convergence
        Of each number.
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
) -> Drawn:
    """Draw from a density by independent ensembles, until they agree or the steps are used up.

    Parameters
    ----------
    density : callable
        ln of the density of numbers (d,), minus infinity where there is none, and what is kept
        beside it.
    starts : array (e, w, d)
        Where the walkers of each ensemble begin; more spread than the density.
    names : sequence of str
        Of the d numbers.
    seed : int
        Of the moves: the same seed gives the same draws, bit for bit.
    steps : int
        Most steps of a walker.
    executor : int, str or concurrent.futures.Executor, optional
        Who moves the ensembles; this process where none is given. The draws do not depend on it.
    tell : callable, optional
        Told how many steps are made, and how well the ensembles agree.

    Raises
    ------
    DataError
        If emcee is not installed.

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
    with crew_of(executor) as crew:
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
    """Raise where the sampler is not there.

    Raises
    ------
    DataError
        That says how to install it.
    """
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

    from pmmkit.identification.posterior.moves import FittedMove

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
) -> Drawn:
    """The draws of all steps but the first."""
    left_out = int(done * BEGINNING)
    draws, log_density, more = (
        np.stack([np.concatenate([piece[i] for piece in own])[left_out:] for own in pieces])
        for i in range(3)
    )
    accepted = [sum(float(np.mean(piece[3])) for piece in own) / done for own in pieces]
    return Drawn(
        draws=draws,
        log_density=log_density,
        more=more,
        accepted=np.array(accepted),
        steps=done,
        left_out=left_out,
        convergence=convergence(draws, names),
    )
