"""Free-running tests as recorders keep them: instants, latitudes, a heading that wraps; and all
trials below each other in one text.

The motion is that of a tank that shares no code with the package (`tests/support/free_tank`).
"""

from __future__ import annotations

import csv
import json
from datetime import datetime, timedelta

import numpy as np
import pytest
from free_tank.campaigns import Setup, records

import pmmkit as pk
from pmmkit.base import CampaignError
from pmmkit.campaigns import open_campaign
from pmmkit.cli import main
from pmmkit.intake import examine
from pmmkit.readers import READERS, Options, Request

RECORDS = records(Setup(ship="s175", runs=3, seed=5))
COURSE = 30.0
"""To which she goes before the rudder [deg]."""
RADIUS = 6371.0e3


def recorder(folder, sailed=RECORDS):
    """A file a trial: UTC, latitude, longitude, knots, degrees, rpm, at 1 Hz."""
    for name, record in sailed.items():
        t, turn = record["t"], np.radians(COURSE)
        north = np.cos(turn) * record["x"] - np.sin(turn) * record["y"]
        east = np.sin(turn) * record["x"] + np.cos(turn) * record["y"]
        lat = 35.0 + np.degrees(north / RADIUS)
        lon = 139.0 + np.degrees(east / RADIUS / np.cos(np.radians(35.0)))
        speed = np.hypot(np.gradient(north, t), np.gradient(east, t)) / 0.514444
        heading = (np.degrees(record["psi"]) + COURSE) % 360.0
        start = datetime(2024, 5, 1, 23, 59, 0)
        with (folder / f"{name}.csv").open("w", newline="") as stream:
            rows = csv.writer(stream)
            rows.writerow(["UTC", "LAT", "LON", "SOG [kn]", "HDG [deg]", "RUDDER [deg]", "RPM"])
            for k in range(0, len(t), 2):
                rows.writerow(
                    [
                        (start + timedelta(seconds=float(t[k]))).isoformat() + "Z",
                        f"{lat[k]:.7f}",
                        f"{lon[k]:.7f}",
                        f"{speed[k]:.2f}",
                        f"{heading[k]:.2f}",
                        f"{np.degrees(record['delta'][k]):.1f}",
                        f"{60 * record['n'][k]:.1f}",
                    ]
                )


