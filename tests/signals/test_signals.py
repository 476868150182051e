"""Steady windows, means, cycles and harmonics of records whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from scipy.stats import t as student

from pmmkit.base import DataError
from pmmkit.signals import (
    estimate_frequency,
    harmonics,
    steady_mean,
    steady_window,
    white_noise,
    whole_cycles,
)
from pmmkit.signals.fourier import trapezoid_harmonics


def ar1(shape, rho, seed):
    """Stationary AR(1) records of unit variance."""
    rng = np.random.default_rng(seed)
    white = rng.normal(size=shape) * np.sqrt(1 - rho**2)
    white[:, 0] /= np.sqrt(1 - rho**2)
    return lfilter([1.0], [1.0, -rho], white, axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(("rho", "n"), [(0.0, 300), (0.8, 600), (0.95, 2000), (0.98, 5000)])
def test_intervals_of_a_steady_mean_hold_the_truth(rho, n):
    t = np.arange(n) * 0.1
    mean = steady_mean(t, ar1((1500, n), rho, 1))
    std = np.sqrt(np.diagonal(mean.covariance))
    half = student.ppf(0.975, mean.dof) * std
    assert 0.925 < np.mean(np.abs(mean.value) < half) < 0.975


def test_a_steady_record_is_kept():
    t = np.arange(800) * 0.1
    lengths = []
    for seed in range(60):
        window = steady_window(t, ar1((3, 800), 0.9, seed))
        lengths.append(window.stop - window.start)
    assert np.mean(np.array(lengths) >= 0.8 * 800) > 0.9


@pytest.mark.parametrize("share", [0.1, 0.25, 0.4])
def test_a_carriage_ramp_does_not_leak_into_the_mean(share):
    """Force rising with the square of the speed over the first part of the record."""
    t = np.arange(1200) * 0.05
    speed = np.clip(t / (share * t[-1]), 0, 1)
    for seed in range(10):
        force = 50.0 * speed**2 + 0.5 * ar1((1, 1200), 0.9, seed)
        window = steady_window(t, force)
        mean = steady_mean(t[window.start : window.stop], force[:, window.start : window.stop])
        assert abs(mean.value[0] - 50.0) < 5 * np.sqrt(mean.covariance[0, 0])
        assert "start-up" in window.reason


def test_an_impulsive_start_and_a_braking_carriage_are_left_out():
    """A CFD record with huge first samples, and a tank record that stops before its end."""
    t = np.arange(1000) * 0.05
    start = 40.0 * (1 + 30 * np.exp(-t / 0.2) + np.exp(-t / 2) * np.cos(3 * t))
    stop = np.where(t > 42.0, np.clip(1 - (t - 42.0) / 5.0, 0, 1), 1.0)
    force = (start * stop)[None] + 0.3 * ar1((1, 1000), 0.8, 2)
    window = steady_window(t, force)
    mean = steady_mean(t[window.start : window.stop], force[:, window.start : window.stop])
    assert abs(mean.value[0] - 40.0) < 0.5
    assert t[window.stop - 1] <= 42.5


@pytest.mark.slow
@pytest.mark.parametrize(("rho", "cycles"), [(0.0, 3), (0.8, 4), (0.95, 4), (0.9, 2)])
def test_intervals_of_harmonics_hold_the_truth(rho, cycles):
    per = 120
    theta = np.arange(cycles * per) * (2 * np.pi / per)
    records = 3.0 + np.sin(theta) - 2 * np.cos(3 * theta) + ar1((1200, len(theta)), rho, 5)
    found = harmonics(theta, records)
    truth = np.zeros(11)
    truth[[0, 2, 5]] = 3.0, 1.0, -2.0
    std = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2))
    half = student.ppf(0.975, found.dof)[:, None] * std
    coverage = np.mean(np.abs(found.coefficients - truth) < half, axis=0)
    assert coverage[1:].min() > 0.90
    assert 0.92 < coverage.mean() < 0.98


@given(
    st.integers(0, 2**31 - 1),
    st.integers(1, 5),
    st.integers(24, 300),
    st.floats(-3, 3),
    st.booleans(),
)
@settings(max_examples=40, deadline=None)
def test_noise_free_harmonics_are_exact(seed, cycles, per, start, uneven):
    rng = np.random.default_rng(seed)
    cycles += uneven
    truth = rng.normal(size=(2, 11))
    theta = start + np.arange(cycles * per) * (2 * np.pi / per)
    if uneven:
        theta = theta + rng.uniform(-0.3, 0.3, len(theta)) * (2 * np.pi / per)
    order = np.arange(1, 6)
    basis = np.concatenate(
        [
            np.ones((1, len(theta))),
            np.stack([np.cos(np.outer(order, theta)), np.sin(np.outer(order, theta))], 1).reshape(
                10, -1
            ),
        ]
    )
    found = harmonics(theta, truth @ basis)
    assert found.coefficients == pytest.approx(truth, abs=1e-10)
    assert np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2)).max() < 1e-10


def test_trapezoidal_rule_agrees_on_uniform_whole_cycles():
    """The integration of the CFD paper: the same on uniform whole cycles, not on uneven ones."""
    theta = np.arange(4 * 97) * (2 * np.pi / 97)
    record = np.random.default_rng(3).normal(size=(3, len(theta)))
    least = harmonics(theta, record).coefficients
    assert trapezoid_harmonics(theta, record) == pytest.approx(least, abs=1e-12)


def test_transient_cycles_are_dropped_and_steady_ones_kept():
    t = np.arange(6 * 150) * 0.1
    theta = 2 * np.pi * t / 15.0
    steady = np.stack([20 * np.cos(theta), 5 * np.sin(theta)])
    kept = []
    for seed in range(20):
        noise = 0.3 * ar1((2, len(t)), 0.8, seed)
        growing = steady * (1 + 0.4 * np.exp(-t / 4.0)) + noise
        assert whole_cycles(t, theta, growing).first >= 1
        kept.append(whole_cycles(t, theta, steady + noise).count)
    assert np.mean(np.array(kept) >= 5) > 0.8


def test_the_third_cycle_alone_or_a_range():
    t = np.arange(500) * 0.1
    theta = 2 * np.pi * t / 10.0
    record = np.cos(theta)[None]
    third = whole_cycles(t, theta, record, cycles=3)
    assert (third.start, third.stop, third.count) == (200, 300, 1)
    some = whole_cycles(t, theta, record, cycles=(2, 4))
    assert (some.start, some.stop, some.count) == (100, 400, 3)
    with pytest.raises(DataError):
        whole_cycles(t, theta, record, cycles=9)


def test_frequency_is_found_near_the_nominal_one():
    t = np.arange(1200) * 0.1
    true = 0.5
    record = 3 * np.cos(true * t) + np.sin(3 * true * t) + 0.3 * ar1((1, 1200), 0.8, 4)
    found, std = estimate_frequency(t, record, 0.51)
    assert abs(found - true) < 4 * std
    assert std < 1e-3


@pytest.mark.parametrize("samples", [2.0, 3.0, 6.0, 7.9])
def test_few_samples_a_cycle_do_not_tell_a_frequency(samples):
    """The last digit of a carriage's speed goes up and down: 'waves' of two samples."""
    t = 0.025 * np.arange(1258)
    omega = 2 * np.pi / (0.025 * samples)
    assert estimate_frequency(t, 0.007 * np.cos(omega * t), omega) == (omega, np.inf)


def test_white_noise_passes_over_what_is_missing_and_says_where_it_cannot_be_told():
    noise = np.random.default_rng(4).normal(size=4000)
    values = 1e-3 * np.arange(4000.0) ** 2 + 0.3 * noise
    holed = np.where(np.arange(4000) % 50 == 7, np.nan, values)
    assert white_noise(holed) == pytest.approx(0.3, rel=0.05)
    assert np.isnan(white_noise(values[:12]))
    assert np.isfinite(white_noise(values[:13]))
