"""The loop: diagnose, add, watch the error fall, undo, replay; and the model that comes out."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np
import pandas as pd
import pytest
from hidden_effects import hidden_campaign
from threadpoolctl import threadpool_info, threadpool_limits

from pmmkit import (
    begin,
    fit,
    model_of,
    open_campaign,
    own_effect,
    reduce_campaign,
    replay,
    simulate,
)
from pmmkit.base import ModelError, UnknownNameError
from pmmkit.diagnosis import Session, undone
from pmmkit.diagnosis.captive.held_out import held_out
from pmmkit.diagnosis.findings import Transfer
from pmmkit.files import datasets_folder
from pmmkit.models import load_model, model_text, save_model
from tests.support.uncoupled import uncoupled


@pytest.fixture(scope="module")
def bare():
    return uncoupled()


@pytest.fixture(scope="module")
def session(bare):
    hidden = {
        "yaw_sway_coupling": 1.0,
        "fault_misalignment": 1.0,
        "memory": 1.0,
        "surge_yaw_coupling": 1.0,
    }
    return begin(bare, hidden_campaign("full", hidden, seed=7))


@pytest.mark.slow
def test_the_loop_ends_where_nothing_is_missing(session):
    while (found := session.diagnose()).verdict == "missing_effect":
        for item in found.proposed:
            session = session.add(item.effect, item.evidence)
        assert len(session.steps) <= 4
    assert {step.effect for step in session.steps} == {
        "yaw_sway_coupling",
        "fault_misalignment",
        "memory",
    }
    shares = session.fall().totals
    assert all(after < before for before, after in pairwise(shares))
    assert session.fall().useless == ()


@pytest.fixture(scope="module")
def coupled(bare):
    """A session about few runs, with the coupling that they hide beside a fault already in it."""
    hidden = {"yaw_sway_coupling": 1.0, "fault_pmm_amplitude": 1.0}
    begun = begin(bare, hidden_campaign("small", hidden, seed=1))
    return begun.add("yaw_sway_coupling")


@pytest.mark.parametrize("added", [(), ("fault_pmm_amplitude",)])
def test_a_session_asks_what_the_model_that_it_writes_is_asked(coupled, added):
    """Faults act on what the base expects: one without the coupling expects other forces."""
    session = coupled
    for effect in added:
        session = session.add(effect)
    found = session.diagnose()
    again = begin(session.model(), session.evidence.campaign).diagnose()
    assert (found.verdict, found.best, found.flags) == (again.verdict, again.best, again.flags)
    asked = {item.names: item.log_evidence for item in again.entries}
    told = {item.names: item.log_evidence for item in found.entries}
    assert told == pytest.approx(asked, rel=1e-5, abs=1e-5)
    assert found.base == pytest.approx(again.base, rel=1e-6)
    assert found.given == ("yaw_sway_coupling", *added)


def test_of_what_is_not_the_whole_story_the_strongest_effect_alone_is_proposed(coupled):
    found = coupled.undo().diagnose()
    weak, strong = sorted(found.findings, key=lambda item: item.log_odds)
    assert replace(found, flags=()).proposed == found.findings
    flagged = replace(found, flags=("not_the_whole_story", "something is left"))
    assert flagged.proposed == (strong,)
    assert flagged.to_dict()["proposed"] == [strong.effect]
    assert weak.effect not in flagged.to_dict()["proposed"]
    useless = Transfer(effect=strong.effect, changes={"turns": 0.04, "zigzags": 0.03})
    useful = Transfer(effect=weak.effect, changes={"turns": -0.23, "zigzags": -0.17})
    assert replace(flagged, transfers=(useless, useful)).proposed == (weak,)
    assert replace(flagged, transfers=(useless,)).proposed == (strong,)


@pytest.mark.slow
def test_the_model_that_comes_out_has_the_values_of_the_virtual_ship(session):
    """Nv and Nvvr of Son and Nomoto, through the model's own convention (separate Coriolis)."""
    full = session
    for effect in ("yaw_sway_coupling", "fault_misalignment", "memory"):
        full = full.add(effect)
    made = full.model()
    truth = load_model("s175-3dof")
    at = [made.covariance_names.index(name) for name in ("Nv", "Nvvr", "Yr", "Xvr")]
    std = np.sqrt(np.diagonal(made.covariance))[at]
    for name, spread in zip(("Nv", "Nvvr", "Yr", "Xvr"), std, strict=True):
        got, want = (x.values("hull_polynomial")[name] for x in (made, truth))
        assert abs(got - want) < max(4 * spread, 0.03 * abs(want)), name
    assert made.convention == truth.convention
    assert "fault_misalignment" not in made.parts
    late = made.values("memory")
    assert -0.006 < late["Yv_late"] < -0.0012, "a fifth of Yv is hidden, -0.0023"
    assert 0.15 < late["lag"] < 0.45, "0.283 L/U is hidden"
    turned = made.steps[-2].coefficients["turned"]
    assert [line.split(":")[0] for line in made.history[-3:]] == [
        "Added yaw_sway_coupling",
        f"Added fault_misalignment, turned = {turned:.4g}",
        "Added memory",
    ]


