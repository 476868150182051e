"""``pmmkit reduce --method``: what it writes and says of several methods."""

from __future__ import annotations

import csv
import json
from typing import get_args

import pytest
from small_campaign import TRUTH, write_campaign

import pmmkit
from pmmkit.actions.jobs.reduce import Fourier, Method
from pmmkit.cli import main
from pmmkit.models import ReferenceTable
from pmmkit.reduction.methods.registry import ALL, METHODS


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return write_campaign(tmp_path_factory.mktemp("tests") / "small")


def test_the_command_offers_every_method():
    assert list(get_args(Method)) == [*METHODS, ALL]
    assert "trapezoid" in get_args(Fourier)


@pytest.mark.slow
def test_all_methods_stand_side_by_side(campaign, tmp_path, capsys):
    out = tmp_path / "all"
    assert main(["reduce", str(campaign), "--method", "all", "--out", str(out), "--json"]) == 0
    output = capsys.readouterr()
    content = json.loads(output.out)
    assert content["method"] == "regression"
    assert list(content["methods"]) == list(METHODS)
    assert set(content["methods"]["ekf"]["innovations"][0]) >= {"channel", "nis", "p_white"}
    assert "Kalman filter: at most" in output.err
    with (out / "derivatives_by_method.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    titles = {row["method"] for row in rows}
    assert {"global regression", "harmonics", "sparse regression", "Kalman filter"} <= titles
    assert "published: Son and Nomoto 1981" in titles
    beside = [row for row in rows if row["method"] == "Kalman filter"]
    assert {row["derivative"] for row in beside} == set(TRUTH)
    shares = [row for row in rows if row["derivative"] == "Yv|v|" and row["share"]]
    assert {row["method"].partition(":")[0] for row in shares} == {"sparse regression"}
    assert all(0 <= float(row["share"]) <= 1 for row in shares)
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "part of the bags of runs in which each term was taken" in report
    assert "Every method less the global regression" in report
    assert (out / "methods.svg").is_file()


@pytest.mark.slow
def test_the_table_and_the_model_are_of_the_method_that_was_asked_for(campaign, tmp_path, capsys):
    out = tmp_path / "harmonics"
    arguments = ["--method", "harmonics", "--fourier", "trapezoid", "--cycles", "1"]
    assert main(["reduce", str(campaign), *arguments, "--out", str(out)]) == 0
    table = pmmkit.read_table(out / "derivatives.csv")
    assert set(table.method.ravel()) == {"harmonics"}
    model = pmmkit.load_model(out / "model.toml")
    assert model.parts["hull_polynomial"].values["Yv"] == pytest.approx(table["Yv"])
    assert "by harmonics (Each derivative" in (out / "report.html").read_text(encoding="utf-8")
    assert ReferenceTable.published(table).name == "Son and Nomoto 1981"
    capsys.readouterr()


def test_a_ship_that_the_library_does_not_hold_has_no_published_values():
    ship = pmmkit.Ship(name="m", L=5.0, B=1.0, d=0.2, volume=0.5, mass=500.0, Izz=600.0)
    table = pmmkit.from_values({"Yv": -0.01}, ship=ship, water=pmmkit.Water())
    assert ReferenceTable.published(table) is None


def test_an_unknown_method_is_refused_with_those_there_are(campaign, tmp_path, capsys):
    assert main(["reduce", str(campaign), "--method", "magic", "--out", str(tmp_path / "x")]) == 2
    assert "harmonics" in capsys.readouterr().err
