"""Each metric that a command prints has its unit, that of the table of metrics."""

from __future__ import annotations

import re

import pytest

from pmmkit.cli import main
from pmmkit.conventions import METRICS, Metric
from pmmkit.simulation import MANOEUVRES

CASES = {"turning": (), "zigzag": ("--rudder-deg", "10"), "pull_out": ("--rudder-deg", "20")}


@pytest.mark.slow
@pytest.mark.parametrize("manoeuvre", CASES)
def test_a_sweep_has_units_over_its_columns(manoeuvre, tmp_path, capsys):
    order = ["sweep", "kvlcc2", "--speeds", "6,8", "--manoeuvre", manoeuvre, *CASES[manoeuvre]]
    assert main([*order, "--out", str(tmp_path / "s")]) == 0
    head = capsys.readouterr().out.splitlines()[1]
    columns = dict(re.findall(r"(\w+) \[([^\]]+)\]", head))
    assert columns.pop("speed") == "m/s"
    assert re.sub(r"\w+ \[[^\]]+\]", "", head).split() == ["Fn"]
    known = MANOEUVRES[manoeuvre].metrics
    assert columns == {name: Metric.of(name, known).unit_of(name) for name in columns}
    assert columns


def test_a_sweep_over_a_setting_has_its_unit(tmp_path, capsys):
    order = ["sweep", "kvlcc2", "--speeds", "8", "--over", "rudder_deg", "--values", "20,35"]
    assert main([*order, "--out", str(tmp_path / "s")]) == 0
    assert capsys.readouterr().out.splitlines()[1].startswith("rudder_deg [deg]")


@pytest.mark.parametrize("manoeuvre", CASES)
def test_a_simulation_prints_a_unit_with_every_metric(manoeuvre, tmp_path, capsys):
    order = ["simulate", "kvlcc2", "--speed", "8", "--manoeuvre", manoeuvre, *CASES[manoeuvre]]
    assert main([*order, "--no-figures", "--out", str(tmp_path / "s")]) == 0
    lines = capsys.readouterr().out.splitlines()
    start = lines.index("Metrics") + 2
    rows = [line.split() for line in lines[start : lines.index("", start)]]
    known = MANOEUVRES[manoeuvre].metrics
    assert {row[0]: row[2] for row in rows} == {
        row[0]: Metric.of(row[0], known).unit_of(row[0]) for row in rows
    }
    assert len(rows) >= 3


@pytest.mark.slow
def test_what_decides_a_metric_is_said_with_its_unit(tmp_path, capsys):
    order = ["uncertainty", "kvlcc2", "--speed", "8", "--spread", "0.05", "--ships", "5"]
    for metric, unit in (("advance_L", " L"), ("time_90", " s"), ("speed_ratio", "")):
        assert main([*order, "--metric", metric, "--out", str(tmp_path / "u")]) == 0
        assert re.search(
            rf"What decides {metric}, which is [\d.]+{unit}\n", capsys.readouterr().out
        )


def test_every_metric_there_is_has_a_unit():
    for manoeuvre in MANOEUVRES.values():
        names = METRICS.in_lengths(metric.name for metric in manoeuvre.metrics)
        assert all(Metric.of(name, manoeuvre.metrics).unit_of(name) for name in names)
    assert all(metric.unit for metric in METRICS.values())
