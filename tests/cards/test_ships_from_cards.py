"""Ships from their cards: how far they are moved, what is foretold, what a card cannot tell.

Cards are those of library ships by their own models, which share no formula with the estimate, and
of trials that were published.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.actions import action
from pmmkit.cards import Card, read_card, ship_from_card

SPEEDS = {
    "kvlcc2": 7.97,
    "kcs": 12.35,
    "s175": 9.0,
    "esso-osaka-3m": 0.52,
    "esso190k": 8.23,
    "mariner": 7.7175,
    "bulk-carrier-170": 7.25,
}
TURN = {"advance_L", "transfer_L", "tactical_diameter_L"}


def known(card, **wanted):
    """A card with some measures to starboard, by manoeuvre; of zigzags those 10/10."""
    tests = []
    for test in card.tests:
        rudder = test.settings.get("rudder_deg", 0.0)
        kept = tuple(
            x for x in test.measures if x.name in wanted.get(test.manoeuvre, ()) and rudder >= 0.0
        )
        if kept and not (test.manoeuvre == "zigzag" and rudder != 10.0):
            tests.append(replace(test, measures=kept))
    return replace(card, tests=tuple(tests))


def with_std(card, std):
    """The same card with one standard deviation for all of its measures."""
    tests = (
        replace(test, measures=tuple(replace(item, std=std) for item in test.measures))
        for test in card.tests
    )
    return replace(card, tests=tuple(tests))


def moved(found):
    """Values after less before, over the standard deviation before."""
    table = found.values()
    return (table["value"] - table["before"]) / (table["std"] / table["std_over_before"])


@pytest.fixture(scope="module")
def kcs():
    return Card.of("kcs", SPEEDS["kcs"])


@pytest.fixture(scope="module")
def fitted(kcs):
    """KCS from a turn and a zigzag 10/10 to starboard."""
    return ship_from_card(known(kcs, turning=TURN, zigzag={"overshoot_1_deg", "overshoot_2_deg"}))


def test_the_ship_manoeuvres_as_on_the_card(fitted):
    turn = pk.simulate(fitted.model, "turning", rudder_deg=35, speed=SPEEDS["kcs"]).metrics
    own = pk.simulate("kcs", "turning", rudder_deg=35, speed=SPEEDS["kcs"]).metrics
    for name in TURN:
        assert turn[name] == pytest.approx(own[name], rel=0.04), name
    assert {round(abs(item.missed) / 2.0) for item in fitted.met} == {0}


def test_intervals_are_of_what_the_saved_model_says(fitted, tmp_path):
    pk.save_model(fitted.model, tmp_path / "model.toml")
    again = pk.load_model(tmp_path / "model.toml")
    many = pk.monte_carlo(again, "zigzag", rudder_deg=20, switch_deg=20, executes=3,
                          speed=SPEEDS["kcs"], n=200)  # fmt: skip
    item = next(
        x for x in fitted.foretold if x.words.startswith("zigzag 20/20, to starb")
        and x.name == "overshoot_1_deg"
    )  # fmt: skip
    assert many.interval("overshoot_1_deg") == pytest.approx((item.low, item.high), rel=1e-6)


@pytest.mark.slow
def test_a_certain_measure_is_met_and_a_vague_one_moves_nothing(kcs):
    card = known(kcs, turning={"advance_L"})
    sure, vague = (ship_from_card(with_std(card, std), ships=20) for std in (1e-3, 1e3))
    (measure,) = card.tests[0].measures
    turn = pk.simulate(sure.model, "turning", rudder_deg=35, speed=SPEEDS["kcs"])
    assert turn.metrics["advance_L"] == pytest.approx(measure.value, abs=2e-3)
    assert sure.told == pytest.approx(1.0, abs=1e-3), "one measure tells one thing"
    assert vague.told == pytest.approx(0.0, abs=1e-3)
    assert float(np.abs(moved(vague)).max()) < 1e-3
    assert len(vague.untold) == len(vague.names)


@pytest.mark.slow
def test_the_shortest_way_to_a_measure_is_along_covariance_times_slope(kcs):
    """Of one measure that is nearly met: dx = C g dy / (gᵀ C g), by slopes of the test's own."""
    card = known(kcs, turning={"tactical_diameter_L"})
    test = card.tests[0]
    start = ship_from_card(with_std(card, 1e3), ships=20).model

    def diameter(model):
        return pk.simulate(model, "turning", rudder_deg=35, speed=SPEEDS["kcs"]).metrics[
            "tactical_diameter_L"
        ]

    nearly = replace(test.measures[0], value=1.01 * diameter(start), std=1e-4)
    asked = replace(card, tests=(replace(test, measures=(nearly,)),))
    found = ship_from_card(asked, ships=20)
    ways = moved(found)
    shares = {}
    for name in ("Nr", "Nv", "Yv", "Nvvr"):
        value, std = start.values("hull_polynomial")[name], start.std[name][0]
        ends = [
            diameter(start.with_values("hull_polynomial", **{name: value + step * std}))
            for step in (-0.01, 0.01)
        ]
        shares[name] = (ends[1] - ends[0]) / 0.02
    for name, slope in shares.items():
        assert ways[name] / ways["Nr"] == pytest.approx(slope / shares["Nr"], rel=0.03), name


