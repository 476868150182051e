"""Records over a near bottom: the model goes by the depth, or lacks what the bottom does."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import FreeRecord
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.hypotheses import candidates_for
from pmmkit.diagnosis.free_running.question import records_of
from pmmkit.identification import Prediction, Smoothed
from pmmkit.models import Model
from tests.support.free_tank.campaigns import Setup, write
from tests.support.recorded import recorded

SPEED = 7.0
SENSORS = {"x": 1.0, "y": 1.0, "psi": math.radians(0.1), "r": math.radians(0.01), "u": 0.03}
TANKER = pk.load_model("esso190k")
DEPTH = 1.6 * TANKER.ship.d
RUNS = (
    ("zigzag", {"rudder_deg": 20.0, "switch_deg": 20.0}),
    ("zigzag", {"rudder_deg": -10.0, "switch_deg": 10.0}),
    ("turning", {"rudder_deg": -20.0, "duration": 1000.0}),
)


def in_deep_water(model: Model) -> Model:
    """The tanker without the terms that van Berlekom and Goddard (1972) measured over a bottom."""
    part = model.parts["tanker_bis"]
    values = {name: 0.0 if name.endswith("z") else x for name, x in part.values.items()}
    deep = replace(part, values=MappingProxyType(values))
    return replace(model, parts=MappingProxyType({**model.parts, "tanker_bis": deep}))


def sailed(model: Model, depth: float | None, *, stated: float | None) -> list[FreeRecord]:
    rng = np.random.default_rng(0)
    found = []
    for number, (kind, asked) in enumerate(RUNS):
        track = pk.simulate(model, kind, speed=SPEED, dt=2.0, depth=depth, **asked)
        record = recorded(track, SENSORS, rng, name=f"run {number}", speed=SPEED, depth=stated)
        found.append(record.cut(0.0, 1000.0))
    return found


def test_it_is_asked_where_a_depth_is_stated_that_matters():
    deep = in_deep_water(TANKER)
    asked = {
        depth: "shallow_water"
        in {item.name for item in candidates_for(deep, sailed(deep, None, stated=depth))}
        for depth in (None, DEPTH, 20.0 * TANKER.ship.d)
    }
    assert asked == {None: False, DEPTH: True, 20.0 * TANKER.ship.d: False}


def test_a_stated_depth_speaks_for_the_bottom_before_any_record():
    """A model of deep water lacks what is there; one that feels the bottom may be right of it."""
    deep = in_deep_water(TANKER)
    offered = {x.name: x for x in candidates_for(deep, sailed(deep, None, stated=DEPTH))}
    assert offered["shallow_water"].price == 0.0
    assert {x.price for name, x in offered.items() if name != "shallow_water"} == {math.log(80.0)}
    felt = offered["shallow_water"].added_to(deep)
    again = {x.name: x for x in candidates_for(felt, sailed(deep, None, stated=DEPTH))}
    assert again["shallow_water"].price == math.log(80.0)


def test_a_model_that_feels_the_bottom_sails_records_at_their_depth():
    def error(depth: float | None) -> float:
        records = sailed(TANKER, DEPTH, stated=depth)
        found = Prediction.of(
            TANKER, Smoothed.references(TANKER, records, sensors=SENSORS), window=150.0
        )
        return found.pooled()["heading"]

    assert error(DEPTH) < 0.25 * error(None)


def test_the_depth_of_a_campaign_reaches_its_records(tmp_path):
    folder = write(Setup(ship="kvlcc2-l7", case="bottom", size=1.0, runs=3, seed=0), tmp_path)
    campaign = pk.open_campaign(folder)
    ship = pk.load_model("kvlcc2-l7")
    (first, *_) = records_of(campaign, ship)
    assert first.depth == campaign.water.depth == pytest.approx(2.5 * ship.ship.d, rel=1e-3)


@pytest.mark.slow
def test_the_bottom_that_a_tanker_was_measured_over_is_named():
    """Formulas of other authors for other ships: their growth is found at about its size."""
    deep = in_deep_water(TANKER)
    found = diagnose_free(deep, sailed(TANKER, DEPTH, stated=DEPTH), sensors=SENSORS, most=1)
    assert found.group == ((("shallow_water",), 1.0),)
    (finding,) = found.findings
    assert 0.5 < finding.coefficients["share"] < 1.3
    assert finding.error_after < 0.6 * finding.error_before
    better = found.model
    assert better.values("shallow_water")["share"] == pytest.approx(finding.coefficients["share"])


@pytest.mark.slow
def test_what_a_bottom_moves_beside_the_formulas_is_said_to_hold_at_its_depth(tmp_path):
    """Growth of another form in the tank: values fit as well, so that none is named."""
    setup = Setup(ship="s175", case="bottom", size=1.0, runs=3, seed=1)
    found = pk.diagnose(pk.load_model("s175"), pk.open_campaign(write(setup, tmp_path)))
    assert found.verdict == "refit"
    (note,) = [item for item in found.notes if "draughts deep" in item]
    assert "2.5 draughts" in note
    assert "values are those of this depth" in note
