"""Heel of measured turning circles."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.identification import evaluate_trials
from pmmkit.identification.trials.evaluate import heel_of_turn

SPEED = 9.0


def as_recorded(track, rng, *, listed=0.0, noise=0.1, roll=0.0):
    """Columns at 1 Hz from two minutes before the order: heel in degrees, with a list and waves."""
    t = np.arange(-120.0, math.floor(track.t[-1])) + 0.4
    inside = np.clip(t, 0.0, None)
    sailed = {name: np.interp(inside, track.t, getattr(track, name)) for name in ("x", "y", "psi")}
    sailed["x"] = np.where(t < 0, SPEED * t, sailed["x"])
    phi = np.where(t < 0, 0.0, np.interp(inside, track.t, track.phi))
    waves = roll * np.sin(2 * math.pi * t / 9.0)
    return {
        "t": t,
        **{name: x + 0.3 * rng.normal(size=len(t)) for name, x in sailed.items() if name != "psi"},
        "psi_deg": np.degrees(sailed["psi"]) % 360.0,
        "heel_deg": np.degrees(phi) + listed + waves + noise * rng.normal(size=len(t)),
        "delta_deg": np.degrees(np.where(t < 0, 0.0, np.interp(inside, track.t, track.delta))),
    }


def campaign(folder, columns, rudder):
    names = list(columns)
    rows = np.stack([columns[name] for name in names], axis=1)
    np.savetxt(folder / "T.csv", rows, delimiter=",", header=",".join(names), comments="")
    (folder / "campaign.toml").write_text(
        '[campaign]\ntitle = "Heel"\nkind = "free-running"\n[ship]\nname = "s175"\n[water]\n'
        f'depth = 200.0\n[[runs]]\nid = "T"\nfile = "T.csv"\ntest = "turning"\nspeed = {SPEED}\n'
        f"rudder_deg = {rudder}\n",
        encoding="utf-8",
    )
    return pk.open_campaign(folder)


@pytest.mark.parametrize("rudder", [35.0, -35.0])
def test_heel_of_a_turn_is_found_beside_a_list_and_noise(rudder, tmp_path):
    track = pk.simulate("s175", rudder_deg=rudder, speed=SPEED, dt=0.5)
    columns = as_recorded(track, np.random.default_rng(3), listed=1.5)
    (trial,) = evaluate_trials(campaign(tmp_path, columns, rudder))
    for name, wide in (("heel_max_deg", 4.0), ("heel_steady_deg", 4.0)):
        away = trial.metrics[name] - track.metrics[name]
        assert abs(away) < wide * trial.std[name] + 0.05
    assert "heels by 1.5° to starboard in the approach" in str(trial)
    assert "heel steady" in str(trial)


def test_a_long_average_takes_waves_off_the_steady_heel(tmp_path):
    track = pk.simulate("s175", rudder_deg=35.0, speed=SPEED, dt=0.5)
    columns = as_recorded(track, np.random.default_rng(4), roll=2.0)
    (trial,) = evaluate_trials(campaign(tmp_path, columns, 35.0))
    away = trial.metrics["heel_steady_deg"] - track.metrics["heel_steady_deg"]
    assert abs(away) < 3.0 * trial.std["heel_steady_deg"]
    # waves are part of what the ship heeled by
    assert trial.metrics["heel_max_deg"] > track.metrics["heel_max_deg"] + 0.5


def test_a_short_turn_has_no_steady_heel_and_one_without_heel_none():
    t = np.arange(-50.0, 100.0)
    psi = np.maximum(t, 0.0) * math.radians(2.0)
    phi = np.where(t < 0, 0.0, math.radians(-4.0) * np.sin(np.pi * np.clip(t / 20.0, 0.0, 1.0)))
    found = heel_of_turn(t, phi, psi, order=0.0, until=99.0, side=1.0, pace=20.0)
    assert math.isnan(found.steady)
    assert math.degrees(found.largest) == pytest.approx(4.0, abs=0.02)
    empty = np.full(len(t), np.nan)
    assert heel_of_turn(t, empty, psi, order=0.0, until=99.0, side=1.0, pace=20.0) is None
