"""A Fourier basis that several fits share gives each of them what its own would."""

from __future__ import annotations

import itertools
import warnings

import numpy as np
import pytest

from pmmkit.signals import CycleSums, FourierBasis, design_matrix, harmonics, whole_cycles
from pmmkit.signals.autoregression import levinson
from pmmkit.signals.fourier import cycle_edges


@pytest.fixture
def record():
    """Uneven phases over six cycles and two channels, the first with a transient."""
    rng = np.random.default_rng(1)
    theta = 0.3 + np.sort(rng.uniform(0.0, 12 * np.pi, 1200))
    theta[0], theta[-1] = 0.3, 0.3 + 12 * np.pi
    y = np.stack([2.0 + np.cos(theta) + np.exp(-theta), np.sin(3 * theta) - 1.0])
    return theta, y + 0.01 * rng.normal(size=y.shape)


def test_functions_are_those_of_trigonometry():
    theta = np.linspace(-40.0, 40.0, 333)
    basis = FourierBasis.at(theta, 6)
    for n in range(1, 7):
        np.testing.assert_allclose(basis.rows[2 * n - 1], np.cos(n * theta), atol=2e-14)
        np.testing.assert_allclose(basis.rows[2 * n], np.sin(n * theta), atol=2e-14)
    assert FourierBasis.at(theta, 0).rows.tolist() == [[1.0] * 333]


def test_the_projector_is_least_squares_on_any_phases(record):
    theta, y = record
    basis = FourierBasis.at(theta, 7).up_to(5).within(slice(100, 900))
    expected = np.linalg.lstsq(design_matrix(theta[100:900], 5), y[:, 100:900].T, rcond=None)[0]
    np.testing.assert_allclose(basis.projector @ y[:, 100:900].T, expected, atol=1e-12)


def test_a_basis_stands_for_its_phases(record):
    theta, y = record
    basis, t = FourierBasis.at(theta, 6), np.arange(len(theta)) * 0.1
    alone, shared = harmonics(theta, y), harmonics(basis, y)
    np.testing.assert_allclose(shared.coefficients, alone.coefficients, atol=1e-13)
    np.testing.assert_allclose(shared.covariance, alone.covariance, rtol=1e-9)
    assert whole_cycles(t, basis, y) == whole_cycles(t, theta, y)


@pytest.mark.parametrize("lead", [0.0, 0.7, -3.1])
def test_a_basis_ahead_is_that_of_the_later_phases(record, lead):
    theta, _ = record
    ahead, expected = FourierBasis.at(theta, 6).ahead(lead), FourierBasis.at(theta + lead, 6)
    np.testing.assert_array_equal(ahead.phase, expected.phase)
    np.testing.assert_allclose(ahead.rows, expected.rows, atol=1e-13)
    assert FourierBasis.at(theta, 0).ahead(lead).rows.tolist() == [[1.0] * len(theta)]


def test_sums_that_are_there_stand_for_the_cycles(record):
    """Sums of more harmonics over all cycles, for what fewer harmonics need of some of them."""
    theta, y = record
    basis, t = FourierBasis.at(theta, 6), np.arange(len(theta)) * 0.1
    sums = CycleSums.of(y, basis.rows, cycle_edges(theta, 6))
    kept = whole_cycles(t, basis, y)
    assert kept.first > 0
    assert whole_cycles(t, basis, y, sums=sums) == kept
    own = sums.within(kept.first, kept.first + kept.count)
    part = slice(kept.start, kept.stop)
    single = [
        np.linalg.lstsq(design_matrix(theta[i:j], 5), y[:, i:j].T, rcond=None)[0].T
        for i, j in itertools.pairwise(own.edges)
    ]
    found = harmonics(theta[part], y[:, part], sums=own).scatter
    np.testing.assert_allclose(found, np.std(single, axis=0, ddof=1), rtol=1e-9)


def test_sums_over_cycles_fit_one_cycle_or_several(record):
    theta, y = record
    edges = cycle_edges(theta, 6)
    sums = CycleSums.of(y, FourierBasis.at(theta, 3).rows, edges)
    for first, last in ((0, 6), (2, 5), (4, 5)):
        part = slice(edges[first], edges[last])
        fitted = np.linalg.lstsq(design_matrix(theta[part], 3), y[:, part].T, rcond=None)[0].T
        np.testing.assert_allclose(sums.together(first, last), fitted, atol=1e-12)
    np.testing.assert_allclose(sums.single[4], sums.together(4, 5), atol=1e-13)


def test_autoregressions_have_the_autocovariances_they_are_made_from():
    """AR(2) x_t = 0.6 x_{t-1} - 0.3 x_{t-2} + e: rho_1 = 0.6/1.3 (Yule and Walker)."""
    first = 0.6 / 1.3
    gamma = 4.0 * np.array([[1.0, first, 0.6 * first - 0.3]])
    filters, unexplained = levinson(gamma, 1.0)
    np.testing.assert_allclose(filters, [[1.0, -0.6, 0.3]])
    np.testing.assert_allclose(unexplained, 1.0 - 0.6 * first + 0.3 * (0.6 * first - 0.3))


def test_a_record_of_zeros_has_no_memory():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        filters, unexplained = levinson(np.zeros((1, 4)), 0.99)
    assert filters.tolist() == [[1.0, 0.0, 0.0, 0.0]]
    assert unexplained.tolist() == [1.0]
