"""Uncertainty by Monte Carlo: the whole fit repeated with perturbed records and settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array
from pmmkit.observations.equations import Rows, Sensitivity
from pmmkit.reduction.solve import Solution, solve, to_table

if TYPE_CHECKING:
    from pmmkit.reduction.reduce import Reduction


def monte_carlo(reduction: Reduction, *, n: int = 500, seed: int = 0) -> Array:
    """Repeat the fit with errors drawn from what is known of the noise and the settings.

    An independent check of the covariance: the regressors are perturbed and the least squares are
    solved anew, where the covariance follows first-order derivatives.

    Parameters
    ----------
    reduction : Reduction
        What was reduced.
    n : int
        Number of draws.
    seed : int
        Seed of the random numbers; the same seed gives the same draws.

    Returns
    -------
    array (n, k, p)
        Derivatives in the order of the table, NaN where not determined.
    """
    groups = [
        (float(froude), members)
        for froude, members in zip(reduction.solution.Fn, reduction.solution.groups, strict=True)
    ]
    noise = _noise(reduction.solution)
    draws = []
    for number in range(n):
        rng = np.random.default_rng([seed, number])
        rows = _perturbed(reduction.rows, reduction.sensitivities, noise, rng)
        found = solve(rows, reduction.sensitivities, reduction.columns, groups)
        table = to_table(
            found, reduction.columns, reduction.campaign, reduction.convention, method="draw"
        )
        draws.append(table.select(reduction.table.names).value)
    return np.stack(draws)


def _noise(solution: Solution) -> dict[tuple[int, str], tuple[Array, NDArray[np.bool_]]]:
    """Cholesky factor of the noise of each run and channel, with the rows it stands for."""
    found: dict[tuple[int, str], tuple[Array, NDArray[np.bool_]]] = {}
    for group, item in solution.fits:
        for block, covariance in zip(item.blocks, item.noise, strict=True):
            run = solution.groups[group][block.run]
            factor = np.linalg.cholesky(covariance).astype(np.float64)
            found[run, item.channel] = (factor, block.keep)
    return found


def _perturbed(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    noise: dict[tuple[int, str], tuple[Array, NDArray[np.bool_]]],
    rng: np.random.Generator,
) -> list[Rows]:
    sources = [change.source for change in sensitivities[0]] if sensitivities else []
    common = rng.normal(size=len(sources))
    made = []
    for place, item in enumerate(rows):
        sizes = np.where(
            [source.shared for source in sources], common, rng.normal(size=len(sources))
        )
        force = dict(item.force)
        design = dict(item.design)
        for size, change in zip(sizes, sensitivities[place], strict=True):
            force = {name: values + size * change.force[name] for name, values in force.items()}
            design = {name: values + size * change.design[name] for name, values in design.items()}
        for channel in design:
            if (place, channel) in noise:
                factor, keep = noise[place, channel]
                shake = np.zeros(len(force[channel]))
                shake[keep] = factor @ rng.normal(size=int(keep.sum()))
                force[channel] = force[channel] + shake
        made.append(replace(item, force=force, design=design))
    return made
