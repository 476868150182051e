"""Files are dropped, told what they are, corrected, and become a campaign; nothing is lost."""

from __future__ import annotations

import tomllib
from urllib.parse import quote

import pytest
from asgi import Browser, ask
from strange_tank import ANSWERS, write_files

from pmmkit import open_campaign
from pmmkit.actions import action
from pmmkit.actions.jobs.new_campaign import NewCampaignSettings, new_campaign
from pmmkit.workbench import Desk, incoming
from pmmkit.workbench.application import application


@pytest.fixture(scope="module")
def strange(tmp_path_factory):
    """A named folder with a stranger's files."""
    folder = tmp_path_factory.mktemp("named") / "tank"
    write_files(folder)
    return folder


@pytest.fixture
def desk(tmp_path, strange):
    own = Desk(tmp_path / "workbench", [strange.parent, tmp_path], action)
    yield own
    own.close()


@pytest.fixture
def browser(desk):
    return Browser(application(desk, "key", 8175), 8175, "key")


def drop(browser, name, body, into=""):
    """A file sent as the page sends it."""
    length = (b"content-length", str(len(body)).encode())
    address = f"/api/drop?into={quote(into)}&name={quote(name, safe='')}"
    return ask(browser.app, address, method="POST", headers=[*browser.own, length], body=body)


def look(browser, folder, **more):
    answer = browser.post("/api/look", {"folder": str(folder), **more})
    assert answer.status == 200, answer.text
    return answer.json


def field(page, name):
    return next(item for item in page["fields"] if item["name"] == name)


def test_dropped_files_lie_together_and_become_a_campaign_that_opens(browser, desk, strange):
    into = ""
    for file in sorted(strange.glob("*.csv")):
        kept = drop(browser, file.name, file.read_bytes(), into).json
        into = kept["into"]
    place = desk.folder / into
    assert sorted(x.read_bytes() for x in place.iterdir()) == sorted(
        x.read_bytes() for x in strange.glob("*.csv")
    )
    (found,) = browser.get("/api/incoming").json
    assert [item["name"] for item in found["files"]] == ["run001.csv", "run002.csv", "run003.csv"]
    page = look(browser, place)
    assert {x["name"] for x in page["groups"][0]["columns"]} == {
        *("t", "U_carriage", "", "X", "Y", "N")
    }
    assert all(len(x["t"]) > 10 for x in page["groups"][0]["columns"])
    written = browser.post("/api/campaign", {"folder": str(place), "answers": ANSWERS}).json
    assert (written["complete"], written["faults"]) == (True, [])
    campaign = open_campaign(place)
    assert [run.test for run in campaign] == ["static_drift"] * 3
    breadth = campaign.ship.B
    assert breadth == pytest.approx(0.705556)


def test_the_file_is_that_of_the_command(browser, strange, tmp_path):
    new_campaign(NewCampaignSettings(folder=strange, output=tmp_path / "campaign.toml"))
    drafted = (tmp_path / "campaign.toml").read_text("utf-8")
    page = look(browser, strange)
    told = [line for line in page["text"].splitlines() if not line.startswith("file = ")]
    assert told == [line for line in drafted.splitlines() if not line.startswith("file = ")]


@pytest.mark.parametrize(
    "name",
    [
        *(
            "../up.csv",
            "a/../b.csv",
            "..\\up.csv",
            "C:\\x.csv",
            "..",
            ".hidden",
            "",
            " ",
            "a\0b.csv",
        ),
        *("con", "NUL.csv", "com1.txt", "<b>x</b>.csv", "a:b.csv", "a?.csv", "end.", "x" * 130),
        *("‮txt.csv", "line\nbreak.csv"),
    ],
)
def test_names_that_lead_elsewhere_are_refused_with_the_reason(browser, desk, name):
    answer = drop(browser, name, b"t,X\n0,1\n")
    assert (answer.status, answer.headers["content-type"]) == (400, "application/json")
    assert "Rename it" in answer.json["error"]
    assert [x for x in desk.folder.rglob("*") if x.is_file()] == []


def test_nothing_is_replaced_and_a_set_is_one_of_the_workbenchs_own(browser, desk):
    first = drop(browser, "run.csv", b"t,X\n0,1\n").json
    for name in ("run.csv", "RUN.csv"):
        again = drop(browser, name, b"other", first["into"])
        assert "there already" in again.json["error"]
    assert (desk.folder / first["into"] / "run.csv").read_bytes() == b"t,X\n0,1\n"
    assert drop(browser, "run.csv", b"t\n0\n").json["into"] == "dropped-2"
    for into in ("..", "../tank", "dropped-9", "nowhere"):
        assert "no set of files" in drop(browser, "a.csv", b"1", into).json["error"]
    assert "empty" in drop(browser, "none.csv", b"", first["into"]).json["error"]


def test_what_is_too_large_is_not_kept(browser, desk, monkeypatch):
    long = [*browser.own, (b"content-length", b"999999999999")]
    refused = ask(browser.app, "/api/drop?name=a.csv", method="POST", headers=long)
    assert refused.status == 413
    monkeypatch.setattr(incoming, "LARGEST", 4)
    assert "Name its folder" in drop(browser, "a.csv", b"12345").json["error"]
    assert list((desk.folder / "dropped").iterdir()) == []