def test_nothing_is_known_worse_than_before(fitted):
    assert float(np.max(fitted.shrunk)) < 1.0 + 1e-9
    assert 3.0 < fitted.told < len(fitted.met)
    assert "Nvvr" not in fitted.untold
    assert "Xudot" in fitted.untold
    for item in fitted.foretold:
        if item.test.manoeuvre == "zigzag":
            assert item.high - item.low < 0.6 * (item.high_before - item.low_before), item.words


@pytest.mark.slow
def test_a_card_that_no_such_ship_has_names_what_is_missed(kcs):
    card = known(kcs, turning={"advance_L", "tactical_diameter_L"})
    test = card.tests[0]
    wide = tuple(
        replace(x, value={"advance_L": 2.2, "tactical_diameter_L": 9.0}[x.name], std=0.1)
        for x in test.measures
    )
    found = ship_from_card(replace(card, tests=(replace(test, measures=wide),)), ships=40)
    assert [item.card.name for item in found.missed] == ["tactical_diameter_L"]
    assert found.widened > 2.0
    assert float(np.max(found.shrunk)) < 1.0 + 1e-9, "doubt ends at what was known before"
    told = " ".join(found.warnings())
    assert "tactical diameter is 9.00 ± 0.20 L on the card; such a ship comes to" in told
    assert "contradict one another" in told


@pytest.mark.slow
def test_an_engine_that_nobody_states_is_part_of_the_tolerance_of_a_stop(kcs):
    card = known(kcs, stopping={"track_reach_L"})
    (measure,) = card.tests[0].measures
    free = ship_from_card(card, ships=20)
    stated = replace(card.tests[0], settings={"turns": -0.7, "reversal_s": 60.0})
    held = ship_from_card(replace(card, tests=(stated,)), ships=20)
    assert free.met[0].std > 2.0 * measure.std
    assert measure.std < held.met[0].std < 2.0 * measure.std, (
        "what is left is the thrust deduction astern"
    )
    assert "nobody states the engine" in str(free)
    assert "nobody states the engine" not in str(held)
    assert not [x for x in held.foretold if x.name == "track_reach_L"], "it is on the card"


@pytest.mark.slow
def test_a_model_of_tests_is_moved_by_a_card(kcs):
    card = known(kcs, turning=TURN)
    wide = with_std(card, 0.02)
    test = wide.tests[0]
    wider = tuple(replace(x, value=1.1 * x.value) for x in test.measures)
    asked = replace(wide, tests=(replace(test, measures=wider),))
    found = ship_from_card(asked, model="kcs", spread=0.2, ships=20)
    turn = pk.simulate(found.model, "turning", rudder_deg=35, speed=SPEEDS["kcs"])
    assert turn.metrics["tactical_diameter_L"] == pytest.approx(wider[2].value, rel=0.02)


def test_a_model_with_values_at_several_speeds_is_refused(kcs):
    slow = pk.with_effect(
        pk.load_model("kcs"), "froude_linear", coefficients="typical", Fn=(0.1, 0.2, 0.3)
    )
    with pytest.raises(pk.PmmkitError, match="one set for all"):
        ship_from_card(known(kcs, turning=TURN), model=slow, spread=0.1)


def test_the_completed_card_has_the_whole_poster_and_is_read_back(fitted, tmp_path):
    file = tmp_path / "card.toml"
    file.write_text(fitted.completed().text(), encoding="utf-8")
    back = read_card(file)
    assert len(back) == len(fitted.met) + len(fitted.foretold)
    words = [test.words for test in back.tests]
    assert len(set(words)) == len(words)


def held(name, card):
    """Share of the measures foretold, stops apart, whose intervals hold what the own model does."""
    full = Card.of(name, SPEEDS[name])
    truth = {(test.words, x.name): x.value for test in full.tests for x in test.measures}
    found = ship_from_card(card(full))
    judged = [
        item.low <= truth[item.test.words, item.name] <= item.high
        for item in found.foretold
        if item.test.manoeuvre != "stopping" and (item.test.words, item.name) in truth
    ]
    return sum(judged) / len(judged)


