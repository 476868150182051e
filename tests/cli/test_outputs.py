"""Where commands write: no result takes the place of another unseen."""

from __future__ import annotations

import json

import pytest
from small_campaign import write_campaign

from pmmkit.actions.setting import stem
from pmmkit.cli import main
from pmmkit.models import load_model, save_model

FAST = ("--speed", "1.179", "--no-figures")


@pytest.fixture
def at_home(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_command_typed_three_times_leaves_three_folders(at_home, capsys):
    angles = (35.0, 20.0, 10.0)
    told = []
    for angle in angles:
        assert main(["simulate", "kvlcc2-l7", *FAST, "--rudder-deg", str(angle)]) == 0
        told.append(capsys.readouterr())
    folders = ("kvlcc2-l7-turning", "kvlcc2-l7-turning-2", "kvlcc2-l7-turning-3")
    kept = [json.loads((at_home / name / "metrics.json").read_text()) for name in folders]
    assert [item["rudder_deg"] for item in kept] == list(angles)
    assert not told[0].err
    assert "kvlcc2-l7-turning holds former results: these go to" in told[1].err
    assert "Results: kvlcc2-l7-turning-3" in told[2].out


def test_a_named_folder_is_taken_and_what_stands_there_is_told(at_home, capsys):
    for _ in range(2):
        assert main(["simulate", "kvlcc2-l7", *FAST, "--out", "mine"]) == 0
    assert "mine is not empty: files of the same names are replaced" in capsys.readouterr().err
    assert [folder.name for folder in at_home.iterdir()] == ["mine"]


@pytest.mark.slow
def test_diagnose_thrice_leaves_three_folders_and_hints_at_new_files(at_home, capsys):
    campaign = write_campaign(at_home / "small")
    (at_home / "model2.toml").touch()
    hints = []
    for _ in range(3):
        assert main(["diagnose", "linear", str(campaign), "--no-figures"]) == 0
        hints.append(capsys.readouterr().out)
        (at_home / "small-reduced").mkdir(exist_ok=True)
        (at_home / "small-reduced" / "model.toml").touch()
    found = {folder.name for folder in at_home.glob("small-diagnosed*")}
    assert found == {"small-diagnosed", "small-diagnosed-2", "small-diagnosed-3"}
    assert all("-o model3.toml" in text for text in hints)
    assert "--out small-reduced\n" in hints[0]
    assert "--out small-reduced-2\n" in hints[1]
    assert "pmmkit add small-reduced-2/model.toml" in hints[1]


def test_add_does_not_write_over_its_own_input_unless_forced(at_home, capsys):
    campaign = write_campaign(at_home / "small")
    save_model(load_model("s175-3dof"), "own.toml")
    before = (at_home / "own.toml").read_bytes()
    order = ["add", "own.toml", "nonlinear_added_mass", "--fit", str(campaign)]
    assert main([*order, "-o", "./own.toml"]) == 1
    assert "own.toml is what is read: it was not replaced." in capsys.readouterr().err
    assert (at_home / "own.toml").read_bytes() == before
    assert main([*order, "-o", "own.toml", "--force"]) == 0
    assert "nonlinear_added_mass" in load_model("own.toml").parts


def test_add_leaves_no_model_without_its_folder(at_home, capsys, monkeypatch):
    """What stops while pictures are drawn leaves neither of the two."""
    from pmmkit.actions.jobs import add

    def full(fall, drawn):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(add, "_files", full)
    campaign = write_campaign(at_home / "small")
    order = ["add", "s175-3dof", "nonlinear_added_mass", "--fit", str(campaign), "-o", "new.toml"]
    assert main([*order, "--out", "new"]) != 0
    assert "No space left" in capsys.readouterr().err
    assert [item.name for item in at_home.iterdir()] == ["small"]


@pytest.mark.parametrize(
    ("order", "read"),
    [
        (
            ("scale", "m/model.toml", "--length", "320", "--froude-only", "--out", "m"),
            "m/model.toml",
        ),
        (("model", "set", "m/model.toml", "Nvvr=-0.04", "-o", "m/model.toml"), "m/model.toml"),
    ],
)
def test_no_command_writes_its_model_over_the_one_it_read(order, read, at_home, capsys):
    save_model(load_model("kvlcc2-l7"), read)
    before = (at_home / read).read_bytes()
    assert main(list(order)) == 1
    assert "is what is read" in capsys.readouterr().err
    assert (at_home / read).read_bytes() == before
    assert main([*order, "--force"]) == 0
    assert (at_home / read).read_bytes() != before


def test_files_without_a_name_take_the_next_one(at_home):
    for _ in range(2):
        assert main(["model", "set", "kvlcc2-l7", "Nvvr=-0.04"]) == 0
        assert main(["export", "kvlcc2-l7", "--to", "mss", "--speed", "1.2"]) == 0
    names = {file.name for file in at_home.iterdir()}
    assert {"kvlcc2-l7-changed.toml", "kvlcc2-l7-changed-2.toml"} <= names
    assert len([name for name in names if name.endswith(".m")]) == 2


@pytest.mark.parametrize("name", ["tests.zip", "tests.h5", "tests", "tests/campaign.toml"])
def test_results_are_named_as_the_campaign_however_it_is_packed(at_home, name):
    assert stem(at_home / name) == "tests"