def test_a_choice_corrects_a_guess_in_the_file(browser, strange):
    choice = {"file": "run001.csv", "column": 4, "name": "Y", "unit": "kN", "sign": -1}
    page = look(browser, strange, choices=[choice])
    stated = tomllib.loads(page["text"])["columns"]["Y"]
    assert stated == {"name": "Fy (N)", "unit": "kN", "scale": -1.0}
    shown = page["groups"][0]["columns"][4]
    assert (shown["name"], shown["chosen_unit"], shown["sign"]) == ("Y", "kN", -1)
    swapped = look(browser, strange, choices=[{**choice, "name": "X", "unit": None}])
    assert "Fx (N)" not in str(tomllib.loads(swapped["text"])["columns"].values())
    for wrong in ({"unit": "deg"}, {"name": "Z"}, {"column": 99}, {"file": "other.csv"}):
        answer = browser.post("/api/look", {"folder": str(strange), "choices": [choice | wrong]})
        assert answer.status == 400


def test_what_is_wrong_is_said_beside_its_field(browser, strange):
    page = look(browser, strange, answers={**ANSWERS, "ship.d": "deep", "ship.L": "-3"})
    assert "number" in field(page, "ship.d")["error"]
    assert "tests have 0.5 to 500 m" in field(page, "ship.L")["error"]
    assert field(page, "ship.B")["error"] == ""
    assert field(page, "campaign.forces")["options"] == ["hydrodynamic", "balance"]
    asked = {"folder": str(strange), "answers": {"ship.d": "deep"}}
    assert browser.post("/api/campaign", asked).json["written"] == ""
    assert not (strange / "campaign.toml").exists()


def test_a_file_that_is_there_is_changed_with_its_comments_kept(browser, tmp_path):
    folder = tmp_path / "mine"
    write_files(folder)
    asked = {"folder": str(folder), "answers": ANSWERS}
    browser.post("/api/campaign", asked)
    file = folder / "campaign.toml"
    mine = file.read_text("utf-8").replace("[columns]", "# my own words\n[columns]")
    file.write_text(mine.replace('Y = "Fy (N)"', 'Y = "Fy (N)" # gauge 7,'), encoding="utf-8")
    choice = {"file": "run001.csv", "column": 4, "name": "Y", "unit": None, "sign": -1}
    assert look(browser, folder)["changed"] is False
    after = browser.post("/api/campaign", {"folder": str(folder), "choices": [choice]}).json
    text = file.read_text("utf-8")
    assert after["text"] == text
    assert "# my own words\n[columns]" in text
    assert 'Y = { name = "Fy (N)", scale = -1.0 } # gauge 7,' in text
    lines = [line for line in text.splitlines() if not line.startswith("Y = ")]
    assert set(lines) == {x for x in mine.splitlines() if not x.startswith("Y = ")}


def test_bad_folders_are_told_in_place(browser, tmp_path):
    empty, damaged, odd = (tmp_path / name for name in ("empty", "damaged", "odd"))
    empty.mkdir()
    write_files(damaged)
    (damaged / "broken.csv").write_bytes(b"\x00\xff" * 40)
    write_files(odd)
    (odd / "campaign.toml").write_text("[campaign\n")

    def told(folder):
        return browser.post("/api/look", {"folder": str(folder)})

    assert "no measurements" in told(empty).json["error"]
    assert "by hand" in told(odd).json["error"]
    assert "no folder" in told(damaged / "run001.csv").json["error"]
    assert "outside" in told("/etc").json["error"]
    assert len(told(damaged).json["groups"]) == 1


def test_a_file_lies_in_the_folders_it_was_dropped_with(browser, desk, strange):
    into = ""
    for file in sorted(strange.glob("*.csv")):
        into = drop(browser, f"drift/1.0 m/{file.name}", file.read_bytes(), into).json["into"]
    place = desk.folder / into
    assert len(list((place / "drift" / "1.0 m").iterdir())) == 3
    (found,) = browser.get("/api/incoming").json
    assert found["files"][0]["name"] == "drift/1.0 m/run001.csv"
    written = browser.post("/api/campaign", {"folder": str(place), "answers": ANSWERS}).json
    assert (written["complete"], len(open_campaign(place))) == (True, 3)


@pytest.mark.parametrize(
    "name",
    [
        *("../run.csv", "a/../../run.csv", "/etc/run.csv", "a//run.csv", "a/./run.csv"),
        *("a\\run.csv", "/".join("abcdefghi"), "con/run.csv", "/".join(["x" * 115] * 3)),
    ],
)
def test_no_name_of_a_folder_leads_elsewhere(browser, desk, name):
    answer = drop(browser, name, b"t,Y\n0,1\n")
    assert answer.status == 400
    assert not [x for x in desk.folder.rglob("*") if x.is_file() and x.suffix == ".csv"]


def test_a_file_is_no_folder_of_others(browser):
    into = drop(browser, "run", b"t,Y\n0,1\n").json["into"]
    assert drop(browser, "run/1.csv", b"t,Y\n0,1\n", into).status == 400
    assert drop(browser, "drift/1.csv", b"t,Y\n0,1\n", into).status == 200
    assert drop(browser, "drift", b"t,Y\n0,1\n", into).status == 400
    assert drop(browser, "drift/1.CSV", b"t,Y\n0,1\n", into).status == 400
