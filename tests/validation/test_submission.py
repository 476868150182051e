"""A submission beside a measurement: E% of D, U_V, the conditions that match, the figures."""

from __future__ import annotations

import csv
import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scenes import overlap

import pmmkit as pk
from pmmkit import Campaign, Run, compare_submission, errors_in_percent
from pmmkit.base import DataError, TableError
from pmmkit.campaigns import Settings, TypeB
from pmmkit.cli import main
from pmmkit.conventions import Ship, Water
from pmmkit.identification import Trial
from pmmkit.models import from_values, write_table
from pmmkit.plotting.layout import laid_out
from pmmkit.plotting.marks import BarSeries
from pmmkit.views import derivative_bars
from pmmkit.views.figures.comparison import overlays
from pmmkit.views.figures.workshop import forces_over_phase, static_forces

SHIP = Ship(name="model", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=450.0)
SPEED, PERIOD = 1.2, 8.0
UNIT = 0.5 * 1000.0 * 4.0**2 * SPEED**2
"""½ρL²U² [N]."""
SWAY = {"Y_cos": [1.0, -20.0], "Y_sin": [0.0, 60.0], "N_cos": [0.5, -30.0], "N_sin": [0.0, 4.0]}


def drift(name, degrees, force, *, speed=SPEED, **settings):
    data = xr.Dataset({key: ((), value) for key, value in force.items()})
    given = Settings(speed=speed, drift=math.radians(degrees), **settings)
    return Run(id=name, test="static_drift", kind="means", settings=given, loader=lambda: data)


def sway(name, parts, *, speed=SPEED, period=PERIOD, amplitude=0.3):
    order = len(next(iter(parts.values())))
    data = xr.Dataset(
        {key: ("harmonic", value) for key, value in parts.items()},
        coords={"harmonic": np.arange(order)},
    )
    given = Settings(speed=speed, period=period, amplitude=amplitude)
    return Run(id=name, test="pure_sway", kind="harmonics", settings=given, loader=lambda: data)


def campaign_of(*runs, title="D", ship=SHIP, **said):
    return Campaign(title=title, ship=ship, water=Water(rho=1000.0), runs=runs, **said)


def measured(**said):
    return campaign_of(
        drift("SD_0", 0.0, {"X": -20.0, "Y": 0.4, "N": 0.2}),
        drift("SD_8", 8.0, {"X": -25.0, "Y": 80.0, "N": 120.0}),
        sway("PS", SWAY),
        **said,
    )


def percents(found, run, channel):
    table = errors_in_percent(found.captive)
    return table[(table["run"] == run) & (table["channel"] == channel)].set_index("harmonic")


def test_the_error_is_measured_less_submitted_in_per_cent_of_the_measured():
    """Y five per cent too large, N three too small, X right."""
    more = {"X": -25.0, "Y": 1.05 * 80.0, "N": 0.97 * 120.0}
    submission = campaign_of(drift("SD_8", 8.0, more), title="S")
    found = compare_submission(submission, measured())
    for channel, error in (("X", 0.0), ("Y", -5.0), ("N", 3.0)):
        row = percents(found, "SD_8", channel).loc["C0"]
        assert row["E_percent"] == pytest.approx(error, abs=1e-9)
        assert (row["within"]) == (channel == "X")
    assert percents(found, "SD_8", "X").loc["C0", "S"] == -25.0
    assert found.model == "S"
    assert any("Without a counterpart in the submission: SD_0, PS." in note for note in found.notes)


def test_a_submission_at_another_scale_is_compared_by_its_coefficients():
    """Twice the length at the same Froude number: forces times 8, moments times 16."""
    ship = replace(SHIP, L=8.0, B=2.0, d=0.5, volume=4.0, mass=4000.0, Izz=14400.0)
    pace, time = SPEED * math.sqrt(2.0), PERIOD * math.sqrt(2.0)
    larger = {"Y": 8.0, "N": 16.0}
    parts = {key: [larger[key[0]] * x for x in value] for key, value in SWAY.items()}
    submission = campaign_of(
        drift("theirs", 8.0, {"X": -200.0, "Y": 640.0, "N": 1920.0}, speed=pace),
        sway("swayed", parts, speed=pace, period=time, amplitude=0.6),
        drift("slower", 8.0, {"X": -1.0, "Y": 2.0, "N": 3.0}, speed=0.9 * pace),
        ship=ship,
        title="S",
    )
    found = compare_submission(submission, measured())
    assert [run.view.run.id for run in found.captive] == ["SD_8", "PS"]
    assert np.abs(errors_in_percent(found.captive)["E_percent"].dropna()).max() < 1e-9
    assert any("2 times as long" in note for note in found.notes)


