"""Rows of a sheet that are the samples of one run: dynamic tests of one cycle, as published."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import openpyxl
import pytest

from pmmkit import open_campaign, reduce_campaign
from pmmkit.base import CampaignError

HEAD = ("Test", "Kind", "y [m]", "psi [deg]", "u [m/s]", "v [m/s]", "r [deg/s]", "delta [deg]")
FORCES = ("X [N]", "Y [N]", "N [Nm]")
TOP = """[campaign]
forces = "hydrodynamic"
[ship]
L = 4.0
B = 0.6
d = 0.2
volume = 0.3
Izz = 300.0
[water]
rho = 1000.0
"""
CYCLE = """[[tables]]
id = "{Test}"
test = "TEST"
file = "tests.xlsx"
samples = "cycle"
where = { Kind = ["SWAY", "YAW"] }
[tables.columns]
y = "y [m]"
psi = "psi [deg]"
u = "u [m/s]"
v = "v [m/s]"
r = "r [deg/s]"
"""
SPEED, PERIOD, COUNT = 0.6, 40.0, 24
Yv, Yvdot, Nv, Nvdot = -60.0, -250.0, -90.0, -20.0


def forces(v: np.ndarray, vdot: np.ndarray) -> list[np.ndarray]:
    """X, Y [N] and N [N m] of a hull that is linear in sway."""
    return [-2.0 + 0 * v, Yv * v + Yvdot * vdot, Nv * v + Nvdot * vdot]


def sway(name: str, amplitude: float, count: int = COUNT) -> list[list[object]]:
    """One cycle of pure sway, the phase of its first row not zero."""
    phase = 2 * math.pi * (np.arange(count) + 0.5) / count
    omega = 2 * math.pi / PERIOD
    y, v = amplitude * np.sin(phase), amplitude * omega * np.cos(phase)
    motion = [y, 0 * y, np.full(count, SPEED), v, 0 * y, 0 * y]
    table = [*motion, *forces(v, -(omega**2) * y)]
    return [[name, "SWAY", *map(float, row)] for row in zip(*table, strict=True)]


def book(folder: Path, rows: list[list[object]]) -> Path:
    page = openpyxl.Workbook()
    page.active.append([*HEAD, *FORCES])
    for row in rows:
        page.active.append(row)
    page.save(folder / "tests.xlsx")
    return folder


def opened(folder: Path, table: str):
    (folder / "campaign.toml").write_text(TOP + table, encoding="utf-8")
    return open_campaign(folder)


STATISTICS = [["a", "AVERAGE", *[9.0] * 9], ["a", "STAND. DEV.", *[0.1] * 9]]


def test_rows_of_one_name_are_one_run(tmp_path):
    """Speed, period and amplitude are those of the motion, though no column is a time."""
    rows = [*sway("a", 0.2), *STATISTICS, *sway("b", 0.3)]
    campaign = opened(book(tmp_path, rows), CYCLE.replace("TEST", "pure_sway"))
    assert [run.id for run in campaign] == ["a", "b"]
    for run, amplitude in zip(campaign, (0.2, 0.3), strict=True):
        assert run.kind == "history"
        assert run.settings.period == pytest.approx(PERIOD, rel=1e-9)
        assert run.settings.amplitude == pytest.approx(amplitude, rel=1e-9)
        assert run.settings.speed == pytest.approx(SPEED, rel=2e-3)
        t = run.data["t"].values
        assert t == pytest.approx(np.arange(COUNT) * PERIOD / COUNT)
    assert campaign["b"].source == "tests.xlsx rows 28 to 51"
    assert campaign["b"].data["v"].values[0] == pytest.approx(rows[-24][5])


def test_they_reduce_as_a_record_does(tmp_path):
    rows = [row for place in range(3) for row in sway(f"s{place}", 0.1 * (place + 1))]
    campaign = opened(book(tmp_path, rows), CYCLE.replace("TEST", "pure_sway"))
    table = reduce_campaign(campaign, structure="Yv Yvdot Nv Nvdot").table
    scale = 0.5 * 1000.0 * 4.0**2
    found = table["Yv"].item() * scale * SPEED, table["Yvdot"].item() * scale * 4.0
    assert found == pytest.approx((Yv, Yvdot), rel=5e-3)


def test_too_short_a_cycle_is_told(tmp_path):
    table = CYCLE.replace("TEST", "pure_sway")
    with pytest.raises(CampaignError, match="a cycle of 6 samples is too short: 8 are needed"):
        opened(book(tmp_path, sway("a", 0.2, count=6)), table)


def test_a_steady_test_has_no_cycle(tmp_path):
    table = CYCLE.replace("TEST", "static_drift")
    with pytest.raises(CampaignError, match="a static_drift test has no cycle"):
        opened(book(tmp_path, sway("a", 0.2)), table)


def test_without_displacement_the_period_is_asked_for(tmp_path):
    table = CYCLE.replace("TEST", "pure_sway").replace('y = "y [m]"\n', "")
    book(tmp_path, sway("a", 0.2))
    with pytest.raises(CampaignError, match="need its period, or displacement and velocity"):
        opened(tmp_path, table)
    stated = table.replace("[tables.columns]", "period = 40.0\n[tables.columns]")
    assert opened(tmp_path, stated)["a"].settings.period == 40.0


def test_samples_in_time_need_a_time(tmp_path):
    table = CYCLE.replace("TEST", "pure_sway").replace('"cycle"', '"time"')
    with pytest.raises(CampaignError, match="samples in time need a column t"):
        opened(book(tmp_path, sway("a", 0.2)), table)


def test_a_steady_row_has_the_speed_through_the_water(tmp_path):
    """A model that is towed sideways: u is zero, and U is not."""
    rows = [["d12", "STAT", 0.0, 12.0, 0.6, -0.8, 0.0, 0.0, -1.0, 3.0, 4.0]]
    table = CYCLE.replace("TEST", "static_drift").replace('samples = "cycle"\n', "")
    table = table.replace('["SWAY", "YAW"]', '"STAT"')
    assert opened(book(tmp_path, rows), table)["d12"].settings.speed == pytest.approx(1.0)


def test_rows_are_told_apart_by_their_place(tmp_path):
    """Five rows of one slow sweep of the rudder, each a steady test."""
    rows = [["m", "STAT", 0, 0, 0.6, 0.0, 0, 7.0 * n, -1.0, 3.0, 4.0] for n in range(5)]
    table = CYCLE.replace("TEST", "static_rudder").replace('samples = "cycle"\n', "")
    table = table.replace('["SWAY", "YAW"]', '"STAT"').replace("{Test}", "{Test}_{row}")
    campaign = opened(book(tmp_path, rows), table + 'rudder_deg = "delta [deg]"\n')
    assert [run.id for run in campaign] == [f"m_{row}" for row in range(2, 7)]


def test_what_stands_below_the_last_row_is_not_read(tmp_path):
    rows = [*sway("a", 0.2), ["time", "SWAY", "x", "y", "psi", "Xf", "Yf", "Xa", "Ya", "K", "n"]]
    table = CYCLE.replace("TEST", "pure_sway")
    book(tmp_path, rows)
    with pytest.raises(CampaignError, match="is not a number"):
        opened(tmp_path, table)
    source = "[tables.source]\nlast_row = 25\n[tables.columns]"
    assert len(opened(tmp_path, table.replace("[tables.columns]", source))) == 1
