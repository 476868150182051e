"""Filters and smoother of a linear system against the normal vector of a whole record."""

from __future__ import annotations

import math
from importlib.util import module_from_spec, spec_from_file_location

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import multivariate_normal, norm

from pmmkit.identification.passes import room
from pmmkit.inference import InformationRoot, Innovations, estimators

GIVEN = np.array(
    [[0.0, 1.0, 0.0, 0.0], [-1.69, -0.39, 0.0, 0.0], [0.0, 0.2, -0.4, 0.2], [0.1, 0.0, -0.3, -0.5]]
)
"""Rates of a damped oscillator of 1.3 rad/s and of two states that it moves."""
PUSH = np.array([0.0, 1.0, 0.0, 0.3])
"""Rates of the states over a value."""
DIFFUSION = np.array([0.0, 0.05, 0.02, 0.03])
SENSORS = ((0, 0.05), (2, 0.03), (3, 0.02))
START, SPREAD = np.array([0.1, 0.0, 1.0, 0.2]), np.array([0.05, 0.1, 0.2, 0.2])
COUNT = 40


def module_of(F, push):
    """The estimators with a linear system in them, as Python runs them."""
    spec = spec_from_file_location("estimators_of_a_linear_system", estimators.__file__)
    made = module_from_spec(spec)
    spec.loader.exec_module(made)
    size, m = push.shape

    def slopes(time):
        ahead = expm(time * np.block([[F, push], [np.zeros((m, size + m))]]))
        return ahead[:size, :size], ahead[:size, size:]

    def transition(system, t, points, changes):
        A, B = slopes(system[t] - system[t - 1])
        points[:, :size] = points[:, :size] @ A.T + (changes + 0.3) @ B.T
        return 0

    def linearised(system, t, z, change, y, A, B):
        A[:], B[:] = slopes(system[t] - system[t - 1])
        y[:] = A @ z[:size] + B @ (change + 0.3)
        return 0

    def sensed(system, kind, z, h):
        h[:] = 0.0
        h[kind] = 1.0
        return z[kind]

    made.NS, made.transition, made.linearised, made.sensed = size, transition, linearised, sensed
    made.at_instant = lambda system, t, change: None
    made.innovation = lambda difference, kind: difference
    return made


def exact(F, D, step):
    """Transition and noise of an interval (Van Loan 1978, theorem 1)."""
    n = len(F)
    whole = expm(step * np.block([[-F, np.diag(D)], [np.zeros((n, n)), F.T]]))
    return whole[n:, n:].T, whole[n:, n:].T @ whole[:n, n:]


class Whole:
    """A record as one normal vector of all states at all instants."""

    def __init__(self, A, Q, mean, P, count=COUNT):
        n = len(mean)
        means, covariances = [mean], [P]
        for _ in range(count - 1):
            means.append(A @ means[-1])
            covariances.append(A @ covariances[-1] @ A.T + Q)
        whole = np.zeros((count, n, count, n))
        for i, covariance in enumerate(covariances):
            for j in range(i, count):
                whole[j, :, i] = np.linalg.matrix_power(A, j - i) @ covariance
                whole[i, :, j] = whole[j, :, i].T
        self.size, self.mean = n, np.concatenate(means)
        self.covariance = whole.reshape(count * n, count * n)

    def drawn(self, seed):
        """Measurements with a gap in all channels and one in one."""
        draw = np.random.default_rng(seed)
        states = draw.multivariate_normal(self.mean, self.covariance, method="eigh")
        noise = draw.normal(size=(COUNT, len(SENSORS))) * [std for _, std in SENSORS]
        measured = states.reshape(COUNT, self.size)[:, [place for place, _ in SENSORS]] + noise
        measured[10:18] = np.nan
        measured[25:30, 1] = np.nan
        return measured

    def given(self, measured):
        """Means, standard deviations, ln of the density, and standardised innovations."""
        H = np.kron(np.eye(COUNT), np.eye(self.size)[[place for place, _ in SENSORS]])
        there = np.isfinite(measured.ravel())
        H, R = H[there], np.tile([std**2 for _, std in SENSORS], COUNT)[there]
        S = H @ self.covariance @ H.T + np.diag(R)
        left = measured.ravel()[there] - H @ self.mean
        gain = np.linalg.solve(S, H @ self.covariance).T
        covariance = self.covariance - gain @ H @ self.covariance
        return (
            (self.mean + gain @ left).reshape(COUNT, -1),
            np.sqrt(np.diagonal(covariance)).reshape(COUNT, -1),
            multivariate_normal(cov=S).logpdf(left),
            np.linalg.solve(np.linalg.cholesky(S), left),
        )


