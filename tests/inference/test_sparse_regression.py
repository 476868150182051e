"""Least squares on triangles of equations, and terms chosen in bags of runs."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit.identification.sparse.collinear import Collinearity
from pmmkit.inference import EffectiveSample, Equations, Resampling, Selection, SparseProblem
from pmmkit.inference.sparse import Elimination

WIDE = np.array([1e-8, 1.0, 1e8, 1e3])
"""Units of columns that differ as those of a moment and of a fifth power do, and more."""


def library(rows=200, seed=0):
    v = np.random.default_rng(seed).uniform(-1, 1, rows)
    return np.stack([v, v**3, v * np.abs(v), np.ones(rows)], axis=1)


def inverse_of_products(X):
    """(X'X)⁻¹ in rational numbers."""
    rows = [[Fraction(float(x)) for x in row] for row in X]
    p = X.shape[1]
    whole = [
        [sum(row[i] * row[j] for row in rows) for j in range(p)]
        + [Fraction(int(i == j)) for j in range(p)]
        for i in range(p)
    ]
    for i in range(p):
        whole[i] = [x / whole[i][i] for x in whole[i]]
        for k in set(range(p)) - {i}:
            whole[k] = [x - whole[k][i] * y for x, y in zip(whole[k], whole[i], strict=True)]
    return np.array([[float(x) for x in row[p:]] for row in whole])


def test_the_covariance_is_the_inverse_of_the_products_whatever_the_units():
    X = np.column_stack([library(60), library(60)[:, 0]])
    X[:, 4] += 1e-5 * np.random.default_rng(1).normal(size=60)
    for units in (np.ones(5), np.append(WIDE, 1e-4)):
        run = Equations.of((X * units, X[:, 0]))
        np.testing.assert_allclose(
            run.covariance(np.ones(5, bool), np.ones(1)), inverse_of_products(X * units), rtol=1e-9
        )


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-12, 12), min_size=4, max_size=4), st.integers(0, 3))
def test_what_rows_determine_does_not_hang_on_units(powers, twin):
    """A column and its double are not determined, the others are, in any units."""
    X = np.column_stack([library(), 2.0 * library()[:, twin]])
    units = 10.0 ** np.array([*powers, powers[0]])
    run = Equations.of((X * units, X[:, 0]))
    lost = np.isnan(np.diagonal(run.covariance(np.ones(5, bool), np.ones(1))))
    assert np.flatnonzero(lost).tolist() == [twin, 4]
    assert np.flatnonzero(run.dependent()).tolist() == [twin, 4]
    assert np.flatnonzero(~run.determined(run.rms())).tolist() == [twin, 4]


def test_triangles_hold_all_that_least_squares_need():
    rng = np.random.default_rng(0)
    runs = [(rng.normal(size=(n, 4)), rng.normal(size=n)) for n in (1, 3, 40, 7)]
    whole = Equations.joined([Equations.of(run) for run in runs])
    A, b = (np.concatenate([run[i] for run in runs]) for i in (0, 1))
    expected = np.linalg.lstsq(A, b, rcond=None)[0]
    np.testing.assert_allclose(whole.least_squares(np.ones(4, bool)), expected, rtol=1e-12)
    assert whole.squares(expected) == pytest.approx([np.sum((A @ expected - b) ** 2)])
    assert whole.rows.tolist() == [51]
    np.testing.assert_allclose(whole.rms(), np.sqrt(np.mean(A**2, axis=0)))


def test_variance_inflation_is_that_of_its_definition():
    """1 over the share of a column that a regression on the others leaves (Belsley 1980)."""
    X = library() * WIDE
    found = Collinearity.of(Equations.of((X, X[:, 0])), "abcd", ["Y"])
    for place, name in enumerate("abcd"):
        others = np.delete(X / np.linalg.norm(X, axis=0), place, axis=1)
        own = X[:, place] / np.linalg.norm(X[:, place])
        left = own - others @ np.linalg.lstsq(others, own, rcond=None)[0]
        assert found.inflation[name] == pytest.approx(1.0 / (left @ left), rel=1e-9)
    assert found.condition["Y"] == pytest.approx(np.linalg.cond(X / np.linalg.norm(X, axis=0)))


