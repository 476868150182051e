"""A campaign of a programme: what is not made yet is left out, and named; nothing else is."""

from __future__ import annotations

import pytest

from pmmkit.base import CampaignError
from pmmkit.campaigns import load_campaign, open_campaign, save_campaign
from pmmkit.cli import main

FILE = """
[campaign]
title = "a day"
planned = true
[ship]
name = "kvlcc2-l7"
[water]
rho = 1000.0
[[runs]]
id = "SD[1]"
test = "static_drift"
file = "runs/a.csv"
speed = 1.0
drift_deg = 4.0
[[runs]]
id = "SD[2]"
test = "static_drift"
file = "runs/b.csv"
speed = 1.0
drift_deg = 8.0
[[runs]]
id = "SD[2]_2"
test = "static_drift"
file = "runs/c.csv"
speed = 1.0
drift_deg = 8.0
repeat_of = "SD[2]"
"""
RECORD = "t [s],X [N],Y [N],N [N m]\n" + "".join(f"{t},-9,{40 + t % 2},60\n" for t in range(60))


def day(folder, text=FILE, made=("a",)):
    (folder / "runs").mkdir()
    for name in made:
        (folder / "runs" / f"{name}.csv").write_text(RECORD)
    (folder / "campaign.toml").write_text(text)
    return folder


def test_runs_without_a_file_are_left_out_with_the_reason(tmp_path):
    found = open_campaign(day(tmp_path, made=("a", "c")))
    assert [run.id for run in found.runs] == ["SD[1]", "SD[2]_2"]
    assert {run.id: why for run, why in found.excluded} == {
        "SD[2]": "not made yet: there is no runs/b.csv"
    }
    assert found.not_made == ("SD[2]",)
    assert sorted(found.file_hashes()) == ["runs/a.csv", "runs/c.csv"]


def test_they_are_named(tmp_path, capsys):
    main(["check", str(day(tmp_path))])
    assert "Not made yet (no file): SD[2], SD[2]_2" in capsys.readouterr().out


def test_before_the_first_run_there_is_nothing_to_reduce(tmp_path, capsys):
    assert main(["reduce", str(day(tmp_path, made=())), "--out", str(tmp_path / "out")]) == 1
    assert "None of the 3 runs is made yet" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_in_any_other_campaign_a_missing_file_is_a_fault(tmp_path):
    with pytest.raises(CampaignError, match=r"runs/b\.csv' is not there"):
        open_campaign(day(tmp_path, FILE.replace("planned = true\n", "")))


def test_a_table_that_is_missing_is_a_fault_even_so(tmp_path):
    text = FILE.replace("speed = 1.0\ndrift_deg = 4.0", "speed = 1.0\nrow = { n = 1 }")
    with pytest.raises(CampaignError, match=r"runs/a\.csv' is not there"):
        open_campaign(day(tmp_path, text, made=()))


def test_what_is_not_made_is_kept_in_a_saved_campaign(tmp_path):
    save_campaign(open_campaign(day(tmp_path)), tmp_path / "day.h5")
    again = load_campaign(tmp_path / "day.h5")
    assert again.not_made == ("SD[2]", "SD[2]_2")
    assert [run.id for run, _ in again.excluded] == ["SD[2]", "SD[2]_2"]
