"""The golden set: what it sees, what it lets pass, and how it is changed."""

from __future__ import annotations

import datetime as dt
import math
import tomllib

import pytest

from scripts.golden.differences import differences
from scripts.golden.files import columns_of, tables_of
from scripts.golden.job import ROOT, Job, empty_folder, masked
from scripts.golden.judged import judge, judged, refused_names
from scripts.golden.kept import accepted, answer_of
from scripts.golden.typed import typed
from scripts.golden.values import LONG, WHOLE, plain, text

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
    assert moved({"a": True}, {"a": 1}) == ["a: True -> 1"]
    assert moved({"a": 2}, {"a": 2.0}) == []


def test_dust_of_sums_that_cancel_moves_nothing_beside_large_numbers():
    assert moved({"Y": [1e3, 1e-10]}, {"Y": [1e3, -1e-10]}) == []
    assert moved({"Y": [1e3, 1e-4]}, {"Y": [1e3, -1e-4]}) == ["Y[1]: 0.0001 -> -0.0001  (2 of it)"]
    assert moved({"Y": 1e3, "N": 1e-10}, {"Y": 1e3, "N": -1e-10}) != []


def test_a_long_record_moves_wherever_one_of_its_numbers_does():
    old = [float(k) for k in range(LONG + 1)]
    assert plain(old)["entries"] == LONG + 1
    for k in range(1, LONG + 1):
        new = [-x if i == k else x for i, x in enumerate(old)]
        assert moved(old, new), k
    rows = [{"run": str(k), "Y": float(k)} for k in range(LONG + 1)]
    assert moved(rows, [{**row, "run": "0" if row["run"] == "17" else row["run"]} for row in rows])


def test_a_long_column_with_gaps_sees_its_texts_and_lets_rounding_pass():
    """A cell without a number is empty text: it takes no tolerance from the others."""
    old = ["" if k % 7 == 0 else 1.0 + k for k in range(LONG + 1)]
    assert moved(old, [x if isinstance(x, str) else x * (1 + 1e-12) for x in old]) == []
    assert moved(old, ["gap" if k == 7 else x for k, x in enumerate(old)])
    assert moved(old, [-x if k == 8 else x for k, x in enumerate(old)])
    assert plain({"fingerprint": "3f2a"}) == {"fingerprint": "FINGERPRINT"}


def test_a_long_text_moves_by_any_letter():
    lines = [f"line {k}" for k in range(WHOLE + 1)]
    one = "\n".join(lines)
    assert text("a\nb") == ["a", "b"]
    assert moved(text(one), text(one)) == []
    assert moved(text(one), text(one.replace("line 17", "line 71"))) != []


def test_files_are_held_by_their_numbers():
    assert columns_of("t,told\n1.5,yes\n") == {"0 t": [1.5], "1 told": ["yes"]}
    page = "<style>p {}</style><p>Usable</p><table><tr><th>Yv</th><td>-0.3</td></tr></table>"
    held = tables_of(page)
    assert held["tables"] == ["Yv | -0.3"]
    assert moved(held, tables_of(page.replace("p {}", "p { }"))) == []
    assert moved(held, tables_of(page.replace("Usable", "Not usable"))) != []


def test_days_folders_and_versions_are_masked(tmp_path):
    text = f"{tmp_path}/a {ROOT}/b {dt.date.today()}T10:11:12Z Yv 2.5"
    assert masked(text, tmp_path) == "FOLDER/a ROOT/b DAY Yv 2.5"


def test_how_long_something_took_is_masked():
    told = (
        "Steady after 81.2 s\n  ekf  0.0817   0.35 s\n  model   rate     time\n"
        "harmonics: 1.6 standard deviations from the regression (Yv), 0.1 s."
    )
    assert masked(told).splitlines() == [
        "Steady after 81.2 s",
        "  ekf  0.0817 SECONDS",
        "  model   rate SECONDS",
        "harmonics: 1.6 standard deviations from the regression (Yv) SECONDS",
    ]
    assert plain({"seconds": 0.3, "Yv": 1.0}) == {"seconds": "SECONDS", "Yv": 1.0}


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