def made(rng, runs=6, terms=8):
    truth = rng.normal(size=terms) * (rng.random(terms) > 0.4)
    found = []
    for _ in range(runs):
        X = rng.normal(size=(30, terms)) * np.geomspace(0.1, 10, terms)
        y = X @ (truth / np.geomspace(0.1, 10, terms)) + 0.3 * rng.normal(size=30)
        found.append((X, y))
    return found


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("threshold", [0.05, 0.3, 1.0])
def test_thresholds_are_those_of_pysindy_where_terms_stand_alone(seed, threshold):
    """Sequentially thresholded least squares of pysindy on columns of unit rms, bag by bag."""
    from pysindy.optimizers import STLSQ

    parts = made(np.random.default_rng(seed))
    runs = [Equations.of(part) for part in parts]
    resampling = Resampling.of(len(runs), 10, np.random.default_rng(seed))
    problem = SparseProblem.single("Y", 8, "stlsq")
    assert problem.plain
    found = Selection.of(problem, runs, resampling, threshold=threshold)
    grouped = SparseProblem(
        channels=("Y",),
        columns=tuple(range(8)),
        groups=(*((place,) for place in range(8)), ()),
        always=(False,) * 9,
        method="stlsq",
    )
    assert not grouped.plain
    ours = Selection.of(grouped, runs, resampling, threshold=threshold)
    np.testing.assert_allclose(ours.coefficients, found.coefficients, rtol=1e-10)
    for bag, drawn in enumerate(resampling.draws):
        X, y = (np.concatenate([parts[run][i] for run in drawn]) for i in (0, 1))
        scale = np.sqrt(np.mean(X**2, axis=0))
        theirs = STLSQ(threshold=threshold, alpha=0.0, unbias=False).fit(X / scale, y[:, None])
        stays = theirs.coef_[0] != 0
        np.testing.assert_array_equal(found.coefficients[bag] != 0, stays)
        if stays.any():
            expected = np.linalg.lstsq(X[:, stays], y, rcond=None)[0]
            np.testing.assert_allclose(found.coefficients[bag, stays], expected, rtol=1e-9)


@pytest.mark.parametrize("units", [np.ones(5), np.append(WIDE, 1e-4)])
def test_elimination_finds_the_set_that_an_exhaustive_search_finds(units):
    rng = np.random.default_rng(8)
    v = rng.uniform(-1, 1, 300)
    X = np.stack([v, v**3, v * np.abs(v), v**5, np.ones(300)], axis=1)
    y = 30 * v + 25 * v * np.abs(v) + rng.normal(size=300)
    chosen = np.flatnonzero(Elimination(300).fit(X * units, y[:, None]).coef_[0])

    def score(columns):
        left = y - X[:, columns] @ np.linalg.lstsq(X[:, columns], y, rcond=None)[0]
        return left @ left + len(columns) * math.log(300)

    every = [[i for i in range(5) if bits >> i & 1] for bits in range(1, 32)]
    assert chosen.tolist() == min(every, key=score)


def test_rows_that_share_errors_are_worth_what_kish_says():
    """Runs of m rows with an offset of size τ: n = N / (1 + (m - 1) ρ), ρ = τ² / (1 + τ²)."""
    rng = np.random.default_rng(0)
    m, count, tau = 20, 300, 0.5
    runs = [
        Equations.of((np.ones((m, 1)), 3.0 + tau * rng.normal() + rng.normal(size=m)))
        for _ in range(count)
    ]
    sample = EffectiveSample.of(runs)
    effect = 1 + (m - 1) * tau**2 / (1 + tau**2)
    assert sample.size == pytest.approx(m * count / effect, rel=0.2)
    assert sample.variance == pytest.approx([effect * (1 + tau**2)], rel=0.2)
    white = EffectiveSample.of([Equations.of((x, x @ [2.0] + y)) for x, y in pairs_of(rng, m)])
    assert white.size == pytest.approx(m * 300, rel=0.2)
    assert white.variance == pytest.approx([1.0], rel=0.2)


