"""Noise of like runs: a cycle is as noisy as another, whatever was kept of the record."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.observations.noise import BELIEVED, moderated


def test_a_mean_over_half_the_cycles_is_noisier_by_two():
    """One level for all: variances go with the inverse of the length."""
    lengths = [4.0, 4.0, 2.0, 4.0, 2.0]
    rng = np.random.default_rng(5)
    found, _ = moderated(
        [np.eye(3) / n * rng.chisquare(40) / 40 for n in lengths], [40.0] * 5, 1.0, lengths
    )
    level = np.array([c[0, 0] for c in found]) * lengths
    assert level == pytest.approx(level.mean(), rel=1e-6)


def test_a_record_far_quieter_than_its_sisters_is_not_believed():
    noise = [np.eye(2)] * 6 + [0.1 * np.eye(2)]
    found, _ = moderated(noise, [200.0] * 7, 10.0, [3.0] * 7)
    assert found[-1][0, 0] == pytest.approx(BELIEVED**2, rel=0.1)
    loud, _ = moderated([np.eye(2)] * 6 + [100.0 * np.eye(2)], [200.0] * 7, 10.0, [3.0] * 7)
    assert loud[-1][0, 0] > 50.0
    assert loud[0][0, 0] < 1.5
