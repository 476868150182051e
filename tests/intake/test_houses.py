"""Laboratories with habits of their own: pounds and feet, numbered LabVIEW files with a list of the
tests, monitors of a computation, one HDF5 file, one MATLAB file of structs, one text, Tecplot.

The files and the truth share no code with the package (`scripts.datasets.strangers`).
"""

from __future__ import annotations

import json

import numpy as np
import pytest

from pmmkit.campaigns import open_campaign
from pmmkit.cli import main
from pmmkit.intake.drafts.motion import motion_facts
from pmmkit.intake.drafts.names import facts_of
from scripts.datasets.strangers.houses import HOUSES, SPEED, programme
from scripts.datasets.strangers.hulls import RHO, TANKER, forces, inertia
from scripts.datasets.strangers.motions import circle, drift
from scripts.studies.strangers import PLACES, filled, held, particulars

QUESTIONS = 4
"""That a draft may leave to a person."""
OUTSIDE = 4
"""Intervals of 95 % that may miss among 16, in one draw of the noise."""


@pytest.fixture(scope="module", params=list(HOUSES))
def house(request, tmp_path_factory):
    """Name of a laboratory, and its folder with the draft as it was written."""
    folder = tmp_path_factory.mktemp(request.param) / "tests"
    HOUSES[request.param](folder)
    assert main(["new-campaign", str(folder), "--quiet"]) == 0
    return request.param, folder


@pytest.fixture(scope="module")
def stated(house):
    """The folder with the ship stated where the draft asks for her."""
    _, folder = house
    file = folder / "campaign.toml"
    draft = file.read_text(encoding="utf-8")
    asked = [item for item in (*particulars(TANKER), PLACES) if item[0] in draft]
    file.write_text(filled(draft, asked), encoding="utf-8")
    return folder


def test_a_draft_leaves_few_questions_and_every_run_is_as_it_was_set(house, stated, capsys):
    name, folder = house
    again = ["new-campaign", str(folder), "-o", str(folder / "again.toml"), "--json"]
    assert main(again) == 0
    assert len(json.loads(capsys.readouterr().out)["todo"]) <= QUESTIONS
    kinds = {"drift": "static_drift", "sway": "pure_sway", "yaw": "pure_yaw"}
    wanted = sorted(
        (kinds[order.kind], round(order.set_to.get("beta", 0.0), 2), order.set_to.get("T", 0.0))
        for order in programme()
    )
    campaign = open_campaign(stated)
    # Forces and headings that count to port may be taken for those of the ship in a mirror.
    side = -1.0 if name == "listed_tdms" else 1.0
    found = sorted(
        (run.test, side * round(float(np.degrees(run.settings.drift)), 2), run.settings.period or 0)
        for run in campaign
    )
    assert [item[0] for item in found] == [item[0] for item in wanted]
    assert np.array([x[1:] for x in found]) == pytest.approx(
        np.array([x[1:] for x in wanted]), abs=0.02
    )
    assert {round(run.settings.speed, 2) for run in campaign} == {SPEED}
    if name == "pounds":
        assert campaign.ship.mass == pytest.approx(TANKER.mass, rel=1e-3)


def test_nothing_sound_is_accused(stated, capsys):
    assert main(["check", str(stated), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["findings"]
    assert [item["message"] for item in found if item["severity"] != "info"] == []


def test_the_derivatives_hold_the_truth(stated, tmp_path):
    assert main(["reduce", str(stated), "--out", str(tmp_path / "reduced"), "-q"]) == 0
    inside, missed, _ = held(TANKER, tmp_path / "reduced" / "derivatives.csv")
    assert (inside + len(missed), len(missed) <= OUTSIDE) == (16, True), missed


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        ("ST_beta_m04", "drift_deg", -4.0),
        ("drift_bp08", "drift_deg", 8.0),
        ("rudder_m10_beta_p02", "rudder_deg", -10.0),
        ("drift_0deg_V1p2", "speed", 1.2),
        ("SD_V3.94fps", "speed", 3.94 * 0.3048),
        ("pure_sway_A0.82ft", "amplitude_m", 0.82 * 0.3048),
    ],
)
def test_signs_as_letters_and_feet_in_names(name, key, value):
    assert facts_of(name).settings[key][0] == pytest.approx(value)


@pytest.fixture
def mean_cycle(tmp_path):
    """A drift test with samples in time, and a mean cycle over t/T beside it."""
    t = np.linspace(0.0, 20.0, 401)
    steady = np.column_stack([t, *(0.01 * np.sin(7.0 * t + x) - 0.02 for x in range(3))])
    cycle = np.linspace(0.0, 1.0, 65)
    swing = np.column_stack([cycle, *(np.sin(2 * np.pi * cycle + x) for x in range(4))])
    np.savetxt(
        tmp_path / "SD_U1.2_beta+4.csv", steady, "%.6f", ",", header="t,X',Y',N'", comments=""
    )
    return tmp_path, swing


def todo_of(folder, capsys):
    assert main(["new-campaign", str(folder), "--json"]) == 0
    return json.loads(capsys.readouterr().out)["todo"]


