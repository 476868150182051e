"""Noise of like runs: a second is as noisy as another, whatever was kept of the record."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmmkit.reduction.observations.noise import degrees, moderated, shrunk_levels


def test_a_mean_over_half_the_time_is_noisier_by_two():
    """One level for all: variances go with the inverse of the duration."""
    durations = [40.0, 40.0, 20.0, 40.0, 20.0]
    rng = np.random.default_rng(5)
    found = moderated(
        [np.eye(3) / T * rng.chisquare(40) / 40 for T in durations], [40.0] * 5, 1.0, durations
    )
    level = np.array([c[0, 0] for c in found.covariances]) * durations
    assert level == pytest.approx(level.mean(), rel=1e-6)


def test_a_duration_that_is_not_known_is_as_the_others():
    noise = [np.eye(2)] * 4
    known = moderated(noise, [20.0] * 4, 1.0, [10.0] * 4)
    part = moderated(noise, [20.0] * 4, 1.0, [10.0, math.nan, 10.0, 10.0])
    assert np.array_equal(known.covariances, part.covariances)


def test_noise_of_other_frequencies_keeps_its_spectrum():
    """Strangers share the level, not how it is distributed over the harmonics."""
    steep, flat = np.diag([9.0, 1.0]), np.diag([5.0, 5.0])
    found = moderated([steep, flat, flat], [30.0] * 3, 1.0, [1.0] * 3, spectrum=False)
    assert found.covariances[0][0, 0] / found.covariances[0][1, 1] == pytest.approx(9.0)


def test_doubt_of_the_levels_is_that_of_many_draws():
    """Scatter of the common level and of what each run keeps, against 4000 draws."""
    rng = np.random.default_rng(2)
    dof = np.array([12.0, 30.0, 20.0, 60.0])
    truth = np.array([1.0, 1.0, 1.0, 1.0])
    draws, variances = [], []
    for _ in range(4000):
        levels, own, doubt = shrunk_levels(truth * rng.chisquare(dof) / dof, dof)
        if own.max() == 0:
            draws.append(np.log(levels))
            variances.append(doubt @ doubt.T)
    covariance = np.cov(np.array(draws).T)
    assert np.mean(variances, axis=0) == pytest.approx(covariance, rel=0.1)
    assert degrees(np.diagonal(variances[0])) == pytest.approx(dof.sum())