@pytest.mark.parametrize(
    "name", ["kvlcc2", *(pytest.param(x, marks=pytest.mark.slow) for x in SPEEDS if x != "kvlcc2")]
)
def test_intervals_hold_what_a_library_ship_does_besides_her_card(name):
    """Zigzags 20/20, initial turning and the other side, from a turn and a 10/10 zigzag."""

    def card(full):
        return known(full, turning=TURN, zigzag={"overshoot_1_deg", "overshoot_2_deg"})

    assert held(name, card) >= 0.85


@pytest.mark.slow
def test_the_bulk_carriers_turn_to_port_from_her_turn_to_starboard():
    """Trial of a 170 m bulk carrier in ballast (docs/bulk_carrier.md); nothing of it is fitted to
    but the turn to starboard."""
    ship = pk.load_model("bulk-carrier-170")
    bare = Card(ship=ship.ship, water=ship.water, speed=14.1 * 1852 / 3600, tests=())
    turn = next(x for x in Card.of(ship, bare.speed).tests if x.manoeuvre == "turning")
    trial = {"advance_L": 3.62, "transfer_L": 0.85, "tactical_diameter_L": 3.08}
    measures = tuple(
        replace(x, value=trial[x.name], std=0.05 * trial[x.name])
        for x in turn.measures
        if x.name in trial
    )
    found = ship_from_card(replace(bare, tests=(replace(turn, measures=measures),)))
    port = {x.name: x for x in found.foretold if x.words.startswith("turning 35°, to port")}
    for name, value in {"advance_L": 3.61, "tactical_diameter_L": 2.99}.items():
        assert port[name].low <= value <= port[name].high, name


@pytest.mark.slow
def test_hsvas_zigzags_20_10_from_those_10_10(tmp_path):
    """Overshoots of HSVA's free-running KVLCC2 at 1.179 m/s, from their report."""
    text = (
        '[card]\nspeed = "1.179 m/s"\n[ship]\nname = "KVLCC2 at HSVA"\nL = 7.0\nB = 1.2688\n'
        "d = 0.455\nvolume = 3.2724\nxG = 0.2436\n[water]\nrho = 1000.0\n"
        "[propeller]\nD = 0.204\nP_over_D = 0.808\narea_ratio = 0.448\nblades = 4\n"
        "[rudder]\narea_lateral = 0.0654\nrate_deg_s = 15.8\n"
        "[[zigzag]]\novershoot_1_deg = 9.69\novershoot_2_deg = 20.5\n"
        '[[zigzag]]\nside = "port"\novershoot_1_deg = 9.73\novershoot_2_deg = 17.8\n'
    )
    file = tmp_path / "card.toml"
    file.write_text(text, encoding="utf-8")
    found = ship_from_card(file)
    for rudder, angles in ((20.0, (11.7, 15.6, 12.4)), (-20.0, (12.0, 13.9))):
        many = pk.monte_carlo(found.model, "zigzag", speed=1.179, rudder_deg=rudder,
                              switch_deg=10, n=200)  # fmt: skip
        for number, angle in enumerate(angles, start=1):
            low, high = many.interval(f"overshoot_{number}_deg")
            assert low <= angle <= high, (rudder, number)
            assert high - low < 2.0 * angle


@pytest.mark.slow
def test_the_command_takes_a_person_from_an_empty_card_to_a_ship(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    do = action("card")
    asked = do.do(do.asked({"action": "form"}))
    file = tmp_path / asked.content["card"]
    text = file.read_text("utf-8").replace('speed = ""', 'speed = "15.5 kn"', 1)
    for key, value in {"L": 320, "B": 58, "d": 20.8, "CB": 0.81}.items():
        text = text.replace(f'\n{key} = ""', f"\n{key} = {value}")
    file.write_text(text.replace('advance = ""', 'advance = "5.1 cables"', 1), encoding="utf-8")
    made = do.do(do.asked({"action": "fit", "what": str(file), "ships": 20}))
    folder = tmp_path / made.content["out"]
    assert sorted(x.name for x in folder.iterdir()) == [
        "card.toml", "measures.csv", "measures.svg", "model.toml", "values.csv",
    ]  # fmt: skip
    (row,) = [x for x in made.content["measures"] if math.isfinite(x["card"])]
    assert row["card"] == pytest.approx(5.1 * 185.2 / 320.0)
    track = pk.simulate(folder / "model.toml", speed=15.5 * 1852 / 3600)
    assert track.metrics["advance_L"] == pytest.approx(row["value"], rel=1e-3)
