"""Process noise of the filters: its covariance over an interval, and what it makes probable."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import multivariate_normal
from test_filters import BY_WATER, SPEED

from pmmkit.equations import InputField, prepare
from pmmkit.identification import Binding
from pmmkit.identification.filters import process
from pmmkit.identification.passes import Process, RecordView, passed, state_steps
from pmmkit.models import load_model

STATES = ("x", "y", "psi", "u", "v", "r")
EVEN = load_model("kvlcc2-l7").with_values("rudder_mmg", gamma_positive=0.5, gamma_negative=0.5)
"""The tanker with a rudder that feels drift to both sides alike."""
KINDS = np.array([1, 2, 5])
"""Channels y, psi and r: the surge of a single screw has a bend at no drift."""
VARIANCES = np.array([2e-3, 1e-4, 1e-4]) ** 2
L = EVEN.ship.L
SPREAD = np.array([0.01, 0.01, 2e-3, 5e-3, 5e-3, 1e-3]) ** 2


def scattered(F, diffusion, time):
    """Ours, where F are the slopes of the rates."""
    Q = np.zeros_like(F)
    ahead = expm(F * time)
    keep = np.diagonal(ahead)[6:].copy()
    BY_WATER.scatter(Q, ahead[:6, :6].copy(), ahead[:6, 6:].copy(), keep, diffusion, time)
    return Q


def van_loan(F, diffusion, time):
    """The same integral as a part of one exponential (Van Loan 1978, theorem 1)."""
    n = len(F)
    whole = expm(time * np.block([[-F, np.diag(diffusion)], [np.zeros((n, n)), F.T]]))
    return whole[n:, n:].T @ whole[:n, n:]


@pytest.mark.parametrize(("share", "near"), [(0.1, 1e-8), (0.4, 1e-5), (1.0, 2e-3)])
def test_over_an_interval_it_is_that_of_nomotos_first_order_in_closed_form(share, near):
    """dψ = r dt, dr = -r/T dt + dw over a share of T."""
    T, q = 2.0, 0.3
    F, diffusion = np.zeros((6, 6)), np.zeros(6)
    F[2, 5], F[5, 5], diffusion[5] = 1.0, -1.0 / T, q
    left = math.exp(-share)
    Q = scattered(F, diffusion, share * T)
    assert Q[5, 5] == pytest.approx(0.5 * q * T * (1.0 - left**2), rel=near)
    assert Q[2, 5] == pytest.approx(0.5 * q * T**2 * (1.0 - left) ** 2, rel=near)
    rest = share - 2.0 * (1.0 - left) + 0.5 * (1.0 - left**2)
    assert Q[2, 2] == pytest.approx(q * T**3 * rest, rel=3 * near)
    assert np.count_nonzero(Q) == 4
    np.testing.assert_array_equal(Q, Q.T)


def test_over_an_interval_it_is_that_of_van_loan():
    """Six states, a force that forgets (Ornstein-Uhlenbeck) and one that does not."""
    draw = np.random.default_rng(0)
    F, diffusion = np.zeros((8, 8)), draw.uniform(0.2, 1.0, 8)
    F[:6] = 0.5 * draw.normal(size=(6, 8))
    F[6, 6] = -0.7
    right = van_loan(F, diffusion, 0.4)
    Q = scattered(F, diffusion, 0.4)
    np.testing.assert_allclose(Q, right, atol=1e-4 * np.max(right))
    assert np.linalg.eigvalsh(Q)[0] > 0.0
    np.testing.assert_array_equal(scattered(F, np.zeros(8), 0.4), 0.0)


def slopes_of_rates(k, turns):
    """Slopes of the tanker's rates over its states, straight ahead."""
    even, F = np.array([0.0, 0.0, 0.0, SPEED, 0.0, 0.0]), np.empty((6, 6))
    for j, size in enumerate(1e-4 * np.eye(6)):
        ends = np.empty((2, 6))
        for end, sign in zip(ends, (1.0, -1.0), strict=True):
            BY_WATER.rates(even + sign * size, 0.0, turns, 0.0, k, end)
        F[:, j] = (ends[0] - ends[1]) / 2e-4
    return F


def likelihood(method, binding, inputs, t, measured, diffusion):
    """ln of how probable a filter without parameters takes a record for."""
    record = RecordView(
        name="made",
        t=t,
        inputs=inputs,
        channels=("y", "psi", "r"),
        measured=measured,
        kinds=KINDS,
        variances=VARIANCES,
    )
    none = np.zeros(0)
    moving = Process(
        diffusion=diffusion,
        fading=none,
        frozen=none,
        steps=state_steps(STATES, SPEED, L),
        longest=0.3,
    )
    z, P = np.array([0.0, 0.0, 0.0, SPEED, 0.0, 0.0]), np.diag(SPREAD)
    found = passed(BY_WATER, binding, record, moving, z, P, method=method)
    return found.innovations.log_likelihood()


@pytest.mark.parametrize("method", ["ekf", "ukf"])
def test_a_record_is_as_probable_as_all_its_measurements_at_once(method):
    """Sway and yaw are linear about straight ahead: the whole record is one normal vector, whose
    covariance is made of exponentials of the slopes of the rates. With the noise of each interval
    at its end that vector is off by 6.5 here."""
    binding = Binding.of(EVEN, (), SPEED)
    k, turns = binding.base.copy(), prepare(EVEN, SPEED).self_propulsion()
    assert BY_WATER.complete(k) == 0
    F, diffusion = slopes_of_rates(k, turns), process(STATES, 3e-3, SPEED, L)
    count, step = 40, 0.6
    ahead, noise = expm(F * step), van_loan(F, diffusion, step)
    t = step * np.arange(count)
    covariances = [np.diag(SPREAD)]
    for _ in range(count - 1):
        covariances.append(ahead @ covariances[-1] @ ahead.T + noise)
    whole = np.empty((count, 6, count, 6))
    for i, covariance in enumerate(covariances):
        for j in range(i, count):
            whole[j, :, i] = np.linalg.matrix_power(ahead, j - i) @ covariance
            whole[i, :, j] = whole[j, :, i].T
    size = len(KINDS) * count
    seen = whole[:, KINDS][:, :, :, KINDS].reshape(size, size)
    right = multivariate_normal(cov=seen + np.diag(np.tile(VARIANCES, count)))
    drawn = right.rvs(random_state=3)
    inputs = np.zeros((count, len(InputField)))
    inputs[:, InputField.revolutions] = turns
    measured = drawn.reshape(count, len(KINDS))
    told = likelihood(method, binding, inputs, t, measured, diffusion)
    assert told == pytest.approx(right.logpdf(drawn), abs=0.05)
