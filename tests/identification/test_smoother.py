"""The smoother: motion, accelerations and the forces that a model lacks, where both are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_filters import FAST, LINER, SENSORS, SPEED, TANKER, sailed

import pmmkit as pk
from pmmkit import fit_to_forces
from pmmkit.base import DataError, SimulationError
from pmmkit.equations import prepare
from pmmkit.identification import Prior, Smoothed
from pmmkit.identification import smoother as smoother_module

LACKING = TANKER.with_values("hull_polynomial", Yvvv=0.0, Nvvr=0.0, Xuu=-0.012, Xvr=0.0)
"""The tanker with half its resistance and without three terms; the added mass is the same."""
UNIT = sailed(seed=0).force_units(TANKER)
SETTLED = 30
"""Instants at each end in which a smoother leans on its start values."""


def true_motion(model=TANKER, manoeuvre="zigzag", *, speed=SPEED, dt=0.1, **settings):
    """States, accelerations and controls of the simulation that `sailed` adds noise to."""
    if manoeuvre == "zigzag":
        settings = {"rudder_deg": 20.0, "switch_deg": 20.0, **settings}
    track = pk.simulate(model, manoeuvre, speed=speed, dt=dt, **settings)
    ready = prepare(model, speed)
    motion = {name: getattr(track, name) for name in ("psi", "u", "v", "r", "delta", "n")}
    if model.rolls:
        motion |= {"p": track.p, "phi": track.phi}
    rates = np.array(
        [
            ready.accelerations(
                *(float(motion[x][i]) if x in motion else 0.0 for x in ("u", "v", "r", "p", "phi")),
                delta=float(motion["delta"][i]),
                n=float(motion["n"][i]),
            )
            for i in range(len(track))
        ]
    )
    motion |= dict(zip(("udot", "vdot", "rdot", "pdot"), rates.T, strict=True))
    return track, motion


def lacked(truth, wrong, motion, speed=SPEED):
    """Forces of one model less those of another, along a motion."""
    one, other = (
        ready.water_forces(motion) for ready in (prepare(truth, speed), prepare(wrong, speed))
    )
    return {channel: one[channel] - other[channel] for channel in one}


@pytest.mark.parametrize("seed", [0, 1])
def test_the_forces_that_a_model_lacks_are_found_within_their_intervals(seed):
    _, motion = true_motion()
    expected = lacked(TANKER, LACKING, motion)
    found = Smoothed.of(LACKING, sailed(seed=seed), sensors=SENSORS)
    errors = []
    for channel in ("X", "Y", "N"):
        true = expected[channel]
        error = (found.residual[channel] - true)[SETTLED:-SETTLED]
        assert np.std(error) < 0.45 * np.std(true)
        errors.append(error / found.residual_std[channel][SETTLED:-SETTLED])
    inside = np.abs(np.array(errors)) < 1.96
    assert 0.85 < np.mean(inside) <= 1.0


def test_a_constant_force_is_found():
    """A ship that a steady push to port turns off its course, smoothed without knowing of it."""
    pushed = TANKER.with_values("hull_polynomial", Y0=-0.01, N0=0.002)
    found = Smoothed.of(TANKER, sailed(pushed, seed=2), sensors=SENSORS)
    middle = slice(200, -200)
    _, motion = true_motion(pushed)
    expected = lacked(pushed, TANKER, motion)
    for channel in ("Y", "N"):
        true = expected[channel][middle]
        assert np.mean(found.residual[channel][middle]) == pytest.approx(np.mean(true), rel=0.15)
    unit = 0.5 * 1000.0 * 7.0 * 0.46
    speeds = motion["u"] ** 2 + motion["v"] ** 2
    assert expected["Y"] == pytest.approx(-0.01 * unit * speeds, rel=1e-2)


def test_a_true_model_lacks_nothing():
    found = Smoothed.of(TANKER, sailed(seed=3), sensors=SENSORS)
    assert found.size == min(smoother_module.SIZES)
    for channel, force in found.residual.items():
        assert np.max(np.abs(force)) < 2e-3 * UNIT[channel]
    assert Smoothed.of(LACKING, sailed(seed=3), sensors=SENSORS).size > 10 * found.size


def test_motion_and_accelerations_are_near_the_true_ones():
    track, motion = true_motion()
    record = sailed(seed=4)
    found = Smoothed.of(LACKING, record, sensors=SENSORS)
    inner = slice(SETTLED, -SETTLED)
    for name in ("x", "y", "psi", "u", "r"):
        error = (found.motion[name] - getattr(track, name))[inner]
        noise = (record.measured[name] - getattr(track, name))[inner]
        assert np.std(error) < 0.5 * np.std(noise)
        assert np.mean(np.abs(error) < 1.96 * found.motion_std[name][inner]) > 0.8
    for name in ("udot", "vdot", "rdot"):
        error = (found.motion[name] - motion[name])[inner]
        assert np.std(error) < 0.15 * np.std(motion[name][inner])


def test_accelerations_are_the_slopes_of_the_velocities():
    found = Smoothed.of(TANKER, sailed(seed=4), sensors=SENSORS)
    for name in ("u", "v", "r"):
        slope = np.gradient(found.motion[name], found.t)
        error = (found.motion[f"{name}dot"] - slope)[SETTLED:-SETTLED]
        assert np.std(error) < 0.1 * np.std(slope)


def test_positions_and_heading_alone_are_enough():
    track, motion = true_motion()
    sensors = {name: SENSORS[name] for name in ("x", "y", "psi")}
    found = Smoothed.of(LACKING, sailed(seed=5, sensors=sensors), sensors=sensors)
    inner = slice(SETTLED, -SETTLED)
    for name in ("u", "v", "r"):
        error = (found.motion[name] - getattr(track, name))[inner]
        assert np.std(error) < 0.1 * np.std(getattr(track, name))
        assert np.mean(np.abs(error) < 1.96 * found.motion_std[name][inner]) > 0.8
    expected = lacked(TANKER, LACKING, motion)["Y"][inner]
    assert np.corrcoef(found.residual["Y"][inner], expected)[0, 1] > 0.9


def test_a_gap_widens_the_intervals_and_still_holds_the_truth():
    track, _ = true_motion()
    record = sailed(seed=6)
    gaps = {name: values.copy() for name, values in record.measured.items()}
    for values in gaps.values():
        values[500:700] = np.nan
    full, gappy = (
        Smoothed.of(LACKING, item, sensors=SENSORS, size=0.03)
        for item in (record, record.with_(measured=gaps))
    )
    for name in ("x", "y", "psi"):
        assert gappy.motion_std[name][600] > 3.0 * full.motion_std[name][600]
        error = np.abs(gappy.motion[name] - getattr(track, name))[500:700]
        assert np.all(error < 4.0 * gappy.motion_std[name][500:700])
    assert gappy.residual_std["Y"][600] > 1.5 * full.residual_std["Y"][600]
    assert gappy.residual_std["Y"][600] < 1.001 * 0.03 * UNIT["Y"]
    assert gappy.motion_std["x"][100] == pytest.approx(full.motion_std["x"][100], rel=1e-6)


def test_instants_that_are_missing_are_those_at_which_nothing_was_measured():
    """A gap of 12 ship lengths in a straight run, without its rows and with empty ones: a force
    forgets in either, and the noise of the whole gap is not that of one step over it."""
    record = sailed(seed=6)
    there = np.ones(len(record), bool)
    there[500:700] = False
    empty = {name: np.where(there, values, np.nan) for name, values in record.measured.items()}
    held = {
        name: np.interp(record.t, record.t[there], getattr(record, name)[there])
        for name in ("delta", "turns")
    }
    whole, cut = (
        Smoothed.of(LACKING, item, sensors=SENSORS, size=0.03)
        for item in (record.with_(measured=empty, **held), record.at(there))
    )
    for one, other in (
        (whole.motion, cut.motion),
        (whole.motion_std, cut.motion_std),
        (whole.residual_std, cut.residual_std),
    ):
        for name, values in other.items():
            if name.endswith("dot"):
                continue
            np.testing.assert_allclose(
                values, one[name][there], rtol=0.01, atol=0.01 * np.std(one[name])
            )


def test_without_news_a_force_is_forgotten():
    """After the last measurement the spread returns to that of the process, the force to zero."""
    record = sailed(seed=6)
    gaps = {name: values.copy() for name, values in record.measured.items()}
    for values in gaps.values():
        values[400:] = np.nan
    found = Smoothed.of(LACKING, record.with_(measured=gaps), sensors=SENSORS, size=0.03)
    assert found.residual_std["N"][-1] == pytest.approx(0.03 * UNIT["N"], rel=1e-3)
    last, memory = found.residual["N"][399], 7.0 / SPEED
    later = found.t - found.t[399]
    faded = last * np.exp(-later[399:] / memory)
    np.testing.assert_allclose(found.residual["N"][399:], faded, atol=1e-6 * abs(last))


def test_wild_values_are_not_taken_in():
    record = sailed(seed=7)
    wild = {name: values.copy() for name, values in record.measured.items()}
    for name in ("x", "psi"):
        wild[name][300::100] += 50.0 * SENSORS[name]
    count = 2 * len(wild["x"][300::100])
    clean, found = (
        Smoothed.of(LACKING, item, sensors=SENSORS, size=0.03)
        for item in (record, record.with_(measured=wild))
    )
    assert (clean.gated, found.gated) == (0, count)
    assert np.max(np.abs(found.motion["x"] - clean.motion["x"])) < 2.0 * SENSORS["x"]


@pytest.mark.slow
def test_a_rolling_ship_has_a_moment_of_roll_too():
    wrong = LINER.with_values("hull_polynomial", Kv=0.0)
    settings = {"speed": 9.0, "dt": 0.5}
    _, motion = true_motion(LINER, **settings)
    expected = lacked(LINER, wrong, motion, 9.0)["K"]
    record = sailed(LINER, sensors=FAST, seed=8, **settings)
    found = Smoothed.of(wrong, record, sensors=FAST)
    assert set(found.residual) == {"X", "Y", "N", "K"}
    error = (found.residual["K"] - expected)[SETTLED:-SETTLED]
    assert np.std(error) < 0.3 * np.std(expected)
    assert np.mean(np.abs(error) < 1.96 * found.residual_std["K"][SETTLED:-SETTLED]) > 0.8


def test_implied_forces_are_those_of_the_true_model_along_the_true_motion():
    _, motion = true_motion()
    ready = prepare(TANKER, SPEED)
    expected = ready.water_forces(motion)
    record = sailed(seed=9)
    forces = Smoothed.of(LACKING, record, sensors=SENSORS).implied_forces(LACKING)
    for channel in ("X", "Y", "N"):
        error = (forces.forces[channel] - expected[channel])[SETTLED:-SETTLED]
        assert np.std(error) < 0.15 * np.std(expected[channel])
    assert forces.correlated == round(2.0 * (7.0 / SPEED) / 0.1)
    np.testing.assert_array_equal(forces.motion["delta"], record.delta)


def test_what_a_model_lacks_is_fitted_to_implied_forces():
    names = ("Yvvv", "Nvvr", "Nv", "Nr")
    start = TANKER.with_values("hull_polynomial", Yvvv=-0.8, Nvvr=-0.1, Nv=-0.11, Nr=-0.06)
    truth = Prior.of(TANKER, names, SPEED).mean
    forces = [
        Smoothed.of(start, sailed(seed=seed), sensors=SENSORS).implied_forces(start)
        for seed in (0, 1)
    ]
    prior = Prior.of(start, names, SPEED, spread=0.5)
    found = fit_to_forces(start, forces, names, prior=prior)
    assert found.values[2:] == pytest.approx(truth[2:], rel=0.05)
    assert np.all(np.abs(found.values - truth) < 4.0 * found.std)
    assert np.all(np.abs(found.values - truth) < 0.5 * np.abs(prior.mean - truth))


def test_what_cannot_be_smoothed_is_refused(monkeypatch):
    record = sailed(seed=10)
    monkeypatch.setattr(smoother_module, "ROOM", 1e5)
    with pytest.raises(DataError, match="every second instant"):
        Smoothed.of(TANKER, record, sensors=SENSORS)
    monkeypatch.undo()
    unstable = TANKER.with_values("hull_polynomial", Xuu=50.0)
    with pytest.raises(SimulationError, match="loses the motion"):
        Smoothed.of(unstable, record.only(["psi"]), sensors=SENSORS, size=1e-4)
    assert math.isfinite(Smoothed.of(TANKER, record, sensors=SENSORS, size=1e-3).log_likelihood)
