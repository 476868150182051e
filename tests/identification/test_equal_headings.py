"""The current by the drift between equal headings, as MSC/Circ.1053 (3.4.2.5) has it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.identification.trials.circle import fit_circle
from pmmkit.identification.trials.evaluate import equal_headings

DRIFT = st.floats(-1.5, 1.5)


def steady(current, *, rate=0.01, radius=500.0, to=800.0, step=2.0):
    """A steady turn of some degrees, in a current: closed form."""
    t = np.arange(0.0, np.radians(to) / abs(rate) + step, step)
    psi = rate * t
    side = np.sign(rate)
    x = radius * np.sin(side * psi) + current[0] * t
    y = side * radius * (1.0 - np.cos(psi)) + current[1] * t
    return t, x, y, psi


@given(north=DRIFT, east=DRIFT, rate=st.sampled_from((0.01, -0.01, 0.02)))
def test_a_steady_turn_drifts_with_the_current_alone(north, east, rate):
    found = equal_headings(*steady((north, east), rate=rate))
    assert (found.x, found.y) == pytest.approx((north, east), abs=0.01)
    assert max(found.std) < 0.01


def test_what_lies_before_180_degrees_does_not_count():
    t, x, y, psi = steady((0.4, -0.2))
    spoiled = np.where(psi < np.pi - 0.05, 300.0 * np.random.default_rng(0).normal(size=len(t)), 0)
    found = equal_headings(t, x + spoiled, y - spoiled, psi)
    assert (found.x, found.y) == pytest.approx((0.4, -0.2), abs=0.01)


def test_less_than_540_degrees_have_no_equal_headings_to_compare():
    assert equal_headings(*steady((0.4, -0.2), to=535.0)) is None
    assert equal_headings(*steady((0.4, -0.2), to=560.0)) is not None


def test_a_ship_that_still_loses_speed_seems_to_drift_and_the_fit_of_the_circle_does_not():
    """Both find the current of a turn of 720°; of the two the fit lets the speed die away."""
    track = pk.simulate(
        "kvlcc2", "turning", rudder_deg=35, speed=7.97, dt=2.0, duration=1800.0, compiled=False
    )
    t, current = np.asarray(track.t), (0.5, -0.6)
    moved = (track.x + current[0] * t, track.y + current[1] * t, track.psi)
    drift, circle = equal_headings(t, *moved), fit_circle(t, *moved, pace=320.0 / 7.97)
    misses = [np.hypot(one.x - 0.5, one.y + 0.6) for one in (drift, circle.current)]
    assert misses[0] < 0.03
    assert misses[1] < 0.5 * misses[0]


def test_a_circle_does_not_hang_on_the_relaxations_that_are_tried():
    """Sharp fixes know the relaxation closely: another pace tries others and finds the same."""
    t = np.arange(0.0, 1300.0, 1.0)
    rng, psi = np.random.default_rng(2), 0.01 * t
    u = 3.0 * (1.0 + 0.2 * np.exp(-t / 200.0))
    speed = np.stack([u * np.cos(psi + 0.15) + 0.2, u * np.sin(psi + 0.15) - 0.1])
    steps = np.concatenate([np.zeros((2, 1)), 0.5 * (speed[:, 1:] + speed[:, :-1])], axis=1)
    x, y = np.cumsum(steps, axis=1) + 0.3 * rng.normal(size=(2, len(t)))
    one, other = (fit_circle(t, x, y, psi, pace=pace) for pace in (80.0, 92.0))
    std = np.array(one.current.std)
    away = np.array([one.current.x - other.current.x, one.current.y - other.current.y])
    assert np.all(np.abs(away) < 0.02 * std)
    assert np.array(other.current.std) == pytest.approx(std, rel=0.02)
    assert one.relaxation == pytest.approx(other.relaxation, rel=0.02)
