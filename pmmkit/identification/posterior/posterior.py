"""Sampling the posterior of parameters from free-running records."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import DataError, Progress, SimulationError, Workers
from pmmkit.identification.lack import LackOfFit
from pmmkit.identification.posterior.density import (
    DEGREES,
    PROCESS_NOISE,
    SENSOR_SCALE,
    Density,
    density_of,
)
from pmmkit.identification.posterior.ensembles import (
    ENSEMBLES,
    R_HAT,
    Convergence,
    EnsembleDraws,
    check_emcee,
    drawn_from,
    walkers_of,
)
from pmmkit.identification.posterior.tree import draws_of, tree_of, write_posterior
from pmmkit.identification.prior import Prior
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.restarts import filtered
from pmmkit.models import Model
from pmmkit.numerics import Array, root_of
from pmmkit.simulation import Draws

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.conventions import Convention
    from pmmkit.plotting import Figure

STEPS: Final = 2000
"""Most steps of a walker."""
WIDER: Final = 1.5
"""Spread of the walkers' starts over that of the estimate they begin from: R-hat asks for more."""
LEAST_ROUGH: Final = 1e-4
"""Process noise about which walkers begin where the estimate has none."""
APART: Final = 0.7
"""Standard deviation of the logarithm of the process noise that they begin with."""
TRIES: Final = 30
"""Times that a start where the density is nothing is moved halfway to the estimate."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Posterior:
    """Draws from the posterior of parameters, and what they say.

    Parameters
    ----------
    names : tuple of str
        Parameters.
    values : array (m,)
        Means of the draws.
    covariance : array (m, m)
        Of the draws.
    prior : Prior
        What was known before.
    lack : LackOfFit
        What the Kalman filter, from whose estimate the walkers began, says against the model.
    tree : xarray.DataTree
        Draws, what was told of them, and the records, in the layout of ArviZ.
    convergence : Convergence
        Of the parameters and what was drawn beside them.
    quantiles : mapping of str to (float, float, float)
        2.5 %, 50 % and 97.5 % of everything drawn.
    ensembles, walkers, steps, beginning : int
        Of the sampler; `beginning` are the steps that are left out.
    tried : tuple of str
        What the filter had to try before the motion was not lost.
    seconds : float
        It took.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    prior: Prior
    lack: LackOfFit
    tree: xr.DataTree
    convergence: Convergence
    quantiles: Mapping[str, tuple[float, float, float]]
    ensembles: int
    walkers: int
    steps: int
    beginning: int
    tried: tuple[str, ...]
    seconds: float

    @property
    def converged(self) -> bool:
        """Whether the ensembles agree and say enough."""
        return self.convergence.reached

    @property
    def draws(self) -> Draws:
        """For `monte_carlo` and `Bands.of`, in place of a spread."""
        return draws_of(self.tree)

    def write(self, path: str | Path) -> None:
        """Write the draws as NetCDF4, which ArviZ reads; the same draws give the same bytes."""
        write_posterior(self.tree, path)

    @property
    def unconverged(self) -> tuple[str, ...]:
        """What is to be said where the ensembles do not agree; nothing where they do."""
        if self.converged:
            return ()
        return (
            f"The posterior is NOT converged after {self.steps} steps: "
            f"{self.convergence.words()}, where {self.convergence.chains} ensembles need R-hat "
            f"below {R_HAT:g} and an effective sample size of {self.convergence.asked:.0f}. Values "
            f"and intervals are not to be used: allow more steps, or name fewer parameters.",
        )

    def plot(self, convention: Convention | None = None) -> Figure:
        """How everything drawn is distributed, ensemble by ensemble, beside its prior.

        Parameters
        ----------
        convention : Convention, optional
            Of the derivatives, for their symbols.
        """
        from pmmkit.identification.figures import marginals

        return marginals(self.tree, convention)

    def content(self) -> dict[str, Any]:
        """For JSON: whether it converged, agreement by parameter, quantiles."""
        told = self.convergence
        return {
            "converged": self.converged,
            "convergence": {
                name: {"r_hat": a, "ess_bulk": b, "ess_tail": c}
                for name, a, b, c in zip(
                    told.names,
                    told.r_hat.tolist(),
                    told.ess_bulk.tolist(),
                    told.ess_tail.tolist(),
                    strict=True,
                )
            },
            "quantiles": {name: list(three) for name, three in self.quantiles.items()},
        }

    def notes(self) -> tuple[str, ...]:
        """How it was drawn, and what was drawn beside the parameters."""
        said = [
            f"{self.ensembles} ensembles of {self.walkers} walkers, {self.steps} steps, the first "
            f"{self.beginning} left out, {'converged' if self.converged else 'NOT converged'}: "
            f"{self.convergence.words()}"
        ]
        if PROCESS_NOISE in self.quantiles:
            low, middle, high = self.quantiles[PROCESS_NOISE]
            said.append(
                f"process noise {middle:.2g} ({low:.2g} to {high:.2g}) U²/L over the root of L/U"
            )
        low, middle, high = self.quantiles[SENSOR_SCALE]
        said.append(
            f"standard deviations of the sensors {middle:.3g} ({low:.3g} to {high:.3g}) times as "
            f"large as stated or told"
        )
        if self.lack.words():
            said.append("intervals of a posterior are not widened by what is missing")
        return tuple(said)


