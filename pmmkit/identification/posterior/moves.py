"""A move of walkers that emcee does not have; imported only where emcee is there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from emcee.moves import RedBlueMove

from pmmkit.numerics import Array

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
