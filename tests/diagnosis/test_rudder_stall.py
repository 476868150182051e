"""The stall of a rudder: asked of records as that rudder's own option, put in and taken out."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import pytest

import pmmkit as pk
from pmmkit.base import ModelError, UnknownNameError
from pmmkit.diagnosis import undone
from pmmkit.diagnosis.findings import Finding
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.hypotheses import FreeCandidate, candidates_for
from pmmkit.identification import Prior
from pmmkit.models import Model, load_model, model_text, save_model
from tests.support.zigzags import SENSORS, SHIP, SPEED, sailed

BEGIN = 15.0
RUNS = ((30.0, 20.0), (-35.0, 10.0))
FOUND = Finding(
    effect="rudder_stall",
    family="rudder",
    kind="physics",
    summary="",
    coefficients={"stall_loss": 0.3, "stall_deg": 3.0},
    std={"stall_loss": 0.01, "stall_deg": 0.2},
    typical={"stall_loss": 0.4, "stall_deg": 5.0},
    value=0.0,
    parameter="",
    log_odds=50.0,
    rivals=(),
    separating_test="",
    beside=True,
    error_before=1.0,
    error_after=0.1,
    errors={},
)


def stalling(model: Model, form: str, degrees: float, loss: float) -> Model:
    """The ship with a rudder that stalls."""
    part = model.parts["rudder_mmg"]
    part = replace(
        part,
        options=MappingProxyType({**part.options, "stall": form}),
        values=MappingProxyType({**part.values, "stall_deg": degrees, "stall_loss": loss}),
    )
    return replace(model, parts=MappingProxyType({**model.parts, "rudder_mmg": part}))


def candidate(model: Model) -> FreeCandidate:
    (found,) = (x for x in candidates_for(model, []) if x.name == "rudder_stall")
    return found


def track(model: Model):
    return pk.simulate(model, "turning", rudder_deg=35.0, speed=SPEED, dt=0.5, duration=40.0)


def test_a_rudder_behind_the_propeller_stalls_by_its_own_option():
    item = candidate(SHIP)
    assert item.values == ("rudder_mmg.stall_loss", "rudder_mmg.stall_deg")
    part = item.added_to(SHIP).parts["rudder_mmg"]
    assert part.options["stall"] == "linear"
    assert (part.values["stall_deg"], part.values["stall_loss"]) == (BEGIN, 0.0)


def test_a_stall_that_loses_nothing_leaves_the_ship_as_she_sails():
    assert (track(candidate(SHIP).added_to(SHIP)).psi == track(SHIP).psi).all()


def test_a_rudder_that_stalls_already_keeps_its_form_and_values():
    known = stalling(SHIP, "smooth", 22.0, 0.2)
    assert model_text(candidate(known).added_to(known)) == model_text(known)
    better = pk.with_effect(known, FOUND)
    assert better.values("rudder_mmg")["stall_deg"] == pytest.approx(25.0)
    assert better.parts["rudder_mmg"].options["stall"] == "smooth"


def test_values_that_no_option_used_do_not_act_at_once():
    """A part may hold numbers of a stall that its option does not use."""
    idle = stalling(SHIP, "none", 10.0, 0.9)
    assert (track(candidate(idle).added_to(idle)).psi == track(SHIP).psi).all()
    back, _ = undone(pk.with_effect(idle, FOUND))
    assert model_text(back) == model_text(idle)


def test_a_rudder_of_derivatives_stalls_by_its_cubes():
    assert set(candidate(load_model("mariner")).values) == {"Yddd", "Nddd"}


@pytest.mark.parametrize("name", ["kvlcc2-l7", "s175"])
def test_a_stall_is_put_in_and_taken_out_to_the_bit(name, tmp_path):
    ship = load_model(name)
    save_model(pk.with_effect(ship, FOUND), tmp_path / "better.toml")
    better = load_model(tmp_path / "better.toml")
    values = better.values("rudder_mmg")
    assert (values["stall_deg"], values["stall_loss"]) == (BEGIN + 3.0, 0.3)
    assert better.parts["rudder_mmg"].options["stall"] == "linear"
    back, effect = undone(better)
    assert effect == "rudder_stall"
    assert model_text(back) == model_text(ship)
    without = pk.without_effect(better, "rudder_stall")
    assert model_text(without.with_(steps=ship.steps)) == model_text(ship)


@pytest.mark.parametrize("name", ["kvlcc2-l7", "s175"])
def test_by_name_it_is_what_the_diagnosis_adds(name):
    ship = load_model(name)
    named = pk.with_effect(ship, "rudder_stall")
    part, added = named.parts["rudder_mmg"], candidate(ship).added_to(ship).parts["rudder_mmg"]
    assert (part.values, part.options) == (added.values, added.options)
    assert named.parts["hull_polynomial"] == ship.parts["hull_polynomial"]
    usual = pk.with_effect(ship, "rudder_stall", coefficients="typical").values("rudder_mmg")
    assert (usual["stall_loss"], usual["stall_deg"]) == (0.4, BEGIN + 5.0)
    stated = pk.with_effect(ship, "rudder_stall", coefficients={"stall_loss": 0.2})
    assert stated.values("rudder_mmg")["stall_loss"] == 0.2
    for made in (named, stated):
        back = pk.without_effect(made, "rudder_stall")
        assert model_text(back.with_(steps=ship.steps)) == model_text(ship)


def test_by_name_derivatives_stay_what_they_are():
    """As captive tests find them, and as a rudder of derivatives has them."""
    cubes = {"Yddd": 0.0045, "Nddd": -0.0022}
    made = pk.with_effect(SHIP, "rudder_stall", coefficients=cubes)
    assert {"Yddd", "Nddd"} <= made.values("hull_polynomial").keys()
    assert "stall" not in made.parts["rudder_mmg"].options
    back = pk.without_effect(made, "rudder_stall")
    assert back.parts["hull_polynomial"] == SHIP.parts["hull_polynomial"]
    bare = pk.without_effect(load_model("mariner"), "rudder_stall")
    assert {"Yddd", "Nddd"} <= {
        name for part in pk.with_effect(bare, "rudder_stall").parts.values() for name in part.values
    }


def test_a_rudder_that_stalls_by_name_twice_is_refused():
    with pytest.raises(ModelError, match="already"):
        pk.with_effect(pk.with_effect(SHIP, "rudder_stall"), "rudder_stall")


def test_an_option_that_was_another_word_is_put_back():
    idle = stalling(SHIP, "none", 10.0, 0.0)
    better = pk.with_effect(idle, FOUND)
    before = better.steps[-1].before
    assert before is not None
    assert before.options == {"rudder_mmg.stall": "none"}


def test_a_stall_of_another_kind_of_rudder_is_refused():
    with pytest.raises(UnknownNameError, match="stall_loss"):
        pk.with_effect(load_model("mariner"), FOUND)
    cubes = replace(FOUND, coefficients={"Yddd": 0.002, "Nddd": -0.001})
    with pytest.raises(ModelError, match="diagnose with this model"):
        pk.with_effect(SHIP, cubes)


@pytest.mark.slow
def test_a_stalled_rudder_is_named_and_its_values_found():
    """Zigzags of a rudder that loses 30 % with each 10° beyond 18°."""
    records = sailed(stalling(SHIP, "linear", 18.0, 0.3), 3, runs=RUNS)
    some = [
        item
        for item in candidates_for(SHIP, records)
        if item.name in ("rudder_stall", "rudder_hull_interaction", "asymmetry")
    ]
    known = ("Yv", "Nv", "Nr", "rudder_mmg.epsilon")
    prior = Prior.of(SHIP, known, SPEED, spread=0.02)
    found = diagnose_free(SHIP, records, prior=prior, candidates=some, sensors=SENSORS, most=1)
    assert found.group == ((("rudder_stall",), 1.0),)
    (finding,) = found.findings
    for name, true in (("stall_loss", 0.3), ("stall_deg", 18.0 - BEGIN)):
        assert abs(finding.coefficients[name] - true) < 3.5 * finding.std[name]
    assert found.model.parts["rudder_mmg"].options["stall"] == "linear"


@pytest.mark.slow
def test_an_effect_whose_values_no_model_can_have_is_not_dropped_in_silence():
    """A rudder that gains 90 % with each 10° beyond 15°, asked as one that gains beyond 18°: more
    than the 100 % that a model takes."""
    item = candidate(SHIP)
    one = replace(
        item,
        moves={"stall_loss": item.moves["stall_loss"]},
        typical={"stall_loss": item.typical["stall_loss"]},
        begins={**item.begins, "rudder_mmg.stall_deg": 18.0},
    )
    records = sailed(stalling(SHIP, "linear", BEGIN, -0.9), 3, runs=((20.0, 20.0), (-20.0, 10.0)))
    prior = Prior.of(SHIP, ("Yv", "Nv", "Nr"), SPEED, spread=0.02)
    found = diagnose_free(SHIP, records, prior=prior, candidates=[one], sensors=SENSORS, most=1)
    assert found.group == ()
    (said,) = (note for note in found.notes if note.startswith("rudder_stall"))
    assert "no model can have" in said
    assert "stall_loss" in said
