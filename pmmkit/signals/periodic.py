"""Noise beside the harmonics of a record of whole cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array
from pmmkit.signals import autoregression as ar

Ints = NDArray[np.intp]

TURN: Final = 2.0 * np.pi
MAX_ORDER: Final = 3
PENALTY: Final = 2.0
STEPS: Final = 25
TINY: Final = 1e-300


def phase_cells(phase: Array, count: int) -> tuple[Ints, int]:
    """First sample of each equal stretch of phase, and the stretches in a cycle.

    No stretch is empty as long as the widest gap between samples is below a twelfth of a cycle;
    a stretch holds as nearly as possible the same number of samples as any other.

    Parameters
    ----------
    phase : (n,) array
        Increasing [rad].
    count : int
        Whole cycles.
    """
    step = np.diff(phase)
    mean = (phase[-1] - phase[0]) / step.size
    samples = TURN / mean
    finest = 48 if count < 4 else 32
    finest_kept = min(samples / max(1, (samples + 0.01) // finest), TURN / step.max())
    a_cycle = max(12, int(1.001 * finest_kept))
    cell = ((phase - phase[0] + 0.02 * mean) * (a_cycle / TURN)).astype(np.intp)
    return np.flatnonzero(np.diff(cell, prepend=-1)), a_cycle


def between_harmonics(cells: int, count: int, order: int) -> NDArray[np.bool_]:
    """Which of the discrete frequencies 0 … cells/2 of whole cycles hold noise alone.

    With two cycles or more those that are not multiples of the cycle's; with one cycle those
    above the highest harmonic.

    Parameters
    ----------
    cells : int
        Stretches of phase in the record.
    count : int
        Whole cycles.
    order : int
        Highest harmonic.
    """
    bins = np.arange(cells // 2 + 1)
    noise = bins % count != 0 if count > 1 else bins > order
    return noise & (2 * bins < cells)


def fit_noise(rest: Array, count: int, order: int, lags: int) -> tuple[Array, Array]:
    """Autocovariances and degrees of freedom of the noise in `count` whole cycles.

    Parameters
    ----------
    rest : (c, m) array
        What the harmonics leave, as means over m equal stretches of phase; none constant.
    count : int
        Whole cycles.
    order : int
        Highest harmonic that was removed.
    lags : int
        Autocovariances wanted.

    Returns
    -------
    gamma : (c, lags) array
    dof : (c, order + 1) array
        Degrees of freedom of the noise spectrum at the frequency of each harmonic.

    Notes
    -----
    Autoregressions of order 1 to 3 (with one cycle 1) are fitted to the periodogram between the
    harmonics: what the harmonics have taken away is filled in by its expectation and the
    Yule-Walker equations are solved anew, with the leakage of a finite record accounted for in
    both (Whittle likelihood by expectation and maximisation). The order has the smallest Akaike
    criterion; degrees of freedom are 2 over the variance of the logarithm of the spectrum.
    """
    c, m = rest.shape
    noise = between_harmonics(m, count, order)
    observed = np.abs(np.fft.rfft(rest, axis=-1)) ** 2 / m
    bins = int(noise.sum())
    best = np.full(c, np.inf)
    power = observed[:, noise].mean(axis=-1)
    expected = np.repeat(power[:, None], observed.shape[-1], axis=1)
    covariance = np.zeros((c, m))
    covariance[:, 0] = power
    waves = _Waves.of(m, noise, MAX_ORDER if count > 1 else 1)
    filters = np.eye(1, waves.order + 1).repeat(c, axis=0)
    innovation = np.zeros(c)
    orders = np.zeros(c, dtype=int)
    for p in range(1, waves.order + 1):
        fitted, unexplained, expected, covariance = _expect_and_fit(
            observed, waves, expected, covariance, p
        )
        ratio = observed[:, noise] / np.maximum(expected[:, noise], TINY)
        scale = ratio.mean(axis=-1)
        misfit = 2.0 * np.sum(
            np.log(np.maximum(scale[:, None] * expected[:, noise], TINY)), axis=-1
        )
        score = misfit + PENALTY * p * bins / max(bins - p - 2, 1)
        better = score < best
        best[better], orders[better] = score[better], p
        filters[better, : p + 1] = fitted[better]
        innovation[better] = (scale * unexplained * covariance[:, 0])[better]
    dof = np.zeros((c, order + 1))
    for p in set(orders.tolist()) - {0}:
        own = orders == p
        dof[own] = _degrees(filters[own, : p + 1], m, noise, np.arange(order + 1) * count)
    return ar.autocovariances(filters, innovation, lags), dof


@dataclass(frozen=True, kw_only=True, eq=False)
class _Waves:
    """Cosines and sines by which periodograms of m samples and their few first lags are turned
    into each other; a table of them takes less time than a transform of few numbers.

    `hidden (bins,)`: 1 at the frequencies of the periodogram that the harmonics have taken
    away, 0 elsewhere. `lagged (bins, order + 1)`: from a periodogram to its circular
    autocovariances. `cosines, sines (order + 1, n)`: from a filter to its response at the n
    frequencies of a transform without aliasing.
    """

    hidden: Array
    lagged: Array
    cosines: Array
    sines: Array

    @classmethod
    def of(cls, m: int, noise: NDArray[np.bool_], order: int) -> _Waves:
        weight = np.full(m // 2 + 1, 2.0 / m)
        weight[0] = 1.0 / m
        weight[-1] /= 1.0 + (m % 2 == 0)
        circular = _turns(m, order).real.T * weight[:, None]
        response = _turns(ar.transform_length(m), order)
        return cls(
            hidden=np.where(noise, 0.0, 1.0),
            lagged=circular,
            cosines=response.real.copy(),
            sines=response.imag.copy(),
        )

    @property
    def order(self) -> int:
        """Highest lag."""
        return len(self.cosines) - 1


def _turns(length: int, order: int) -> NDArray[np.complex128]:
    """Powers 0 to `order` of the turn by a sample, at the frequencies of a transform."""
    once = np.exp(1j * (TURN / length) * np.arange(length // 2 + 1))
    return np.cumprod([np.ones_like(once), *[once] * order], axis=0)


def _expect_and_fit(
    observed: Array, waves: _Waves, expected: Array, covariance: Array, p: int
) -> tuple[Array, Array, Array, Array]:
    """Autoregressions of records, with the share of the variance that is innovation, and what they
    lead to expect: periodogram and autocovariances."""
    m = covariance.shape[-1]
    share = np.arange(m) / m
    rest = 1.0 - share
    near = share[1 : p + 1] / rest[1 : p + 1]
    lagged_by = waves.lagged[:, : p + 1] / rest[: p + 1]
    seen = (observed * (1.0 - waves.hidden)) @ lagged_by
    unseen = waves.hidden[:, None] * lagged_by
    cosines, sines = waves.cosines[: p + 1], waves.sines[: p + 1]
    limit = 1.0 - 0.5 / m
    for _ in range(STEPS):
        lagged = seen + expected @ unseen
        lagged[:, 1:] -= near * covariance[:, : -p - 1 : -1]
        filters, unexplained = ar.levinson(lagged, limit)
        gain = (filters @ cosines) ** 2 + (filters @ sines) ** 2
        spectrum = (lagged[:, 0] * unexplained)[:, None] / gain
        covariance = np.fft.irfft(spectrum, axis=-1)[:, :m]
        folded = rest * covariance
        folded[:, 1:] += share[1:] * covariance[:, :0:-1]
        before = expected
        expected = np.maximum(np.fft.rfft(folded, axis=-1).real, 1e-9 * lagged[:, :1])
        if np.all(np.abs(expected - before) <= 0.01 * before):
            break
    return filters, unexplained, expected, covariance


def _degrees(filters: Array, m: int, noise: NDArray[np.bool_], at: Ints) -> Array:
    """2 over the variance of the logarithm of the spectrum at some of its frequencies."""
    response = np.fft.rfft(filters, m, axis=-1)
    lag = np.arange(1, filters.shape[-1])
    delay = np.exp(-1j * TURN / m * lag[:, None] * np.arange(response.shape[-1]))
    slope = -2.0 * (delay / response[:, None, :]).real
    slope = np.concatenate((np.ones_like(slope[:, :1]), slope), axis=1)
    information = slope[:, :, noise] @ slope[:, :, noise].transpose(0, 2, 1)
    wanted = slope[:, :, at]
    variance = np.sum(wanted * np.linalg.solve(information, wanted), axis=1)
    return np.asarray(2.0 / variance)


def weighted_covariance(weights: Array, gamma: Array) -> Array:
    """Covariances (c, p, p) of p weighted sums (p, m) over noise with autocovariances (c, m)."""
    m = weights.shape[-1]
    even = np.concatenate((gamma, np.zeros((gamma.shape[0], 1)), gamma[:, :0:-1]), axis=-1)
    spectrum = np.fft.rfft(even, axis=-1).real
    seen = np.fft.rfft(weights, 2 * m, axis=-1)
    spectrum[:, 1:-1] *= 2.0
    product = (seen * spectrum[:, None, :]) @ seen.conj().T
    return np.asarray(product.real / (2 * m))
