"""How noisy each run is, with strength borrowed from runs that are alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmmkit.numerics import Array

FLOOR = 1e-6
"""Noise below this share of a channel's size does not count: records of a noise-free solver."""
KIN = 3
"""So many like runs show how far their noise differs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Noise:
    """Noise of the rows of k runs, and how well its levels are known.

    `covariances (m_i, m_i)`: covariance of each run's rows. `doubt (k, q)`: standard errors of
    the logarithms of the variances, a column for each thing that was estimated: a column that
    several runs share moves their levels together. Infinite where nothing is known.
    """

    covariances: tuple[Array, ...]
    doubt: Array

    @property
    def dof(self) -> Array:
        """Degrees of freedom of each run's variance by itself, (k,)."""
        return degrees(np.sum(self.doubt**2, axis=1))


def degrees(variance: Array) -> Array:
    """Degrees of freedom of variances whose logarithms have these variances: 2 over them.

    Examples
    --------
    >>> degrees(np.array([0.25, 0.0, np.inf]))
    array([ 8., inf,  0.])
    """
    with np.errstate(divide="ignore"):
        return np.asarray(2.0 / np.asarray(variance, float))


def shrunk_levels(levels: Array, dof: Array) -> tuple[Array, Array, Array]:
    """Noise levels of like runs, drawn towards each other as far as their scatter is chance.

    levels (k,); dof (k,); levels, own (k,); doubt (k, k + 1).

    Notes
    -----
    Empirical Bayes on the logarithm of the variances, whose sampling variance is the trigamma
    function of half the degrees of freedom (Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3(1)). The
    common level is the weighted mean of the variances themselves, which no error in the degrees
    of freedom can bias.

    Examples
    --------
    >>> levels, own, doubt = shrunk_levels(np.array([1.0, 1.1, 0.9, 1.05]), np.full(4, 10.0))
    >>> bool(np.ptp(levels) < 1e-12), own
    (True, array([0., 0., 0., 0.]))
    >>> degrees((doubt**2).sum(axis=1)).round(6)
    array([40., 40., 40., 40.])
    """
    from scipy.special import digamma, polygamma

    half = np.clip(dof, 1.0, 1e6) / 2
    own = np.ones(len(levels))
    if len(levels) >= KIN:
        log = np.log(levels) - (digamma(half) - np.log(half))
        sampling = polygamma(1, half)
        centre = float(np.log(half @ levels / half.sum()))
        between = max(0.0, float(np.var(log, ddof=1) - sampling.mean()))
        own = between / (between + sampling)
        levels = np.exp(own * log + (1 - own) * centre)
    doubt = np.column_stack([np.diag(own / np.sqrt(half)), (1 - own) / np.sqrt(half.sum())])
    return levels, own, doubt


def moderated(
    covariances: Sequence[Array],
    dof: Sequence[float],
    size: float,
    durations: Sequence[float],
    *,
    spectrum: bool = True,
) -> Noise:
    """Covariances of like runs with moderated levels and spectra, and a floor.

    What is alike is the noise of a second: means over more of them are quieter.

    covariances (m_i, m_i); durations [s].
    """
    floor = (FLOOR * size) ** 2
    longer = _relative(durations)
    safe = [
        factor * (covariance + floor * np.eye(len(covariance)))
        for factor, covariance in zip(longer, covariances, strict=True)
    ]
    common = None
    if spectrum and len({covariance.shape for covariance in safe}) == 1:
        common = np.mean(safe, axis=0)
    unit = np.ones(1) if common is None else np.diagonal(common)
    levels = np.array([np.mean(np.diagonal(covariance) / unit) for covariance in safe])
    calm, own, doubt = shrunk_levels(levels, np.asarray(dof, float))
    return Noise(
        covariances=tuple(
            new
            / factor
            * (
                covariance / old
                if common is None
                else share * covariance / old + (1 - share) * common
            )
            for new, old, share, factor, covariance in zip(
                calm, levels, own, longer, safe, strict=True
            )
        ),
        doubt=doubt,
    )


def _relative(durations: Sequence[float]) -> Array:
    """Durations over their mean; 1 where one is not known."""
    known = np.asarray(durations, float)
    if not np.isfinite(known).any():
        return np.ones(len(known))
    return np.asarray(np.nan_to_num(known / np.nanmean(known), nan=1.0))


def whiteners(covariances: Sequence[Array]) -> list[Array]:
    """W with ``W C Wᵀ = 1`` for each covariance, by Cholesky of the correlation.

    Examples
    --------
    >>> whiteners([np.diag([4.0, 25.0])])
    [array([[0.5, 0. ],
           [0. , 0.2]])]
    """
    found: list[Array] = [np.zeros((0, 0))] * len(covariances)
    sizes = [len(covariance) for covariance in covariances]
    for size in dict.fromkeys(sizes):
        places = [place for place, own in enumerate(sizes) if own == size]
        alike = np.stack([covariances[place] for place in places])
        scale = np.sqrt(np.diagonal(alike, axis1=1, axis2=2))[:, None, :]
        factor = np.linalg.cholesky(alike / scale / np.swapaxes(scale, 1, 2))
        for place, white in zip(places, np.linalg.inv(factor) / scale, strict=True):
            found[place] = white
    return found
