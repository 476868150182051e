"""What users mistype, and the answers that say what to type instead."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from pmmkit.cli import main
from pmmkit.models import load_model, save_model

SHIP = '[ship]\nname = "kvlcc2-l7"\n[water]\nrho = 1000.0\n'


@pytest.mark.parametrize(
    ("typed", "status", "said"),
    [
        ("turn kvlcc2", 2, "--manoeuvre turning"),
        ("simulate kvlcc2 zigzag --speed 8", 2, "--manoeuvre zigzag"),
        ("simulate kvlcc2", 2, "State the speed of the approach: 8.0 [m/s], '15.5 kn'"),
        ("scale kvlcc2 --to 36", 2, "Example: pmmkit scale kvlcc2-l7 --length"),
        ("compare kvlcc2", 2, "All options: pmmkit compare --help"),
        ("reduce . --missing none", 2, "pmmkit: Invalid value for '--missing': 'none' is not"),
        ("effects kross", 1, "There are: added_mass"),
        ("reduce a.csv", 1, "a file of measurements; the campaign file says what it holds"),
        ("reduce .", 1, "There is one in tests, twice: name that folder."),
        ("reduce empty", 1, "pmmkit new-campaign empty drafts one from its files"),
        ("simulate tests --speed 1", 1, "pmmkit reduce tests makes a model"),
        ("simulate made --speed 1", 1, "It holds one: write made/model.toml"),
        ("check twice", 1, "This name stands twice in its table"),
        ("model set kvlcc2 rudder.arae=3", 1, "did you mean 'area'?"),
        ("card fit nothere", 1, "nothere: there is no such card. pmmkit card form makes one"),
        ("simulate kvlcc2 8 9", 2, "'8' and '9' are too much"),
        ("trial kvlcc2 nothere", 2, "trial takes 1 argument, campaign: 'nothere' is too much"),
        ("new-campaign tests", 1, "Name another -o, or --force"),
    ],
)
def test_a_mistake_is_answered_with_what_to_type(
    typed, status, said, tmp_path, monkeypatch, capsys
):
    for folder in ("tests", "made", "twice", "empty"):
        (tmp_path / folder).mkdir()
    (tmp_path / "a.csv").write_text("t,X\n0,1\n1,2\n", encoding="utf-8")
    (tmp_path / "tests" / "campaign.toml").write_text(SHIP, encoding="utf-8")
    (tmp_path / "made" / "model.toml").write_text("", encoding="utf-8")
    (tmp_path / "twice" / "campaign.toml").write_text(f"{SHIP}rho = 1.0\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(typed.split()) == status
    assert said in capsys.readouterr().err


def test_a_model_of_one_speed_sails_there(tmp_path, monkeypatch, capsys):
    model = load_model("kvlcc2")
    save_model(replace(model, Fn=(0.142,)), tmp_path / "one.toml")
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "one.toml", "--no-figures"]) == 0
    said = capsys.readouterr()
    assert f"{0.142 * (9.81 * 320.0) ** 0.5:.4g} m/s, Fn 0.142" in said.err


def test_json_holds_the_answer_too(capsys):
    assert main(["turn", "kvlcc2", "--json"]) == 2
    told = json.loads(capsys.readouterr().out)["error"]
    assert told["type"] == "usage"
    assert told["message"].endswith("--manoeuvre turning.")


@pytest.mark.parametrize(
    ("command", "file"), [("model", "MODEL-changed.toml"), ("new-campaign", "campaign.toml beside")]
)
def test_the_help_tells_where_a_file_goes_that_is_not_named(command, file, capsys):
    assert main([command, "--help"]) == 0
    assert f"is {file}" in " ".join(capsys.readouterr().out.split())