def test_the_validation_uncertainty_is_that_of_both_sides():
    """U_V² = U_D² + U_S², each k = 2; the submission's U_SN, the measurement's noise and gauge."""
    gauge = TypeB(name="Y_gauge", std=0.3, shared=True)
    D = campaign_of(drift("A", 8.0, {"Y": 80.0, "Y_std": 0.4}), uncertainty=(gauge,))
    S = campaign_of(drift("A", 8.0, {"Y": 82.0}), numerical={"Y": 1.2}, title="S")
    (run,) = compare_submission(S, D, floor=0.0).captive
    assert run.measurement_uncertainty("Y")[0] == pytest.approx(2 * 0.5)
    assert run.uncertainty("Y")[0] == pytest.approx(2 * 1.3)
    row = percents(compare_submission(S, D, floor=0.0), "A", "Y").loc["C0"]
    assert row["U_D_percent"] == pytest.approx(100 * 1.0 / 80.0)
    assert row["U_V_percent"] == pytest.approx(100 * 2.6 / 80.0)
    assert row["within"]


def test_of_several_runs_in_one_condition_the_one_of_the_same_name_counts():
    again = drift("again", 8.0, {"Y": 90.0})
    S = campaign_of(again, drift("SD_8", 8.0, {"Y": 84.0}), title="S")
    assert percents(compare_submission(S, measured()), "SD_8", "Y").loc["C0", "S"] == 84.0
    S = campaign_of(again, title="S")
    assert percents(compare_submission(S, measured()), "SD_8", "Y").loc["C0", "S"] == 90.0


def test_what_is_no_larger_than_its_uncertainty_is_no_size_for_a_share():
    found = compare_submission(measured(title="S"), measured(), floor=0.01)
    row = percents(found, "SD_0", "Y").loc["C0"]
    assert math.isnan(row["E_percent"])
    assert math.isnan(row["U_V_percent"])
    assert percents(found, "SD_0", "X").loc["C0", "E_percent"] == 0.0


def test_harmonics_are_compared_that_both_have():
    longer = {key: [*value, 0.1, 0.2] for key, value in SWAY.items()}
    bare = {"Y_cos": SWAY["Y_cos"], "Y_sin": SWAY["Y_sin"]}
    found = compare_submission(
        campaign_of(sway("PS", bare), title="S"), campaign_of(sway("PS", longer))
    )
    (run,) = found.captive
    assert run.channels == ("Y",)
    assert run.view.labels == ("C0", "C1", "S1")
    assert run.error("Y").tolist() == [0.0, 0.0, 0.0]
    theta = 2 * math.pi * np.arange(len(run.history["Y"])) / len(run.history["Y"])
    wave = 1.0 - 20.0 * np.cos(theta) + 60.0 * np.sin(theta)
    assert run.history["Y"] == pytest.approx(wave, abs=1e-9)


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(DataError, match="is free-running"):
        compare_submission(campaign_of(kind="free-running"), measured())
    other = campaign_of(drift("SD_8", 9.0, {"Y": 1.0}), title="S")
    with pytest.raises(DataError, match="nothing can be compared"):
        compare_submission(other, measured())


def test_figures_show_the_coefficients_and_the_uncertainty():
    D = measured(uncertainty=(TypeB(name="Y_gauge", std=2.0, shared=True),))
    S = campaign_of(
        drift("SD_0", 0.0, {"X": -21.0, "Y": 0.0, "N": 0.0}),
        drift("SD_8", 8.0, {"X": -26.0, "Y": 84.0, "N": 110.0}),
        sway("PS", SWAY),
        title="S of somebody",
    )
    found = compare_submission(S, D)
    figure = static_forces(found)
    sway_force = figure.axes[1]
    (line,) = [item for item in sway_force.points if item.dash == "--"]
    assert line.x == pytest.approx([0.0, 8.0])
    assert line.y == pytest.approx([0.0, 1e3 * 84.0 / UNIT])
    (points,) = [item for item in sway_force.points if item.y_error is not None]
    low, high = points.y[1] + points.y_error[:, 1] * [-1.0, 1.0]
    assert (low, high) == pytest.approx((1e3 * 76.0 / UNIT, 1e3 * 84.0 / UNIT))
    assert figure.axes[-1].xlabel.text == "drift angle β [deg]"
    scene = laid_out(figure)
    told = [own.text for own in scene.letters if overlap(own.box, scene.legend)]
    assert sorted(told) == ["Fn 0.192", "S of somebody", "measured, with $U_D$"]
    cycle = forces_over_phase(found, [run for run in found.captive if run.view.run.dynamic])
    before, after = cycle.axes[0].points
    assert before.y[30] == pytest.approx(1e3 * (1.0 + 60.0) / UNIT)
    assert after.y == pytest.approx(before.y)


def heights(axis):
    """Of all bars of some axes."""
    bars = (mark for mark in axis.marks if isinstance(mark, BarSeries))
    return [height for own in bars for height in own.length.tolist()]


