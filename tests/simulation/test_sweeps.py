"""Sweeps: every point is a manoeuvre on its own, with the unit that its number has."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pmmkit import sweep
from pmmkit.base import DataError
from pmmkit.models import Part, load_model, save_model, scaled
from pmmkit.simulation import MANOEUVRES, froude_sweep, monte_carlo, simulate

CONTAINER = load_model("s175-3dof")
TANKER = load_model("kvlcc2-l7")
SPEED = 1.179


def same(found, i, alone):
    """The metrics of one point are those of a manoeuvre alone, bit for bit."""
    assert set(found.data_vars) == set(alone)
    for name, value in alone.items():
        np.testing.assert_array_equal(found[name].values[i], value, err_msg=name)


# Points


def test_a_sweep_of_the_rudder_is_a_turn_at_each_angle():
    angles = [-35.0, 10.0, 20.0, 35.0]
    found = sweep(CONTAINER, "rudder_deg", angles, speed=9.0)
    np.testing.assert_array_equal(found["rudder_deg"].values, angles)
    for i, angle in enumerate(angles):
        same(found, i, simulate(CONTAINER, rudder_deg=angle, speed=9.0).metrics)


def test_a_sweep_of_the_depth_is_a_turn_at_each_depth():
    shallow = CONTAINER.with_(
        parts={**CONTAINER.parts, "shallow_water": Part(effect="shallow_water", values={})}
    )
    depths = [85.0, 34.0, 17.0]
    found = sweep(shallow, "depth", depths, speed=6.0)
    for i, depth in enumerate(depths):
        same(found, i, simulate(shallow, depth=depth, speed=6.0).metrics)
    assert np.all(np.diff(found["tactical_diameter_L"].values) > 0)


@pytest.mark.parametrize(
    ("manoeuvre", "over", "values", "fixed"),
    [
        ("zigzag", "switch_deg", [5.0, 20.0], {"rudder_deg": 10.0}),
        ("zigzag", "rudder_rate_deg", [5.0, 30.0], {}),
        ("stopping", "turns", [-0.3, -0.7], {}),
        ("course_change", "heading_deg", [30.0, 90.0], {"rudder_deg": 15.0}),
        ("turning", "revolutions", [9.0, 12.0], {}),
    ],
)
def test_any_setting_can_be_swept(manoeuvre, over, values, fixed):
    found = sweep(TANKER, over, values, manoeuvre, speed=SPEED, **fixed)
    for i, value in enumerate(values):
        alone = simulate(TANKER, manoeuvre, speed=SPEED, **{**fixed, over: value}).metrics
        same(found, i, alone)
    assert found.attrs["manoeuvre"] == manoeuvre


def test_loading_conditions_are_swept_as_models():
    """Three metacentric heights of one ship: the more of it, the less heel and the wider a turn."""
    ship = load_model("s175")
    loaded = {f"GM {GM}": ship.with_(ship=replace(ship.ship, GM=GM)) for GM in (0.3, 0.6, 1.0)}
    found = sweep(loaded, "model", speed=9.0)
    assert found["model"].values.tolist() == list(loaded)
    for i, model in enumerate(loaded.values()):
        same(found, i, simulate(model, speed=9.0).metrics)
    assert np.all(np.diff(found["heel_max_deg"].values) < 0)
    assert np.all(np.diff(found["tactical_diameter_L"].values) > 0)


def test_models_may_be_names_and_files(tmp_path):
    path = tmp_path / "tanker.toml"
    save_model(TANKER, path)
    found = sweep({"library": "kvlcc2-l7", "file": path}, "model", speed=SPEED)
    assert found["advance"].values[0] == found["advance"].values[1]


def test_a_froude_sweep_is_a_manoeuvre_at_each_speed():
    speeds = [6.0, 9.0]
    found = froude_sweep(CONTAINER, speeds, "zigzag", rudder_deg=20.0, switch_deg=20.0)
    np.testing.assert_array_equal(found["speed"].values, speeds)
    np.testing.assert_allclose(found["Fn"].values, np.divide(speeds, math.sqrt(9.81 * 175.0)))
    for i, speed in enumerate(speeds):
        alone = simulate(CONTAINER, "zigzag", speed=speed, rudder_deg=20.0, switch_deg=20.0)
        same(found, i, alone.metrics)


def test_speeds_and_froude_numbers_say_the_same():
    numbers = [0.15, 0.25]
    speeds = [x * math.sqrt(9.81 * 175.0) for x in numbers]
    one, other = froude_sweep(CONTAINER, Fn=numbers), froude_sweep(CONTAINER, speeds)
    for name in one.data_vars:
        np.testing.assert_allclose(one[name].values, other[name].values, rtol=1e-7)


def test_a_ship_that_only_gathers_speed_needs_no_rudder():
    found = froude_sweep(TANKER, [0.8, 1.0], "accelerating")
    for i, speed in enumerate((0.8, 1.0)):
        same(found, i, simulate(TANKER, "accelerating", speed=speed).metrics)


# Intervals


def test_intervals_of_a_sweep_are_those_of_its_ships():
    many = {"n": 150, "spread": 0.03, "seed": 5}
    angles = [20.0, 35.0]
    found = sweep(TANKER, "rudder_deg", angles, speed=SPEED, **many)
    for i, angle in enumerate(angles):
        alone = monte_carlo(TANKER, speed=SPEED, rudder_deg=angle, **many)
        for name, nominal in alone.nominal.items():
            ends = found[f"{name}_low"].values[i], found[f"{name}_high"].values[i]
            assert ends == alone.interval(name)
            assert ends[0] < nominal < ends[1], name
            assert found[name].values[i] == pytest.approx(nominal, rel=1e-9)


def test_intervals_hold_95_of_100_ships():
    many = monte_carlo(TANKER, speed=SPEED, n=400, spread=0.03)
    low, high = many.interval("tactical_diameter_L")
    inside = np.mean(
        (many.metrics["tactical_diameter_L"] >= low) & (many.metrics["tactical_diameter_L"] <= high)
    )
    assert inside == pytest.approx(0.95, abs=0.005)


def test_intervals_widen_with_the_spread_of_the_derivatives():
    widths = []
    for spread in (0.01, 0.02):
        row = froude_sweep(TANKER, [SPEED], n=150, spread=spread)
        widths.append(float((row["advance_L_high"] - row["advance_L_low"])[0]))
    assert widths[1] == pytest.approx(2.0 * widths[0], rel=0.1)


@pytest.mark.slow
def test_intervals_are_those_of_the_conditions_swept():
    """The wind counts for the ships of the interval as for the ship alone."""
    windy = TANKER.with_(
        parts={**TANKER.parts, "wind": Part(effect="wind", values={"AF": 0.5, "AL": 1.5})}
    )
    found = sweep(
        windy, "wind_speed", [6.0], speed=SPEED, wind_direction_deg=90.0, n=60, spread=0.002
    )
    for name in ("transfer_L", "tactical_diameter_L"):
        low, here, high = (float(found[name + x][0]) for x in ("_low", "", "_high"))
        assert low < here < high
        assert not low < simulate(windy, speed=SPEED).metrics[name] < high


@pytest.mark.parametrize(
    "setting", [{"rudder_law": "lag", "rudder_lag": 0.5}, {"revolutions": 12.0}]
)
def test_a_sweep_with_intervals_takes_the_settings_of_one_without(setting):
    found = froude_sweep(TANKER, [SPEED], n=60, spread=0.002, **setting)
    low, here, high = (float(found["advance_L" + x][0]) for x in ("_low", "", "_high"))
    assert low < here < high


# Units

FROUDE = {"m": 1.0, "s": 0.5, "m/s": 0.5, "deg/s": -0.5, "deg": 0.0, "-": 0.0}
"""Power of the scale by which a quantity of each unit grows at one Froude number."""


@pytest.mark.slow
@pytest.mark.parametrize("manoeuvre", MANOEUVRES)
def test_units_of_the_metrics_are_those_by_which_they_scale(manoeuvre):
    """A ship 25 times the model: metres times 25, seconds times 5, angles the same (Froude)."""
    small, large = (
        sweep({"one": ship}, "model", manoeuvre=manoeuvre, speed=speed)
        for ship, speed in ((TANKER, SPEED), (scaled(TANKER, 175.0), 5.0 * SPEED))
    )
    assert set(small.data_vars) == set(large.data_vars)
    for name in small.data_vars:
        unit = small[name].attrs["units"]
        a, b = float(small[name][0]), float(large[name][0])
        if math.isnan(a):
            assert math.isnan(b), name
            continue
        power = 25.0 ** FROUDE[unit]
        assert b == pytest.approx(power * a, rel=1e-4, abs=1e-4 * power), (name, unit)


def test_units_of_what_is_swept():
    turned = sweep(CONTAINER, "rudder_deg", [35.0], speed=6.0)
    assert turned["rudder_deg"].attrs["units"] == "deg"
    faster = sweep(CONTAINER, "speed", [6.0])
    assert faster["speed"].attrs["units"] == "m/s"
    assert froude_sweep(CONTAINER, [6.0])["speed"].attrs["units"] == "m/s"
    many = froude_sweep(TANKER, [SPEED], n=10, spread=0.02)
    for end in ("low", "high"):
        assert many[f"advance_{end}"].attrs["units"] == "m"
        assert many[f"advance_L_{end}"].attrs["units"] == "-"


@pytest.mark.parametrize(
    ("over", "values", "unit"),
    [
        ("depth", [30.0], "m"),
        ("wind_speed", [5.0], "m/s"),
        ("wind_direction_deg", [5.0], "deg"),
        ("rudder_rate_deg", [3.0], "deg/s"),
        ("revolutions", [1.2], "1/s"),
        ("turns", [-0.5], "-"),
    ],
)
def test_units_of_other_settings(over, values, unit):
    manoeuvre = "stopping" if over == "turns" else "turning"
    found = sweep(CONTAINER, over, values, manoeuvre, speed=6.0)
    assert found[over].attrs["units"] == unit


# What is refused


def test_a_sweep_over_nothing_is_refused():
    with pytest.raises(DataError, match="values of rudder_deg"):
        sweep(CONTAINER, "rudder_deg", speed=6.0)
    with pytest.raises(DataError, match='over="model"'):
        sweep({"one": CONTAINER}, "rudder_deg", [10.0], speed=6.0)
    with pytest.raises(DataError, match='over="model"'):
        sweep({}, "model", speed=6.0)


def test_a_setting_that_there_is_not_is_refused():
    with pytest.raises((DataError, TypeError), match="rudder_angle"):
        sweep(CONTAINER, "rudder_angle", [10.0], speed=6.0)


def test_values_may_be_an_array():
    angles = np.array([20.0, 35.0])
    found = sweep(CONTAINER, "rudder_deg", angles, speed=6.0)
    np.testing.assert_array_equal(found["rudder_deg"].values, angles)
