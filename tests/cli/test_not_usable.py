"""Commands on tests that give no ship: each arrow is written or its reason, and the end says it."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from commands import rows_of, said
from small_campaign import TRUTH, write_campaign

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.views import Turns

ODD = "PS_U1_a0.3"
FILES = {"derivatives.csv", "derivatives.nc", "report.html", "findings.json", "runs.csv"}


@pytest.fixture(autouse=True)
def loud():
    """What numpy warns of is an error: it is nothing that a user can act on."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        yield


@pytest.fixture(scope="module")
def odd(tmp_path_factory):
    """One run's side force is in another unit."""
    return write_campaign(tmp_path_factory.mktemp("odd") / "tests", hundredfold=ODD)


@pytest.fixture(scope="module")
def pushed(tmp_path_factory):
    """A propeller turned in all runs, and its thrust stands inside X."""
    return write_campaign(tmp_path_factory.mktemp("pushed") / "tests", thrust=0.002)


@pytest.mark.slow
def test_not_usable_ends_with_three_a_table_a_report_and_no_model(odd, tmp_path, capsys):
    status, told, words = said(capsys, "reduce", odd, "--out", tmp_path / "r")
    assert status == 3
    assert told["verdict"]["use"] == "not usable"
    names = {file.name for file in (tmp_path / "r").iterdir()}
    assert names >= FILES
    assert "model.toml" not in names
    assert told["model"] is None
    assert "No model.toml: the derivatives are not usable. --force makes one" in words
    assert words.rstrip().splitlines()[-1].startswith("Not usable: ")
    assert len(rows_of(tmp_path / "r" / "derivatives.csv")) == 2 * len(TRUTH)
    report = (tmp_path / "r" / "report.html").read_text(encoding="utf-8")
    assert "Not usable: " in report


@pytest.mark.slow
def test_by_force_there_is_a_model_that_every_command_marks(odd, tmp_path, capsys):
    out, model = tmp_path / "r", tmp_path / "r" / "model.toml"
    parts = ("--parts", "s175-3dof")
    status, told, _ = said(capsys, "reduce", odd, *parts, "--force", "--out", out)
    assert (status, told["model"]) == (3, "model.toml")
    assert ODD in pk.load_model(model).not_usable
    sailing = [
        ("simulate", model, "--speed", "8", "--no-figures"),
        ("imo", model, "--speed", "8", "--ships", "0"),
        ("stability", model, "--speed", "8"),
        ("compare", model, odd, "--no-figures"),
        ("diagnose", model, odd, "--no-figures"),
        ("plan", model, odd),
        ("scale", model, "--length", "100", "--froude-only"),
    ]
    for number, words in enumerate(sailing):
        status, told, lines = said(capsys, *words, "--out", tmp_path / str(number))
        assert status == 3, words[0]
        assert told["not_usable"].startswith("NOT USABLE"), words[0]
        assert "NOT USABLE" in lines, words[0]
    status, told, _ = said(capsys, "imo", model, "--speed", "8", "--ships", "0", "--out", tmp_path)
    assert {item["passed"] for item in told["verdicts"]} == {None}
    assert "not settled" in (tmp_path / "imo_form.html").read_text(encoding="utf-8")
    status, told, _ = said(capsys, "model", "show", model)
    assert (status, told["not_usable"][:10]) == (3, "NOT USABLE")
    file = tmp_path / "ship.m"
    status, told, _ = said(capsys, "export", model, "--to", "mss", "--speed", "8", "-o", file)
    assert (status, told["not_usable"][:10]) == (3, "NOT USABLE")
    changed = tmp_path / "m.toml"
    assert said(capsys, "model", "set", model, "rudder.area=33", "-o", changed)[0] == 3
    assert pk.load_model(changed).not_usable


@pytest.mark.slow
def test_the_test_report_ends_so_too(odd, tmp_path, capsys):
    status, told, words = said(capsys, "report", odd, "-o", tmp_path / "r.html")
    assert (status, told["verdict"]["use"]) == (3, "not usable")
    assert "Verdict: not usable." in words
    assert "not usable" in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_a_budget_of_a_manoeuvre_needs_force(odd, tmp_path, capsys):
    words = ("budget", odd, "--manoeuvre", "turning", "--parts", "s175-3dof", "--speed", "8")
    status, told, _ = said(capsys, *words, "--out", tmp_path / "b")
    assert (status, told["error"]["type"]) == (1, "NotUsableError")
    assert "--force" in told["error"]["problems"][-1]["remedy"]