def passed(functions, step, measured, z, P, noise, *, method="extended", **settings):
    """A filter over a record, and the smoother after the extended one."""
    n, m = len(z), len(z) - functions.NS
    times, z, P = step * np.arange(COUNT), z.copy(), P.copy()
    means, residuals = np.empty((COUNT, 2 * n)), np.empty(measured.shape)
    spreads, about = np.empty(measured.shape), settings.get("about", np.zeros(m))
    kinds = np.array([place for place, _ in SENSORS])
    variances = np.array([std**2 for _, std in SENSORS])
    begin = (times, times, measured, kinds, variances, about)
    gate = settings.get("gate", math.inf)
    rest = (z, P, settings.get("fading", np.zeros(m)), noise, gate, means, residuals, spreads)
    smooth = None
    if method == "extended":
        kept = np.zeros((COUNT, room(functions.NS, m)))
        frozen = settings.get("frozen", np.zeros(m))
        assert functions.extended(*begin, frozen, *rest, kept) == 0
        smooth = np.empty((COUNT, n)), np.empty((COUNT, n, n))
        functions.smoothed(kept, n, *smooth)
    else:
        assert functions.unscented(*begin, *rest) == 0
    told = Innovations(names=("a", "b", "c"), residuals=residuals, variances=spreads, gate=gate)
    return z, P, told, smooth


@pytest.mark.parametrize("method", ["extended", "unscented"])
@pytest.mark.parametrize(("step", "near"), [(0.02, 1e-6), (0.1, 1e-6), (0.3, 1e-5)])
def test_filters_are_the_normal_vector_of_all_measurements(method, step, near):
    """The widest step is .4 of a radian of the oscillator."""
    whole = Whole(*exact(GIVEN, DIFFUSION, step), START, np.diag(SPREAD**2))
    measured = whole.drawn(0)
    mean, std, density, innovations = whole.given(measured)
    functions = module_of(GIVEN, np.zeros((4, 0)))
    z, P, told, smooth = passed(
        functions, step, measured, START, np.diag(SPREAD**2), DIFFUSION, method=method
    )
    np.testing.assert_allclose(z, mean[-1], atol=near * np.min(std[-1]))
    np.testing.assert_allclose(np.sqrt(np.diagonal(P)), std[-1], rtol=near)
    assert told.log_likelihood() == pytest.approx(density, abs=20 * near)
    own = told.normalised[np.isfinite(told.normalised)]
    np.testing.assert_allclose(own, innovations, atol=2 * near)
    if smooth is not None:
        assert np.max(np.abs(smooth[0] - mean) / std) < near
        np.testing.assert_allclose(np.sqrt(np.einsum("tii->ti", smooth[1])), std, rtol=near)


def with_value(fading, size, step):
    """States and one value that wanders, as one linear system."""
    F = np.zeros((5, 5))
    F[:4, :4], F[:4, 4], F[4, 4] = GIVEN, PUSH, -fading
    growth = 2.0 * fading * size**2 if fading else 0.01
    noise = np.append(DIFFUSION, growth)
    P = np.diag(np.append(SPREAD, size) ** 2)
    return Whole(*exact(F, noise, step), np.append(START, 0.0), P), noise, P


@pytest.mark.parametrize("method", ["extended", "unscented"])
@pytest.mark.parametrize("fading", [0.0, 0.5])
@pytest.mark.parametrize(("step", "near"), [(0.02, 2e-4), (0.1, 3e-3), (0.3, 0.04)])
def test_a_value_that_wanders_does_so_through_the_interval(fading, method, step, near):
    """The truth has the value for a state. Held from instant to instant the value comes half an
    interval late, and its mean is off by .7 of its standard deviation at the widest step."""
    whole, noise, P = with_value(fading, 0.4, step)
    measured = whole.drawn(1)
    mean, std, density, _ = whole.given(measured)
    functions, about = module_of(GIVEN, PUSH[:, None]), np.full(1, 0.3)
    z, end, told, smooth = passed(
        functions,
        step,
        measured,
        np.append(START, 0.0),
        P,
        noise,
        method=method,
        fading=np.full(1, fading),
        about=about,
    )
    assert np.max(np.abs(z - mean[-1]) / std[-1]) < near
    np.testing.assert_allclose(np.sqrt(np.diagonal(end)), std[-1], rtol=near)
    assert told.log_likelihood() == pytest.approx(density, abs=10 * near)
    if smooth is not None:
        assert np.max(np.abs(smooth[0] - mean) / std) < near
        np.testing.assert_allclose(np.sqrt(np.einsum("tii->ti", smooth[1])), std, rtol=near)


