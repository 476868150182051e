"""An independent check of the covariance: the whole fit repeated with drawn errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array
from pmmkit.reduction.observations.equations import Rows, Sensitivity
from pmmkit.reduction.solve import Solution, solve, to_table

if TYPE_CHECKING:
    from pmmkit.reduction.reduce import Reduction


def monte_carlo(reduction: Reduction, *, n: int = 500, seed: int = 0) -> Array:
    """Repeat the fit with errors drawn from what is known of the noise and the settings.

    An independent check of the covariance: the regressors are perturbed and the least squares are
    solved anew, where the covariance follows first-order derivatives.
    """
    groups = [
        (float(froude), members)
        for froude, members in zip(reduction.solution.Fn, reduction.solution.groups, strict=True)
    ]
    noise = _noise(reduction.solution)
    names = next(iter(reduction.estimates.values())).table.names
    draws = []
    for number in range(n):
        rng = np.random.default_rng([seed, number])
        rows = _perturbed(reduction.rows, reduction.sensitivities, noise, rng)
        between = reduction.solution.between
        found = solve(
            rows, reduction.sensitivities, reduction.columns, groups, between, intervals=False
        )
        table = to_table(
            found, reduction.columns, reduction.campaign, reduction.convention, method="draw"
        )
        draws.append(table.select(names).value)
    return np.stack(draws)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Chance:
    """What chance does to the rows of one run in one channel.

    `factor` is the Cholesky factor of the noise, `drawn` what the run draws for itself per
    standard deviation, at the rows `keep`.
    """

    factor: Array
    drawn: Array
    keep: NDArray[np.bool_]

    def draw(self, rng: np.random.Generator) -> Array:
        """One error (m,)."""
        shake = np.zeros(len(self.keep))
        shake[self.keep] = self.factor @ rng.normal(size=len(self.factor))
        shake[self.keep] += self.drawn @ rng.normal(size=self.drawn.shape[1])
        return shake


def _noise(solution: Solution) -> dict[tuple[int, str], _Chance]:
    """Noise and scatter of each run and channel."""
    return {
        (solution.groups[group][block.run], item.channel): _Chance(
            factor=np.linalg.cholesky(covariance).astype(np.float64), drawn=drawn, keep=block.keep
        )
        for group, item in solution.fits
        for block, covariance, drawn in zip(
            item.blocks, item.noise.covariances, item.width.columns, strict=True
        )
    }


def _perturbed(
    rows: Sequence[Rows],
    sensitivities: Sequence[Sequence[Sensitivity]],
    noise: dict[tuple[int, str], _Chance],
    rng: np.random.Generator,
) -> list[Rows]:
    sources = [change.source for change in sensitivities[0]] if sensitivities else []
    first: dict[str, int] = {}
    causes = [
        first.setdefault(source.common, number) if source.common else number
        for number, source in enumerate(sources)
    ]
    common = rng.normal(size=len(sources))[causes]
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
                force[channel] = force[channel] + noise[place, channel].draw(rng)
        made.append(replace(item, force=force, design=design))
    return made