@pytest.mark.slow
def test_a_ship_that_propelled_herself_turns_with_a_resistance_that_is_estimated(
    pushed, tmp_path, capsys
):
    status, told, _ = said(capsys, "reduce", pushed, "--out", tmp_path / "r")
    assert status == 0
    assert any("thrust less resistance" in text for text in told["verdict"]["reasons"])
    assert all(0.2 < turn["speed_ratio"] < 1.0 for turn in told["turns"])


@pytest.fixture(scope="module")
def feeble(tmp_path_factory):
    """The ship with a propeller that holds her at no speed."""
    file = tmp_path_factory.mktemp("feeble") / "feeble.toml"
    ship = pk.load_model("s175-3dof")
    pk.save_model(ship.with_values("propeller", kt0=-0.1), file)
    return file


@pytest.mark.slow
def test_a_ship_that_no_propeller_holds_costs_the_turn_and_nothing_else(feeble, tmp_path, capsys):
    folder = write_campaign(tmp_path / "tests")
    status, told, words = said(capsys, "reduce", folder, "--parts", feeble, "--out", tmp_path / "r")
    assert status == 0
    assert {file.name for file in (tmp_path / "r").iterdir()} >= {*FILES, "model.toml"}
    assert "No turning circle: No propeller revolutions hold" in words
    assert told["turns"] == []


@pytest.mark.slow
def test_the_way_of_my_data_ends_with_its_results_too(odd, pushed, tmp_path, capsys):
    status, told, words = said(capsys, "demo", "--my-data", odd, "--out", tmp_path / "odd")
    assert status == 3
    assert "not usable" in told["stopped"]
    assert told["result"]["verdict"]["use"] == "not usable"
    assert (tmp_path / "odd" / "report.html").is_file()
    status, told, words = said(capsys, "demo", "--my-data", pushed, "--out", tmp_path / "pushed")
    assert status == 0
    assert "thrust less resistance" in words
    assert (tmp_path / "pushed" / "model.toml").is_file()


@pytest.mark.slow
def test_what_fails_after_the_model_keeps_the_model(tmp_path, capsys, monkeypatch):
    """Of my data too: a band that cannot be told costs the band."""
    folder = write_campaign(tmp_path / "tests")

    def fails(*_, **__):
        raise pk.PmmkitError("no ship of the band comes round")

    monkeypatch.setattr("pmmkit.simulation.ensemble.monte_carlo", fails)
    status, told, words = said(capsys, "demo", "--my-data", folder, "--out", tmp_path / "r")
    assert status == 0
    assert told["result"]["model"] == "model.toml"
    assert "no ship of the band comes round" in words


@pytest.mark.slow
def test_no_number_has_more_digits_than_it_means(tmp_path, capsys):
    """A hull that falls off against its rudder has no steady diameter."""
    ship = pk.load_model("s175-3dof").with_values("hull_polynomial", Nv=0.02)
    track = pk.simulate(ship, speed=8.0, duration=900)
    assert np.isnan(track.metrics["steady_diameter_L"])
    assert any("does not turn to the side of its rudder" in note for note in track.notes)
    pk.save_model(ship, tmp_path / "away.toml")
    for name, *options in (
        ("simulate", "--duration", "900", "--no-figures"),
        ("uncertainty", "--set", "duration=900", "--spread", "0.1", "--ships", "4"),
    ):
        words = [name, tmp_path / "away.toml", "--speed", "8", *options, "--out", tmp_path / name]
        assert main([*map(str, words)]) == 0
        told = capsys.readouterr()
        assert not re.search(r"\d{9}", told.out.replace(str(tmp_path), "")), name
        assert "Warning" not in told.err


@pytest.mark.slow
def test_a_speed_that_no_propeller_holds_costs_the_turn_at_that_speed():
    ship = pk.load_model("s175-3dof")
    drag = ship.parts["hull_polynomial"].values["Xuu"]
    hull = replace(
        ship.parts["hull_polynomial"],
        values={**ship.parts["hull_polynomial"].values, "Xuu": (-drag, drag)},
    )
    model = ship.with_(Fn=(0.145, 0.29), parts={**ship.parts, "hull_polynomial": hull})
    turns = Turns.of(model, ())
    assert [round(track.Fn, 3) for track in turns.tracks] == [0.29]
    assert list(turns.sweeps) == ["these derivatives"]
    (why,) = turns.failed
    assert "No propeller revolutions hold 6" in why
