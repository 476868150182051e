"""The measured heel of records: smoothed, taken over, and what it is worth."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pmmkit as pk
from pmmkit import Run
from pmmkit.base import DataError, ModelError
from pmmkit.campaigns import Settings
from pmmkit.conventions import parse_derivative
from pmmkit.effects import HULL
from pmmkit.identification import FreeRecord, Prediction, Prior, Smoothed, free_records, with_roll
from pmmkit.identification.from_run import measured_roll
from pmmkit.identification.trajectory import fit_trajectories
from pmmkit.models import load_model

ROLLING, UPRIGHT = load_model("s175"), load_model("s175-3dof")
HEEL_TERMS = {name: x for name, x in ROLLING.values(HULL).items() if parse_derivative(name).heels}
HEELED = UPRIGHT.with_values(HULL, **HEEL_TERMS)
NOISE = {"x": 0.3, "y": 0.3, "psi": math.radians(0.1), "u": 0.02, "v": 0.02}
NOISE |= {"r": math.radians(0.01), "phi": math.radians(0.1)}


def run_of(manoeuvre, *, speed=8.0, dt=1.0, **settings):
    """A simulated manoeuvre of the rolling ship as a run with noisy sensors."""
    track, draw = pk.simulate(ROLLING, manoeuvre, speed=speed, dt=dt, **settings), dice(5)
    columns = {name: getattr(track, name) for name in ("delta", "n")}
    columns |= {name: getattr(track, name) + draw(std, len(track.t)) for name, std in NOISE.items()}
    data = xr.Dataset({name: ("t", x) for name, x in columns.items()}, {"t": track.t})
    run = Run(
        id=manoeuvre,
        test=manoeuvre,
        kind="history",
        loader=lambda: data,
        settings=Settings(speed=speed),
    )
    return run, track


def dice(seed):
    draw = np.random.default_rng(seed)
    return lambda std, size: std * draw.normal(size=size)


@pytest.fixture(scope="module")
def records():
    """A turn and a zigzag at 8 m/s, for a model that does not roll."""
    runs = (run_of("turning", rudder_deg=20.0), run_of("zigzag", rudder_deg=10.0, switch_deg=10.0))
    return [record for run, _ in runs for record in free_records(run, UPRIGHT)]


# Noise


@pytest.mark.parametrize("period", [8.0, 33.0, 120.0])
def test_noise_falls_and_roll_stays_whatever_its_period(period):
    """No width is asked for: a slow roll is smoothed over longer times than a fast one."""
    t = np.arange(0.0, 400.0, 0.5)
    truth, rate = 0.1 * np.sin(2 * np.pi * t / period), 0.2 * np.pi / period
    noise = dice(1)(math.radians(0.1), len(t))
    roll, p, _ = measured_roll(t, truth + noise)
    inner = slice(20, -20)
    assert np.std((roll - truth)[inner]) < 0.75 * np.std(noise)
    errors = p - rate * np.cos(2 * np.pi * t / period)
    assert np.std(errors[inner]) < 0.12 * rate


def test_a_heel_without_noise_is_left_as_it_is():
    t = np.arange(0.0, 200.0, 0.5)
    truth = 0.1 * np.sin(0.2 * t)
    roll, p, pdot = measured_roll(t, truth)
    np.testing.assert_allclose(roll, truth, atol=2e-6)
    np.testing.assert_allclose(p, 0.02 * np.cos(0.2 * t), atol=2e-5)
    inner = slice(5, -5)
    np.testing.assert_allclose(pdot[inner], -0.004 * np.sin(0.2 * t)[inner], atol=2e-5)


def test_uneven_instants_give_the_same_roll():
    t = np.sort(np.random.default_rng(0).uniform(0.0, 200.0, 400))
    truth = 0.1 * np.sin(0.2 * t)
    roll, p, _ = measured_roll(t, truth + dice(1)(0.002, 400))
    inner = slice(15, -15)
    assert np.std((roll - truth)[inner]) < 0.002
    assert np.std((p - 0.02 * np.cos(0.2 * t))[inner]) < 0.002


def test_a_measured_roll_rate_is_taken_before_the_slope_of_the_heel():
    t = np.arange(0.0, 100.0, 0.5)
    _, p, pdot = measured_roll(t, np.zeros(len(t)), 0.02 * np.cos(0.2 * t))
    np.testing.assert_allclose(p, 0.02 * np.cos(0.2 * t), atol=1e-5)
    np.testing.assert_allclose(pdot, -0.004 * np.sin(0.2 * t), atol=1e-5)


# Records


def test_a_model_that_does_not_roll_is_given_the_measured_heel():
    run, track = run_of("turning", rudder_deg=20.0)
    (record,) = free_records(run, UPRIGHT)
    assert "phi" not in record.measured
    assert np.std(record.roll - track.phi) < 0.6 * NOISE["phi"]
    assert np.std(record.roll_rate - track.p) < 0.15 * np.std(track.p)
    columns = np.c_[record.roll, record.roll_rate, record.roll_acceleration]
    np.testing.assert_array_equal(record.inputs[:, -3:], columns)
    short = record.cut(20.0, 60.0)
    assert len(short.roll) == len(short.roll_rate) == len(short.roll_acceleration) == len(short)
    thinned = record.at(slice(None, None, 3))
    np.testing.assert_array_equal(thinned.inputs, record.inputs[::3])
    (left,) = free_records(run, UPRIGHT, roll=False)
    assert left.roll is left.roll_rate is left.roll_acceleration is None
    assert np.all(left.inputs[:, -3:] == 0.0)


def test_a_model_that_rolls_measures_by_the_heel():
    (record,) = free_records(run_of("turning", rudder_deg=20.0)[0], ROLLING)
    assert "phi" in record.measured
    assert record.roll is None


def test_a_heel_of_another_length_or_with_gaps_is_no_input(records):
    with pytest.raises(DataError, match="one length"):
        records[0].with_(roll=np.zeros(3))
    with pytest.raises(DataError, match="The heel of record"):
        records[0].with_(roll=np.full(len(records[0]), np.nan))


def test_gaps_of_the_heel_are_bridged():
    run, track = run_of("turning", rudder_deg=20.0)
    data = run.data.copy(deep=True)
    data["phi"].values[100:106] = np.nan
    (record,) = free_records(run.with_(loader=lambda: data), UPRIGHT)
    assert np.max(np.abs(record.roll - track.phi)) < math.radians(0.5)


def test_forces_of_a_record_know_the_heel(records):
    motion = Smoothed.of(UPRIGHT, records[1], size=0.03).implied_forces(UPRIGHT).motion
    np.testing.assert_array_equal(motion["phi"], records[1].roll)


@pytest.fixture(scope="module")
def campaign(shared_data):
    """Turns and zigzags of a rolling ship by another program."""
    return pk.open_campaign(shared_data / "free_hidden" / "f898966" / "campaign.toml")


@pytest.mark.slow
def test_the_heel_that_a_ship_lacks_is_told_by_windows(campaign):
    """Full scale, noise of 0.1° in the heading; the truth has heel and its terms."""
    chosen = [run for run in campaign.runs if run.id in ("turning_10_+20", "zigzag_7_+15")]
    found = [record for run in chosen for record in free_records(run, UPRIGHT)]
    for record in found:
        turned = np.unwrap(record.measured["psi"])
        r, step = record.measured["r"], np.diff(record.t)

        def missed(rate, turned=turned, step=step):
            integral = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * step))
            return np.degrees(np.std(turned - integral))

        assert missed(r * np.cos(record.roll)) < 0.14
    sensors = {name: std for name, std in NOISE.items() if name != "phi"}
    smoothed = Smoothed.references(UPRIGHT, found, sensors=sensors)
    before, after = (Prediction.of(model, smoothed).pooled() for model in (UPRIGHT, HEELED))
    assert after["heading"] < 0.13 < 1.0 < before["heading"]
    assert after["position"] < 0.6 < 2.0 < before["position"]


# Roll of its own


@pytest.mark.slow
def test_levers_that_fit_the_heel_of_records_give_that_of_other_turns(records):
    """S175 heels by the levers 0.026 L (hull), 0.031 L (added mass) and 0.033 L (rudder)."""
    made = with_roll(HEELED, records, GM=ROLLING.ship.GM, Ixx=ROLLING.ship.Ixx)
    assert made.rolls
    assert made.values(HULL)["Kv"] == pytest.approx(ROLLING.values(HULL)["Kv"], rel=0.2)
    assert made.values("added_mass")["lx"] == pytest.approx(0.0313, rel=0.15)
    for speed, angle in ((8.0, 35.0), (10.0, -25.0), (6.0, 15.0), (9.0, 30.0)):
        mine, truth = (
            pk.simulate(model, "turning", speed=speed, rudder_deg=angle).metrics
            for model in (made, ROLLING)
        )
        for name in ("heel_max_deg", "heel_steady_deg"):
            assert mine[name] == pytest.approx(truth[name], rel=0.15), (speed, angle, name)


def test_the_step_says_what_was_found_and_how_well(records):
    made = with_roll(HEELED, records[1:], GM=ROLLING.ship.GM, Ixx=ROLLING.ship.Ixx)
    assert "Effect roll added: damping = " in made.history[-1]
    assert "(rms)" in made.history[-1]
    assert {"roll", f"{HULL}.Kv"} <= set(made.steps[-1].before.absent)


def test_roll_asks_for_particulars_and_for_a_heel(records):
    with pytest.raises(ModelError, match="no GM and no Ixx"):
        with_roll(HEELED, records)
    with pytest.raises(ModelError, match=r"no Ixx.*\. State them: Ixx"):
        with_roll(replace(HEELED, ship=replace(HEELED.ship, GM=0.3)), records)
    bare = [record.with_(roll=None, roll_rate=None, roll_acceleration=None) for record in records]
    with pytest.raises(DataError, match="column phi"):
        with_roll(HEELED, bare, GM=0.3, Ixx=1.5e9)
    with pytest.raises(ModelError, match="rolls already"):
        with_roll(ROLLING, records)


@pytest.mark.slow
@pytest.mark.parametrize(("model", "largest"), [(ROLLING, 1e-3), (HEELED, 0.2)])
def test_a_trajectory_fit_sees_the_velocity_over_ground_of_a_heeled_ship(model, largest):
    """At 13° of heel sway lies 3 % off the level: the heading goes wrong by 0.5 without it.

    The ship that is only driven by the heel lacks the side force of the roll acceleration.
    """
    track = pk.simulate(ROLLING, "turning", speed=10.0, rudder_deg=20.0, dt=1.0)
    level, ahead, aside = track.v * np.cos(track.phi), np.cos(track.psi), np.sin(track.psi)
    measured = {name: getattr(track, name) for name in ("psi", "u", "v", "r")}
    measured |= {"xdot": track.u * ahead - level * aside, "ydot": track.u * aside + level * ahead}
    record = FreeRecord(
        name="turn",
        t=track.t,
        delta=track.delta,
        turns=track.n,
        measured=measured | ({"phi": track.phi} if model.rolls else {}),
        speed=10.0,
        roll=track.phi,
        roll_rate=track.p,
        roll_acceleration=np.gradient(track.p, track.t),
    )
    sensors = dict.fromkeys(measured, 0.01) | {"psi": 0.003, "phi": 0.003, "r": 1e-4}
    found = fit_trajectories(
        model, [record.cut(0.0, 250.0)], Prior.of(model, ["Yv"], 10.0, spread=0.1), sensors=sensors
    )
    assert found.rms["psi"] < largest
    assert not model.rolls or max(found.rms.values()) < largest
