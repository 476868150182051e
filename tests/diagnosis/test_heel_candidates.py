"""A heel that was measured is evidence, whether the model rolls or not."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit import FreeRecord
from pmmkit.conventions import parse_derivative
from pmmkit.diagnosis.free_running.hypotheses import candidates_for, excited
from pmmkit.effects import CATALOGUE, HULL, INERTIA
from pmmkit.identification import Binding
from pmmkit.models import load_model

UPRIGHT = load_model("s175-3dof")


def record(**inputs):
    t = np.arange(3.0)
    return FreeRecord(
        name="turn",
        t=t,
        delta=0.1 * t,
        turns=0.0 * t + 1.4,
        speed=9.0,
        measured={"psi": t},
        **inputs,
    )


HEELED, BARE = record(roll=np.zeros(3), roll_rate=np.zeros(3)), record()


def test_records_with_a_heel_hold_roll():
    assert "roll" in excited(UPRIGHT, [HEELED, HEELED])
    assert "roll" not in excited(UPRIGHT, [HEELED, BARE])
    assert "roll" not in excited(UPRIGHT, [])
    assert "roll" in excited(load_model("s175"), [BARE])


def test_heel_coupling_has_a_place_in_a_model_that_does_not_roll():
    found = {item.name: item for item in candidates_for(UPRIGHT, [HEELED])}
    assert "heel_coupling" not in {item.name for item in candidates_for(UPRIGHT, [BARE])}
    heel = found["heel_coupling"]
    made = heel.added_to(UPRIGHT)
    values = {**made.values(HULL), **made.values(INERTIA)}
    assert {name: values[name] for name in heel.values} == dict.fromkeys(heel.values, 0.0)
    binding = Binding.of(made, heel.values, 9.0)
    assert np.all(np.diff(binding.starts) == 1)
    assert not binding.equations.structure.rolls


def test_sailing_shows_more_of_heel_than_captive_tests():
    """Son and Nomoto (1981) give twelve derivatives of heel and roll rate that are not zero, and
    the added mass that couples roll to sway, which a ship that rolls has among her masses."""
    found = {item.name: item for item in candidates_for(UPRIGHT, [HEELED])}
    ship = load_model("s175")
    hull = {name for name, x in ship.values(HULL).items() if parse_derivative(name).heels and x}
    assert set(found["heel_coupling"].values) == hull | {"Ypdot"}
    assert ship.values(INERTIA)["Ypdot"] == pytest.approx(
        found["heel_coupling"].typical["Ypdot"], rel=0.01
    )
    rolling = {item.name: item for item in candidates_for(ship, [HEELED])}
    assert set(rolling["heel_coupling"].values) == hull
    assert len(CATALOGUE["heel_coupling"].coefficients) == 6


def test_the_damping_of_roll_needs_a_ship_that_rolls():
    stable = UPRIGHT.with_(ship=load_model("s175").ship)
    assert "roll_damping" not in {item.name for item in candidates_for(stable, [HEELED])}
    assert "roll_damping" in {item.name for item in candidates_for(load_model("s175"), [BARE])}
