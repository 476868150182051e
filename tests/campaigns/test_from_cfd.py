"""From what OpenFOAM and STAR-CCM+ wrote to a derivative table, in the commands as typed."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from pmmkit.cli import main
from pmmkit.models import read_table
from scripts.datasets.campaign_text import S175
from scripts.datasets.make_cfd_cases import SPEED, history, programme, write_openfoam, write_star
from scripts.datasets.s175_truth import load_truth
from scripts.datasets.virtual_tank import SHIP, WATER

MESH = {
    "openfoam": """[axes]
y = "-y"
z = "-z"
[cfd]
forces_in = "earth"
moment_centre_moves = false
ramp_s = 9.0
""",
    "star": """[axes]
x = "-x"
z = "-z"
[cfd]
ramp_s = 9.0
""",
}


def filled_in(text: str, solver: str) -> str:
    """The draft with what a person must say."""
    head, tail = text.split("[ship]")[0], text[text.index("[source]") :]
    tail = re.sub(r"# ([vr]_amplitude = [0-9.]+) .*", r"\1", tail)
    tail = re.sub(r"period = 12[0-9.]+ .*", "period = 12.7264", tail)
    tail = re.sub(r"period = 9[0-9.]+ .*", "period = 9.2555", tail)
    return head + S175 + MESH[solver] + tail


def run(*words) -> int:
    return main([str(word) for word in words])


def drafted(solver: str, folder: Path) -> Path:
    """The draft of the campaign file of a solver's cases."""
    phase = {"openfoam": 0.0, "star": math.pi}[solver]
    write = {"openfoam": write_openfoam, "star": write_star}[solver]
    for plan in programme():
        write(folder, plan, history(plan, phase=phase if plan.yaw_amplitude else 0.0))
    assert run("new-campaign", folder) == 0
    return folder / "campaign.toml"


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["openfoam", "star"])
def test_a_start_up_and_a_restart_leave_the_truth(solver, tmp_path):
    draft = drafted(solver, tmp_path)
    draft.write_text(filled_in(draft.read_text(encoding="utf-8"), solver), encoding="utf-8")
    assert run("check", tmp_path) == 0
    assert run("reduce", tmp_path, "--out", tmp_path / "reduced") == 0
    table = read_table(tmp_path / "reduced" / "derivatives.csv")
    truth = load_truth().at(SHIP.froude(SPEED, WATER.g))
    found = table.at()
    for name in ("Xuu", "Xvv", "Yv", "Yr", "Yvvv", "Yvdot", "Nv", "Nr", "Nvvr", "Nrdot"):
        assert found[name] == pytest.approx(truth[name], rel=0.005), name


@pytest.mark.slow
def test_an_axis_that_was_not_stated_is_seen_in_the_signs_of_the_drift(tmp_path, capsys):
    """The cases recorded their motion, so no run has the settings of its oscillation."""
    draft = drafted("openfoam", tmp_path)
    text = filled_in(draft.read_text(encoding="utf-8"), "openfoam")
    draft.write_text(text.replace('y = "-y"\n', ""), encoding="utf-8")
    assert run("check", tmp_path) == 1
    assert "Y' over the drift angle" in capsys.readouterr().out
