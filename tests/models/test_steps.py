"""Steps of a model: data in its file, sentences for people, and the way back."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.base import ModelError
from pmmkit.diagnosis import read_session, undone
from pmmkit.diagnosis.captive.refit import effects_of
from pmmkit.models import Step, load_model, model_text, save_model
from pmmkit.models.step import SENTENCES, Action, Before, added
from pmmkit.models.store import steps_of_sentences

DATA = Path(__file__).parents[1] / "data"
FULL = Step(
    action="effect_added",
    effect="memory",
    coefficients={"Yv_late": -0.002, "Nv F": (0.1, -0.2)},
    system="prime",
    parameter="lag in L/U",
    value=0.3,
    Fn=(0.1, 0.2),
    log_odds=3.0,
    error_before=0.031,
    error_after=0.019,
    campaign='tests "of" 1984,\nsecond part',
    count=21,
    faults=("fault_misalignment",),
    names=("Yv",),
    left_out=("Nvvr",),
    numbers={"Fn0": 0.15},
    source="given (memory)",
    ship="a ship",
    parts="another",
    method="ekf",
    before=Before(
        absent=("memory", "hull_polynomial.Yv|v|"),
        values={"hull_polynomial.Yv": -0.01, "hull_polynomial.Nv": (1.0, 2.0)},
        sources={"hull_polynomial.Yv": "library: a book"},
        pooled=True,
    ),
    note="",
)


def test_every_action_has_its_sentence():
    assert set(SENTENCES) == set(get_args(Action))


@pytest.mark.parametrize("action", get_args(Action))
def test_steps_come_back_from_the_file_without_loss(action, tmp_path):
    model = pk.full_scale(load_model("kvlcc2-l7"), 320.0, speed=7.97)
    numbers = {name: x for step in model.steps for name, x in step.numbers.items()}
    step = replace(FULL, action=action, numbers=numbers)
    made = model.with_(steps=(Step(action=action, numbers=numbers), step))
    save_model(made, tmp_path / "model.toml")
    again = load_model(tmp_path / "model.toml")
    assert again.steps == made.steps
    assert again.history == made.history
    assert model_text(again) == model_text(made)


@pytest.mark.slow
@settings(deadline=None, max_examples=60)
@given(texts=st.lists(st.text(max_size=80), min_size=3, max_size=3))
def test_any_text_of_a_step_comes_back(texts, tmp_path_factory):
    campaign, note, name = texts
    step = replace(FULL, campaign=campaign, note=note, coefficients={name: 1.0})
    path = tmp_path_factory.mktemp("steps") / "model.toml"
    made = load_model("s175").with_(steps=(step, Step(action="noted", note=note)))
    save_model(made, path)
    assert load_model(path).steps == made.steps


def test_a_model_without_steps_is_a_file_of_the_first_release():
    assert model_text(load_model("s175")).startswith("schema = 1\n")
    assert model_text(load_model("s175").stepped(FULL)).startswith("schema = 2\n")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('action = "effect_added"', 'action = "effect_lost"', "steps.2.action is 'effect_lost'"),
        ('action = "effect_added"', "", "steps.2 lacks action"),
        ('effect = "memory"', "effect = 3", "steps.2.effect must be a text"),
        ('effect = "memory"', 'efect = "memory"', "steps.2 has no 'efect'"),
        ("value = 0.3", "value = nan", "steps.2.value"),
        ("value = 0.3", "value = true", "steps.2.value"),
        ("Fn = [0.1, 0.2]", 'Fn = ["a"]', "steps.2.Fn"),
        ("count = 21", "count = 2.5", "steps.2.count must be a whole number"),
        ("count = 21", "count = true", "steps.2.count must be a whole number"),
        ("Yv_late = -0.002", 'Yv_late = "small"', "steps.2.coefficients.Yv_late"),
        ("pooled = true", "pooled = 1", "steps.2.before.pooled must be true or false"),
        ('["fault_misalignment"]', "[3]", "steps.2.faults must be a list of texts"),
        ('"library: a book"', "7", "steps.2.before.sources"),
        ("length = 320.0", "", "steps.1: A step 'scaled' lacks the numbers length"),
        ('[[steps]]\naction = "scaled"', '[steps]\naction = "scaled"', "not valid TOML"),
    ],
)
def test_a_damaged_step_is_named_with_its_place(old, new, says, tmp_path):
    scaled = pk.full_scale(load_model("kvlcc2-l7"), 320.0, speed=7.97).steps[0]
    text = model_text(load_model("kvlcc2-l7").with_(steps=(scaled, FULL)))
    assert old in text
    path = tmp_path / "model.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ModelError, match=re.escape(says)) as caught:
        load_model(path)
    assert all(problem.file == str(path) for problem in caught.value.problems)


def test_steps_that_are_no_sections_are_refused(tmp_path):
    path = tmp_path / "model.toml"
    text = model_text(load_model("s175"))
    path.write_text(text.replace("[ship]", 'steps = ["a text"]\n[ship]', 1), encoding="utf-8")
    with pytest.raises(ModelError, match=re.escape("[[steps]]")):
        load_model(path)


def test_a_number_of_a_step_is_finite():
    with pytest.raises(ModelError, match="not finite"):
        Step(action="effect_added", coefficients={"Yv": float("nan")})
    with pytest.raises(ModelError, match="not finite"):
        Step(action="effect_added", log_odds=float("inf"))


# Files of the first release


def test_a_file_of_the_first_release_keeps_its_sentences_and_their_meaning():
    """Written by the first release: two effects and a fault by `add`, one by `with_effect`."""
    old = load_model(DATA / "model_v1_steps.toml")
    written = re.findall(r'^    "(.*)",$', (DATA / "model_v1_steps.toml").read_text(), re.M)
    assert list(old.history) == [line for line in written if "added" in line.lower()]
    assert len(old.history) == 4
    assert [(step.action, step.effect) for step in old.steps] == [
        ("effect_added", "yaw_sway_coupling"),
        ("fault_corrected", "fault_misalignment"),
        ("effect_added", "memory"),
        ("noted", ""),
    ]
    assert old.steps[0].note == "over 1000 to 1"
    assert old.steps[0].campaign == "hidden effects, full"
    assert old.steps[2].error_after == pytest.approx(0.0121, abs=6e-5)
    assert "fault_misalignment" in effects_of(old)


def test_the_steps_of_a_file_of_the_first_release_are_undone_as_they_were(tmp_path):
    model = load_model(DATA / "model_v1_steps.toml")
    taken = []
    for _ in range(3):
        save_model(model, tmp_path / "model.toml")
        model, effect = undone(load_model(tmp_path / "model.toml"))
        taken.append(effect)
    assert taken == ["memory", "fault_misalignment", "yaw_sway_coupling"]
    assert "memory" not in model.parts
    assert "Nvvr" not in model.values("hull_polynomial")
    assert "fault_misalignment" not in effects_of(model)
    with pytest.raises(ModelError, match="knows of no effect"):
        undone(model)


def test_a_session_of_the_first_release_is_read():
    saved = read_session(DATA / "session_v1.toml")
    assert saved.floor == 0.005
    assert [(step.action, step.effect, step.note) for step in saved.steps] == [
        ("effect_added", "yaw_sway_coupling", "over 1000 to 1"),
        ("fault_corrected", "fault_misalignment", "about 20 to 1"),
        ("effect_added", "memory", ""),
    ]


@pytest.mark.parametrize(
    "line",
    [
        "Derivatives of S175 joined with the parts of s175-3dof.",
        "Effect memory added: Yv_late = -0.002, lag = 0.5.",
        "Added to by hand",
        "",
    ],
)
def test_any_other_sentence_is_noted_as_it_is(line):
    (step,) = steps_of_sentences([line])
    assert step == Step(action="noted", note=line)


@settings(deadline=None)
@given(
    why=st.text(max_size=40),
    campaign=st.text(min_size=1, max_size=40),
    errors=st.tuples(*[st.integers(0, 20_000)] * 2),
)
def test_a_sentence_of_the_first_release_says_the_same_again(why, campaign, errors):
    before, after = (f"{x / 100:.2f}" for x in errors)
    line = (
        f"Added memory{f' ({why})' if why else ''}: error of left-out conditions {before} % to "
        f"{after} % of the rms forces of {campaign}."
    )
    (step,) = steps_of_sentences([line])
    assert step.effect == "memory"
    assert str(step) == line


# The way back


@pytest.fixture(scope="module")
def bare():
    ship = load_model("s175-3dof")
    hull = ship.parts["hull_polynomial"]
    kept = {k: v for k, v in hull.values.items() if k not in ("Yvvr", "Yvrr", "Nvrr")}
    part = replace(hull, values=MappingProxyType(kept), sources={"Yv": "measured: here"})
    return ship.with_(
        parts=MappingProxyType({**ship.parts, "hull_polynomial": part}),
        covariance=np.array([[1e-8, 2e-9], [2e-9, 4e-9]]),
        covariance_names=("Yv", "Nvvr"),
    ).stepped(Step(action="noted", note="as it was"))


@pytest.mark.parametrize(
    "effect", ["memory", "yaw_sway_coupling", "froude_linear", "resistance_curve", "asymmetry"]
)
@pytest.mark.parametrize("Fn", [(), (0.1, 0.2, 0.3)])
def test_an_effect_taken_back_leaves_the_model_to_the_bit(bare, effect, Fn, tmp_path):
    """What was there before the effect stays: Nvvr is not taken out with its companions."""
    old = bare if not Fn else pk.with_effect(bare, "froude_surge", coefficients="typical", Fn=Fn)
    new = pk.with_effect(old, effect, coefficients="typical", Fn=Fn or (0.12, 0.2))
    save_model(new, tmp_path / "new.toml")
    back, name = undone(load_model(tmp_path / "new.toml"))
    assert name == effect
    assert model_text(back) == model_text(old)


def test_a_misfit_stands_until_an_effect_is_fitted_and_again_when_it_is_taken_out(bare, tmp_path):
    misfit = "Y: the misfit is 8 times the noise of the records."
    built = bare.with_(notes=("Izz is as stated.",), steps=()).stepped(
        Step(action="built", ship="a", parts="b", misfit=(misfit,))
    )
    assert built.notes == (misfit, "Izz is as stated.")
    typical = pk.with_effect(built, "memory", coefficients="typical")
    assert typical.notes == built.notes
    fit = {"campaign": "tests", "error_before": 0.07, "error_after": 0.01, "log_odds": 9.0}
    own = {"effect": "memory", "coefficients": {"Yv_late": -0.004}}
    fitted = built.stepped(Step(action="effect_added", **own, **fit))
    assert fitted.notes == ("Izz is as stated.",)
    save_model(fitted, tmp_path / "fitted.toml")
    assert load_model(tmp_path / "fitted.toml").notes == fitted.notes
    back, _ = undone(
        fitted.with_(steps=(*fitted.steps[:-1], replace(fitted.steps[-1], before=BACK)))
    )
    assert back.notes == built.notes


BACK = Before()


def test_effects_are_undone_from_the_last_to_the_first(bare):
    more = pk.with_effect(
        bare, ("memory", "froude_linear", "asymmetry"), coefficients="typical", Fn=(0.1, 0.2)
    )
    more = pk.without_effect(more, "asymmetry")
    assert added(more.steps)[-1] == 2
    back, effect = undone(more)
    assert effect == "froude_linear"
    back, effect = undone(back)
    assert effect == "memory"
    assert model_text(back.with_(steps=bare.steps)) == model_text(bare)