def test_bars_of_derivatives_have_the_values_and_intervals():
    D, S = (
        from_values({"Yv": x, "Yvvv": 9 * x}, std={"Yv": 0.01}, ship=SHIP, water=Water())
        for x in (-0.2, -0.3)
    )
    first, higher = derivative_bars({"tank": D, "CFD": S}).shown
    assert heights(first) == pytest.approx([-200.0, -300.0])
    assert heights(higher) == pytest.approx([-1800.0, -2700.0])
    low, high = first.points[0].y[0] + first.points[0].y_error[:, 0] * [-1.0, 1.0]
    assert (low, high) == pytest.approx((-219.6, -180.4), abs=0.1)
    with pytest.raises(TableError, match="at least two"):
        derivative_bars({"tank": D})


def test_bars_of_derivatives_show_each_froude_number():
    """Four speeds: three beside each other, the fourth below; a source over all speeds in each."""
    D = from_values(
        {"Yv": [-0.1, -0.2, -0.3, -0.4]}, Fn=[0.1, 0.2, 0.3, 0.4], ship=SHIP, water=Water()
    )
    S = from_values({"Yv": -0.25}, ship=SHIP, water=Water())
    axes = derivative_bars({"tank": D, "CFD": S}).shown
    assert [axis.title.text for axis in axes] == [f"Fn 0.{k}00" for k in (1, 2, 3, 4)]
    assert [heights(axis) for axis in axes] == [
        pytest.approx([-100.0 * k, -250.0]) for k in (1, 2, 3, 4)
    ]


def manoeuvre(test, rudder, track):
    """A trial that went just as a simulation did, and the simulation."""
    trial = Trial(
        run="T",
        speed_std=0.0,
        heading_deg=0.0,
        order=0.0,
        std={},
        noise=None,
        x_ground=track.x,
        y_ground=track.y,
        **vars(track) | {"manoeuvre": test, "rudder_deg": rudder},
    )
    return trial, track


def test_tracks_lie_over_each_other():
    """A trial that went as simulated: the same path, heading and yaw rate twice."""
    turn = pk.simulate("kvlcc2-l7", "turning", rudder_deg=35, speed=1.179, compiled=False)
    weave = pk.simulate(
        "kvlcc2-l7", "zigzag", rudder_deg=10, switch_deg=10, speed=1.179, compiled=False
    )
    found = overlays(
        [manoeuvre("turning", 35.0, turn), manoeuvre("zigzag", 10.0, weave)], other="simulated"
    )
    assert list(found) == ["turning_circles", "zigzag"]
    measured, simulated = (
        next(line for line in found["turning_circles"].axes[0].points if said in line.label)
        for said in ("T, measured", "T, simulated")
    )
    assert measured.x == pytest.approx(simulated.x)
    assert measured.y == pytest.approx(simulated.y)
    one, two = found["zigzag"].axes[1].points[:2]
    assert one.y == pytest.approx(two.y, abs=0.05)
    assert overlays([], other="simulated") == {}


def test_the_command_takes_an_archive_for_a_submission(tmp_path, capsys):
    pk.export(measured(), tmp_path / "D")
    factor = {"X": 1.0, "Y": 0.9, "N": 1.0}
    runs = []
    for run in measured().runs[:2]:
        force = {name: factor[name] * float(run.data[name]) for name in factor}
        runs.append(drift(run.id, math.degrees(run.settings.drift), force))
    pk.export(campaign_of(*runs, title="S"), tmp_path / "S.zip")
    typed = ["compare", str(tmp_path / "S.zip"), str(tmp_path / "D"), "--no-figures"]
    assert main([*typed, "--out", str(tmp_path / "out")]) == 0
    with (tmp_path / "out" / "percent.csv").open(encoding="utf-8", newline="") as stream:
        rows = {(row["run"], row["channel"]): row for row in csv.DictReader(stream)}
    assert float(rows["SD_8", "Y"]["E_percent"]) == pytest.approx(10.0)
    assert "S beside D" in capsys.readouterr().out
    assert main([*typed, "--extrapolate"]) == 2


def test_the_command_takes_two_tables(tmp_path, capsys):
    for name, value in (("ours", -0.0118), ("theirs", -0.0116)):
        table = from_values({"Yv": value}, std={"Yv": 1e-4}, ship=SHIP, water=Water())
        write_table(table, tmp_path / f"{name}.csv")
    typed = ["compare", str(tmp_path / "ours.csv"), str(tmp_path / "theirs.csv")]
    assert main([*typed, "--no-figures", "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "derivatives_beside.csv").is_file()
    assert "Farthest apart: Yv: -1.41 standard deviations" in capsys.readouterr().out
    assert main([typed[0], typed[1], "datasets/s175"]) == 2
