"""Several campaigns of one ship on one page: asked together, each with its map and its error."""

from __future__ import annotations

import json

import pytest
from asgi import Browser
from commands import said
from hidden_effects import hidden_campaign
from long_work import done

from pmmkit import save_campaign
from pmmkit.actions import action
from pmmkit.models import load_model
from pmmkit.workbench import Desk
from pmmkit.workbench.application import answers, application
from pmmkit.workbench.saved import find_state

pytestmark = pytest.mark.slow
FAULT = "fault_misalignment"


@pytest.fixture(scope="module")
def folder(place):
    other = hidden_campaign("middle", {"yaw_sway_coupling": 1.0}, seed=4).with_(title="north")
    save_campaign(other, place / "north.h5")
    return place


@pytest.fixture(scope="module")
def desk(folder):
    own = Desk(folder / "several", [folder], action)
    yield own
    own.close()


@pytest.fixture(scope="module")
def browser(desk):
    return Browser(application(desk, "key", 8175), 8175, "key")


@pytest.fixture(scope="module")
def looped(folder, browser):
    """A campaign is put beside the first; what both say is added, then the fault of the first."""
    done(browser, "open", campaign=str(folder / "hidden.h5"), model=str(folder / "model.toml"))
    opened = done(browser, "beside", campaign=str(folder / "north.h5"))
    before = [browser.get(f"/api/misfit?of={of}").json for of in (0, 1)]
    done(browser, "diagnose")
    missing = browser.get("/api/missing").json
    done(browser, "add", effect="yaw_sway_coupling")
    fault = next(item for item in missing["candidates"] if item["effect"] == FAULT)
    state = done(browser, "add", effect=FAULT, campaign=fault["campaign"])
    fall = browser.get("/api/fall").json
    after = [browser.get(f"/api/misfit?of={of}").json for of in (0, 1)]
    return {
        "opened": opened, "missing": missing, "state": state, "fall": fall,
        "before": before, "after": after,
    }  # fmt: skip


def test_what_both_say_is_named_and_a_fault_stays_with_its_campaign(looped):
    first, second = (item["title"] for item in looped["opened"]["campaigns"])
    named = [item for item in looped["missing"]["candidates"] if item["named"]]
    assert [(item["effect"], item["campaign"]) for item in named] == [
        ("yaw_sway_coupling", ""),
        (FAULT, first),
    ]
    assert [vote["campaign"] for vote in named[0]["votes"]] == [first, second]
    assert "the ship's" in named[0]["said"]
    assert {x["name"] for x in named[0]["coefficients"]} == {"Yvvr", "Yvrr", "Nvvr", "Nvrr"}


def test_what_a_candidate_would_do_is_drawn_over_each_campaign(looped):
    first, second = looped["missing"]["drawn"]
    for drawn, fall in zip((first, second), looped["fall"]["campaigns"], strict=True):
        before, after = (step["error"] for step in fall["steps"][:2])
        share = drawn["shares"]["yaw_sway_coupling"]["all"]
        assert share == pytest.approx(1.0 - (after / before) ** 2, abs=0.01)
        assert drawn["overlays"]["yaw_sway_coupling"].keys()
    assert FAULT in first["shares"]
    assert FAULT not in second["shares"], "the other has it"


def test_each_campaign_has_its_own_fall_and_its_own_map(looped):
    falls = looped["fall"]["campaigns"]
    assert [item["title"] for item in falls] == [x["title"] for x in looped["opened"]["campaigns"]]
    first, second = ([step["error"] for step in item["steps"]] for item in falls)
    assert first[0] > 3.0 * first[1] > 3.0 * first[2]
    assert second[0] > 3.0 * second[1]
    assert second[1] == second[2], "it was not asked for the fault of the other"
    for before, after in zip(looped["before"], looped["after"], strict=True):
        assert after["within"] > before["within"]


def test_the_command_line_replays_several_campaigns(looped, folder, tmp_path, capsys):
    lines = [item["line"] for item in looped["state"]["commands"]]
    title = looped["opened"]["campaigns"][0]["title"]
    (compared,) = (line for line in lines if line.startswith("pmmkit compare "))
    assert all(f"{name}.h5" in compared for name in ("hidden", "north"))
    assert any(f"{FAULT}@'{title}' --fit " in line for line in lines)
    both = [x for name in ("hidden.h5", "north.h5") for x in ("--fit", folder / name)]
    own = folder / "several"
    status, _, _ = said(
        capsys, "add", own / "model_0.toml", "--steps", own / "steps.toml", *both,
        "-o", tmp_path / "replayed.toml",
    )  # fmt: skip
    assert status == 0
    mine, theirs = load_model(own / "model_2.toml"), load_model(tmp_path / "replayed.toml")
    assert {name: part.values for name, part in mine.parts.items()} == {
        name: part.values for name, part in theirs.parts.items()
    }


def test_what_was_open_is_found_again(looped, desk, folder):
    state = find_state(desk.folder)
    assert state.campaigns == (str(folder / "hidden.h5"), str(folder / "north.h5"))
    assert [step.campaign for step in state.steps] == [
        "",
        looped["opened"]["campaigns"][0]["title"],
    ]


def test_a_saved_page_holds_both_campaigns(looped, desk):
    held = answers(desk)
    assert {"misfit 2", "misfit 2 1", "runs 0", "runs 0 1"} <= held.keys()
    second = [name for name in held if name.startswith("run ") and name.endswith(" 2 1")]
    assert len(second) == len(held["misfit 2 1"]["groups"][0]["rows"]) + sum(
        len(group["rows"]) for group in held["misfit 2 1"]["groups"][1:]
    )
    json.dumps(held["fall"])


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ("/api/misfit?of=2", "no campaign 3"),
        ("/api/misfit?of=-1", "whole number"),
        ("/api/runs?of=x", "whole number"),
        ("/api/record?run=none&of=1", "no run 'none'"),
    ],
)
def test_a_campaign_that_is_not_there_is_said(asked, why, looped, browser):
    answer = browser.get(asked)
    assert answer.status == 400
    assert why in answer.json["error"]


@pytest.mark.parametrize(
    ("campaign", "why"), [("north.h5", "named twice"), ("none.h5", "no "), ("/etc", "outside")]
)
def test_what_cannot_be_put_beside_is_said(campaign, why, looped, browser, folder):
    revision = browser.get("/api/state").json["revision"]
    answer = browser.post("/api/beside", {"revision": revision, "campaign": str(folder / campaign)})
    assert answer.status == 400
    assert why in answer.json["error"]
    assert len(browser.get("/api/state").json["steps"]) == 2


def test_a_campaign_that_is_taken_off_leaves_the_other(folder):
    desk = Desk(folder / "left", [folder], action)
    browser = Browser(application(desk, "key", 8176), 8176, "key")
    both = {"campaign": str(folder / "hidden.h5"), "also": [str(folder / "north.h5")]}
    try:
        done(browser, "open", model=str(folder / "model.toml"), **both)
        left = done(browser, "without", of=0)
        assert [item["title"] for item in left["campaigns"]] == ["north"]
        revision = browser.get("/api/state").json["revision"]
        for of, why in ((1, "no campaign 2"), (0, "only campaign")):
            answer = browser.post("/api/without", {"revision": revision, "of": of})
            assert answer.status == 400
            assert why in answer.json["error"]
        assert browser.get("/api/misfit").status == 200
    finally:
        desk.close()
