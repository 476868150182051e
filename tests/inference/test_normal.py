"""Linear Gaussian evidence against densities written out, and blocks left out against new fits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from pmmkit.diagnosis.evidence import integrated_out
from pmmkit.inference import LeastSquares, Normal, dependent, log_normal, of_others

ROWS = 30


@pytest.fixture
def measured():
    """Columns of very different sizes, two nearly alike, expected coefficients, data."""
    rng = np.random.default_rng(5)
    columns = rng.normal(size=(ROWS, 5)) * np.array([3.0, 1.0, 0.2, 1e-3, 1.0])
    columns[:, 1] += 0.9 * columns[:, 0]
    centre = np.array([0.3, 0.0, -1.0, 0.5, 0.0])
    return columns, columns @ np.array([0.5, -1.0, 0.3, 0.0, 0.0]) + rng.normal(size=ROWS), centre


def density(columns, data, centre):
    """ln N(d; A c, 1 + A A'), by scipy."""
    whole = np.eye(len(data)) + columns @ columns.T
    return multivariate_normal(columns @ centre, whole).logpdf(data)


def test_the_evidence_is_a_ratio_of_densities(measured):
    columns, data, centre = measured
    known = Normal.of(columns, data, centre)
    none = multivariate_normal(np.zeros(ROWS), np.eye(ROWS)).logpdf(data)
    whole = density(columns, data, centre)
    assert known.log_evidence == pytest.approx(whole - none, rel=1e-11)
    constant = 0.5 * ROWS * np.log(2 * np.pi)
    assert known.log_density == pytest.approx(whole + constant, rel=1e-11)


def test_columns_of_another_size_keep_their_expected_force(measured):
    """A prior three times as wide about the same force: z = c / 3."""
    columns, data, centre = measured
    at, size = np.array([0, 3, 4]), np.array([3.0, 0.5, 2.0])
    none = density(np.zeros((ROWS, 1)), data, np.zeros(1))
    truth = density(columns[:, at] * size, data, centre[at] / size) - none
    assert Normal.of(columns, data, centre).only(at, size).log_evidence == pytest.approx(
        truth, rel=1e-11
    )


def test_evidence_beside_columns_that_are_there_is_what_they_add(measured):
    columns, data, centre = measured
    known = Normal.of(columns, data, centre)
    there, asked = np.array([0, 2]), np.array([1, 3])
    beside = known.given(known.taken(there)).only(asked)
    both = np.concatenate([there, asked])
    added = density(columns[:, both], data, centre[both])
    added -= density(columns[:, there], data, centre[there])
    assert beside.log_evidence == pytest.approx(added, rel=1e-9)
    constant = 0.5 * ROWS * np.log(2 * np.pi)
    whole = density(columns[:, both], data, centre[both])
    assert beside.log_density == pytest.approx(whole + constant, rel=1e-11)


def test_the_posterior_is_ridge_regression(measured):
    """Rows of the prior below those of the data, by numpy's least squares."""
    columns, data, centre = measured
    mean, covariance = Normal.of(columns, data, centre).posterior
    below = np.vstack([columns, np.eye(5)])
    truth = np.linalg.lstsq(below, np.concatenate([data, centre]), rcond=None)[0]
    np.testing.assert_allclose(mean, truth, rtol=1e-10)
    np.testing.assert_allclose(Normal.of(columns, data, centre).mean, truth, rtol=1e-10)
    np.testing.assert_allclose(covariance, np.linalg.inv(below.T @ below), rtol=1e-10)


def test_coefficients_may_have_any_covariance_before(measured):
    columns, data, _ = measured
    root = np.tril(np.random.default_rng(1).normal(size=(5, 5)))
    own = Normal.of(columns, data).in_terms_of(root)
    truth = multivariate_normal(
        np.zeros(ROWS), np.eye(ROWS) + columns @ root @ root.T @ columns.T
    ).logpdf(data)
    assert own.log_density - 0.5 * ROWS * np.log(2 * np.pi) == pytest.approx(truth, rel=1e-11)


def test_data_add_up_and_are_taken_off_again(measured):
    columns, data, centre = measured
    first, second = (
        Normal.of(columns[:20], data[:20], centre),
        Normal.of(columns[20:], data[20:], centre),
    )
    whole = Normal.of(columns, data, centre)
    assert (first + second).log_density == pytest.approx(whole.log_density, rel=1e-12)
    assert (whole - second).log_density == pytest.approx(first.log_density, rel=1e-10)


def test_several_systems_stand_side_by_side(measured):
    columns, data, centre = measured
    several = [Normal.of(columns[k:], data[k:], centre) for k in range(4)]
    stacked = Normal(
        information=np.stack([x.information for x in several]),
        score=np.stack([x.score for x in several]),
        centre=centre,
    )
    np.testing.assert_allclose(stacked.log_evidences, [x.log_evidence for x in several], rtol=1e-12)
    means, covariances = stacked.posterior
    np.testing.assert_allclose(means, [x.posterior[0] for x in several], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(covariances[2], several[2].posterior[1], rtol=1e-9, atol=1e-14)


def test_what_is_integrated_out_widens_the_covariance_of_the_data(measured):
    """Products of the others, whitened by 1 + S S', and its determinant."""
    columns, *_ = measured
    S, rest = columns[:, :2], columns[:, 2:]
    products, volume = integrated_out(S.T @ S, S.T @ rest, rest.T @ rest)
    V = np.eye(ROWS) + S @ S.T
    np.testing.assert_allclose(products, rest.T @ np.linalg.solve(V, rest), rtol=1e-9, atol=1e-12)
    assert float(volume) == pytest.approx(np.linalg.slogdet(V)[1], rel=1e-12)


def test_a_density_of_values_that_differ_by_orders_of_magnitude():
    size = np.array([1e-8, 1.0, 1e7])
    correlation = np.array([[1.0, 0.5, 0.2], [0.5, 1.0, -0.3], [0.2, -0.3, 1.0]])
    z = np.array([0.3, -1.0, 2.0])
    truth = multivariate_normal(np.zeros(3), correlation).logpdf(z) - np.log(size).sum()
    assert log_normal(z * size, correlation * np.outer(size, size)) == pytest.approx(truth)


def test_the_chance_counts_columns_alike_once():
    """Ten copies of one column give no more false alarms than one."""
    one = Normal(information=np.ones((1, 1)) * 9.0, score=np.zeros(1), centre=np.zeros(1))
    ten = Normal(information=np.full((10, 10), 9.0), score=np.zeros(10), centre=np.zeros(10))
    best = 1.5
    alone = one.chance_of(best, [[np.array([0])]], draws=20_000)
    copies = ten.chance_of(best, [[np.array([k])] for k in range(10)], draws=20_000)
    # |b| beyond sqrt(2 (1 + G) (best + ½ ln(1 + G))) of b ~ N(0, G).
    bar = np.sqrt(2 * 10.0 * (best + 0.5 * np.log(10.0)) / 9.0)
    from scipy.stats import norm

    assert alone == pytest.approx(2 * norm.sf(bar), abs=0.004)
    assert copies == pytest.approx(alone, abs=0.004)


@settings(max_examples=30)
@given(rows=st.integers(1, 12), seed=st.integers(0, 10_000))
def test_a_block_left_out_is_predicted_as_by_a_new_fit(rows, seed):
    """Fewer and more rows than columns."""
    rng = np.random.default_rng(seed)
    columns, data = rng.normal(size=(40, 5)), rng.normal(size=40)
    Q = np.linalg.qr(columns)[0]
    residual = data - Q @ (Q.T @ data)
    fitted = np.linalg.lstsq(columns[rows:], data[rows:], rcond=None)[0]
    truth = data[:rows] - columns[:rows] @ fitted
    for inverse, determined in (of_others(Q[:rows]), of_others(Q[:rows] @ Q[:rows].T, hat=True)):
        assert determined
        np.testing.assert_allclose(inverse @ residual[:rows], truth, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("rows", [3, 12])
def test_what_the_others_do_not_determine_is_said(rows):
    """All the rows that any column has."""
    Q = np.linalg.qr(np.random.default_rng(rows).normal(size=(rows, min(rows, 5))))[0]
    inverse, determined = of_others(Q)
    assert not determined
    np.testing.assert_allclose(inverse @ Q, np.zeros_like(Q), atol=1e-9)


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000), copies=st.integers(0, 3))
def test_a_triangle_tells_what_pivoted_least_squares_tells(seed, copies):
    """Combinations of one or two columns put in at any place: all that take part, and no other."""
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(20, 4))
    tied = set()
    for _ in range(copies):
        a, b = rng.choice(4, 2, replace=False)
        columns = np.column_stack([columns, 2.0 * columns[:, a] - columns[:, b]])
        tied |= {int(a), int(b), columns.shape[1] - 1}
    order = rng.permutation(columns.shape[1])
    columns = (columns / np.linalg.norm(columns, axis=0))[:, order]
    truth = np.array([place not in tied for place in order.tolist()])
    np.testing.assert_array_equal(~dependent(np.linalg.qr(columns, mode="r")), truth)
    names = [str(place) for place in range(columns.shape[1])]
    found = LeastSquares.of(names, columns, rng.normal(size=20))
    np.testing.assert_array_equal(found.determined, truth)