@pytest.mark.slow
def test_a_model_is_written_read_and_its_last_step_taken_back(session, tmp_path):
    made = session.add("yaw_sway_coupling").add("memory", "a remark").model()
    save_model(made, tmp_path / "model.toml")
    again = load_model(tmp_path / "model.toml")
    assert again.history == made.history
    before, effect = undone(again)
    assert effect == "memory"
    assert "memory" not in before.parts
    first, effect = undone(before)
    assert effect == "yaw_sway_coupling"
    assert "Nvvr" not in first.values("hull_polynomial")
    with pytest.raises(ModelError, match="knows of no effect"):
        undone(first)


@pytest.mark.slow
def test_the_steps_hold_what_the_fit_says_as_numbers(session):
    found = session.diagnose()
    finding = next(item for item in found.findings if item.effect == "memory")
    made = session.add("fault_misalignment").add(finding, "seen in sway").model()
    fault, memory = made.steps
    assert (fault.action, memory.action) == ("fault_corrected", "effect_added")
    assert fault.faults == memory.faults == ("fault_misalignment",)
    assert list(fault.coefficients) == ["turned"]
    assert fault.before is None
    assert memory.log_odds == finding.log_odds
    part = made.parts["memory"].values
    assert memory.coefficients == {name: part[name] for name in ("Yv_late", "Nv_late")}
    assert memory.value == part["lag"]
    assert memory.error_before == fault.error_after
    assert memory.error_after < memory.error_before
    base = sum(map(len, session.evidence.system.base.names.values()))
    assert memory.count == base + 1 + 3, "one of the fault, two and the lag of the memory"
    assert memory.campaign == "hidden effects, full"
    assert len(memory.Fn) == 3


@pytest.mark.slow
def test_odds_without_a_remark_are_said_in_the_sentence(session):
    finding = next(item for item in session.diagnose().findings if item.effect == "memory")
    (step,) = session.add(finding).model().steps
    assert str(step).startswith(f"Added memory ({finding.evidence}): error")


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["yaw_sway_coupling", "froude_linear", "memory"])
def test_an_undone_step_leaves_the_base_to_be_fitted_again(session, bare, effect, tmp_path):
    """Nvvr was in the base before the effect that has it too: it stays."""
    hull = bare.parts["hull_polynomial"]
    values = MappingProxyType({**hull.values, "Nvvr": -0.03})
    old = bare.with_(
        parts=MappingProxyType({**bare.parts, "hull_polynomial": replace(hull, values=values)})
    )
    before = begin(old, session.evidence.campaign)
    save_model(before.add(effect).model(), tmp_path / "made.toml")
    back, name = undone(load_model(tmp_path / "made.toml"))
    assert name == effect
    assert back.steps == ()
    assert back.Fn == ()
    again, first = (begin(x, session.evidence.campaign).model() for x in (back, old))
    one, other = (tomllib.loads(model_text(x)) for x in (again, first))
    assert one == other


@pytest.mark.slow
def test_a_fault_found_before_is_known_in_the_next_session(session):
    made = session.add("fault_misalignment").model()
    later = begin(made, session.evidence.campaign)
    assert later.given == ("fault_misalignment",)
    assert "fault_misalignment" not in {x for x, _ in later.diagnose().group}


@pytest.mark.slow
def test_each_set_of_effects_is_left_out_once(bare, monkeypatch):
    """Model and waterfall of three states: base, one step, two steps."""
    asked = []

    def counted(system, blocks):
        asked.append([block.candidate.name for block in blocks])
        return held_out(system, blocks)

    monkeypatch.setattr("pmmkit.diagnosis.loop.captive.held_out", counted)
    session = begin(bare, hidden_campaign("middle", {"yaw_sway_coupling": 1.0}, seed=3))
    for effect in ("yaw_sway_coupling", "asymmetry"):
        session = session.add(effect)
        session.model()
        session.fall()
    assert asked == [[], ["yaw_sway_coupling"], ["yaw_sway_coupling", "asymmetry"]]


@pytest.mark.slow
def test_undo_takes_the_last_step_and_nothing_else(session):
    one = session.add("memory")
    two = one.add("fault_misalignment")
    assert two.undo().steps == one.steps
    assert session.steps == ()
    with pytest.raises(ModelError, match="no step"):
        session.undo()


def test_a_step_that_explains_nothing_is_said_so(session):
    fall = session.add("yaw_sway_coupling").add("surge_fourth_order").fall()
    assert fall.useless == ("surge_fourth_order",)
    frame = fall.to_pandas()
    assert set(frame["test"]) > {"all", "static_drift", "yaw_drift"}
    assert (frame["share"].dropna() > 0).all()


