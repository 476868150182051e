"""How uncertain a sailed record is by what the model states of its values: beside Monte Carlo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.identification import FreeRecord, Prediction, Smoothed
from pmmkit.identification.prediction import Course

SHIP = pk.load_model("kvlcc2-l7")
SPEED = 1.179
SENSORS = {"x": 0.01, "y": 0.01, "psi": 0.001, "u": 0.005, "v": 0.005, "r": 0.0005}
NAMES = ("Yv", "Yr", "Nv", "Nr")


@pytest.fixture(scope="module")
def circle():
    """A turning circle of two minutes and more, smoothed."""
    track = pk.simulate(SHIP, "turning", speed=SPEED, rudder_deg=35.0, dt=0.5)
    noise = np.random.default_rng(1)
    kept = track.t < 200.0
    record = FreeRecord(
        name="turning",
        t=track.t[kept],
        delta=track.delta[kept],
        turns=track.n[kept],
        speed=SPEED,
        measured={
            name: getattr(track, name)[kept] + std * noise.normal(size=kept.sum())
            for name, std in SENSORS.items()
        },
    )
    (found,) = Smoothed.references(SHIP, [record], sensors=SENSORS)
    return found


def uncertain(share):
    """The ship with derivatives that are known to a share, two pairs of them correlated."""
    values = SHIP.values("hull_polynomial", Fn=None)
    std = share * np.array([values[name] for name in NAMES])
    alike = np.eye(4) + np.kron(np.diag([0.6, -0.7]), np.array([[0.0, 1.0], [1.0, 0.0]]))
    return SHIP.with_(covariance=alike * np.outer(std, std), covariance_names=NAMES)


def test_the_band_of_a_sailed_record_is_that_of_ships_drawn_from_both_uncertainties(circle):
    """A standard deviation to either side: to one side alone the end of y was a fourth too low,
    or too high, as the signs of eigenvectors fell."""
    model, at = uncertain(0.05), np.arange(0, len(circle.record.t), 10)
    course = Course.of(model, circle.record, NAMES, extrapolate=False)
    start = course.states_of(circle)[0]
    rng, size = np.random.default_rng(4), len(start)
    starts = rng.multivariate_normal(start, circle.covariance[0][:size, :size], size=500)
    changes = rng.multivariate_normal(np.zeros(4), model.covariance, size=500)
    sailed = np.stack(
        [course.sail(at, a[None], b)[0] for a, b in zip(starts, changes, strict=True)]
    )
    std = Prediction.std(model, circle, at)
    for i, name in enumerate(course.states):
        drawn = sailed[:, :, i].std(axis=0, ddof=1)
        assert std[name][-1] == pytest.approx(drawn[-1], rel=0.12), name
        assert np.sqrt(np.mean(std[name] ** 2)) == pytest.approx(
            np.sqrt(np.mean(drawn**2)), rel=0.08
        ), name


def test_a_value_in_other_units_hides_no_derivative(circle):
    """Beside a value that is uncertain by a million of its unit the derivatives count as before."""
    at = np.arange(0, len(circle.record.t), 50)
    alone = Prediction.std(uncertain(0.05), circle, at)
    blades = SHIP.parts["propeller"]
    part = replace(blades, values={**blades.values, "xp": 0.0}, std={"xp": 1e6})
    known = Prediction.std(
        uncertain(0.05).with_(parts={**SHIP.parts, "propeller": part}), circle, at
    )
    for name, std in alone.items():
        assert (known[name] >= 0.99 * std).all(), name
