"""Start values so poor that the motion is lost: filters and fits begin anew, and say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_filters import LINER, SENSORS, SPEED, TANKER, off, sailed

from pmmkit import identify
from pmmkit.base import SimulationError
from pmmkit.identification import Prior

TWO_HERTZ_THINNED = 2.0
"""Seconds between instants."""
NOISE = {"x": 1.0, "y": 1.0, "psi": 2e-3, "r": 5e-4, "u": 0.1, "phi": 2e-3}


def turns(ship=LINER, speed=7.0, sensors=NOISE):
    return [
        sailed(
            ship,
            "turning",
            speed=speed,
            rudder_deg=angle,
            duration=300.0,
            dt=TWO_HERTZ_THINNED,
            sensors=sensors,
        ).with_(name=f"turn {angle:g}")
        for angle in (25.0, -35.0)
    ]


def poor(names, seed):
    """Start values as far off as they are large, whose prior believes in a fifth of that."""
    narrow = Prior.of(LINER, names, 7.0, spread=0.2)
    far = off(replace(narrow, covariance=25.0 * narrow.covariance), seed)
    return replace(far, covariance=narrow.covariance)


HULL = tuple(LINER.parts["hull_polynomial"].values)
MASSES = tuple(name for name in LINER.parts["added_mass"].values if "dot" in name)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("method", ["ekf", "trajectory", "regression"])
def test_turns_sampled_at_two_seconds_are_not_lost(method, seed):
    """Start values off by a fifth, of two turns every two seconds."""
    truth = Prior.of(LINER, ("Yv", "Yr", "Nv", "Nr", "Nrrr"), 7.0, spread=0.2)
    found = identify(
        LINER, turns(), truth.names, method=method, prior=off(truth, seed), sensors=NOISE
    )
    assert np.mean(np.abs(found.values - truth.mean) < 3.0 * found.std) >= 0.8


@pytest.mark.slow
def test_a_fit_through_trajectories_shortens_its_windows_and_lengthens_them_again():
    found = identify(LINER, turns(), HULL, method="trajectory", prior=poor(HULL, 6), sensors=NOISE)
    near = identify(
        LINER,
        turns(),
        HULL,
        method="trajectory",
        prior=Prior.of(LINER, HULL, 7.0, spread=0.2),
        sensors=NOISE,
    )
    assert any("the motion was lost at first" in note for note in found.notes)
    assert found.detail.windows == near.detail.windows
    assert not any("lost" in note for note in near.notes)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "ukf"])
def test_a_filter_begins_anew_from_a_fit(method):
    names = (*HULL, *MASSES)
    found = identify(LINER, turns()[:1], names, method=method, prior=poor(names, 7), sensors=NOISE)
    assert any("the motion was lost at first" in note for note in found.notes)
    assert np.all(np.isfinite(found.values))
    assert np.all(found.std <= 1.001 * found.prior.std * np.sqrt(found.detail.covariance.shape[0]))


@pytest.mark.parametrize("method", ["ekf", "trajectory"])
def test_only_what_no_way_saves_asks_for_signs_and_says_what_was_tried(method):
    """A hull whose yaw feeds itself so much that every motion is lost within a second."""
    names = ("Nr", "Nv")
    mad = TANKER.with_values("hull_polynomial", Nr=300.0, Nv=-80.0)
    prior = Prior.of(mad, names, SPEED, spread=1e-6)
    with pytest.raises(SimulationError, match="signs of rudder") as lost:
        identify(mad, [sailed(dt=2.0)], names, method=method, prior=prior, sensors=SENSORS)
    assert "Tried: " in str(lost.value)
    assert "the model's own values" in str(lost.value)


@pytest.mark.parametrize("method", ["ekf", "ukf", "trajectory", "regression"])
def test_every_method_says_what_it_does(method):
    told = []
    identify(
        TANKER,
        [sailed(dt=0.5)],
        ("Nv", "Nr"),
        method=method,
        spread=0.2,
        sensors=SENSORS,
        progress=lambda done, total, what: told.append((done, total, what)),
    )
    assert len({what for _, _, what in told}) >= 3
    assert all(0 <= done <= total for done, total, _ in told)
