"""``pmmkit model``: what a user types, mistakes included."""

from __future__ import annotations

import pytest

import pmmkit as pk
from pmmkit.cli import main
from tests.support.commands import said


def test_values_and_parts_are_changed_in_a_new_file(tmp_path, capsys):
    first, second = tmp_path / "a.toml", tmp_path / "b.toml"
    status, told, _ = said(
        capsys, "model", "set", "kvlcc2", "rudder.area=120", "--because", "as built", "-o", first
    )
    assert status == 0
    assert told["steps"][-1] == "Stated: rudder_mmg.area = 120, because as built."
    status, _, _ = said(
        capsys, "model", "replace", first, "propeller", "--from", "kcs", "-o", second
    )
    assert status == 0
    made = pk.load_model(second)
    assert made.part("rudder_mmg").values["area"] == 120.0
    assert made.part("propeller").source == "library: kcs"
    assert pk.simulate(made, speed=7.97, rudder_deg=35).metrics["tactical_diameter_L"] > 2.0


def test_it_shows_what_the_model_lacks(capsys, tmp_path):
    _, told, _ = said(capsys, "model", "show", "kvlcc2")
    assert told["lacks"] == []
    assert told["parts"]["propeller"]["values"]["D"]["value"] == pytest.approx(9.86)
    whole = pk.load_model("kvlcc2")
    hull = whole.with_(parts={k: x for k, x in whole.parts.items() if k != "rudder_mmg"})
    pk.save_model(hull, tmp_path / "hull.toml")
    _, told, _ = said(capsys, "model", "show", tmp_path / "hull.toml")
    assert len(told["lacks"]) == 1
    assert "rudder_mmg" in told["lacks"][0]


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (("set", "kvlcc2", "rudder.area"), "write rudder.area=0.055"),
        (("set", "kvlcc2"), "Write what is set"),
        (("set", "kvlcc2", "rudder.aera=3"), "did you mean 'area'"),
        (("replace", "kvlcc2", "propeller"), "--from"),
        (("replace", "kvlcc2", "thruster", "--from", "kcs"), "no part 'thruster'"),
        (("show", "kvlcc2", "propeller"), "show takes a model alone"),
    ],
)
def test_what_is_typed_wrong_is_answered(words, answer, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["model", *words]) != 0
    assert answer in " ".join(capsys.readouterr().err.split())
    assert not list(tmp_path.iterdir())