def test_a_frozen_value_is_estimated_as_well_as_a_free_one():
    """In a linear system it does not matter about which point a constant is linearised."""
    F, noise = np.zeros((5, 5)), np.append(DIFFUSION, 0.0)
    F[:4, :4], F[:4, 4] = GIVEN, PUSH
    P, step = np.diag(np.append(SPREAD, 0.4) ** 2), 0.02
    whole = Whole(*exact(F, noise, step), np.append(START, 0.0), P)
    measured = whole.drawn(2)
    mean, std, _, _ = whole.given(measured)
    functions = module_of(GIVEN, PUSH[:, None])
    settings = {"about": np.full(1, 0.3), "frozen": np.ones(1)}
    _, _, _, (means, covariances) = passed(
        functions, step, measured, np.append(START, 0.0), P, noise, **settings
    )
    assert np.max(np.abs(means - mean) / std) < 1e-4
    np.testing.assert_allclose(np.sqrt(np.einsum("tii->ti", covariances)), std, rtol=1e-4)


def test_what_lies_beyond_the_gate_moves_nothing():
    whole = Whole(*exact(GIVEN, DIFFUSION, 0.1), START, np.diag(SPREAD**2))
    measured = whole.drawn(3)
    measured[30, 0] = np.nan
    functions, begin = module_of(GIVEN, np.zeros((4, 0))), (START, np.diag(SPREAD**2), DIFFUSION)
    clean = passed(functions, 0.1, measured, *begin, gate=5.0)
    measured[30, 0] = 30.0
    wild = passed(functions, 0.1, measured, *begin, gate=5.0)
    np.testing.assert_array_equal(wild[0], clean[0])
    np.testing.assert_array_equal(wild[1], clean[1])
    assert np.argwhere(wild[2].gated).tolist() == [[30, 0]]


@pytest.mark.parametrize("away", [4.999, 5.001, 8.0, 200.0])
def test_the_likelihood_has_no_step_at_the_gate(away):
    """A residual at the gate is worth as much on either side of it, whatever lies further out."""
    draw = np.random.default_rng(0)
    residuals, std = draw.normal(size=(50, 2)), np.array([0.5, 2.0])
    residuals[7, 1], residuals[20, 0], residuals[3, 0] = away, 30.0, np.nan
    item = Innovations(
        names=("a", "b"), residuals=residuals * std, variances=np.tile(std**2, (50, 1)), gate=5.0
    )
    inside = np.clip(residuals, -5.0, 5.0)
    right = np.nansum(norm.logpdf(inside * std, scale=std))
    assert item.log_likelihood() == pytest.approx(right, rel=1e-12)
    assert item.gated.sum() == 1 + (away > 5.0)


# The square-root information filter


def test_blocks_with_noise_of_their_own_are_the_normal_vector_of_all_rows():
    """Innovations are those of Cholesky's factor of the whole covariance, sample by sample."""
    draw = np.random.default_rng(4)
    std, truth = np.array([3.0, 0.1, 1e3]), np.array([1.0, -0.05, 300.0])
    apart = np.abs(np.subtract.outer(np.arange(30), np.arange(30)))
    noise = 0.04 * 0.8**apart + 1e-4 * np.eye(30)
    white = np.linalg.inv(np.linalg.cholesky(noise))
    blocks = [draw.normal(size=(30, 3)) * [1.0, 10.0, 1e-3] for _ in range(4)]
    rows = [x @ truth + draw.multivariate_normal(np.zeros(30), noise) for x in blocks]
    known, innovations = InformationRoot.of(0.1 * std, std), []
    for x, y in zip(blocks, rows, strict=True):
        innovations.append(known.innovations(white @ x, white @ y)[0])
        known = known.with_rows(white @ x, white @ y)
    X, P = np.concatenate(blocks), np.diag(std**2)
    S = X @ P @ X.T + np.kron(np.eye(4), noise)
    left = np.concatenate(rows) - X @ (0.1 * std)
    np.testing.assert_allclose(
        np.concatenate(innovations), np.linalg.solve(np.linalg.cholesky(S), left), atol=1e-9
    )
    np.testing.assert_allclose(known.mean, 0.1 * std + P @ X.T @ np.linalg.solve(S, left))
    right = np.linalg.inv(np.linalg.inv(P) + sum((white @ x).T @ (white @ x) for x in blocks))
    np.testing.assert_allclose(known.covariance, right, rtol=1e-9)
    np.testing.assert_allclose(known.spread(X), np.einsum("ij,jk,ik->i", X, right, X), rtol=1e-9)


def test_columns_that_are_nearly_one_cost_no_digits():
    """Two columns apart by 1e-9 of their length: the normal equations see one."""
    draw = np.random.default_rng(5)
    one, other = draw.normal(size=(2, 20))
    design, truth = np.stack([one, one + 1e-9 * other], axis=1), np.array([2.0, -1.0])
    vague = InformationRoot.of(np.zeros(2), np.full(2, 1e15))
    found = vague.with_rows(design, design @ truth)
    np.testing.assert_allclose(found.mean, truth, atol=1e-5)
