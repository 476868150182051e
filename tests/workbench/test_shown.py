"""A record is shown whole: what was cut off, what is found in it, and what cannot be read."""

from __future__ import annotations

import numpy as np
import pytest
from strange_tank import ANSWERS, write_files

from pmmkit import open_campaign
from pmmkit.base import DataError
from pmmkit.intake import DraftAnswers, examine
from pmmkit.views import page_of
from pmmkit.views.pages import runs
from pmmkit.workbench.data_routes import drawn, taken_back

FREE = """\
[campaign]
title = "turn"
kind = "free-running"
[ship]
name = "s175-3dof"
[water]
rho = 999.1
[[runs]]
id = "T[1]"
test = "turning"
file = "turn.csv"
speed = 1.0
rudder_deg = 20.0   # ordered
"""


@pytest.fixture
def turn(tmp_path):
    """A record of 60 s at 10 Hz whose time begins at 100 s; the position jumps once."""
    t = np.arange(600) / 10.0
    table = np.column_stack(
        [t + 100.0, t + np.where(t > 30.0, 2.0, 0.0), 0.01 * t**2, 0.02 * t, 0.3 + 0 * t]
    )
    head = "t,x,y,psi,delta"
    np.savetxt(tmp_path / "turn.csv", table, delimiter=",", header=head, comments="", fmt="%.6f")
    (tmp_path / "campaign.toml").write_text(FREE, encoding="utf-8")
    return tmp_path


@pytest.fixture
def strange(tmp_path):
    write_files(tmp_path)
    found = DraftAnswers(folder=tmp_path, answers=ANSWERS).drafted()
    (tmp_path / "campaign.toml").write_text(found.text, encoding="utf-8")
    return tmp_path


def test_a_free_record_is_trimmed_and_still_seen_whole(turn):
    drawn(turn, "", 105.0, 125.05, "the rest was lost")(open_campaign(turn), "T[1]")
    text = (turn / "campaign.toml").read_text("utf-8")
    campaign = open_campaign(turn)
    assert "rudder_deg = 20.0   # ordered" in text
    assert float(campaign["T[1]"].data["t"].max()) == pytest.approx(125.0)
    page = page_of(campaign, [], run="T[1]")
    assert (page["begin"], page["seconds"]) == (100.0, 59.9)
    assert page["window"] == pytest.approx([5.0, 25.05])
    assert page["stated"]["reason"] == "the rest was lost"
    assert any("jumps" in mark["text"] and mark["from"] == 30.0 for mark in page["marks"])
    taken_back(turn, "")(campaign, "T[1]")
    assert (turn / "campaign.toml").read_text("utf-8") == FREE


def test_a_gauge_at_its_end_is_marked_where_it_stood(strange):
    file = strange / "run003.csv"
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    head = file.read_text("utf-8").splitlines()[0]
    flat = slice(150, 190)
    rows[flat, 4] = rows[:, 4].min() - 1.0
    rows[240:260, 4] = rows[flat.start, 4]
    np.savetxt(file, rows, delimiter=",", header=head, comments="", fmt="%.6g")
    campaign = open_campaign(strange)
    findings = [item.to_dict() for item in examine(campaign)]
    page = page_of(campaign, findings, run="run003")
    marks = [mark for mark in page["marks"] if mark["channel"] == "Y"]
    assert (15.0, 18.9) in [(mark["from"], mark["to"]) for mark in marks]
    other = page_of(campaign, findings, run="run001")
    assert [mark for mark in other["marks"] if mark["channel"] == "Y"] == []


def test_a_run_that_cannot_be_read_leaves_the_others(strange):
    campaign = open_campaign(strange)
    file = strange / "run002.csv"
    file.write_text(file.read_text("utf-8").replace("Fy (N)", "Fq (N)"), encoding="utf-8")
    first, second, third = page_of(campaign, [])["runs"]
    assert "Fy (N)" in second["error"]
    assert first["channels"]
    assert third["window"]


def test_a_large_file_is_read_on_asking_and_where_there_is_room(strange, monkeypatch):
    campaign = open_campaign(strange)
    monkeypatch.setattr(runs, "LARGE", 1000)
    card = page_of(campaign, [])["runs"][0]
    assert (card["channels"], card["large"] > 1000) == ([], True)
    assert page_of(campaign, [], run="run001")["channels"]
    monkeypatch.setattr(runs, "MEMORY", 1e12)
    assert "memory" in page_of(campaign, [], run="run001")["error"]
    with pytest.raises(DataError, match="no run"):
        page_of(campaign, [], run="other")
