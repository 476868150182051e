"""The page that a command writes: what it has worked out, and nothing else, in one small file."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest
from hidden_effects import hidden_campaign
from pages import answers_in, texts_in
from uncoupled import uncoupled

from pmmkit import save_campaign
from pmmkit.cli import main
from pmmkit.models import save_model
from pmmkit.presentation import Grid, Group, Picture, Section, Symbol
from pmmkit.views import page_file
from pmmkit.views.pages.page_file import MOST, fitted, size_of, state_of, with_runs
from pmmkit.views.pages.sections import told_page


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """The folder of a comparison of a model that lacks an effect."""
    folder = tmp_path_factory.mktemp("compared")
    campaign = hidden_campaign("middle", {"yaw_sway_coupling": 1.0}, seed=3)
    save_campaign(campaign.with_(title="</script><b>hidden</b>"), folder / "hidden.h5")
    save_model(uncoupled(), folder / "model.toml")
    asked = ["compare", str(folder / "model.toml"), str(folder / "hidden.h5")]
    assert main([*asked, "--no-figures", "--out", str(folder / "out")]) == 0
    return folder / "out"


@pytest.mark.slow
def test_the_page_of_a_comparison_holds_the_numbers_that_were_printed(compared):
    page = answers_in(compared / "report.html")
    told = json.loads((compared / "comparison.json").read_text(encoding="utf-8"))
    assert list(page["state"]["places"].items()) == [("data", False), ("where", True)]
    cells = {
        (row["run"], channel): cell
        for group in page["misfit 0"]["groups"]
        for row in group["rows"]
        for channel, cell in row["cells"].items()
    }
    assert len(cells) == len(told["runs"])
    for row in told["runs"]:
        own = cells[row["run"], row["channel"]]
        for name in ("error", "measured", "uncertainty", "ratio"):
            assert own[name] == pytest.approx(row[name], rel=1e-4)
    printed = texts_in(page["told where"]["folded"])
    assert all(item["text"] in printed for item in page["misfit 0"]["sentences"])
    assert "over measured" in printed


@pytest.mark.slow
def test_every_run_of_a_comparison_can_be_looked_at(compared):
    page = answers_in(compared / "report.html")
    runs = {row["run"] for group in page["misfit 0"]["groups"] for row in group["rows"]}
    assert {key for key in page if key.startswith("run ")} == {f"run {name} 0" for name in runs}
    assert all(page[f"run {name} 0"]["predicted"] for name in runs)


@pytest.mark.slow
def test_a_page_lets_nothing_run_or_load_but_its_own(compared):
    text = (compared / "report.html").read_text(encoding="utf-8")
    assert "default-src 'none'; script-src 'sha256-" in text
    assert "unsafe" not in text.partition("<script")[0]
    assert text.count("<script") == text.count("</script>") == 3
    assert "</script><b>" not in text


def of_size(size):
    """A figure of so many letters."""
    return SimpleNamespace(svg=lambda _: f"<svg>{'x' * size}</svg>")


def big(runs):
    """Answers with a map of so many runs, and pictures of three sizes."""
    cells = {"Y": {"error": 1.2345, "measured": 12.345, "uncertainty": 0.12345, "within": False}}
    rows = [
        {"run": f"r{i}", "words": "1 m/s, drift 2°", "cells": {"Y": cells["Y"] | {"ratio": i}}}
        for i in range(runs)
    ]
    figures = [
        Picture(figure=of_size(size), caption=f"{size}", file="large" * (size > 1e6))
        for size in (1000, 600_000, 1_500_000)
    ]
    return {
        "state": state_of(title="Large", kind="captive", runs=runs, model="m"),
        "misfit 0": {"kind": "captive", "groups": [{"test": "static_drift", "rows": rows}]},
        "told where": told_page(after=[Section(title="Pictures", figures=figures)]),
    }


def test_few_runs_keep_all_their_pictures():
    whole = big(100)
    assert fitted(whole) == whole


def test_many_runs_lose_the_largest_picture_first_and_it_is_said():
    held = fitted(big(9000))
    figures = held["told where"]["after"][0]["figures"]
    assert [bool(item["svg"]) for item in figures] == [True, True, False]
    assert figures[-1]["file"] == "large.svg"
    assert size_of(held) <= MOST


def test_very_many_runs_keep_those_with_the_largest_errors():
    answers = with_runs(
        big(20_000), ["r19999"], lambda name, buckets: {"run": name}, "run {} 0".format
    )
    page = page_file(answers)
    assert len(page.encode()) < 3_000_000
    misfit = answers_in(page)["misfit 0"]
    kept = [row["run"] for group in misfit["groups"] for row in group["rows"]]
    assert misfit["left_out"] == 20_000 - len(kept)
    assert kept == [f"r{i}" for i in range(20_000 - len(kept), 20_000)]


@pytest.mark.parametrize("several", [False, True])
def test_candidates_are_drawn_over_the_runs_with_the_largest_errors(several):
    """Ten candidates over a thousand runs alone would be larger than a file may be."""
    own = {f"r{i}": {"Y": [1.234567] * 30} for i in range(1000)}
    table = {"overlays": dict.fromkeys("abcdefghij", own), "base": {}, "shares": {}}
    missing = {"drawn": [table, table]} if several else table
    answers = big(1000) | {"missing": missing}
    answers |= {"misfit 0 1": answers["misfit 0"]} if several else {}
    held = fitted(answers)
    assert size_of(held) <= MOST
    tables = held["missing"]["drawn"] if several else [held["missing"]]
    for table in tables:
        (runs,) = {tuple(sorted(item)) for item in table["overlays"].values()}
        assert 50 < len(runs) < 1000
        assert set(runs) == {f"r{i}" for i in range(1000 - len(runs), 1000)}


def test_candidates_over_records_are_kept_where_all_has_room():
    own = {f"r{i}": {"x": [1.234567] * 5000} for i in range(2)}
    missing = {"overlays": dict.fromkeys("abcdefghij", own), "base": own, "shares": {}}
    answers = big(100) | {"missing": missing}
    assert size_of(missing["overlays"]) > 0.3 * MOST
    answers["told where"] = {"before": [], "after": [], "folded": []}
    assert fitted(answers)["missing"] == missing


def test_histories_are_as_fine_as_there_is_room_for():
    asked = []

    def give(name, buckets):
        asked.append(buckets)
        return {"x": "9" * 100 * buckets}

    names = [f"r{i}" for i in range(300)]
    held = with_runs({}, names, give, "run {} 0".format)
    assert asked[-1] == 50
    assert [key for key in held if key.startswith("run")] == [f"run {name} 0" for name in names]


def test_a_derivative_is_typeset_and_reads_as_text():
    symbol = Symbol("N′", "vvr")
    grid = Grid(head=["", "Fn 0.2"], groups=[Group(rows=[[symbol, None]])])
    (section,) = told_page(before=[Section(tables=[grid])])["before"]
    assert section["tables"][0]["groups"][0]["rows"] == [[{"letter": "N′", "below": "vvr"}, None]]
    assert f"{symbol} = 0" == "N′vvr = 0"
