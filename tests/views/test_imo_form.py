"""The form of MSC/Circ.1053, appendix 6: its fields, its results, what is missing, its page."""

from __future__ import annotations

import csv
import json
import re

import pytest

import pmmkit as pk
from pmmkit.base import DataError
from pmmkit.campaigns import CampaignFile
from pmmkit.cli import main
from pmmkit.views import form_of_model, read_stated

SPEED = 8.0
STATED = {
    "administration": "of the flag",
    "reference": "17/3",
    "ship_type": "tanker",
    "rudder_type": "semi-spade",
    "rudders": 1,
    "rudder_area": 98.0,
    "propeller_type": "fixed pitch",
    "propellers": 1,
    "engine_type": "steam turbine",
    "full_load_draught": 18.46,
    "full_load_trim": 0.0,
    "ballast": "segregated, 9 m mean",
    "draught_fore": 18.4,
    "draught_aft": 18.52,
    "speed_85": 8.5,
}
ASKED = (
    "administration",
    "reference",
    "ship_type",
    "L_over_V",
    "L_over_B",
    "B_over_T",
    "block",
    "rudder_type",
    "rudder_area_over_LT",
    "rudders",
    "propeller_type",
    "propellers",
    "full_load_trim",
    "engine_type",
    "ballast",
    "loading",
)
"""What the form of the notes asks of a ship; wind, sea state and depth are conditions."""


@pytest.fixture(scope="module")
def verdicts():
    return pk.imo_verdicts("esso190k", SPEED, n=0, astern=-0.7, compiled=False)


@pytest.fixture(scope="module")
def empty(verdicts):
    return form_of_model(pk.load_model("esso190k"), verdicts, speed=SPEED)


@pytest.fixture(scope="module")
def filled(verdicts):
    return form_of_model(pk.load_model("esso190k"), verdicts, speed=SPEED, stated=STATED)


def test_every_field_that_the_notes_ask_for_is_there(empty, filled):
    for form in (empty, filled):
        names = [item.name for item in form.entries]
        assert set(ASKED) < set(names)
        assert len(names) == len(set(names))
        assert {"depth", "wind", "sea_state"} < {item.name for item in form.conditions}


def test_every_criterion_stands_with_both_sides_limit_and_margin(filled, verdicts):
    assert [line.criterion.name for line in filled.lines] == list(
        dict.fromkeys(item.criterion for item in verdicts)
    )
    for line in filled.lines:
        assert set(line.verdicts) == ({""} if line.unit == "L" and line.limit == 15.0 else SIDES)
        for side, verdict in line.verdicts.items():
            (same,) = (x for x in verdicts if (x.criterion, x.side) == (line.criterion.name, side))
            assert verdict is same
        assert line.margin == min(item.margin for item in line.verdicts.values())


SIDES = {"port", "starboard"}


def test_what_nobody_supplied_is_printed_and_listed(empty, filled):
    assert filled.not_supplied == ()
    missing = [item for item in empty.entries if item.value is None]
    assert len(missing) == 14
    assert {item.shown for item in missing} == {"not supplied"}
    assert set(empty.not_supplied) == {item.title for item in missing} | {
        "condition: draught",
        "condition: approach speed",
    }


def test_ratios_of_the_ship_are_those_of_her_particulars(filled):
    ship = pk.load_model("esso190k").ship
    told = {item.name: item.value for item in filled.entries}
    assert told["L_over_V"] == pytest.approx(304.8 / 8.0)
    assert told["B_over_T"] == pytest.approx(ship.B / 18.46)
    assert told["rudder_area_over_LT"] == pytest.approx(98.0 / (304.8 * 18.46))
    assert told["loading"] == "simulated at full load"
    assert told["draught"] == pytest.approx(18.46)
    assert told["trim"] == pytest.approx(0.12)


def test_ratios_at_another_draught_than_that_of_full_load_are_not_made_up(verdicts):
    other = form_of_model(
        pk.load_model("esso190k"), verdicts, speed=SPEED, stated={"full_load_draught": 20.0}
    )
    told = {item.name: item for item in other.entries}
    assert told["block"].shown == "not supplied"
    assert told["B_over_T"].value == pytest.approx(pk.load_model("esso190k").ship.B / 20.0)
    assert told["loading"].value == "simulated at partial load, not corrected"
    assert "conditions NOT met: draught" in other.verdict