def sample_posterior(
    model: Model,
    records: Sequence[FreeRecord],
    prior: Prior,
    *,
    sensors: Mapping[str, float] | None = None,
    roughness: float | None = None,
    steps: int = STEPS,
    ensembles: int = ENSEMBLES,
    walkers: int | None = None,
    seed: int = 0,
    extrapolate: bool = False,
    executor: Workers = None,
    progress: Progress | None = None,
) -> Posterior:
    """Draw parameters from their posterior, given free-running records.

    Notes
    -----
    The likelihood is that of the innovations of an extended Kalman filter whose states are those of
    the ship alone: motion and start of each record are integrated out, linearised about the
    filtered motion, and so is what acts on the ship beside the model, as white process noise
    (Kristensen, Madsen and Jørgensen 2004). One unknown factor of all variances is integrated out
    too: it has a scaled inverse χ² of 10 degrees of freedom about 1 (0.7 to 1.8 times the standard
    deviations in 95 of 100), and is not told by the measurements that find the starts. The process
    noise has an exponential prior of mean 0.03 U²/L over the root of L/U (Simpson et al. 2017).
    States begin within a ship length, 0.5 rad, and a third of the speed about what the records
    imply, far wider than they tell. Outliers are those of the filter's own estimate, the same for
    all draws.

    Walkers begin about that estimate with 1.5 times its spread.
    """
    check_emcee()
    started = time.perf_counter()
    if ensembles < ENSEMBLES:
        raise DataError(
            f"ensembles = {ensembles}: whether they agree is seen from {ENSEMBLES} or more."
        )
    about, tried = filtered(
        model, records, prior, method="ekf", sensors=sensors, extrapolate=extrapolate
    )
    density = density_of(
        model,
        records,
        prior,
        about,
        sensors=sensors or {},
        roughness=roughness,
        extrapolate=extrapolate,
    )
    count = walkers or walkers_of(len(density.names))
    if count < 2 * len(density.names) or count % 2:
        raise DataError(
            f"walkers = {count}: an ensemble needs an even number, twice as many as the "
            f"{len(density.names)} numbers that are drawn, or more."
        )
    begin = np.stack(
        [
            _starts(density, about.values, about.lack.alone, about.roughness, count, (seed, i))
            for i in range(ensembles)
        ]
    )

    def tell(done: int, what: str) -> None:
        if progress is not None:
            progress(done, steps, f"{done} steps of {ensembles} ensembles: {what}")

    found = drawn_from(
        density, begin, density.names, seed=seed, steps=steps, executor=executor, tell=tell
    )
    return _told(density, records, found, about.lack, tried, seed, started)


def _starts(
    density: Density,
    values: Array,
    covariance: Array,
    roughness: float,
    walkers: int,
    seed: tuple[int, int],
) -> Array:
    """Numbers (w, d) of the walkers of an ensemble, all where the density is not nothing."""
    rng = np.random.default_rng(seed)
    drawn = WIDER * rng.standard_normal((walkers, len(values))) @ root_of(covariance).T
    rough = max(roughness, LEAST_ROUGH) * np.exp(APART * rng.standard_normal((walkers, 1)))
    own = PROCESS_NOISE in density.names
    middle = density.numbers(np.append(values, [max(roughness, LEAST_ROUGH)] * own))
    begin = density.numbers(np.hstack([values + drawn, rough[:, : int(own)]]))
    for i in range(walkers):
        for _ in range(TRIES):
            if np.isfinite(density(begin[i])[0]):
                break
            begin[i] = 0.5 * (begin[i] + middle)
        else:
            raise SimulationError(
                "The motion is lost about the values from which the walkers would begin. Check "
                "the signs of rudder and heading, and the sensors' standard deviations."
            )
    return begin


def _told(
    density: Density,
    records: Sequence[FreeRecord],
    found: EnsembleDraws,
    lack: LackOfFit,
    tried: tuple[str, ...],
    seed: int,
    started: float,
) -> Posterior:
    own = density.parameters(found.draws)
    scales = _scales(density, found, seed)
    everything = {name: own[..., i] for i, name in enumerate(density.names)}
    everything[SENSOR_SCALE] = scales
    m = len(density.prior.names)
    flat = own[..., :m].reshape(-1, m)
    covariance = np.cov(flat, rowvar=False).reshape(m, m)
    ensembles, _, walkers, _ = found.draws.shape
    return Posterior(
        names=density.prior.names,
        values=flat.mean(axis=0),
        covariance=covariance,
        prior=density.prior,
        lack=replace(lack, covariance=covariance, alone=covariance),
        tree=tree_of(density, records, found, everything, seed),
        convergence=found.convergence,
        quantiles={
            name: tuple(np.quantile(x, [0.025, 0.5, 0.975]).tolist())
            for name, x in everything.items()
        },
        ensembles=ensembles,
        walkers=walkers,
        steps=found.steps,
        beginning=found.left_out,
        tried=tried,
        seconds=time.perf_counter() - started,
    )


def _scales(density: Density, found: EnsembleDraws, seed: int) -> Array:
    """Factors of the sensors' standard deviations, drawn given each draw of the parameters."""
    squares = found.more[..., 1]
    rng = np.random.default_rng([seed, len(squares)])
    chance = rng.chisquare(density.freedom, squares.shape)
    drawn: Array = np.sqrt((DEGREES + squares) / chance)
    return drawn