def one_text(folder):
    """All trials in one file, SI and degrees."""
    with (folder / "trials.csv").open("w", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(["trial", "time", "x", "y", "psi_deg", "delta_deg", "rps"])
        for name, record in RECORDS.items():
            table = [record["t"], record["x"], record["y"], np.degrees(record["psi"])]
            table += [np.degrees(record["delta"]), record["n"]]
            rows.writerows([name, *(f"{x:.5f}" for x in row)] for row in zip(*table, strict=True))


def velocities(folder, sailed=RECORDS, channels="u v r psi"):
    """A file a trial, of an inertial unit, as data of system identification are published."""
    names = ["t", *channels.split(), "delta", "n"]
    for name, record in sailed.items():
        table = np.column_stack([record[channel] for channel in names])
        np.savetxt(
            folder / f"{name}.csv", table, delimiter=",", header=",".join(names), comments=""
        )


@pytest.mark.parametrize("write", [recorder, one_text])
def test_records_are_found_as_they_were_sailed(write, tmp_path, capsys):
    write(tmp_path)
    order = ["new-campaign", str(tmp_path), "--ship", "s175", "--json"]
    assert main(order) == 0
    asked = json.loads(capsys.readouterr().out)["todo"]
    assert not any("which column" in text or "speed" in text for text in asked)
    campaign = open_campaign(tmp_path)
    assert {run.id for run in campaign} == set(RECORDS)
    for run in campaign:
        record, data = RECORDS[run.id], run.data
        t = np.asarray(data["t"])
        at = {name: np.interp(t, record["t"], record[name]) for name in ("psi", "delta", "n")}
        assert t[-1] == pytest.approx(record["t"][-1], abs=1.1)
        turned = np.unwrap(np.asarray(data["psi"]))
        assert turned - turned[0] == pytest.approx(at["psi"] - at["psi"][0], abs=5e-4)
        assert np.asarray(data["delta"]) == pytest.approx(at["delta"], abs=1e-3)
        assert np.asarray(data["n"]) == pytest.approx(at["n"], abs=1e-3)
        gone = np.hypot(np.diff(data["x"]), np.diff(data["y"])).sum()
        path = np.hypot(np.diff(record["x"]), np.diff(record["y"])).sum()
        assert gone == pytest.approx(path, rel=0.03)


def three_digits(folder):
    """A file a trial without any names, 1.23E+02 of time, place, degrees, velocities over the
    ground, rate of turn, rudder and revolutions a minute, at 7.4 Hz: as MARIN published her own."""
    for name, record in RECORDS.items():
        t = np.arange(0.0, record["t"][-1], 0.13526)
        at = {key: np.interp(t, record["t"], x) for key, x in record.items()}
        speeds = np.gradient(at["x"], t), np.gradient(at["y"], t)
        angles = [np.degrees(at[key]) for key in ("psi", "r", "delta")]
        table = [t, at["x"], at["y"], angles[0], *speeds, *angles[1:], 60.0 * at["n"]]
        told = f"A tank\nManoeuvre of a ship: {name}\n\n"
        rows = ["\t".join(f"{x:.2E}" for x in row) for row in zip(*table, strict=True)]
        (folder / f"{name}.dat").write_text(told + "\n".join(rows) + "\n")


def test_numbers_of_three_digits_without_names_are_told_by_the_motion(tmp_path, capsys):
    three_digits(tmp_path)
    assert main(["new-campaign", str(tmp_path), "--ship", "s175", "--json"]) == 0
    asked = json.loads(capsys.readouterr().out)["todo"]
    campaign = open_campaign(tmp_path)
    assert {run.id for run in campaign} == set(RECORDS)
    assert not any("heading" in text or "which column is the time" in text for text in asked)
    for run in campaign:
        record, data = RECORDS[run.id], run.data
        t = np.asarray(data["t"])
        assert np.diff(t) == pytest.approx(0.13526, rel=2e-3)
        assert t[-1] == pytest.approx(record["t"][-1], abs=1.0)
        for name, near in (("x", 6.0), ("y", 6.0), ("psi", 0.02), ("delta", 0.02)):
            exact = np.interp(t, record["t"], record[name])
            assert np.max(np.abs(np.asarray(data[name]) - exact)) < near, name
        assert "the even clock of 0.135" in data.attrs["conversions"]
    jumps = [x for x in examine(campaign) if "jump" in x.message or "stand" in x.message]
    assert jumps == []


def test_a_run_that_is_not_there_is_told(tmp_path):
    one_text(tmp_path)
    request = Request(
        path=tmp_path / "trials.csv",
        shown="trials.csv",
        options=Options(format="csv", where=(("trial", "turning"),)),
    )
    with pytest.raises(CampaignError, match=r"no row has trial = turning"):
        READERS["csv"].columns(request, lambda *_: (1, 2))


def test_a_fault_is_told_with_the_row_of_the_file(tmp_path):
    one_text(tmp_path)
    file = tmp_path / "trials.csv"
    lines = file.read_text().splitlines()
    last = list(RECORDS)[-1]
    row = next(place for place, line in enumerate(lines) if line.startswith(last)) + 3
    lines[row] = lines[row].rpartition(",")[0] + ",?"
    file.write_text("\n".join([*lines, ""]))
    options = Options(format="csv", where=(("trial", last),))
    request = Request(path=file, shown="trials.csv", options=options)
    with pytest.raises(CampaignError, match=f"row {row + 1}"):
        READERS["csv"].columns(request, lambda *_: (1, 6))


@pytest.mark.parametrize("channels", ["u v r psi", "u v r"])
def test_velocities_alone_tell_the_track(channels, tmp_path, capsys):
    velocities(tmp_path, channels=channels)
    assert main(["new-campaign", str(tmp_path), "--ship", "s175", "--json"]) == 0
    asked = json.loads(capsys.readouterr().out)["todo"]
    assert not any("which column" in text for text in asked)
    campaign = open_campaign(tmp_path)
    for run in campaign:
        record, data = RECORDS[run.id], run.data
        assert "dead reckoning" in data.attrs["conversions"]
        gone = np.hypot(*(np.asarray(data[name]) - record[name] for name in ("x", "y")))
        length = np.hypot(np.diff(record["x"]), np.diff(record["y"])).sum()
        assert gone.max() < 0.01 * length
        assert np.asarray(data["psi"]) == pytest.approx(record["psi"], abs=0.03)
    found = pk.compare("s175", campaign)
    assert len(found.free) == len(RECORDS)
    assert any("3 records without positions" in note for note in found.notes)
    share = [row["error"] <= row["uncertainty"] for row in found.rows()]
    assert np.mean(share) > 0.9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "write", "named"),
    [
        ("none", recorder, []),
        ("none", velocities, []),
        ("stall", recorder, ["rudder_stall"]),
        ("stall", velocities, ["rudder_stall"]),
        ("current", recorder, ["current"]),
        ("current", velocities, []),
    ],
)
def test_what_is_hidden_is_found_in_records_without_roll(case, write, named, tmp_path):
    """She heels, and nothing measures it; a current does not show in velocities through water."""
    write(tmp_path, records(Setup(case=case, ship="s175", runs=6, seed=2)))
    assert main(["new-campaign", str(tmp_path), "--ship", "s175", "-q"]) == 0
    found = pk.diagnose(pk.load_model("s175"), open_campaign(tmp_path))
    assert [item.effect for item in found.findings] == named