def test_the_engine_astern_stands_beside_the_stop(filled, verdicts):
    assert filled.assumptions == (verdicts[-1].full_astern.words,)
    assert filled.verdict == "7 of 7 criteria met"
    # where nobody states the revolutions, 0.6 of them fail and 0.7 do not
    open_ = [*verdicts[:-1], pk.imo_verdicts("esso190k", SPEED, n=200)[-1]]
    form = form_of_model(pk.load_model("esso190k"), open_, speed=SPEED, stated=STATED)
    assert form.verdict.startswith("6 of 7 criteria met; 1 not settled (What the engine does")
    assert "of such ships meet the limit" in form.verdict


def test_a_stop_that_is_too_long_may_ask_for_more(verdicts):
    late = pk.imo_verdicts("esso190k", SPEED, n=0, astern=-0.6, compiled=False)
    form = form_of_model(pk.load_model("esso190k"), late, speed=SPEED, stated=STATED)
    assert form.verdict == "6 of 7 criteria met; NOT met: crash stop: track reach"
    assert any("up to 20 L" in text for text in form.remarks)


def test_a_ship_sailed_to_one_side_is_not_judged_to_both(verdicts):
    starboard = [item for item in verdicts if item.side == "starboard"]
    form = form_of_model(pk.load_model("esso190k"), starboard, speed=SPEED, stated=STATED)
    assert form.verdict == "0 of 7 criteria met; 7 not judged"
    assert "turning circle 35°: advance, port" in form.not_supplied


# The page


def test_the_page_has_no_script_and_a_style_for_print(filled):
    page = filled.html()
    assert "<script" not in page
    assert "default-src 'none'" in page
    assert re.search(r"@page \{[^}]*A4", page)
    assert "@media print" in page
    for item in filled.entries:
        assert f">{item.shown}<" in page
    assert "Structured after the form of IMO MSC/Circ.1053" in page


def test_texts_of_the_user_cannot_leave_their_place(verdicts):
    evil = "</dd><script>alert(1)</script>"
    form = form_of_model(
        pk.load_model("esso190k"), verdicts, speed=SPEED, stated={"ship_type": evil}
    )
    assert "<script" not in form.html()


# Files and commands


def written(folder, **stated):
    lines = [f"{name} = {json.dumps(value)}" for name, value in stated.items() if value is not None]
    path = folder / "ship.toml"
    path.write_text("\n".join(["[imo]", *lines, ""]), encoding="utf-8")
    return path


def test_a_file_holds_what_it_says_and_its_mistakes_are_all_named(tmp_path):
    assert read_stated(written(tmp_path, **STATED)) == STATED
    assert set(STATED) < set(CampaignFile.keys_of("imo"))
    with pytest.raises(DataError) as caught:
        read_stated(written(tmp_path, sea_state=12, rudders="one", colour="red"))
    assert len(caught.value.problems) == 3
    (tmp_path / "other.toml").write_text("[ship]\nL = 3.0\n")
    with pytest.raises(DataError, match=r"no table \[imo\]"):
        read_stated(tmp_path / "other.toml")


@pytest.mark.slow
def test_the_command_writes_the_form_to_print_and_for_machines(tmp_path, capsys):
    out = tmp_path / "out"
    order = ["imo", "esso190k", "--speed", "8", "--ships", "0", "--reversal", "60", "--json"]
    form = written(tmp_path, **STATED)
    assert main([*order, "--form", str(form), "--out", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert set(told["files"]) == {file.name for file in out.iterdir()}
    held = json.loads((out / "imo_form.json").read_text(encoding="utf-8"))
    assert held["not_supplied"] == []
    assert held["fields"]["rudders"] == 1
    assert [item["criterion"] for item in held["results"][-1:]] == ["track_reach"]
    stop = told["verdicts"][-1]
    assert held["results"][-1]["full_astern"] == stop["full_astern"]
    with (out / "imo_form.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    results = [row for row in rows if row["part"] == "results"]
    assert len(results) == 13
    by_place = {(row["name"], row["side"]): float(row["value"]) for row in results}
    for item in told["verdicts"]:
        assert by_place[item["criterion"], item["side"]] == pytest.approx(item["value"])
    assert "Not supplied" in (out / "imo_form.html").read_text(encoding="utf-8")
