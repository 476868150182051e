"""What is mistyped is answered with the nearest name there is."""

from __future__ import annotations

import re

import pytest
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.cli import main


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    folder = tmp_path_factory.mktemp("desk")
    write_campaign(folder / "small")
    model = pk.load_model("s175-3dof")
    pk.save_model(model, folder / "model.toml")
    text = (folder / "model.toml").read_text(encoding="utf-8")
    (folder / "key.toml").write_text(text.replace("[ship]", "[shp]", 1), encoding="utf-8")
    campaign = (folder / "small" / "campaign.toml").read_text(encoding="utf-8")
    for name, right, wrong in (("table", "[water]", "[watr]"), ("entry", "rho =", "roh =")):
        (folder / name).mkdir()
        (folder / name / "campaign.toml").write_text(campaign.replace(right, wrong), "utf-8")
    return folder


@pytest.mark.parametrize(
    ("order", "status", "meant"),
    [
        ("simulat", 2, "simulate"),
        ("simulate kvlcc2 --sped 8", 2, "--speed"),
        ("simulate kvlcc3 --speed 8", 1, "kvlcc2"),
        ("simulate kvlcc2 --speed 8 --manoeuvre zigzig", 1, "zigzag"),
        ("simulate kvlcc2 --speed 8 --manoeuvre zigzag --set execute=3", 1, "executes"),
        ("simulate key.toml --speed 8", 1, "ship"),
        ("model set model.toml ruder.area=1", 1, "rudder_mmg"),
        ("add model.toml crossflow_drga --fit small", 1, "crossflow_drag"),
        ("diagnose linear small --given memori", 1, "memory"),
        ("diagnose cubc small", 1, "cubic"),
        ("reduce small --structure abkowitz", 1, "abkowitz3"),
        ("check table", 1, "water"),
        ("check entry", 1, "rho"),
        ("uncertainty kvlcc2 --speed 8 --spread 0.1 --ships 2 --metric advence_L", 1, "advance_L"),
    ],
)
def test_the_nearest_name_is_said(order, status, meant, desk, monkeypatch, capsys):
    monkeypatch.chdir(desk)
    assert main(order.split()) == status
    words = capsys.readouterr().err
    if status == 2:  # typer's own words
        assert re.search(rf"No such .*\W{meant}\b", words)
    else:
        assert f"did you mean '{meant}'" in words


@pytest.mark.parametrize("order", ["simulate cubic --speed 8", "add cubic memory --fit small"])
def test_a_structure_in_the_place_of_a_ship_is_told_what_makes_a_model(
    order, desk, monkeypatch, capsys
):
    monkeypatch.chdir(desk)
    assert main(order.split()) == 1
    assert "pmmkit reduce --structure cubic makes a model" in capsys.readouterr().err


def test_a_derivative_that_a_table_lacks_is_guessed(desk):
    table = pk.reduce(pk.open_campaign(desk / "small"), structure="linear", fn="pooled")
    with pytest.raises(pk.PmmkitError, match="did you mean 'Nr'"):
        table["Nrr"]