def pairs_of(rng, m):
    return [(rng.normal(size=(m, 1)), rng.normal(size=m)) for _ in range(300)]


def test_a_covariance_is_that_of_the_regression_where_bags_are_of_one_mind():
    """Two channels with variances of their own: the sandwich, by numpy."""
    rng = np.random.default_rng(3)
    parts = [[(rng.normal(size=(n, 2)), rng.normal(size=n)) for n in (30, 20)] for _ in range(5)]
    runs = [Equations.of(*part) for part in parts]
    variance = np.array([2.0, 0.5])
    both = Selection(
        coefficients=np.ones((10, 2)), shares=np.ones(2), stays=np.ones(2, bool)
    ).covariance(runs, EffectiveSample(size=100, variance=variance))
    X = [np.concatenate([part[channel][0] for part in parts]) for channel in range(2)]
    inverse = np.linalg.inv(sum(x.T @ x for x in X))
    middle = sum(size * x.T @ x for x, size in zip(X, variance, strict=True))
    np.testing.assert_allclose(both, inverse @ middle @ inverse, rtol=1e-10)


def test_what_a_choice_costs_is_weighted_by_the_bic():
    """Two sets by hand: with both terms, and with the first alone."""
    rng = np.random.default_rng(4)
    X = rng.normal(size=(50, 2))
    X[:, 1] += 2 * X[:, 0]
    y = X @ [1.0, 0.15] + rng.normal(size=50)
    coefficients = np.array([[1.0, 1.0], [1.0, 1.0], [1.0, 0.0]])
    found = Selection(
        coefficients=coefficients, shares=np.array([1.0, 2 / 3]), stays=np.ones(2, bool)
    ).covariance_of_choice([Equations.of((X, y))], EffectiveSample(size=50, variance=np.ones(1)))
    whole = np.linalg.lstsq(X, y, rcond=None)[0]
    alone = np.array([X[:, 0] @ y / (X[:, 0] @ X[:, 0]), 0.0])
    bic = [np.sum((y - X @ b) ** 2) + k * math.log(50) for b, k in ((whole, 2), (alone, 1))]
    weight = 1.0 / (1.0 + math.exp((bic[1] - bic[0]) / 2))
    expected = weight * np.outer(alone - whole, alone - whole)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["stepwise", "elimination"])
def test_intervals_hold_the_truth_of_terms_that_have_a_like_one(rule):
    """Runs with v, v|v| and v³, offsets of runs: bags alone were ten times too wide."""
    far = []
    for seed in range(25):
        rng, runs = np.random.default_rng(seed), []
        for size in np.repeat([0.1, 0.2, 0.3, 0.4], 5):
            v = size * np.sin(np.linspace(0, 6 * np.pi, 60))
            X = np.stack([v, v * np.abs(v), v**3], axis=1)
            y = X @ [60.0, 100.0, 0.0] + rng.normal(size=60) + 0.2 * rng.normal()
            runs.append(Equations.of((X, y)))
        found = Selection.of(
            SparseProblem.single("Y", 3, rule), runs, Resampling.of(len(runs), 30, rng)
        )
        std = np.sqrt(np.diagonal(found.covariance(runs, EffectiveSample.of(runs))))
        theta = Equations.joined(runs).least_squares(found.stays)
        far.append(((theta - [60.0, 100.0, 0.0])[found.stays] / std)[0])
    assert np.mean(np.abs(far) < 1.96) >= 0.88
    assert 0.4 < np.sqrt(np.mean(np.square(far))) < 1.4
