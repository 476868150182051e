"""Does an effect belong to the ship or to the laboratory? What a third laboratory would find."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from pmmkit.inference import log_normal
from pmmkit.numerics import Array

Owner = Literal["the ship's", "the laboratory's", "cannot tell"]
LABORATORY: Final[Owner] = "the laboratory's"
DECIDED: Final = 1.0
"""ln of the odds from which it is said whose an effect is."""
SCATTER: Final = 0.25
"""Scale of the half-normal prior of what laboratories differ by, over the size that is found; two
of them hardly determine it: half and double of it are told too (docs/diagnose.md)."""
LEAST: Final = 0.1
"""Least of these sizes over the usual ones: an effect of hardly any size may differ by some."""
SCALES: Final = np.exp(np.linspace(-14.0, 2.0, 257))
"""What laboratories may differ by, over the scale of the prior, even in its logarithm: from where
no density is left (1e-6) to where the prior has fallen by exp(-27); steps of 6 %."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LaboratoryValues:
    """Coefficients of an effect as one laboratory found them.

    covariance (n, n).
    """

    laboratory: str
    values: Array
    covariance: Array
    coefficients: tuple[str, ...] = ()
    typical: tuple[float, ...] = ()

    def only(self, names: Sequence[str]) -> LaboratoryValues:
        """Some of the coefficients."""
        at = [self.coefficients.index(name) for name in names]
        return replace(
            self,
            values=self.values[at],
            covariance=self.covariance[np.ix_(at, at)],
            coefficients=tuple(names),
            typical=tuple(self.typical[k] for k in at),
        )


def log_shared(
    found: Sequence[LaboratoryValues], prior: Array, centre: Array | None = None
) -> float:
    """ln of how much more probable one set of coefficients for all is than one for each.

    prior (n, n).

    Examples
    --------
    >>> one = lambda x: LaboratoryValues(
    ...     laboratory="", values=np.array([x]), covariance=np.array([[0.01]])
    ... )
    >>> prior = np.array([[2.25]])
    >>> round(log_shared([one(1.0), one(1.1)], prior), 2)
    2.36
    >>> round(log_shared([one(1.0), one(-1.0)], prior), 2)
    -97.19
    """
    c0 = np.zeros(len(prior)) if centre is None else centre
    together = log_normal(
        np.concatenate([item.values - c0 for item in found]),
        _scattered(found, prior, np.zeros_like(prior)),
    )
    alone = sum(log_normal(item.values - c0, item.covariance + prior) for item in found)
    return together - alone


def owner(log_odds: float) -> Owner:
    """Whose an effect is, from `log_shared`."""
    if log_odds > DECIDED:
        return "the ship's"
    return LABORATORY if log_odds < -DECIDED else "cannot tell"


@dataclass(frozen=True, kw_only=True, eq=False)
class Third:
    """What a laboratory that has not tested yet would find.

    `values, std`: mean and standard deviation: of the shared coefficients, and of what
    laboratories differ by. `scale`: of the half-normal prior of what they differ by, over the
    usual sizes.
    """

    values: Array
    std: Array
    scale: float


def found_size(found: Sequence[LaboratoryValues], usual: Array) -> float:
    """Root mean square of the coefficients of all laboratories over their usual sizes, each
    weighed by how well it is known and without what its uncertainty makes of it; `LEAST` to 1.

    Examples
    --------
    >>> sharp = LaboratoryValues(
    ...     laboratory="", values=np.array([0.3]), covariance=np.array([[1e-4]])
    ... )
    >>> vague = LaboratoryValues(
    ...     laboratory="", values=np.array([0.9]), covariance=np.array([[1.0]])
    ... )
    >>> round(found_size([sharp, vague], np.ones(1)), 2)
    0.3
    """
    z = np.concatenate([item.values / usual for item in found])
    variance = np.concatenate([np.diagonal(item.covariance) / usual**2 for item in found])
    weight = 1.0 / variance
    square = float(np.sum(weight * np.maximum(z**2 - variance, 0.0)) / np.sum(weight))
    return min(max(math.sqrt(square), LEAST), 1.0)


def third(
    found: Sequence[LaboratoryValues], prior: Array, usual: Array, *, scale: float = SCATTER
) -> Third:
    """The shared coefficients, with the interval of a laboratory that has not tested yet.

    prior (n, n).

    Examples
    --------
    >>> one = LaboratoryValues(laboratory="", values=np.array([1.0]), covariance=np.array([[0.01]]))
    >>> [
    ...     round(float(third([one, one], np.eye(1), np.ones(1), scale=x).std[0]), 2)
    ...     for x in (0.25, 0.5, 1.0)
    ... ]
    [0.23, 0.39, 0.64]
    """
    spread = np.diag(np.square(usual))
    weight, mean, square = [], [], []
    for tau in (scale * SCALES).tolist():
        between = tau**2 * spread
        whole = _scattered(found, prior, between)
        across = np.tile(prior, (1, len(found)))
        c = np.concatenate([item.values for item in found])
        value = across @ np.linalg.solve(whole, c)
        left = prior - across @ np.linalg.solve(whole, across.T) + between
        # The last is what a step of ln τ holds of τ.
        weight.append(log_normal(c, whole) - 0.5 * (tau / scale) ** 2 + math.log(tau))
        mean.append(value)
        square.append(np.diagonal(left) + value**2)
    share = np.exp(np.array(weight) - max(weight))
    share = share / share.sum()
    values = share @ np.stack(mean)
    variance = share @ np.stack(square) - values**2
    return Third(values=values, std=np.sqrt(variance), scale=scale)


def _scattered(found: Sequence[LaboratoryValues], prior: Array, between: Array) -> Array:
    """Covariance of what laboratories find: what they share, by which they differ, and noise."""
    n = len(prior)
    whole = np.tile(prior, (len(found), len(found)))
    for i, item in enumerate(found):
        own = slice(i * n, (i + 1) * n)
        whole[own, own] += item.covariance + between
    return whole