@pytest.mark.slow
def test_steps_are_saved_and_replayed(session, bare, tmp_path):
    made = session.add("memory", "seen in sway").add("yaw_sway_coupling")
    made.save(tmp_path / "steps.toml")
    again = replay(tmp_path / "steps.toml", bare, session.evidence.campaign)
    assert again.steps == made.steps
    assert again.evidence.floor == made.evidence.floor
    found = next(item for item in session.diagnose().findings if item.effect == "memory")
    session.add(found).save(tmp_path / "found.toml")
    (step,) = replay(tmp_path / "found.toml", bare, session.evidence.campaign).steps
    assert step.log_odds == found.log_odds
    pd.testing.assert_frame_equal(again.fall().to_frame(), made.fall().to_frame())


@pytest.mark.parametrize(
    "text",
    [
        "",
        "session = 3\n",
        "[session]\n",
        "[session]\nfloor = 'a'\neffects = []\nwhy = []\n",
        "[session]\nfloor = 0.01\neffects = ['memory']\nwhy = []\n",
        "[session]\nfloor = 0.01\neffects = [1]\nwhy = ['']\n",
        "[session]\nfloor = 0.01\n[[steps]]\naction = 'fitted'\n",
        "[session]\nfloor = 0.01\n[[steps]]\naction = 'effect_added'\n",
        "[session]\nfloor = 0.01\n[[steps]]\naction = 'effect_added'\neffect = 3\n",
    ],
)
def test_a_damaged_file_of_steps_is_refused(session, text, tmp_path):
    (tmp_path / "steps.toml").write_text(text)
    with pytest.raises(ModelError, match="no session"):
        replay(tmp_path / "steps.toml", session.evidence.source, session.evidence.campaign)


def test_what_cannot_be_added_is_refused_in_words(session):
    with pytest.raises(UnknownNameError, match="These do"):
        session.add("ghost")
    with pytest.raises(ModelError, match="already"):
        session.add("memory").add("memory")


@pytest.mark.slow
def test_a_structure_is_diagnosed_but_makes_no_model():
    campaign = open_campaign(datasets_folder() / "s175")
    found = begin("cubic", campaign)
    assert found.diagnose().best
    with pytest.raises(ModelError, match="reduce"):
        found.model()


@pytest.mark.slow
def test_values_over_the_froude_number_stay_values_over_the_froude_number():
    """The programme of the S175 has derivatives that change with the speed."""
    campaign = open_campaign(datasets_folder() / "s175")
    each = model_of(reduce_campaign(campaign, structure="abkowitz3"), "s175-3dof")
    made = fit(each, campaign)
    assert made.Fn == each.Fn
    new, old = (np.array(x.parts["hull_polynomial"].values["Yv"]) for x in (made, each))
    np.testing.assert_allclose(new, old, rtol=0.05)
    assert len(set(new.tolist())) == len(new)
    speed = made.ship.speed(made.Fn[1], made.water.g)
    turns = [simulate(x, rudder_deg=35, speed=speed, compiled=False) for x in (made, each)]
    diameters = [x.metrics["tactical_diameter_L"] for x in turns]
    assert diameters[0] == pytest.approx(diameters[1], rel=0.03)


@pytest.mark.slow
def test_an_effect_of_ones_own_is_named_added_and_fitted(bare, tmp_path):
    """Fins aft: one coefficient for force and moment, hidden as the catalogue's sway drag."""
    fins = own_effect("fins", "Y: a*v*|v|; N: -0.2*a*v*|v|; a ~ -0.02")
    campaign = hidden_campaign("full", {"modulus_sway_drag": 1.0, "yaw_sway_coupling": 1.0}, seed=2)
    session = begin(bare, campaign, own=[fins])
    found = session.diagnose()
    assert set(found.best) == {"fins", "yaw_sway_coupling"}, "one coefficient beats two"
    made = session.add("fins").add("yaw_sway_coupling").model()
    hull = made.values("hull_polynomial")
    assert hull["Yv|v|"] == pytest.approx(-0.02, rel=0.25)
    assert hull["Nv|v|"] == pytest.approx(-0.2 * hull["Yv|v|"], rel=1e-9)


def test_a_fit_that_an_effect_cannot_have_says_that_the_tests_do_not_show_it(bare):
    """A truth with a thrust of the cross flow in place of its drag."""
    tests = begin(bare, hidden_campaign("middle", {"crossflow_drag": -1.0}, seed=3))
    with pytest.raises(ModelError, match=r"CD of crossflow_drag at -0\.\d+ ± .*leave it out, or"):
        tests.add("crossflow_drag").model()


@pytest.mark.parametrize("what", ["diagnose", "fall", "held_out_errors", "model"])
def test_what_a_session_answers_hangs_on_no_number_of_threads(what):
    """The last digits of a factorisation hang on how many threads make it."""
    seen = []

    class Evidence:
        def __getattr__(self, name):
            return lambda *_: seen.extend(x["num_threads"] for x in threadpool_info())

    with threadpool_limits(2):
        getattr(Session(evidence=Evidence()), what)()
    assert set(seen) == {1}
