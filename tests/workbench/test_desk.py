"""One whole loop over the server, replayed by the command line; what is saved is found again."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from asgi import Browser
from commands import said
from long_work import MINUTE, done, waited

from pmmkit.actions import action
from pmmkit.base import DataError
from pmmkit.campaigns import open_campaign
from pmmkit.files import datasets_folder
from pmmkit.models import Standing, load_model
from pmmkit.reduction import reduce_campaign
from pmmkit.views.pages.page_file import bundle
from pmmkit.workbench import Desk, WorkbenchState, frozen_page
from pmmkit.workbench.application import answers, application
from pmmkit.workbench.saved import STATE
from pmmkit.workbench.tasks import find_rivals
from pmmkit.workbench.worker import Job


@pytest.fixture(scope="module")
def desk(looped_desk):
    return looped_desk


@pytest.fixture(scope="module")
def browser(looped_browser):
    return looped_browser


@pytest.mark.slow
def test_the_error_falls_to_the_noise_as_what_hides_is_clicked_in(looped):
    assert set(looped["named"]) == {"yaw_sway_coupling", "fault_misalignment"}
    errors = [step["error"] for step in looped["fall"]["steps"]]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1.5 * looped["fall"]["steps"][-1]["level"] < errors[0]
    assert looped["after"]["within"] > looped["before"]["within"]


def test_the_state_is_answered_while_something_long_is_worked_out(desk, looped):
    begun, free = Event(), Event()

    def turn():
        begun.set()
        assert free.wait(MINUTE)
        return "turn"

    with ThreadPoolExecutor(3) as pool:
        try:
            first = pool.submit(desk.known.once, ("a turn",), turn)
            assert begun.wait(MINUTE)
            second = pool.submit(desk.known.once, ("a turn",), lambda: "made twice")
            desk.known.once(("tests",), lambda: "read")
            assert pool.submit(desk.page).result(MINUTE)["opened"]
        finally:
            free.set()
        assert first.result() == second.result() == "turn"


def test_an_answer_that_failed_is_asked_for_again(desk):
    def fails():
        raise DataError("The file is gone.")

    with pytest.raises(DataError, match="gone"):
        desk.known.once(("a record",), fails)
    assert desk.known.once(("a record",), lambda: "there again") == "there again"


@pytest.mark.slow
def test_a_structure_is_lent_propeller_and_rudder_and_the_commands_say_so(place, tmp_path):
    desk = Desk(tmp_path / "lent", [place], action)
    tests = str(place / "hidden.h5")
    try:
        desk.open(WorkbenchState(campaign=tests, model="cubic", parts="s175-3dof"))
        desk.wait(lambda _: None)
        made = load_model(desk.folder / "model_0.toml")
        reduction = reduce_campaign(open_campaign(tests), structure="cubic", fn="pooled")
        assert desk.checks() == [item.to_dict() for item in reduction.findings]
        assert made.parts["rudder_mmg"].source == "library: Son and Nomoto 1981"
        assert Standing.of(made, 1.0).estimated == ()
        first = desk.page()["commands"][0]["line"]
        assert "--structure cubic --fn pooled --parts s175-3dof --out" in first
        with pytest.raises(DataError, match="has its own parts"):
            desk.open(WorkbenchState(campaign=tests, model="s175-3dof", parts="kcs"))
        demonstration = str(datasets_folder() / "s175")
        for model, parts in (("s175-3dof", ""), ("cubic", "s175-3dof")):
            desk.open(WorkbenchState(campaign=demonstration, model=model))
            desk.wait(lambda _: None)
            assert desk.state.parts == parts, (
                "a ship has its own; the demonstration lends to others"
            )
    finally:
        desk.close()


@pytest.mark.slow
def test_the_command_line_replays_the_steps_with_the_same_numbers(looped, desk, place, capsys):
    shown = [item["line"] for item in looped["state"]["commands"]]
    assert shown[-1].startswith("pmmkit add ")
    assert f"--steps {desk.folder / 'steps.toml'}" in shown[-1]
    steps, made = desk.folder / "steps.toml", place / "replayed.toml"
    options = ["--fit", place / "hidden.h5", "-o", made]
    status, told, _ = said(capsys, "add", desk.folder / "model_0.toml", "--steps", steps, *options)
    assert status == 0
    assert told["added"] == looped["named"]
    mine, theirs = load_model(desk.folder / "model_2.toml"), load_model(made)
    assert {name: part.values for name, part in mine.parts.items()} == {
        name: part.values for name, part in theirs.parts.items()
    }


@pytest.mark.slow
def test_the_band_of_a_turn_is_of_all_ships_that_the_tests_accept(looped, desk):
    """The set that was added among them: its ship is the model that came of the steps."""
    speed = desk.range()["speeds"][0]
    asked = {"manoeuvre": "turning", "speed": speed, "rudder_deg": 35.0, "band": True}
    band = desk.sail(asked)["band"]
    rivals = find_rivals(desk.folder, tuple(looped["named"]))
    assert band["rivals"] == [list(effects) for _, _, effects in rivals]
    mine = next(model for model, _, effects in rivals if set(effects) == set(looped["named"]))
    made = load_model(desk.folder / "model_2.toml")
    for name, part in made.parts.items():
        assert mine.parts[name].values == pytest.approx(part.values), name
    assert find_rivals(desk.folder, ("memory",)) == ()


@pytest.mark.slow
def test_another_page_that_saw_an_older_state_changes_nothing(looped, browser):
    answer = browser.post("/api/undo", {"revision": looped["opened"]["revision"]})
    assert answer.status == 409
    assert len(browser.get("/api/state").json["steps"]) == 2


@pytest.mark.slow
def test_what_was_done_is_found_again_after_the_server_ended(looped, desk, place):
    again = Desk(desk.folder, [place], action)
    try:
        assert again.state == desk.state
        assert again.fall() == desk.fall()
        missing = again.missing()
        assert missing is not None
        assert missing["since"] == 2
        assert not {x["effect"] for x in missing["candidates"]} & set(looped["named"])
    finally:
        again.close()


@pytest.mark.slow
def test_undo_and_add_come_back_to_the_same(looped, browser, desk):
    before = json.loads((desk.folder / "fall_2.json").read_text("utf-8"))
    state = done(browser, "undo")
    assert len(state["steps"]) == 1
    assert len(browser.get("/api/fall").json["steps"]) == 2
    done(browser, "add", effect=looped["named"][-1])
    assert json.loads((desk.folder / "fall_2.json").read_text("utf-8")) == before


@pytest.mark.slow
def test_the_file_holds_the_page_and_no_name_ends_an_element(looped, desk):
    page = frozen_page(desk)
    assert len(page.encode()) < 3_000_000
    assert "</script><b>" not in page
    assert page.count("<script") == page.count("</script>") == 3
    assert "http-equiv" in page
    held = answers(desk)
    rows = [row for group in held["misfit 2"]["groups"] for row in group["rows"]]
    assert all(f"run {row['run']} 2" in held for row in rows)


@pytest.mark.slow
def test_work_is_cancelled_at_once_and_can_be_asked_again(looped, browser):
    state = browser.get("/api/state").json
    assert browser.post("/api/diagnose", {"revision": state["revision"]}).status == 200
    assert browser.post("/api/diagnose", {"revision": state["revision"]}).status == 400
    assert browser.post("/api/cancel", {}).json["stand"] == "cancelled"
    assert done(browser, "diagnose")["asked"]


def test_what_is_left_is_told_by_the_parts_done_or_by_the_last_time():
    """A quarter done in ten seconds leaves thirty, and less as time goes; done before in 15 s,
    it leaves five after ten."""
    job = Job(number=1, stand="running", began=100.0, heard=110.0, done=25, total=100)
    assert job.left(110.0) == pytest.approx(30.0)
    assert job.left(120.0) == pytest.approx(20.0)
    assert job.left(145.0) is None
    assert replace(job, done=0).left(110.0) is None
    assert replace(job, usual=15.0).left(110.0) == pytest.approx(5.0)


def test_modules_of_the_page_are_in_the_file_in_the_order_of_their_needs():
    text = bundle()
    places = [text.index(f"const from_{name} ") for name in ("dom", "linear", "where", "main")]
    assert places == sorted(places)
    assert "\nimport " not in text
    assert "\nexport " not in text


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"campaign": 1}', '{"campaign":"x","model":"","data":"","count":"2"}']
)
def test_a_damaged_state_is_said_with_what_to_do(tmp_path, text):
    (tmp_path / STATE).write_text(text, "utf-8")
    with pytest.raises(DataError, match="begin anew"):
        Desk(tmp_path, [tmp_path], action)


@pytest.mark.slow
def test_a_folder_without_tests_is_said_in_place(tmp_path):
    own = Desk(tmp_path / "workbench", [tmp_path], action)
    browser = Browser(application(own, "key", 8175), 8175, "key")
    try:
        browser.post("/api/open", {"campaign": str(tmp_path)})
        job = waited(browser)["job"]
        assert job["stand"] == "failed"
        assert "campaign.toml" in job["text"]
        assert browser.get("/api/state").json["opened"] is False
    finally:
        own.close()


def test_a_campaign_that_is_not_there_is_refused_before_anything_is_served(tmp_path, capsys):
    status, told, _ = said(capsys, "workbench", tmp_path / "none", "--out", tmp_path / "w")
    assert status == 1
    assert "none: there is no such file or folder" in told["error"]["message"]
    assert not (tmp_path / "w" / STATE).exists()


@pytest.mark.slow
def test_a_campaign_file_is_drafted_as_the_command_does_it(tmp_path, capsys):
    for name in ("alpha", "gamma"):
        t = np.arange(400) / 20.0
        table = np.column_stack([t, -20.0 + 0 * t, 3 * np.sin(t), np.cos(t)])
        (tmp_path / name).mkdir()
        head = "t [s],X [N],Y [N],N [Nm]"
        np.savetxt(tmp_path / name / "run.csv", table, delimiter=",", header=head, comments="")
    own = Desk(tmp_path / "workbench", [tmp_path / "alpha"], action)
    browser = Browser(application(own, "key", 8175), 8175, "key")
    try:
        asked = {"folder": str(tmp_path / "alpha")}
        assert browser.post("/api/campaign", asked).json["written"]
        assert browser.post("/api/look", asked).json["new"] is False
        assert browser.post("/api/campaign", {"folder": str(tmp_path / "gamma")}).status == 400
    finally:
        own.close()
    assert said(capsys, "new-campaign", tmp_path / "gamma")[0] == 0
    mine, theirs = (
        (tmp_path / name / "campaign.toml").read_text("utf-8") for name in ("alpha", "gamma")
    )
    assert mine == theirs.replace("gamma", "alpha")


def test_words_of_all_languages_are_those_that_the_page_says():
    words = Path(bundle.__code__.co_filename).parents[1] / "static" / "words"
    english = json.loads((words / "en.json").read_text("utf-8"))
    for file in words.glob("*.json"):
        own = json.loads(file.read_text("utf-8"))
        assert set(own) == set(english), file.name
        for key, text in own.items():
            marks = {part.split("}")[0] for part in text.split("{")[1:]}
            assert marks == {part.split("}")[0] for part in english[key].split("{")[1:]}, key


@pytest.mark.slow
def test_what_does_not_help_is_told_why_and_is_not_added(looped, browser, desk):
    done(browser, "diagnose")
    candidates = desk.missing()["candidates"]
    useless = [item for item in candidates if item["reason"]]
    assert useless
    assert {item["weight"] for item in useless} == {"does not help"}
    assert not any(item["named"] for item in useless)
    nothing = [item for item in useless if item["share"]["all"] < 0.005]
    assert nothing
    assert all("takes nothing of the held-out misfit" in item["reason"] for item in nothing)
    with pytest.raises(DataError, match=r"does not help\. It takes nothing"):
        desk.add(desk.page()["revision"], nothing[0]["effect"])
