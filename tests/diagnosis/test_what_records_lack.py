"""What records cannot be asked for is listed, with what would make it testable."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import FreeRecord
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.hypotheses import why_not_asked
from pmmkit.effects import CATALOGUE
from tests.support.recorded import recorded

SPEED = 1.179
SHIP = pk.load_model("kvlcc2-l7")
SENSORS = {"x": 0.02, "y": 0.02, "psi": math.radians(0.1), "r": math.radians(0.05), "u": 0.01}


def zigzag(angle: float = 20.0) -> FreeRecord:
    track = pk.simulate(SHIP, "zigzag", speed=SPEED, rudder_deg=angle, switch_deg=20.0, dt=0.5)
    return recorded(track, SENSORS, np.random.default_rng(0), name="zigzag", speed=SPEED)


def in_wind(record: FreeRecord) -> FreeRecord:
    still = np.zeros_like(record.t)
    return replace(record, wind_speed=still + 3.0, wind_direction=still)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    """Nothing is hidden in it, and few are asked."""
    records = [zigzag(), zigzag(-20.0)]
    return diagnose_free(SHIP, records, candidates=["asymmetry"], sensors=SENSORS, most=1)


def test_a_sensor_that_is_there_makes_the_wind_testable():
    record, wind = zigzag(), CATALOGUE["wind"]
    assert "log the wind" in why_not_asked(wind, SHIP, [record])
    assert why_not_asked(wind, SHIP, [in_wind(record)]) == ""
    assert "log the wind" in why_not_asked(wind, SHIP, [in_wind(record), record])


def test_a_depth_that_is_stated_makes_the_bottom_testable():
    record, bottom = zigzag(), CATALOGUE["shallow_water"]
    assert "state the depth" in why_not_asked(bottom, SHIP, [record])
    near = replace(record, depth=2.0 * SHIP.ship.d)
    assert why_not_asked(bottom, SHIP, [near]) == ""


def test_what_records_lack_stands_by_name_in_text_and_json(found):
    lacks = {item.name: item.why for item in found.not_testable if math.isinf(item.hides)}
    assert {"wind", "wave_drift", "shallow_water", "roll_damping", "heel_coupling"} <= set(lacks)
    text = " ".join(str(found).split())
    listed = {x["effect"]: x for x in json.loads(json.dumps(found.to_dict()))["not_testable"]}
    for name, why in lacks.items():
        assert why in text
        assert listed[name] == {"effect": name, "why": why, "size_that_could_hide": None}


def test_every_entry_of_the_catalogue_is_asked_or_told_why_not(found):
    """Who chooses the candidates leaves the rest out knowingly."""
    told = {x.name for x in found.covered} | set(found.not_asked)
    left = {x for x in CATALOGUE if why_not_asked(CATALOGUE[x], SHIP, [zigzag()]) == ""}
    assert told | left == set(CATALOGUE)
    assert not told & left - {"asymmetry"}
    assert not {x.name for x in found.covered} & set(found.not_asked)
    assert all(found.not_asked.values())


def test_an_engine_is_not_told_by_revolutions_alone(found):
    assert "log their order" in found.not_asked["shaft"]
    assert "captive tests" in found.not_asked["sinkage_trim"]
