"""The golden set: what it sees, what it lets pass, and how it is changed."""

from __future__ import annotations

import datetime as dt
import math
import tomllib

import pytest

from scripts.golden.differences import LONG, differences, lines_of, plain
from scripts.golden.job import ROOT, Job, empty_folder, masked
from scripts.golden.judged import judge, judged, refused_names
from scripts.golden.kept import accepted, answer_of
from scripts.golden.typed import columns_of, typed

KEPT = {"Yv": [-0.0153, 1e-19], "told": ["Usable."], "odds": 20.0, "none": math.nan}


def moved(old, new, tolerance=1e-9):
    return [str(item) for item in differences(plain(old), plain(new), tolerance)]


def test_the_same_answer_moves_nothing():
    assert moved(KEPT, KEPT) == []
    assert moved(KEPT, {**KEPT, "Yv": [-0.0153 * (1 + 1e-10), -1e-19]}) == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"odds": 20.0001}, "odds: 20.0 -> 20.0001  (5e-06 of it)"),
        ({"Yv": [0.0153, 1e-19]}, "Yv[0]: -0.0153 -> 0.0153  (2 of it)"),
        ({"Yv": [-0.0153]}, "Yv (entries): 2 -> 1"),
        ({"told": ["Not usable."]}, "told[0]: Usable. -> Not usable."),
        ({"none": 1.0}, "none: nan -> 1.0"),
        ({"new": 1}, "new: nothing -> 1"),
    ],
)
def test_what_moved_is_said_with_its_place(change, said):
    assert moved(KEPT, {**KEPT, **change}) == [said]


def test_what_is_missing_is_said():
    assert moved(KEPT, {"Yv": KEPT["Yv"]})[0] == "told: ['Usable.'] -> nothing"


def test_a_line_that_comes_between_moves_no_other():
    old, new = ["one", "two", "three"], ["one", "new", "two", "three", "four"]
    assert moved({"out": old}, {"out": new}) == ["out[1]:  -> new", "out[3]:  -> four"]


def test_a_whole_number_is_no_truth_value():
    assert moved({"a": True}, {"a": 1}) == []  # JSON's own comparison: True == 1
    assert moved({"a": True}, {"a": False}) == ["a: True -> False"]


def test_long_records_are_thinned_and_long_texts_summed():
    record = plain([float(k) for k in range(LONG + 1)])
    assert record["entries"] == LONG + 1
    assert record["at"]["0"] == 0.0
    assert record["at"][str(LONG)] == LONG
    one, other = lines_of("a\nb\n"), lines_of("a\nc\n")
    assert one["sums"].split()[0] == other["sums"].split()[0]
    assert one["sums"] != other["sums"]
    assert columns_of("t,told\n1.5,yes\n") == {"0 t": [1.5], "1 told": ["yes"]}


def test_days_folders_and_versions_are_masked(tmp_path):
    text = f"{tmp_path}/a {ROOT}/b {dt.date.today()}T10:11:12Z Yv 2.5"
    assert masked(text, tmp_path) == "FOLDER/a ROOT/b DAY Yv 2.5"


def test_a_command_leaves_its_words_its_status_and_its_files():
    found = typed("convert nothing.csv --json", "ships --json")
    missing, ships = found.values()
    assert (missing["status"], ships["status"]) == (1, 0)
    assert missing["out"]["error"]["type"] == "TableError"
    assert any(ship["name"] == "s175" for ship in ships["out"]["ships"])


def test_answers_are_kept_with_the_reason(tmp_path):
    folder = tmp_path / "kept"
    first = judge(Job("turn", lambda: {"advance": 3.0}), folder)
    assert first.new
    accepted(first, "The first answers", folder)
    assert answer_of("turn", folder) == {"advance": 3.0}
    again = judge(Job("turn", lambda: {"advance": 3.0}), folder)
    assert not again.new
    assert not again.moved
    other = judge(Job("turn", lambda: {"advance": 3.3}), folder)
    assert [str(item) for item in other.moved] == ["advance: 3.0 -> 3.3  (0.091 of it)"]
    accepted(other, 'The rudder is "faster"', folder)
    told = tomllib.loads((tmp_path / "reasons.toml").read_text("utf-8"))["accepted"]
    assert [item["because"] for item in told] == ["The first answers", 'The rudder is "faster"']
    assert told[1]["furthest"] == pytest.approx(0.091, rel=0.01)


def test_a_job_that_fails_moves_and_is_never_kept(tmp_path):
    found = judge(Job("turn", lambda: 1 / 0), tmp_path)
    assert "ZeroDivisionError" in str(found.moved[0])
    accepted(found, "never", tmp_path)
    assert answer_of("turn", tmp_path) is None


def test_jobs_are_named_with_stars_and_mistyped_ones_corrected():
    every = {"free_wind": Job("free_wind", dict), "free_roll": Job("free_roll", dict)}
    assert [item.name for item in judged(every, ["*wind"], 1)] == ["free_wind"]
    assert "Did you mean 'free_wind'?" in refused_names(["free_wnd"], every)
    assert refused_names(["free_*"], every) == ""


def test_an_empty_folder_is_left_again():
    from pathlib import Path

    before = Path.cwd()
    with empty_folder() as folder:
        assert list(folder.iterdir()) == []
    assert Path.cwd() == before
