"""What a number stands on goes with it: estimated parts and extrapolated speeds settle nothing."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.imo import imo_turning, metrics_of
from pmmkit.models import Standing, with_part_of
from pmmkit.models.estimates import COUPLINGS
from pmmkit.models.particulars import parts_from_particulars

SHIP = pk.load_model("s175-3dof")


def with_parts(propeller, rudder):
    """The ship's hull with parts as somebody states them, the rest estimated."""
    screw, blade = parts_from_particulars(SHIP.ship, propeller, rudder)
    return SHIP.with_(parts={**SHIP.parts, "propeller": screw, "rudder_mmg": blade})


@pytest.fixture(scope="module")
def guessed():
    return with_parts({}, {})


def test_a_ship_of_the_library_stands_on_what_was_published():
    assert Standing.of(SHIP, 9.0).unsettled == ()
    assert [item.words for item in imo_turning(pk.simulate(SHIP, speed=9.0))] == ["met", "met"]


def test_a_guessed_propeller_and_rudder_are_no_ground_for_a_verdict(guessed):
    """Before, such a turn was "NOT met" and the ship's own parts turn within the limits."""
    track = pk.simulate(guessed, speed=9.0)
    (said,) = track.standing.unsettled
    assert said.startswith("Propulsion and steering are estimates")
    assert said in track.standing.sentences
    for item in imo_turning(track):
        assert (item.passed, item.words) == (None, "not settled")
        assert said in item.conditions
    assert metrics_of(track)["standing"]["estimated"] == ["propulsion", "steering"]


def test_it_has_its_probability_all_the_same(guessed):
    found = pk.imo_verdicts(guessed, 9.0, n=40, spread=0.05)
    drawn = [item for item in found if item.side]
    assert all(item.words == "not settled" for item in found if item.unsettled)
    assert all(0.0 <= item.probability <= 1.0 for item in drawn)
    assert all(item.unsettled for item in drawn)


def test_one_estimated_part_is_named_alone():
    values = SHIP.parts["propeller"].values
    stated = with_parts({name: float(x) for name, x in values.items() if name != "J"}, {})
    assert Standing.of(stated, 9.0).estimated == ("steering",)
    assert Standing.of(stated, 9.0).unsettled[0].startswith("Steering is an estimate")


def test_a_turn_beyond_the_tests_says_so_wherever_it_is_told(tmp_path, capsys):
    """At 1.4 times the highest speed of a model that was tested at two."""
    slow, fast = (SHIP.ship.froude(speed, SHIP.water.g) for speed in (7.0, 9.0))
    hull = SHIP.parts["hull_polynomial"]
    many = {name: (float(x), float(x)) for name, x in hull.values.items()}
    model = SHIP.with_(Fn=(slow, fast)).with_values("hull_polynomial", **many)
    track = pk.simulate(model, speed=1.4 * 9.0, extrapolate=True)
    assert track.standing.outside == pytest.approx(0.4)
    assert any("40 % above what was tested" in text for text in track.standing.sentences)
    assert {item.words for item in imo_turning(track)} == {"not settled"}
    pk.save_model(model, tmp_path / "model.toml")
    command = ["simulate", str(tmp_path / "model.toml"), "--speed", "12.6", "--extrapolate"]
    assert main([*command, "--no-figures", "--out", str(tmp_path / "out")]) == 0
    assert "40 % above what was tested" in capsys.readouterr().out
    kept = json.loads((tmp_path / "out" / "metrics.json").read_text())
    assert kept["standing"]["outside"] == pytest.approx(0.4)
    assert kept["imo"][0]["passed"] is None
    inside = pk.simulate(model, speed=9.0)
    assert inside.standing.unsettled == ()


def test_a_hull_without_couplings_is_no_ground_for_a_verdict_on_turns():
    """4.4 L with her couplings; 3.3 L and "met" where a structure did not ask for them."""
    hull = SHIP.parts["hull_polynomial"].values
    coupled = ("Yvvr", "Yvrr", "Nvvr", "Nvrr")
    part = replace(
        SHIP.parts["hull_polynomial"],
        values={name: x for name, x in hull.items() if name not in coupled},
    )
    bare = SHIP.with_(parts={**SHIP.parts, "hull_polynomial": part})
    track = pk.simulate(bare, speed=9.0)
    whole = pk.simulate(SHIP, speed=9.0)
    assert track.metrics["tactical_diameter_L"] < 0.85 * whole.metrics["tactical_diameter_L"]
    assert any("no term of sway and yaw together" in text for text in track.standing.sentences)
    assert {item.words for item in imo_turning(track)} == {"not settled"}
    assert not any(Standing.of(pk.load_model(name), 3.0).uncoupled for name in pk.ships())


def test_estimated_couplings_of_a_measured_hull_are_no_ground_either():
    hull = SHIP.parts["hull_polynomial"]
    empirical = dict.fromkeys(COUPLINGS, "empirical: somebody's formula")
    part = replace(hull, sources={**hull.sources, **empirical})
    model = SHIP.with_(parts={**SHIP.parts, "hull_polynomial": part})
    found = Standing.of(model, 9.0)
    assert (found.coupled, found.uncoupled, found.hull) == (True, False, False)
    (said,) = found.unsettled
    assert said.startswith("The terms of sway and yaw together")
    one = replace(hull, sources={**hull.sources, "Yvvr": "empirical: somebody's formula"})
    assert not Standing.of(SHIP.with_(parts={**SHIP.parts, "hull_polynomial": one}), 9.0).coupled


def test_drawings_and_open_water_of_the_same_ship_do_not_vary():
    """A part of another ship is uncertain in all; of the same hull only in what a hull decides."""
    own = with_part_of(SHIP, "propeller", pk.scaled(SHIP, 4.0)).parts["propeller"]
    other = with_part_of(SHIP, "propeller", pk.load_model("kvlcc2")).parts["propeller"]
    assert set(own.std) == {"t", "wp", "tau"}
    assert set(other.std) == {"t", "wp", "D", "kt0", "kt1", "C2_positive", "C2_negative"}
    again = with_part_of(SHIP, "propeller", SHIP.with_(ship=replace(SHIP.ship, B=30.0)))
    assert own.std["wp"] < 0.5 * again.parts["propeller"].std["wp"]
    blade = with_part_of(SHIP, "rudder", pk.scaled(SHIP, 4.0)).parts["rudder_mmg"]
    assert "area" not in blade.std
    assert {"aH", "gamma", "cRr"} <= set(blade.std)


@given(
    low=st.floats(0.05, 0.3),
    span=st.floats(0.0, 0.2),
    share=st.floats(-0.5, 1.0),
    at=st.floats(0, 1),
)
def test_a_speed_between_is_inside_and_one_beyond_is_out_by_its_share(low, span, share, at):
    tested = (low, low + span)
    assert Standing(Fn=low + at * span, tested=tested).outside == 0.0
    end = tested[1] if share > 0.0 else tested[0]
    found = Standing(Fn=end * (1.0 + share), tested=tested).outside
    if share > 0.021 or share < -0.021:
        assert found == pytest.approx(share)
    elif -0.019 < share < 0.019:
        assert found == 0.0


def test_what_a_track_stands_on_is_told_once():
    track = pk.simulate("kvlcc2", "stopping", speed=7.97, compiled=False)
    assert track.standing.remarks
    assert not set(track.standing.sentences) & set(track.notes)
    assert all(str(track).count(text) == 1 for text in track.standing.sentences)
