"""One call for all methods, and how well the models it gives predict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_filters import SENSORS, SHALLOW, SPEED, TANKER, off, sailed, true_prior

import pmmkit as pk
from pmmkit import identify
from pmmkit.base import DataError, UnknownNameError
from pmmkit.identification import Prediction, Prior, Smoothed
from pmmkit.identification.methods import METHODS
from pmmkit.models import load_model, save_model

NAMES = ("Nv", "Nr")
SKEWED = TANKER.with_values("hull_polynomial", Nv=-0.110, Nr=-0.058)
"""The tanker with two values off by 20 %."""
TRUTH = np.array([-0.137, -0.049])


def one_record(seed=0):
    return sailed(seed=seed)


def found_by(method, records=None, **settings):
    if method in ("ekf", "ukf", "trajectory", "regression"):
        settings.setdefault("prior", Prior.of(SKEWED, NAMES, SPEED, spread=0.3))
    return identify(
        SKEWED, records or [one_record()], NAMES, method=method, sensors=SENSORS, **settings
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "ukf", "trajectory", "regression"])
def test_every_method_finds_the_truth(method):
    found = found_by(method)
    assert found.method == method
    assert found.names == NAMES
    assert found.values == pytest.approx(TRUTH, rel=0.05)
    assert np.all(np.abs(found.values - TRUTH) < 4.0 * found.std)
    assert np.all(found.std < 0.2 * found.prior.std)
    assert found.unseen == ()
    assert found.std == pytest.approx(np.sqrt(np.diagonal(found.covariance)))
    assert found.notes
    hull = found.model.values("hull_polynomial")
    assert [hull[name] for name in NAMES] == pytest.approx(found.values, rel=1e-12)
    others = {name: x for name, x in hull.items() if name not in NAMES}
    assert others.items() <= TANKER.values("hull_polynomial").items()


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "trajectory", "regression"])
def test_a_track_that_follows_from_velocities_teaches_nothing(method):
    """Its noise is that of the velocities summed up: as measurements of their own x, y and psi
    would make the values look better known than they are."""
    record = one_record().with_(reckoned=("x", "y", "psi"))
    alone = record.only([name for name in record.measured if name not in ("x", "y", "r")])
    found, known = found_by(method, [record]), found_by(method, [alone.with_(reckoned=())])
    np.testing.assert_array_equal(found.values, known.values)
    np.testing.assert_array_equal(found.std, known.std)


@pytest.mark.slow
def test_sparse_regression_is_a_method_too():
    records = [one_record(), sailed(seed=1, rudder_deg=-10.0, switch_deg=10.0).with_(name="other")]
    records.append(sailed(seed=2, manoeuvre="turning", rudder_deg=35.0))
    found = found_by("sindy", records)
    assert found.method == "sindy"
    assert found.names == NAMES
    assert found.values == pytest.approx(TRUTH, rel=0.1)
    assert found.model.values("hull_polynomial")["Nv"] == pytest.approx(found.values[0])
    assert set(found.unseen) <= set(NAMES)
    table = found.detail.table
    at = [NAMES.index(name) for name in table.names]
    block = found.covariance[np.ix_(at, at)]
    assert found.model.covariance_names == table.names
    np.testing.assert_allclose(block, found.model.covariance, rtol=1e-12)
    assert np.abs(block - np.diag(np.diagonal(block))).max() > 0.0
    assert found.std == pytest.approx(np.sqrt(np.diagonal(found.covariance)))


def test_all_methods_are_tested():
    assert set(METHODS) == {"ekf", "ukf", "trajectory", "regression", "sindy", "posterior"}


def test_what_is_found_is_a_model_with_its_covariance_and_where_it_comes_from(tmp_path):
    found = found_by("ekf")
    model = found.model
    assert model.covariance_names == NAMES
    np.testing.assert_allclose(model.covariance, found.covariance, rtol=1e-9)
    assert "ekf" in model.parts["hull_polynomial"].sources["Nv"]
    assert "ekf" in model.history[-1]
    save_model(model, tmp_path / "found.toml")
    again = load_model(tmp_path / "found.toml")
    prior = Prior.of(again, NAMES, SPEED)
    np.testing.assert_allclose(prior.covariance, found.covariance, rtol=1e-6)
    assert prior.mean == pytest.approx(found.values, rel=1e-9)


def test_uncertainties_of_parts_are_the_prior_and_go_with_what_is_found():
    """A value of a part counts with the uncertainty that it states, and leaves with its own."""
    names = ("Nr", "rudder_mmg.aH")
    parts = dict(SKEWED.parts)
    parts["rudder_mmg"] = replace(parts["rudder_mmg"], std={"aH": 0.05, "tR": 0.1})
    model = SKEWED.with_(parts=parts)
    prior = Prior.of(model, names, SPEED)
    assert prior.std == pytest.approx([0.3 * 0.058, 0.05])
    found = identify(model, [one_record()], names, method="trajectory", sensors=SENSORS)
    assert found.model.covariance_names == names
    np.testing.assert_allclose(found.model.covariance, found.covariance, rtol=1e-9)
    assert dict(found.model.parts["rudder_mmg"].std) == {"tR": 0.1}
    again = Prior.of(found.model, names, SPEED)
    np.testing.assert_allclose(again.covariance, found.covariance, rtol=1e-9)


def test_the_table_has_a_row_per_parameter():
    found = found_by("trajectory")
    table = found.to_pandas()
    assert list(table.index) == list(NAMES)
    row = table.loc["Nr"]
    assert (row["prior"], row["value"]) == (-0.058, found.values[1])
    assert row["ci_high"] - row["ci_low"] == pytest.approx(3.92 * found.std[1])
    assert row["std_over_prior"] == pytest.approx(found.std[1] / found.prior.std[1])
    assert bool(row["seen"])


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "ukf", "trajectory", "regression"])
def test_what_a_straight_course_says_nothing_of(method):
    """On a straight course the resistance can be seen, damping and rudder cannot."""
    track = pk.simulate(TANKER, "turning", speed=SPEED, rudder_deg=0.01, duration=60.0, dt=0.1)
    draw = np.random.default_rng(3).normal
    record = one_record().with_(
        t=track.t,
        delta=track.delta,
        turns=0.9 * track.n,
        measured={
            name: getattr(track, name) + std * draw(size=len(track))
            for name, std in SENSORS.items()
        },
    )
    names = ("Nvvv", "rudder_mmg.aH", "Yvrr")
    prior = off(Prior.of(TANKER, names, SPEED, spread=0.2), 4)
    found = identify(TANKER, [record], method=method, prior=prior, sensors=SENSORS)
    assert found.unseen == names
    assert found.model.values("rudder_mmg")["aH"] == pytest.approx(prior.mean[1], rel=1e-12)
    hull = found.model.values("hull_polynomial")
    assert [hull[name] for name in ("Nvvv", "Yvrr")] == pytest.approx(prior.mean[[0, 2]], rel=1e-12)


def test_intervals_wider_than_before_do_not_make_a_value_unseen():
    """Three ships of different Nv sail as one: the interval allows for that, the value is taken."""
    ships = [TANKER.with_values("hull_polynomial", Nv=x) for x in (-0.16, -0.11, -0.15)]
    records = [sailed(ship, seed=i).with_(name=str(i)) for i, ship in enumerate(ships)]
    near = TANKER.with_values("hull_polynomial", Nv=-0.12)
    prior = Prior.of(near, ("Nv",), SPEED, spread=0.02)
    found = identify(near, records, ("Nv",), method="ekf", prior=prior, sensors=SENSORS)
    assert found.std[0] > prior.std[0]
    assert found.unseen == ()
    assert found.values[0] < -0.13
    assert found.model.values("hull_polynomial")["Nv"] == pytest.approx(found.values[0])


def test_a_current_is_no_value_of_the_model():
    around = {"current_speed": 0.1, "current_direction_deg": 90.0}
    record = sailed(seed=5, around=around)
    names = ("Nv", "current_x", "current_y")
    found = identify(TANKER, [record], names, spread=0.2, sensors=SENSORS, roughness=0.0)
    assert found.values[1:] == pytest.approx([0.0, 0.1], abs=4e-3)
    assert found.model.covariance_names == ("Nv",)
    still = identify(TANKER, [record], ("Nv",), spread=0.2, sensors=SENSORS, roughness=0.0)
    assert abs(still.values[0] + 0.137) > 10.0 * abs(found.values[0] + 0.137)


def test_without_names_all_derivatives_of_the_hull_are_looked_for():
    found = identify(TANKER, [one_record()], spread=0.05, sensors=SENSORS, roughness=0.0)
    assert set(found.names) == set(TANKER.parts["hull_polynomial"].values)
    assert found.unseen
    assert len(found.unseen) < len(found.names)


def test_what_cannot_be_asked_is_refused():
    record = one_record()
    with pytest.raises(UnknownNameError, match="there are: ekf, ukf"):
        identify(TANKER, [record], NAMES, method="magic")
    with pytest.raises(DataError, match="no record"):
        identify(TANKER, [], NAMES)
    with pytest.raises(UnknownNameError, match="Nzz"):
        identify(TANKER, [record], ("Nzz",))
    for method in ("ekf", "ukf", "trajectory"):
        with pytest.raises(DataError, match="straight line"):
            identify(SHALLOW, [record], ("shallow_water.lambda_Yv",), method=method)


def test_regression_takes_parameters_that_are_no_straight_lines():
    """Drag that the smoother finds, explained by the power with which the bottom raises Nr."""
    deep = SHALLOW.with_values("shallow_water", lambda_Nr=0.4)
    prior = Prior(
        names=("shallow_water.lambda_Nr",), mean=np.array([0.4]), covariance=np.array([[1.0]])
    )
    found = identify(
        deep, [sailed(SHALLOW, seed=6)], method="regression", prior=prior, sensors=SENSORS
    )
    assert found.values == pytest.approx([0.7], abs=0.06)


# Predictions


@pytest.fixture(scope="module")
def references():
    records = [one_record(8), sailed(seed=9, rudder_deg=-10.0, switch_deg=10.0).with_(name="other")]
    return Smoothed.references(TANKER, records, sensors=SENSORS)


def test_the_true_model_predicts_best(references):
    true, poor = (Prediction.of(model, references, window=30.0) for model in (TANKER, SKEWED))
    for name, value in true.pooled().items():
        if name == "windows":
            assert value == poor.pooled()[name]
        else:
            assert value < 0.35 * poor.pooled()[name]
    identified = found_by("trajectory").model
    assert Prediction.of(identified, references, window=30.0).pooled()["heading"] < (
        1.5 * true.pooled()["heading"]
    )


def test_windows_are_the_same_for_all_models(references):
    for model in (TANKER, SKEWED):
        found = Prediction.of(model, references, window=20.0)
        for item in references:
            length = item.t[-1] - item.t[0]
            expected = int((length - 20.0) / 5.0 + 1e-9) + 1
            assert found.errors[item.name]["windows"] == expected


def test_the_reference_is_that_of_the_sensors_whatever_the_model():
    record = one_record(10)
    one, other = (
        Prediction.of(
            TANKER, Smoothed.references(model, [record], sensors=SENSORS), window=30.0
        ).pooled()
        for model in (TANKER, SKEWED)
    )
    poor = Prediction.of(
        SKEWED, Smoothed.references(SKEWED, [record], sensors=SENSORS), window=30.0
    ).pooled()
    for name in ("position", "heading"):
        assert abs(other[name] - one[name]) < 0.3 * poor[name]


def test_errors_are_those_between_two_simulations():
    """One window over the whole of a turn: the tracks of two models under the same rudder."""
    settings = {"speed": SPEED, "rudder_deg": 20.0, "duration": 40.0, "dt": 0.05}
    true = pk.simulate(TANKER, **settings)
    other = pk.simulate(SKEWED, revolutions=float(true.n[0]), **settings)
    record = one_record().with_(
        t=true.t,
        delta=true.delta,
        turns=true.n,
        measured={name: getattr(true, name) for name in ("x", "y", "psi", "u", "v", "r")},
    )
    fine = {"x": 1e-4, "y": 1e-4, "psi": 1e-5, "u": 1e-5, "v": 1e-5, "r": 1e-6}
    item = Smoothed.references(TANKER, [record], sensors=fine)
    errors = Prediction.of(SKEWED, item, window=float(true.t[-1])).errors["zigzag"]
    away = np.hypot(true.x - other.x, true.y - other.y)
    assert errors["windows"] == 1
    assert errors["position_end"] == pytest.approx(away[-1], rel=1e-2)
    assert errors["position"] == pytest.approx(np.sqrt(np.mean(away**2)), rel=1e-2)
    heading = np.degrees(true.psi - other.psi)
    assert errors["heading"] == pytest.approx(np.sqrt(np.mean(heading**2)), rel=1e-2)
    speed = np.hypot(true.u, true.v) - np.hypot(other.u, other.v)
    assert errors["speed"] == pytest.approx(np.sqrt(np.mean(speed**2)), rel=1e-2)
    rate = np.degrees(true.r - other.r)
    assert errors["yaw_rate"] == pytest.approx(np.sqrt(np.mean(rate**2)), rel=1e-2)


def test_errors_are_pooled_by_windows():
    one = {"position": 3.0, "windows": 1.0}
    other = {"position": 1.0, "windows": 7.0}
    found = Prediction(window=10.0, errors={"a": one, "b": other})
    assert found.pooled() == {"position": pytest.approx(np.sqrt(2.0)), "windows": 8.0}
    table = found.to_pandas()
    assert list(table.index) == ["a", "b", "all"]
    assert table.loc["all", "position"] == pytest.approx(np.sqrt(2.0))


def test_a_record_shorter_than_a_window_is_left_out(references):
    short = replace(references[0], name="short", t=references[0].t[:100])
    cut = short.record.cut(0.0, 9.95)
    short = replace(short, record=cut, motion={name: x[:100] for name, x in short.motion.items()})
    found = Prediction.of(TANKER, [references[0], short], window=30.0)
    assert set(found.errors) == {references[0].name}
    with pytest.raises(DataError, match="as long as a window of 30 s"):
        Prediction.of(TANKER, [short], window=30.0)


def test_the_prior_that_is_given_counts():
    tight = true_prior(NAMES, spread=1e-4)
    found = identify(SKEWED, [one_record()], NAMES, prior=tight, sensors=SENSORS)
    assert np.all(np.abs(found.values - TRUTH) < 5e-4 * np.abs(TRUTH))
