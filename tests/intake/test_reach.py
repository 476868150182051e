"""Harbour tests beside a programme about straight ahead: told, and left out with the reason."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit import open_campaign
from pmmkit.cli import main
from pmmkit.intake import examine

HARBOUR = """[campaign]
title = "harbour"
[ship]
name = "model"
L = 4.0
B = 0.6
d = 0.25
volume = 0.36
mass = 360.0
Izz = 360.0
[water]
rho = 1000.0
[[tables]]
id = "D{row}"
test = "static_drift"
file = "drift.csv"
columns = { speed = "U", drift_deg = "beta", Y = "Y", N = "N" }
[[tables]]
id = "T{row}"
test = "circular_motion"
file = "turns.csv"
columns = { speed = "U", yaw_rate = "r", Y = "Y", N = "N" }
"""


@pytest.fixture
def harbour(tmp_path):
    """Drift to 180°, turns ahead and on the spot, by hand: Yv' = -.25, Nv' = -.09, Nr' = -.04."""
    drift = [(1.0, beta, *_forces(1.0, beta, 0.0)) for beta in (-10, -5, 0, 5, 10, 90, 180)]
    turns = [(U, r, *_forces(U, 0.0, r)) for U in (1.0, 0.0) for r in (-0.1, -0.05, 0.05, 0.1)]
    for name, head, rows in (("drift", "U,beta,Y,N", drift), ("turns", "U,r,Y,N", turns)):
        lines = [head, *(",".join(f"{value:.6g}" for value in row) for row in rows)]
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "campaign.toml").write_text(HARBOUR)
    return tmp_path


def _forces(U, beta, r):
    L, q = 4.0, 0.5 * 1000.0 * 4.0 * 0.25
    v = -U * math.sin(math.radians(beta))
    return q * (-0.25 * U * v + 0.05 * U * L * r), q * L * (-0.09 * U * v - 0.04 * U * L * r)


def test_turns_on_the_spot_are_no_runs_and_that_is_said(harbour):
    campaign = open_campaign(harbour)
    assert [run.id for run in campaign.runs if run.test == "circular_motion"] == [
        "T2",
        "T3",
        "T4",
        "T5",
    ]
    told = [item for item in examine(campaign) if item.check == "reach"]
    assert [item.severity for item in told] == ["info", "info"]
    across, rows = told
    assert across.runs == ("D7", "D8")
    assert "above 45°" in across.message
    assert "4 rows left out, at no speed" in rows.message
    assert "turns.csv row 6 to turns.csv row 9" in rows.message


def test_a_table_of_them_is_that_of_the_runs_ahead(harbour, tmp_path, capsys):
    assert main(["reduce", str(harbour), "--out", str(tmp_path / "r"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    value = {row["derivative"]: row["value"] for row in told["table"]}
    assert value["Nv"] == pytest.approx(-0.09 * 0.25 / 4.0, rel=1e-4)
    assert value["Nr"] == pytest.approx(-0.04 * 0.25 / 4.0, rel=1e-4)
    assert set(told["excluded"]) == {"D7", "D8"}
    assert any("row 6" in item["message"] for item in told["findings"])


def test_a_diagnosis_leaves_the_flow_across_the_hull_out(tmp_path):
    campaign = open_campaign(write_campaign(tmp_path / "small"))
    first = next(run for run in campaign.runs if run.test == "static_drift")
    across = first.with_(id="across", settings=replace(first.settings, drift=math.pi / 2))
    plain, wide = (
        pk.diagnose("cubic", each, noise=0.01)
        for each in (campaign, campaign.with_(runs=(*campaign.runs, across)))
    )
    assert plain.to_dict() == wide.to_dict()
