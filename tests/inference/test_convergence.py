"""R-hat and effective sample sizes, beside the figures that ArviZ gives for the same chains."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.identification.posterior.ensembles import convergence, ess_bulk, ess_tail, r_hat


def chains():
    """Four of 400 steps: x_i = 0.7 x_{i-1} + noise."""
    noise = np.random.default_rng(3).standard_normal((4, 400))
    found = np.zeros((4, 400))
    for i in range(1, 400):
        found[:, i] = 0.7 * found[:, i - 1] + noise[:, i]
    return found


APART = 0.5 * np.arange(4)[:, None]
WIDE = np.array([1.0, 1.0, 1.0, 3.0])[:, None]


@pytest.mark.parametrize(
    ("change", "r", "bulk", "tail"),
    [  # arviz-stats 0.8.0: rhat(method="rank"), ess(method="bulk"), ess(method="tail")
        (lambda x: x, 1.0061258971914406, 304.7516722220983, 592.450278001127),
        (lambda x: x + APART, 1.1054175739403191, 28.462562865273615, 390.6935534450781),
        (lambda x: x * WIDE, 1.1431087427711033, 287.1579204586548, 37.12114781074756),
    ],
)
def test_as_arviz_has_it(change, r, bulk, tail):
    """Where chains do not agree ArviZ ends Geyer's sequence a pair earlier: 2 % in the sizes."""
    draws = change(chains())
    assert r_hat(draws) == pytest.approx(r, rel=1e-12)
    assert ess_bulk(draws) == pytest.approx(bulk, rel=0.02)
    assert ess_tail(draws) == pytest.approx(tail, rel=0.02)


def test_only_the_order_of_the_draws_counts():
    draws = chains()
    for same in (np.exp(2.0 * draws), draws**3, 5.0 - draws):
        assert r_hat(same) == pytest.approx(r_hat(draws), rel=1e-12)
        assert ess_bulk(same) == pytest.approx(ess_bulk(draws), rel=1e-12)


def test_white_draws_count_in_full_with_walkers_or_without():
    draws = np.random.default_rng(0).normal(size=(4, 50, 20))
    assert ess_bulk(draws) == pytest.approx(draws.size, rel=0.1)
    assert ess_tail(draws) == pytest.approx(draws.size, rel=0.1)
    assert r_hat(draws) < 1.002


def test_a_chain_that_drifts_disagrees_with_itself():
    draws = np.random.default_rng(0).normal(size=(4, 200))
    assert r_hat(draws) < 1.01 < 1.3 < r_hat(draws + 2.0 * np.linspace(-1, 1, 200))


def test_what_never_moves_says_nothing():
    found = convergence(np.ones((4, 20, 6, 1)), ("Yv",))
    assert np.isnan(found.r_hat[0])
    assert not found.reached


def test_the_worst_is_named():
    draws = np.stack([chains(), chains() + APART], axis=-1)[:, :, None]
    found = convergence(draws, ("Yv", "Nr"))
    assert not found.reached
    assert found.words() == ("R-hat at most 1.105 (Nr), effective sample size at least 28 (Nr)")