def test_a_cycle_over_its_period_needs_the_period(mean_cycle, capsys):
    folder, swing = mean_cycle
    head = "t/T,y [m],X',Y',N'"
    np.savetxt(folder / "PS_U1.2_a0.4m.csv", swing, "%.6f", ",", header=head, comments="")
    asked = todo_of(folder, capsys)
    assert any("period [s]" in text and "PS_U1.2_a0.4m" in text for text in asked)
    assert any("prime-d" in text for text in asked)  # primes are no newtons
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    assert "by which t/T is to be multiplied" in text
    assert "taken as SI" not in text.replace("its exact name; no unit stated, taken as SI", "")


def test_files_that_are_named_as_tests_are_not_dropped_in_silence(mean_cycle, capsys):
    folder, swing = mean_cycle
    swing = np.random.default_rng(1).normal(size=swing.shape)
    np.savetxt(
        folder / "PS_U1.2_T9s_a0.4m.csv", swing, "%.6f", ",", header="K1,K2,K3,K4,K5", comments=""
    )
    np.savetxt(folder / "shape.csv", swing, "%.6f", ",", header="K1,K2,K3,K4,K5", comments="")
    (told,) = (text for text in todo_of(folder, capsys) if "Named as tests" in text)
    assert "PS_U1.2_T9s_a0.4m.csv" in told
    assert "shape" not in told


def circular_tests(file, names, factor):
    """A table of a rotating arm as laboratories publish it: β, r' and forces over ½ρLdU²."""
    rng = np.random.default_rng(3)
    unit = 0.5 * RHO * TANKER.L * TANKER.d * SPEED**2
    rows = []
    for turned in (0.0, 0.2, 0.4, 0.6):
        for beta in (-8, -4, 0, 4, 8, 12, 16):
            driven = circle(SPEED, TANKER.L / turned, beta) if turned else drift(SPEED, beta)
            moved = driven(np.zeros(1))
            water, pull = forces(TANKER, moved), inertia(TANKER, moved)
            X, Y, N = (
                (water[key][0] - pull[key][0] + std * rng.standard_normal()) / unit
                for key, std in (("X", 0.05), ("Y", 0.1), ("N", 0.1))
            )
            told = np.array([X, Y, N / TANKER.L]) * factor
            rows.append((len(rows) + 1, SPEED, beta, turned, *told))
    head = f"No.,U0 (m/s),beta (deg),r',{','.join(names)}"
    np.savetxt(file, rows, "%.6g", ",", header=head, comments="")


@pytest.mark.parametrize(
    ("names", "factor"),
    [
        (("X'", "Y'", "N'"), 1.0),
        (("CX", "CY", "CN"), 1.0),
        (("X'H (x10^3)", "Y'H (x10^3)", "N'H (x10^3)"), 1e3),
    ],
)
def test_a_published_table_of_circular_tests_is_read(names, factor, tmp_path, capsys):
    """Its first column counts the tests and is no time; its yaw rate is r' = rL/U."""
    folder = tmp_path / "arm"
    folder.mkdir()
    circular_tests(folder / "CMT.csv", names, factor)
    assert len(todo_of(folder, capsys)) <= QUESTIONS + 1
    draft = (folder / "campaign.toml").read_text(encoding="utf-8")
    known = [item for item in particulars(TANKER) if item[0] in draft]
    system = ('nondimensional = "prime"', 'nondimensional = "prime-d"')
    balance = ('forces = "hydrodynamic"', 'forces = "balance"')
    (folder / "campaign.toml").write_text(filled(draft, [*known, system, balance]), "utf-8")
    campaign = open_campaign(folder)
    rates = {round(run.settings.turn_rate * TANKER.L / SPEED, 3) for run in campaign}
    assert rates == {0.0, 0.2, 0.4, 0.6}
    assert main(["check", str(folder), "--json"]) == 0
    assert not json.loads(capsys.readouterr().out)["findings"]
    assert main(["reduce", str(folder), "--out", str(tmp_path / "r"), "--json", "--quiet"]) == 0
    inside, missed, _ = held(TANKER, tmp_path / "r" / "derivatives.csv")
    assert (inside + len(missed), len(missed) <= OUTSIDE) == (16, True), missed


@pytest.mark.parametrize("side", [1, -1])
def test_a_turn_tells_to_which_side_its_rudder_turns(side):
    """However her yaw rate falls with her speed."""
    t = np.arange(0.0, 300.0, 0.5)
    under = np.clip(t - 10.0, 0.0, None)
    rate = 0.02 * (1 - np.exp(-under / 8.0)) * (0.5 + 0.5 * np.exp(-under / 40.0))
    psi = side * np.cumsum(rate) * 0.5
    delta = np.radians(35.0) * np.clip(under / 5.0, 0.0, 1.0)
    along, across = (np.cumsum(3.0 * part(psi)) for part in (np.cos, np.sin))
    found = motion_facts(t, {"psi": psi, "delta": delta, "x": along, "y": across}, "turning")
    assert (found.turned, found.settings["rudder_deg"][0]) == (side, 35.0)
