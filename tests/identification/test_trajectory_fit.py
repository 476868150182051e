"""Fits through the simulator: recovery, intervals, windows, gaps, and what a model lacks."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from test_filters import (
    BY_WATER,
    FAST,
    LINER,
    NAMES,
    OVER_GROUND,
    SENSORS,
    SPEED,
    TANKER,
    away,
    off,
    sailed,
    true_prior,
)

from pmmkit.base import DataError, SimulationError
from pmmkit.identification import Binding, trajectory
from pmmkit.identification.trajectory import fit_trajectories

PATH = {name: SENSORS[name] for name in ("x", "y", "psi")}
LACKING = TANKER.with_values("hull_polynomial", Yvvv=0.0, Nvvr=0.0)


def fitted(records, prior, model=TANKER, sensors=SENSORS, **settings):
    return fit_trajectories(model, records, prior, sensors=sensors, jobs=2, **settings)


def test_without_noise_the_truth_is_found():
    clean = sailed(sensors=dict.fromkeys(PATH, 0.0), dt=0.05)
    truth = true_prior()
    vague = replace(off(truth, 1), covariance=100.0 * truth.covariance)
    found = fitted([clean], vague, sensors=PATH)
    assert found.converged
    assert found.values == pytest.approx(truth.mean, rel=5e-3)
    assert max(found.rms.values()) < 0.1
    assert found.inflation == 1.0


def test_white_noise_is_known_to_be_white():
    truth = true_prior()
    found = fitted([sailed(seed=1)], off(truth, 1))
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert np.all(found.std[:3] < 0.1 * truth.std[:3])
    for rms in found.rms.values():
        assert rms == pytest.approx(1.0, abs=0.08)
    assert 1.0 <= found.inflation < 2.5


@pytest.mark.slow
def test_intervals_of_95_percent_hold_95_percent():
    truth = true_prior()
    found = [fitted([sailed(seed=seed, dt=0.4)], off(truth, seed)) for seed in range(30)]
    errors = np.array([away(item, truth.mean) for item in found])
    assert 0.86 <= np.mean(np.abs(errors) < 1.96) <= 1.0
    assert 0.5 < np.mean(errors**2) < 1.5
    assert np.median([item.inflation for item in found]) < 1.6


def test_a_rolling_ship_is_fitted():
    names = ("Yv", "Nv", "Nr", "Kv")
    truth = true_prior(names, LINER, 9.0)
    settings = {"speed": 9.0, "sensors": FAST, "dt": 0.5}
    records = [sailed(LINER, **settings), sailed(LINER, "turning", rudder_deg=20.0, **settings)]
    found = fitted(records, off(truth, 2), LINER, FAST)
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert np.all(found.std < 0.2 * truth.std)


@pytest.mark.parametrize("channels", OVER_GROUND)
def test_a_current_is_fitted(channels):
    sensors = OVER_GROUND[channels]
    names = ("Yv", "Nr", "current_x", "current_y")
    truth = true_prior(names)
    truth = replace(truth, mean=np.array([*truth.mean[:2], 0.06, 0.12 * math.sin(math.pi / 3)]))
    prior = replace(truth, mean=np.array([1.1, 1.1, 0.0, 0.0]) * truth.mean)
    around = {"current_speed": 0.12, "current_direction_deg": 60.0}
    found = fitted([sailed(seed=3, sensors=sensors, around=around)], prior, sensors=sensors)
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert np.all(found.std[2:] < 0.2 * prior.std[2:])


def test_windows_bring_their_own_start(monkeypatch):
    """Start states that are wrong by a draw change nothing: they are unknowns of the fit."""
    record, prior = sailed(seed=4), off(true_prior(), 4)
    one = fitted([record], prior)
    kept = trajectory._first_states
    size = np.array([2.0, 2.0, 0.2, 0.1, 0.1, 0.03])

    def wrong(*given):
        first = kept(*given)
        return first + size * np.random.default_rng(1).uniform(-1.0, 1.0, first.shape)

    monkeypatch.setattr(trajectory, "_first_states", wrong)
    other = fitted([record], prior)
    assert np.all(np.abs(one.values - other.values) < 0.02 * one.std)
    assert other.cost == pytest.approx(one.cost, rel=1e-5)


@pytest.mark.slow
def test_a_tiny_problem_is_that_of_scipy():
    """All unknowns at once, start states too, without elimination."""
    record = sailed(seed=25).cut(5.0, 25.0)
    record = record.with_(
        t=record.t[::4],
        delta=record.delta[::4],
        turns=record.turns[::4],
        measured={name: values[::4] for name, values in record.measured.items()},
    )
    prior = off(true_prior(("Nv", "Nr")), 5)
    found = fitted([record], prior, window=10.0)
    assert found.windows == 2
    binding = Binding.of(TANKER, prior.names, SPEED)
    begins = np.array([0, int(np.searchsorted(record.t, record.t[0] + 10.0)), len(record)])
    places = {"x": 0, "y": 1, "psi": 2, "u": 3, "r": 5}

    def residuals(unknown):
        k = binding.constants(unknown[:2] * prior.std)
        BY_WATER.complete(k)
        out = np.empty((len(record), 6))
        first = unknown[2:].reshape(2, 6)
        BY_WATER.windows(record.t, record.inputs, begins, first, k, 0.05 * 7.0 / SPEED, out)
        rows = [
            (record.measured[name] - out[:, place]) / SENSORS[name]
            for name, place in places.items()
        ]
        return np.concatenate([*rows, unknown[:2] - prior.mean / prior.std])

    start = np.zeros((2, 6))
    for w in range(2):
        for name, place in places.items():
            start[w, place] = record.measured[name][begins[w]]
    theirs = least_squares(
        residuals,
        np.concatenate([prior.mean / prior.std, start.ravel()]),
        jac="3-point",
        x_scale="jac",
        xtol=1e-13,
        ftol=1e-13,
        gtol=1e-13,
    )
    covariance = np.linalg.inv(theirs.jac.T @ theirs.jac)[:2, :2]
    covariance *= np.outer(prior.std, prior.std)
    assert found.inflation == 1.0
    assert np.all(np.abs(found.values - theirs.x[:2] * prior.std) < 0.02 * found.std)
    assert found.cost == pytest.approx(theirs.cost, rel=1e-5)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-3)


def test_gaps_do_not_matter():
    truth, record = true_prior(), sailed(seed=6)
    gaps = {name: values.copy() for name, values in record.measured.items()}
    gaps["x"][::2] = np.nan
    gaps["psi"][300:500] = np.nan
    for values in gaps.values():
        values[500:560] = np.nan
    found = fitted([record.with_(measured=gaps)], off(truth, 6))
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert found.inflation < 2.5


@pytest.mark.slow
def test_a_window_without_any_measurement_says_nothing():
    """A gap longer than a window: the rest is fitted as two records would be."""
    truth, record = true_prior(), sailed(seed=7)
    gaps = {name: values.copy() for name, values in record.measured.items()}
    for values in gaps.values():
        values[390:810] = np.nan
    prior = off(truth, 7)
    found = fitted([record.with_(measured=gaps)], prior, window=20.0)
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert found.converged
    assert np.all(found.std > fitted([record], prior, window=20.0).std)


def test_a_channel_that_only_one_record_has():
    truth = true_prior()
    records = [sailed(seed=8), sailed(seed=9, rudder_deg=-10.0, switch_deg=10.0).only(list(PATH))]
    found = fitted(records, off(truth, 8))
    assert np.all(np.abs(away(found, truth.mean)) < 3.5)
    assert np.all(found.std < 1.02 * fitted(records[:1], off(truth, 8)).std)


def manoeuvres(seed):
    return [
        sailed(seed=seed),
        sailed(seed=seed + 100, rudder_deg=-10.0, switch_deg=10.0),
        sailed(manoeuvre="turning", rudder_deg=35.0, seed=seed + 200),
    ]


@pytest.mark.slow
def test_what_a_model_lacks_widens_the_intervals():
    """Yv, Nv, Nr cannot make good for the missing terms: intervals of noise alone would lie."""
    truth = true_prior(("Yv", "Nv", "Nr"))
    right, wrong = (fitted(manoeuvres(10), truth, model=model) for model in (TANKER, LACKING))
    assert right.inflation < 2.0
    assert wrong.inflation > 100.0
    assert max(wrong.rms.values()) > 5.0
    assert np.all(wrong.std > 20.0 * right.std)
    assert np.all(np.abs(away(wrong, truth.mean)) < 4.0)
    assert np.max(np.abs(wrong.values - truth.mean) / right.std) > 100.0


@pytest.mark.slow
def test_a_tight_prior_is_not_overruled_by_a_wrong_model(monkeypatch):
    """Thousands of instants that all lack the same do not count as thousands."""
    prior = true_prior(("Yv", "Nv", "Nr"), spread=0.02)
    weighed = fitted(manoeuvres(11), prior, model=LACKING)
    monkeypatch.setattr(trajectory, "ROUNDS", 1)
    plain = fitted(manoeuvres(11), prior, model=LACKING)
    one, other = (np.max(np.abs(item.values - prior.mean) / prior.std) for item in (weighed, plain))
    assert one < 5.0
    assert other > 3.0 * one


@pytest.mark.slow
@pytest.mark.parametrize("same", [trajectory.SAME, 0.0])
def test_the_inflation_is_what_the_variances_are_wider_by(monkeypatch, same):
    """One channel, no prior to speak of: variance over that of white noise, however many rounds."""
    monkeypatch.setattr(trajectory, "SAME", same)
    record, sensors = sailed(seed=12).only(["psi"]), {"psi": SENSORS["psi"]}
    prior = true_prior(("Nr",), spread=5.0)
    found = fitted([record], prior, model=LACKING, sensors=sensors)
    monkeypatch.setattr(trajectory, "ROUNDS", 1)
    first = fitted([record], replace(prior, mean=found.values), model=LACKING, sensors=sensors)
    white = first.covariance[0, 0] / first.inflation
    assert found.inflation > 3.0
    wider = found.inflation * found.lack.colour["windows"]
    assert found.lack.colour["windows"] > 1.2
    assert found.covariance[0, 0] / white > 0.9 * wider


def test_what_cannot_be_fitted_is_refused():
    with pytest.raises(DataError, match="no record"):
        fitted([], true_prior())
    record = sailed(seed=13)
    astern = TANKER.with_values("hull_polynomial", Xuu=50.0)
    driven_on = replace(true_prior(("Xuu",)), mean=np.array([50.0]))
    with pytest.raises(SimulationError, match=r"Tried: the start values .* signs of rudder"):
        fitted([record], driven_on, model=astern)


def test_threads_change_no_bit():
    record, prior = sailed(seed=14, dt=0.3), off(true_prior(NAMES[:3]), 14)
    one, other = (
        fit_trajectories(TANKER, [record], prior, sensors=SENSORS, jobs=jobs) for jobs in (1, 3)
    )
    np.testing.assert_array_equal(one.values, other.values)
    np.testing.assert_array_equal(one.covariance, other.covariance)
