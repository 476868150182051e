"""A window drawn on a record goes into the campaign file; what depends on it is done anew."""

from __future__ import annotations

import time

import pytest
from asgi import Browser
from long_work import done, waited
from small_campaign import write_campaign

from pmmkit import open_campaign
from pmmkit.actions import action
from pmmkit.models import load_model
from pmmkit.reduction import PreparedRun
from pmmkit.workbench import Desk
from pmmkit.workbench.application import application

pytestmark = pytest.mark.slow
RUN, SWAY = "SD_U1_b+08", "PS_U1_a0.3"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A programme of one speed; its time begins before zero."""
    made = write_campaign(tmp_path_factory.mktemp("named") / "small", rest=2.0)
    file = made / "campaign.toml"
    head, *runs = file.read_text("utf-8").split("\n[[runs]]")
    slow = [run for run in runs if "speed = 1.0" in run]
    file.write_text("\n[[runs]]".join([head, *slow]), encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def desk(folder):
    own = Desk(folder.parent / "workbench", [folder], action)
    # What other places look at first is not asked here.
    own.warm = lambda: None
    yield own
    own.close()


@pytest.fixture(scope="module")
def browser(desk, folder):
    own = Browser(application(desk, "key", 8175), 8175, "key")
    done(own, "open", campaign=str(folder), model="linear")
    return own


def draw(browser, run, start, end, reason="the carriage shook"):
    revision = browser.get("/api/state").json["revision"]
    asked = {"revision": revision, "run": run, "t_start": start, "t_end": end, "reason": reason}
    return browser.post("/api/window", asked)


def back(browser, run):
    revision = browser.get("/api/state").json["revision"]
    return browser.post("/api/unwindow", {"revision": revision, "run": run})


def test_what_counts_is_drawn_where_it_is(browser, folder):
    """The ramp of the carriage is no part of the grey, nor of the cycles, and time begins late."""
    campaign = open_campaign(folder)
    for run in (RUN, SWAY):
        page = browser.get(f"/api/record?run={run.replace('+', '%2B')}").json
        taken = PreparedRun.of(campaign[run], campaign)
        assert page["begin"] + page["window"][0] == pytest.approx(taken.t[0], abs=1e-3)
        assert page["begin"] + page["window"][1] == pytest.approx(taken.t[-1], abs=1e-3)
    assert len(page["edges"]) == taken.result.cycles + 1
    assert page["edges"][0] == page["window"][0]


def test_a_window_is_kept_with_its_reason_and_done_anew_on_asking(browser, desk, folder):
    before = (folder / "campaign.toml").read_bytes()
    model = load_model(desk.folder / "model_0.toml")
    assert browser.get("/api/state").json["outdated"] is False
    assert draw(browser, RUN, 4.95, 12.05).status == 200
    assert browser.get("/api/state").json["outdated"] is True
    (stated,) = open_campaign(folder)[RUN].corrections
    assert (stated.action, stated.reason) == ("window", "the carriage shook")
    shown = {x["run"]: x for x in browser.get("/api/runs?first=0").json["runs"]}[RUN]
    assert shown["stated"]["alone"] is True
    assert "the carriage shook" in shown["reason"]
    state = done(browser, "again")
    assert state["outdated"] is False
    anew = load_model(desk.folder / "model_0.toml")
    assert anew.parts["hull_polynomial"] != model.parts["hull_polynomial"]
    assert back(browser, RUN).status == 200
    assert (folder / "campaign.toml").read_bytes() == before
    assert browser.get("/api/state").json["outdated"] is True


@pytest.mark.parametrize(
    ("run", "start", "end", "reason", "said"),
    [
        (RUN, 5.0, 5.3, "short", "are needed"),
        (SWAY, 5.0, 9.0, "short", "whole cycle"),
        (RUN, 9.0, 5.0, "turned", "before it begins"),
        (RUN, 5.0, 9.0, "  ", "why"),
        ("no such run", 5.0, 9.0, "lost", "no run"),
    ],
)
def test_a_window_that_leaves_too_little_is_refused_and_nothing_is_written(
    browser, folder, run, start, end, reason, said
):
    before = (folder / "campaign.toml").read_bytes()
    answer = draw(browser, run, start, end, reason)
    assert answer.status == 400
    assert said in answer.json["error"]
    assert (folder / "campaign.toml").read_bytes() == before


def test_a_ship_of_the_same_form_lends_propeller_and_rudder_and_takes_them_back(browser, desk):
    """Page and command end in the same parts, at the scale of the tests; the hull stays."""
    done(browser, "again")
    own = load_model(desk.folder / "model_0.toml")
    assert browser.get("/api/range").json["lenders"] == ["s175", "s175-3dof"]
    state = done(browser, "again", parts="s175-3dof")
    assert "--parts s175-3dof" in state["commands"][0]["line"]
    lent, donor = load_model(desk.folder / "model_0.toml"), load_model("s175-3dof")
    rudder = [model.parts["rudder_mmg"].values for model in (lent, donor, own)]
    assert rudder[0] == rudder[1] != rudder[2]
    hulls = [model.parts["hull_polynomial"].values for model in (lent, own)]
    assert hulls[0]["Yv"] == hulls[1]["Yv"]
    assert browser.get("/api/range").json["parts"] == "s175-3dof"
    done(browser, "again", parts="")
    assert load_model(desk.folder / "model_0.toml").parts == own.parts


def test_work_that_is_cancelled_leaves_the_ship_with_the_propeller_and_rudder_she_has(browser):
    before = browser.get("/api/state").json
    asked = {"revision": before["revision"], "parts": "s175-3dof"}
    assert browser.post("/api/again", asked).status == 200
    browser.post("/api/cancel", {})
    assert browser.get("/api/range").json["parts"] == ""
    after = browser.get("/api/state").json
    assert after["commands"] == before["commands"]
    assert after["revision"] == before["revision"]


def test_who_cannot_lend_is_told_and_nothing_changes(browser):
    revision = browser.get("/api/state").json["revision"]
    answer = browser.post("/api/again", {"revision": revision, "parts": "kvlcc2"})
    assert answer.status == 400
    assert "kvlcc2 cannot lend propeller and rudder; these can: s175" in answer.json["error"]
    assert browser.get("/api/state").json["revision"] == revision


def test_a_page_that_is_behind_writes_no_window(browser):
    asked = {"revision": -5, "run": RUN, "t_start": 5.0, "t_end": 9.0, "reason": "old"}
    assert browser.post("/api/window", asked).status == 409


def test_a_process_that_is_killed_while_fitting_is_told_and_replaced(browser, desk):
    revision = browser.get("/api/state").json["revision"]
    assert browser.post("/api/diagnose", {"revision": revision}).status == 200
    end = time.monotonic() + 20.0
    while desk._worker._process is None and time.monotonic() < end:
        time.sleep(0.01)
    desk._worker._process.kill()
    state = waited(browser)
    assert state["job"]["stand"] == "failed"
    assert "Try again" in state["job"]["text"]
    assert state["opened"] is True
    assert browser.post("/api/diagnose", {"revision": revision}).status == 200
    browser.post("/api/cancel", {})


def test_what_is_damaged_is_told_beside_what_is_not(browser, desk, folder):
    own, file = desk.folder / "own.toml", folder / "campaign.toml"
    own.write_text("effects = 3\n[", encoding="utf-8")
    state = browser.get("/api/state").json
    assert state["opened"] is True
    assert state["runs"] > 0
    assert "own.toml" in state["own_error"]
    own.unlink()
    whole = file.read_bytes()
    file.write_bytes(whole + b"[[runs")
    state = browser.get("/api/state")
    assert state.status == 200
    assert "campaign.toml" in " ".join(state.json["faults"])
    assert browser.get("/api/runs?first=0").status == 400
    file.write_bytes(whole)
    assert browser.get("/api/state").json["faults"] == []
