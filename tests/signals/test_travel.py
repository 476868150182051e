"""A carriage's ramp and stop: found by its speed or by the forces, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import DataError
from pmmkit.signals import at_size, at_speed, design_matrix, in_step

RATE, PERIOD = 20.0, 9.0


def towed(rest: float, ramp: float, run: float, stop: float) -> tuple[np.ndarray, np.ndarray]:
    """Time from the instant at which the carriage is at its speed, and the share of it."""
    t = np.arange(round(-(rest + ramp) * RATE), round((run + stop) * RATE)) / RATE
    up = np.clip((t + ramp) / ramp, 0.0, 1.0) if ramp else np.ones_like(t)
    down = np.clip((run + stop - t) / stop, 0.0, 1.0) if stop else np.ones_like(t)
    return t, np.minimum(up, down)


def swung(share: np.ndarray, t: np.ndarray, noise: float, seed: int = 0) -> np.ndarray:
    """X, Y, N of a hull on a balance that oscillates throughout; its own mass pulls on the ramp."""
    theta = 2 * np.pi * t / PERIOD
    clean = [
        -20.0 * share**2 - 2.0 * np.cos(2 * theta) - 30.0 * np.gradient(share, t),
        50.0 * share * np.cos(theta) + 40.0 * np.sin(theta),
        30.0 * share * np.sin(theta) + 25.0 * np.cos(theta),
    ]
    return np.stack(clean) + noise * np.random.default_rng(seed).normal(size=(3, t.size))


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.03])
@pytest.mark.parametrize(("rest", "ramp", "stop"), [(3, 5, 0), (0, 5, 6), (0, 0, 4), (10, 12, 8)])
def test_the_speed_tells_where_the_run_begins_and_ends(rest, ramp, stop, noise):
    t, share = towed(rest, ramp, 30.0, stop)
    speed = 1.2 * share + noise * np.random.default_rng(1).normal(size=t.size)
    found = at_speed(t, speed)
    first, last = t[found.start], t[found.stop - 1]
    assert (-0.2 if ramp else t[0]) <= first <= 0.15 * ramp + (0.5 if ramp else 0.0)
    assert 30.0 - 0.15 * stop - 0.5 <= last <= 30.2 if stop else last == t[-1]
    assert ("speeds up" in found.reason) == bool(ramp)
    assert ("stops" in found.reason) == bool(stop)


@pytest.mark.parametrize(
    "speed",
    [
        lambda t: 1.2 + 0 * t,
        lambda t: 1.2 + 0.01 * t / t[-1],
        lambda t: 1.2 + 0.3 * np.sin(t),
        lambda t: 1.2 / np.cos(0.3 * np.sin(t)),
        lambda t: np.where(t < 20.0, 1.1, 1.2),
        lambda t: 0 * t,
    ],
)
def test_a_speed_without_a_ramp_is_left_alone(speed):
    """Constant, drifting, swinging as in surge and yaw, two legs, or none at all."""
    t = np.arange(0.0, 40.0, 0.05)
    found = at_speed(t, speed(t))
    assert (found.start, found.stop, found.reason) == (0, t.size, "")


@given(gain=st.floats(0.05, 50.0), sign=st.sampled_from([-1.0, 1.0]), late=st.floats(-1e3, 1e3))
def test_unit_direction_and_clock_of_a_speed_do_not_matter(gain, sign, late):
    t, share = towed(2.0, 4.0, 20.0, 5.0)
    one, other = at_speed(t, share), at_speed(t + late, sign * gain * share)
    assert (one.start, one.stop) == (other.start, other.stop)


@pytest.mark.parametrize("noise", [0.01, 0.3, 2.0])
@pytest.mark.parametrize(
    ("rest", "ramp", "cycles", "stop"),
    [(2, 6, 3.0, 0), (0, 5, 2.2, 0), (3, 4, 4.0, 6), (0, 0, 3, 7)],
)
def test_the_forces_tell_it_where_no_speed_is_recorded(rest, ramp, cycles, stop, noise):
    t, share = towed(rest, ramp, cycles * PERIOD, stop)
    found = in_step(t, 2 * np.pi * t / PERIOD, swung(share, t, noise))
    first, last = t[found.start], t[found.stop - 1]
    assert -1.0 <= first <= 1.0 if ramp else first == t[0]
    assert abs(last - cycles * PERIOD) <= 1.2 if stop else last == t[-1]


@pytest.mark.parametrize("cycles", [2.0, 2.7, 4.0, 7.3])
@pytest.mark.parametrize("seed", range(8))
def test_forces_without_a_ramp_are_left_alone(cycles, seed):
    """Also where the oscillator has only begun, or a computation: the first cycle is too large."""
    t, share = towed(0.0, 0.0, cycles * PERIOD, 0.0)
    theta = 2 * np.pi * t / PERIOD
    steady = swung(share, t, 0.5, seed)
    for growing in (0.0, 0.5, 4.0):
        found = in_step(t, theta, steady * (1.0 + growing * np.exp(-t / 2.0)))
        assert found.reason == ""


def test_a_swing_that_builds_up_is_no_ramp():
    """The oscillator starts under a carriage at speed: the pull is there from the first sample."""
    t, share = towed(0.0, 0.0, 4 * PERIOD, 0.0)
    forces = swung(share, t, 0.3)
    forces[1:] *= np.clip(t / 6.0, 0.0, 1.0)
    assert in_step(t, 2 * np.pi * t / PERIOD, forces).reason == ""


@pytest.mark.filterwarnings("error")
def test_a_model_that_is_not_pulled_at_all_tells_nothing():
    t = np.linspace(0, 6 * PERIOD, 3000)
    theta = 2 * np.pi * t / PERIOD
    found = in_step(t, theta, np.stack([np.zeros(t.size), np.cos(theta)]))
    assert (found.start, found.stop, found.reason) == (0, t.size, "")


def test_a_damaged_record_is_refused():
    t = np.arange(0.0, 30.0, 0.05)
    speed = np.ones_like(t)
    speed[7] = np.nan
    with pytest.raises(DataError, match="not finite"):
        at_speed(t, speed)
    with pytest.raises(DataError, match="does not increase"):
        in_step(t[::-1], t, np.ones((1, t.size)))


def swinging(rise: float, cycles: float, fall: float) -> tuple[np.ndarray, np.ndarray]:
    """Time, and a swing of 0.25 m that comes up softly after 8 s and goes down again."""
    full = 8.0 + rise
    t = np.arange(0.0, full + cycles * PERIOD + fall + 4.0, 1.0 / RATE)
    up = np.clip((t - 8.0) / rise, 0.0, 1.0) if rise else np.where(t < 8.0, 0.0, 1.0)
    down = np.clip((full + cycles * PERIOD + fall - t) / fall, 0.0, 1.0) if fall else 1.0 + 0 * t
    size = 0.5 - 0.5 * np.cos(np.pi * np.minimum(up, down))
    return t, 0.25 * size * np.sin(2 * np.pi * t / PERIOD + 0.4)


def amplitude(t: np.ndarray, y: np.ndarray) -> float:
    fit, *_ = np.linalg.lstsq(design_matrix(2 * np.pi * t / PERIOD, 1), y, rcond=None)
    return float(np.hypot(fit[1], fit[2]))


@pytest.mark.parametrize("noise", [0.0, 0.002])
@pytest.mark.parametrize("cycles", [2.0, 3.0, 6.0])
@pytest.mark.parametrize(("rise", "fall"), [(0, 0), (3, 3), (9, 5), (15, 9), (6, 0)])
def test_a_swing_has_its_size_between_its_ramps(rise, fall, cycles, noise):
    """Fitted over the ramps 0.25 m look smaller; between them they are 0.25 m."""
    t, y = swinging(rise, cycles, fall)
    y = y + noise * np.random.default_rng(2).normal(size=t.size)
    found = at_size(t, y, 2 * np.pi / PERIOD)
    kept = slice(found.start, found.stop)
    assert amplitude(t, y) < 0.23
    assert amplitude(t[kept], y[kept]) == pytest.approx(0.25, rel=0.004)
    assert np.ptp(t[kept]) > (cycles - 0.35) * PERIOD
    assert "the oscillator comes up" in found.reason
    assert ("the oscillator goes down" in found.reason) == bool(fall)


def test_the_swing_that_is_on_its_way_longest_counts_for_several_motions():
    t, y = swinging(4.0, 4.0, 0.0)
    _, late = swinging(9.0, 4.0, 0.0)
    both = np.stack([y[: t.size], late[: t.size]])
    assert at_size(t, both, 2 * np.pi / PERIOD).start > at_size(t, y, 2 * np.pi / PERIOD).start


@pytest.mark.parametrize(
    "size",
    [
        lambda t: 1.0 + 0 * t,
        lambda t: 1.0 + 0.03 * t / t[-1],
        lambda t: 1.0 + 0.01 * np.sin(0.3 * t),
        lambda t: np.where(t < 30.0, 1.04, 1.0),
    ],
)
def test_a_swing_without_a_ramp_is_left_alone(size):
    """Constant, growing by 3 %, unsteady, or a little larger at first."""
    t = np.arange(0.0, 70.0, 1.0 / RATE)
    y = 0.25 * size(t) * np.sin(2 * np.pi * t / PERIOD)
    assert at_size(t, y, 2 * np.pi / PERIOD).reason == ""


def test_a_swing_that_overshoots_is_cut_where_it_has_settled():
    t = np.arange(0.0, 80.0, 1.0 / RATE)
    y = 0.25 * (1.0 + (0.3 - t) / 6.0 * np.exp(-t / 3.0)) * np.sin(2 * np.pi * t / PERIOD)
    y = y * np.clip(t / 3.0, 0.0, 1.0)
    found = at_size(t, y, 2 * np.pi / PERIOD)
    assert amplitude(t[found.start :], y[found.start :]) == pytest.approx(0.25, rel=0.004)
