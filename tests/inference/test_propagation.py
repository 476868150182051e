"""Propagation of uncertainty: closed forms of the GUM, Monte Carlo in plain numpy, properties."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pmmkit.inference import COVERAGE, Propagated, Stencil, root, std_along

numbers = st.floats(-3.0, 3.0).map(lambda x: round(x, 3))


def mixed(n, m):
    """A covariance of m inputs from n errors, of sizes ten decades apart, and the errors."""

    @st.composite
    def drawn(draw):
        own = draw(arrays(float, (n, m), elements=numbers)) * 10.0 ** np.linspace(-5, 5, m)
        return own.T @ own, own

    return drawn()


def test_a_product_of_powers_adds_relative_variances_by_the_squares_of_the_powers():
    """JCGM 100:2008, 5.1.6: y = a² b⁻³ c, relative variances 4, 9 and 1 of those of a, b, c."""
    x, relative = np.array([2.0, 3.0, 5.0]), np.array([0.01, 0.002, 0.03])
    y = x[0] ** 2 * x[1] ** -3 * x[2]
    slopes = y * np.array([2.0, -3.0, 1.0]) / x
    found = Propagated.of(slopes[None], np.diag(relative * x) ** 2)
    parts = np.array([4.0, 9.0, 1.0]) * relative**2
    assert found.std[0] == pytest.approx(y * parts.sum() ** 0.5, rel=1e-14)
    np.testing.assert_allclose(found.shares[:, 0], parts / parts.sum(), rtol=1e-13)
    np.testing.assert_allclose(found.alone[:, 0], y * parts**0.5, rtol=1e-13)
    assert found.expanded()[0] == COVERAGE * found.std[0] == 2.0 * found.std[0]
    assert found.expanded(3.0)[0] == 3.0 * found.std[0]


def test_resistors_of_one_standard_add_their_uncertainties():
    """JCGM 100:2008, 5.2.2, example: ten of 1000 Ω, each with 100 mΩ of one standard, give 1 Ω."""
    tied = Propagated(factors=(np.array([[0.1]]),) * 10, causes=("standard",) * 10)
    assert tied.std[0] == pytest.approx(1.0)
    same = Propagated.of(np.ones((1, 10)), np.full((10, 10), 0.01))
    assert same.std[0] == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(same.shares, tied.shares, rtol=1e-12)
    alone = Propagated(factors=(np.array([[0.1]]),) * 10, causes=("",) * 10)
    assert alone.std[0] == pytest.approx(0.1 * 10**0.5)


def test_results_of_shared_inputs_are_correlated_as_the_gum_has_it():
    """JCGM 100:2008, H.2: resistance, reactance and impedance from voltage, current and phase."""
    V, I, phase = 4.9990, 19.6610e-3, 1.04446
    u = np.array([0.0032, 0.0095e-3, 0.00075])
    r = np.array([[1.0, -0.36, 0.86], [-0.36, 1.0, -0.65], [0.86, -0.65, 1.0]])
    R, X, Z = V / I * np.cos(phase), V / I * np.sin(phase), V / I
    J = np.array([[R / V, -R / I, -X], [X / V, -X / I, R], [Z / V, -Z / I, 0.0]])
    found = Propagated.of(J, r * np.outer(u, u))
    np.testing.assert_allclose(found.std, [0.071, 0.295, 0.236], atol=0.0016)
    correlation = found.correlation
    assert correlation[0, 1] == pytest.approx(-0.588, abs=0.006)
    assert correlation[0, 2] == pytest.approx(-0.485, abs=0.006)
    assert correlation[1, 2] == pytest.approx(0.993, abs=0.003)


def test_correlated_inputs_drawn_a_hundred_thousand_times_scatter_as_told():
    rng = np.random.default_rng(3)
    own = rng.normal(size=(4, 4)) * [1.0, 1e-3, 10.0, 1e2]
    C, J = own.T @ own, rng.normal(size=(3, 4)) / [1.0, 1e-3, 10.0, 1e2]
    y = rng.multivariate_normal(np.zeros(4), C, size=100_000) @ J.T
    found = Propagated.of(J, C)
    np.testing.assert_allclose(y.std(axis=0), found.std, rtol=0.01)
    np.testing.assert_allclose(np.corrcoef(y.T), found.correlation, atol=0.01)
    again = (rng.standard_normal((100_000, 4)) @ root(C).T) @ J.T
    np.testing.assert_allclose(again.std(axis=0), found.std, rtol=0.01)


@settings(max_examples=60)
@given(mixed(4, 4), arrays(float, (2, 4), elements=numbers))
def test_all_ways_to_a_variance_are_one(drawn, slopes):
    C, errors = drawn
    J = slopes * 10.0 ** -np.linspace(-5, 5, 4)
    found = Propagated.of(J, C)
    direct = J @ C @ J.T
    size = np.abs(errors @ J.T).sum() ** 2 + 1e-12
    np.testing.assert_allclose(found.covariance, direct, atol=1e-6 * size)
    np.testing.assert_allclose(found.std**2, np.diagonal(found.covariance), atol=1e-12 * size)
    np.testing.assert_allclose(found.variances.sum(axis=0), found.std**2, atol=1e-9 * size)
    np.testing.assert_allclose(found.variances, J.T * (C @ J.T), atol=1e-6 * size)
    np.testing.assert_allclose(std_along(J, C) ** 2, np.diagonal(direct), atol=1e-9 * size)
    np.testing.assert_allclose(
        Propagated(factors=(errors,), causes=("",)).carried(J).covariance, direct, atol=1e-9 * size
    )


@settings(max_examples=60)
@given(mixed(2, 4))
def test_a_root_and_the_axes_give_the_covariance_back_whatever_the_scales_and_the_rank(drawn):
    C, _ = drawn
    scale = np.sqrt(np.diagonal(C))
    S, rows = root(C), root(C, thin=True).T
    np.testing.assert_allclose(S @ S.T, C, atol=1e-12 * np.outer(scale, scale).max(initial=1e-30))
    unit = np.where(scale > 0, scale, 1.0)
    for made in (S @ S.T, rows.T @ rows):
        np.testing.assert_allclose((made - C) / np.outer(unit, unit), 0.0, atol=1e-12)
    assert len(rows) <= 2


def test_a_root_has_no_choice_of_signs_and_independent_inputs_keep_their_own_errors():
    C = np.array([[4.0, 1.2, 0.0], [1.2, 1.0, 0.0], [0.0, 0.0, 0.0]])
    flip = np.diag([1.0, -1.0, 1.0])
    np.testing.assert_allclose(root(flip @ C @ flip), flip @ root(C) @ flip, atol=1e-15)
    np.testing.assert_allclose(root(np.diag([9.0, 1e-20])), np.diag([3.0, 1e-10]), rtol=1e-12)


def test_differences_of_fourth_order_are_exact_for_a_quartic_and_of_second_for_a_parabola():
    at, steps = np.array([0.7, -0.4]), np.array([[0.3, 0.0], [0.2, -0.5]])
    x, y = Stencil(4).points(at, steps).T
    slope = np.array([4 * 0.7**3 * -0.4, 0.7**4])
    np.testing.assert_allclose(Stencil(4).differences(x**4 * y)[0], steps[0] @ slope, rtol=1e-12)
    x, y = Stencil().points(at, steps).T
    np.testing.assert_allclose(
        Stencil().differences(np.column_stack([x * y + x**2, 3 * y])),
        steps @ np.array([[-0.4 + 1.4, 0.0], [0.7, 3.0]]),
        rtol=1e-12,
    )
