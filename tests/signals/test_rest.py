"""Rest at the head of a record: found where the carriage starts, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.signals import head_rest

RATE = 50.0
ZERO = np.array([-1.2, 0.6, -0.9])
NOISE = np.array([0.4, 1.0, 1.5])


def record(
    rest: float,
    *,
    ramp: float = 2.0,
    period: float | None = 12.5,
    length: float = 60.0,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """X, Y, N of a run whose carriage stands for a while, starts and stays at speed."""
    t = np.arange(0.0, length, 1 / RATE)
    on = np.clip((t - rest) / ramp, 0.0, 1.0) if rest > 0 else np.ones_like(t)
    swing = np.ones_like(t) if period is None else np.sin(2 * np.pi * (t - rest) / period)
    turn = np.ones_like(t) if period is None else np.cos(2 * np.pi * (t - rest) / period - 0.4)
    clean = np.stack([-22.0 * on**2 - 2.0 * on * swing**2, 60.0 * on * swing, 90.0 * on * turn])
    noise = NOISE[:, None] * np.random.default_rng(seed).normal(size=clean.shape)
    return t, clean + ZERO[:, None] + noise


@pytest.mark.parametrize("period", [None, 12.5, 30.0])
@pytest.mark.parametrize("rest", [1.5, 3.0, 10.0])
def test_the_gauges_show_their_zero_at_rest(rest, period):
    found = head_rest(*record(rest, period=period))
    assert found is not None
    assert 0.8 * rest <= found.duration <= rest + 0.1
    assert np.all(np.abs(found.value - ZERO) < 4 * found.std)
    assert np.all(found.std < 4 * NOISE / np.sqrt(found.duration * RATE))


@pytest.mark.parametrize("period", [None, 4.0, 12.5, 30.0])
@pytest.mark.parametrize("seed", range(10))
def test_a_record_that_begins_on_the_way_has_none(period, seed):
    assert head_rest(*record(0.0, period=period, seed=seed)) is None


def test_a_zero_as_large_as_the_forces_is_found():
    """A gauge 30 N off in a channel that the run hardly moves."""
    t, values = record(3.0, period=None)
    values[1] = 30.0 + np.random.default_rng(5).normal(size=t.size)
    found = head_rest(t, values)
    assert found is not None
    assert found.value[1] == pytest.approx(30.0, abs=0.4)


def test_a_first_leg_at_a_lower_speed_is_no_rest():
    """1.4 m/s and then 2 m/s: the first leg pulls half of the last."""
    t, values = record(0.0, period=None)
    first = t < 10.0
    values[:, first] = values[:, first] * np.array([0.5, 0.5, 0.5])[:, None]
    assert head_rest(t, values) is None


def test_the_end_of_a_run_is_no_rest():
    t, values = record(8.0, period=None)
    assert head_rest(t, values[:, ::-1]) is None


def test_a_computation_that_starts_at_once_has_none():
    """Large forces that die away, as a solver's first steps."""
    t, values = record(0.0, period=None)
    assert head_rest(t, values * (1.0 + 5.0 * np.exp(-t / 1.5))) is None


@pytest.mark.slow
@given(gain=st.floats(1e-3, 1e3), late=st.floats(-1e4, 1e4))
def test_units_and_the_clock_do_not_matter(gain, late):
    t, values = record(3.0)
    found, again = head_rest(t, values), head_rest(t + late, gain * values)
    assert found is not None
    assert again is not None
    assert abs(found.stop - again.stop) <= 1
    assert again.value == pytest.approx(gain * found.value, rel=0.05)
