"""Conditions of MSC.137(76) and MSC/Circ.1053: the limits themselves, and both of their sides."""

from __future__ import annotations

import pytest

import pmmkit as pk
from pmmkit.identification.trials.evaluate import said
from pmmkit.imo import Condition, simulated_conditions
from pmmkit.imo.conditions import SIMULATED, beaufort
from pmmkit.models import Part
from pmmkit.simulation import Track
from pmmkit.views import form_of_model


@pytest.mark.parametrize(
    ("speed", "number"),
    [(0.2, 0), (0.3, 1), (7.9, 4), (8.0, 5), (10.7, 5), (10.8, 6), (17.2, 8), (32.6, 11), (33, 12)],
)
def test_beaufort_numbers_of_the_scale_of_the_world_meteorological_organization(speed, number):
    assert beaufort(speed) == number


@pytest.mark.parametrize(
    ("condition", "met"),
    [
        (Condition.of_length(100.0), True),
        (Condition.of_length(99.9), False),
        (Condition.of_depth(83.2 + 1e-6, 20.8), True),
        (Condition.of_depth(83.2, 20.8), False),
        (Condition.of_depth(None, 20.8), None),
        (Condition.of_depth(None, 20.8, deep=True), True),
        (Condition.of_wind(10.7), True),
        (Condition.of_wind(10.8), False),
        (Condition.of_wind(None, 5), True),
        (Condition.of_wind(None, 6), False),
        (Condition.of_wind(9.0, 6), True),
        (Condition.of_wind(None), None),
        (Condition.of_sea(4), True),
        (Condition.of_sea(5), False),
        (Condition.of_sea(None), None),
        (Condition.of_current(False, ""), False),
        (Condition.of_draught(20.8 * 0.95, 20.8), True),
        (Condition.of_draught(20.8 * 0.949, 20.8), False),
        (Condition.of_draught(20.8 * 1.051, 20.8), False),
        (Condition.of_draught(20.8, None), None),
        (Condition.of_approach(7.2, 8.0), True),
        (Condition.of_approach(7.19, 8.0), False),
        (Condition.of_approach(7.2, None), None),
        (Condition.of_rudder(-35.2), True),
        (Condition.of_rudder(30.0), None),
    ],
    ids=lambda x: x.name if hasattr(x, "name") else str(x),
)
def test_each_condition_at_its_limit(condition, met):
    assert condition.met is met
    if met is False:
        assert condition.words in said([condition])
    if met is None:
        assert said([condition]) == (
            f"Not shown of what the standard asks for: {condition.title}.",
        )
    if met:
        assert said([condition]) == ()


def test_a_stated_speed_of_the_engine_is_judged_and_no_longer_asked_for():
    slow, fast = (
        pk.imo_verdicts("esso190k", 8.0, n=0, full_speed=x, compiled=False)[0].conditions
        for x in (9.0, 8.8)
    )
    assert fast == ()
    assert "8 m/s, 89 %" in slow[0]


def test_an_unstated_sea_state_is_told_as_no_sentence():
    assert Condition.of_sea(None).words == ""


def test_verdicts_and_form_of_a_model_tell_the_same_conditions():
    model = pk.load_model("kvlcc2")
    full = 1.1 * model.ship.d
    verdicts = pk.imo_verdicts(
        model, 8.0, n=0, depth=40.0, full_speed=8.0, full_draught=full, compiled=False
    )
    stated = {"speed_85": 8.0, "full_load_draught": full}
    form = form_of_model(model, verdicts, speed=8.0, depth=40.0, stated=stated)
    missed = [item for item in form.conditions if item.met is False]
    assert [item.name for item in missed] == ["depth", "draught"]
    for verdict in verdicts:
        assert {item.words for item in missed} <= set(verdict.conditions)
        assert Track.NO_BOTTOM in verdict.conditions


def in_a_sea(height):
    """S175 with a sea of her own, whose table is a wall's."""
    part = Part(effect="wave_drift", values={"Hs": height, "from_deg": 0.0})
    model = pk.load_model("s175-3dof")
    return model.with_(parts={**model.parts, "wave_drift": part})


def test_a_sea_that_the_ship_sails_in_stands_in_the_form():
    """WMO 3700: 4.5 m is state 6, of which the standard permits 4; a ship with waves of her own
    was said to sail in none."""
    model = in_a_sea(4.5)
    found = {item.name: item for item in simulated_conditions(model, 8.0)}
    assert found["sea_state"].shown == "6, Hs 4.5 m, lever held"
    assert found["sea_state"].met is False
    verdicts = pk.imo_verdicts(model, 8.0, n=0, compiled=False)
    assert found["sea_state"].words in verdicts[0].conditions
    form = form_of_model(model, verdicts, speed=8.0)
    assert "6, Hs 4.5 m, lever held" in {item.shown for item in form.conditions}


def test_what_was_asked_of_the_simulation_stands_beside_the_standard():
    found = {
        item.name: item
        for item in simulated_conditions(
            in_a_sea(4.5), 8.0, wave_height=2.0, wind_speed=12.0, current_speed=0.5,
            revolutions="speed",
        )
    }  # fmt: skip
    assert found["sea_state"].shown == "4, Hs 2 m, speed held"
    assert found["sea_state"].met
    assert found["wind"].met is False
    assert found["current"].met is False
    calm = {item.name: item for item in simulated_conditions(pk.load_model("kvlcc2"), 8.0)}
    assert {calm[name].shown for name in ("wind", "sea_state", "current")} == {SIMULATED}
