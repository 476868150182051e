"""An effect of one's own: checked while it is typed, weighed, added and replayed as the others."""

from __future__ import annotations

import shlex

import pytest
from asgi import Browser
from commands import said
from long_work import done

from pmmkit import own_effect
from pmmkit.actions import action
from pmmkit.base import DataError
from pmmkit.files import datasets_folder
from pmmkit.models import load_model, save_model
from pmmkit.workbench import Desk, WorkbenchState
from pmmkit.workbench.application import application
from pmmkit.workbench.saved import OWN, model_file, save_state

TERMS = "Y: v*v*r + v*r*r; N: v*v*r + v*r*r; Yvvr ~ 0.02; Yvrr ~ -0.04; Nvvr ~ -0.04; Nvrr ~ 0.002"
"""The coupling of sway and yaw that the model lacks, under another name."""


@pytest.fixture(scope="module")
def desk(place):
    own = Desk(place / "own", [place], action)
    yield own
    own.close()


@pytest.fixture(scope="module")
def browser(desk):
    return Browser(application(desk, "key", 8175), 8175, "key")


def test_the_check_tells_the_coefficients_with_their_usual_sizes(browser):
    answer = browser.post("/api/check", {"name": "mine", "text": "Y: v*|v|*r; N: v*v*r; Nvvr ~ 1"})
    sizes = {item["name"]: item["typical"] for item in answer.json["coefficients"]}
    assert sizes == dict(own_effect("mine", "Y: v*|v|*r; N: v*v*r; Nvvr ~ 1").typical)


@pytest.mark.parametrize("text", ["Y: v*w", "Y v", "Y: v*|v", "Q: v*r", "Y: __import__(1)", "~"])
def test_what_cannot_be_read_is_told_as_the_parser_tells_it(browser, text):
    with pytest.raises(DataError) as told:
        own_effect("mine", text)
    answer = browser.post("/api/check", {"name": "mine", "text": text})
    assert answer.json == {"error": str(told.value)}


@pytest.mark.slow
def test_an_own_effect_is_weighed_added_and_replayed_as_the_others(browser, desk, place, capsys):
    done(browser, "open", campaign=str(place / "hidden.h5"), model=str(place / "model.toml"))
    state = done(browser, "write", name="mine", text=TERMS)
    assert state["own"] == [{"name": "mine", "text": TERMS}]
    missing = browser.get("/api/missing").json
    mine = next(item for item in missing["candidates"] if item["effect"] == "mine")
    assert mine["log_odds"] > 5.0
    assert mine["share"]["all"] > 0.1
    assert "Y" in next(iter(missing["overlays"]["mine"].values()))
    state = done(browser, "add", effect="mine")
    assert browser.get("/api/fall").json["steps"][-1]["step"] == "mine"
    asked = {"revision": state["revision"], "name": "mine", "text": "Y: v*r*r"}
    assert "undo it" in browser.post("/api/write", asked).json["error"]
    line = shlex.split(state["commands"][-1]["line"])
    made = place / "with_mine.toml"
    line[line.index("replayed.toml")] = str(made)
    assert said(capsys, *line[1:])[0] == 0
    theirs, ours = load_model(made), load_model(desk.folder / "model_1.toml")
    assert {name: part.values for name, part in ours.parts.items()} == {
        name: part.values for name, part in theirs.parts.items()
    }


def test_a_damaged_file_of_own_effects_is_said_beside_them(tmp_path):
    """The state is given all the same: a page without it would be blank."""
    save_model(load_model("s175-3dof"), model_file(tmp_path, ()))
    save_state(
        tmp_path, WorkbenchState(campaign=str(datasets_folder() / "s175"), model="s175-3dof")
    )
    (tmp_path / OWN).write_text("[[effects]]\nname = ", encoding="utf-8")
    desk = Desk(tmp_path, [tmp_path], action)
    try:
        page = desk.page()
        assert page["own"] == []
        assert OWN in page["own_error"]
        with pytest.raises(DataError, match=OWN):
            desk.write(page["revision"], "mine", "Y: v*r*r")
    finally:
        desk.close()
