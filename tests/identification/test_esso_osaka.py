"""Real free-running records as they lie: Esso Osaka outdoors, KVLCC2 in HSVA's tank.

The measurements are not part of the repository; these tests skip without them.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from pmmkit import Campaign, open_campaign
from pmmkit.campaigns import usable
from pmmkit.intake import examine, refuse


def opened(name: str, folder: str, shared_data: Path, datasets: Path) -> Campaign:
    if not (shared_data / folder).is_dir():
        pytest.skip(f"{folder} is not on this machine")
    return open_campaign(datasets / name, data=shared_data)


@pytest.fixture(scope="module")
def esso(shared_data: Path, datasets: Path) -> Campaign:
    return opened("esso_osaka", "esso_osaka_free", shared_data, datasets)


@pytest.fixture(scope="module")
def hsva(shared_data: Path, datasets: Path) -> Campaign:
    return opened("kvlcc2_hsva", "kvlcc2_hsva_free", shared_data, datasets)


@pytest.fixture(scope="module")
def findings(esso: Campaign):
    return examine(esso)


def of(findings, check: str, text: str):
    (item,) = [item for item in findings if item.check == check and text in item.message]
    return item


@pytest.mark.slow
def test_nothing_is_refused(findings, hsva):
    refuse(findings)
    refuse(examine(hsva))


@pytest.mark.slow
def test_the_velocities_are_late_and_hold_a_false_sway(findings):
    assert of(findings, "velocities", "late by").numbers["lag"] == pytest.approx(0.9, abs=0.05)
    item = of(findings, "false sway", "false sway")
    assert item.numbers["slope"] == pytest.approx(-0.22, abs=0.03)
    assert item.numbers["time"] == pytest.approx(-0.85, abs=0.1)


@pytest.mark.slow
def test_the_integral_of_r_falls_short_in_all_turns(findings):
    item = of(findings, "headings", "short of")
    assert len(item.runs) == 4
    assert 0.984 < item.numbers["low"] < item.numbers["high"] < 0.993


@pytest.mark.slow
def test_headings_jump_in_the_zigzag_whose_switches_are_off(findings):
    item = of(findings, "headings", "jumps")
    assert "zigzag_135028" in item.message
    assert math.degrees(item.numbers["turn_jump"]) == pytest.approx(7.2, abs=0.4)
    item = of(findings, "settings", "turned over")
    assert item.runs == ("zigzag_135028",)
    assert math.degrees(item.numbers["switch"]) == pytest.approx(27.3, abs=0.3)


@pytest.mark.slow
def test_positions_stand_jump_and_the_rest(findings):
    assert len(of(findings, "standing samples", "stands still").runs) == 12
    assert 0.25 < of(findings, "velocities", "position jumps").numbers["jump"] < 0.7
    assert len(of(findings, "stop at the end", "propeller").runs) == 10
    order = of(findings, "rudder order", "order")
    assert math.degrees(order.numbers["order_step"]) == pytest.approx(59.8, abs=0.2)
    assert len(order.runs) == 12
    approach = of(findings, "approach", "not steady")
    assert {name for name in approach.runs if "zigzag" in name} >= {"zigzag_130424"}


@pytest.mark.slow
def test_signs_of_rudder_heading_and_wind(esso):
    for run in esso.select("turning"):
        data = run.data
        t = data["t"].values
        psi = np.unwrap(data["psi"].values)
        turning = (np.abs(data["delta"].values - run.settings.rudder) < 0.03) & (t > 150)
        assert np.sign(np.median(data["r"].values[turning])) == np.sign(run.settings.rudder)
        first, last = np.flatnonzero(turning)[[0, -1]]
        assert (psi[last] - psi[first]) * run.settings.rudder > 0
        start = first
        after = np.flatnonzero(np.abs(psi - psi[start]) >= 2 * math.pi)
        stop = after[after > start][0]
        drift = np.array([data[name].values[stop] - data[name].values[start] for name in "xy"])
        wind = data["wind_direction"].values + psi
        speed = data["wind_speed"].values
        blown = -np.array([np.mean((speed * part(wind))[start:stop]) for part in (np.cos, np.sin)])
        cosine = drift @ blown / np.linalg.norm(drift) / np.linalg.norm(blown)
        assert cosine > math.cos(math.radians(45))


@pytest.mark.slow
def test_segments_hold_no_jumps_and_no_stop(esso):
    for run in esso:
        parts = usable(run)
        assert parts.segments
        for part in parts.segments:
            data = part.data
            assert np.abs(np.diff(data["psi"])).max() < math.radians(4)
            if run.test != "random":
                assert abs(float(data["n"][-1])) > 1
        if run.test != "random":
            assert any("propeller stands" in cut.reason for cut in parts.cuts)


@pytest.mark.slow
def test_the_tank_records_are_whole(hsva):
    for run in hsva:
        assert usable(run).cuts == ()
    assert examine(hsva) == ()


@pytest.mark.slow
def test_columns_5_and_6_of_the_tank_taken_for_u_and_v(hsva, shared_data, datasets, tmp_path):
    text = (datasets / "kvlcc2_hsva" / "campaign.toml").read_text(encoding="utf-8")
    wrong = text.replace("xdot = {", "u = {").replace("ydot = {", "v = {")
    (tmp_path / "campaign.toml").write_text(wrong, encoding="utf-8")
    item = of(examine(open_campaign(tmp_path, data=shared_data)), "velocities", "earth axes")
    assert (item.severity, len(item.runs)) == ("error", 13)
    assert item.numbers["earth"] < 0.02 * item.numbers["body"]


@pytest.mark.slow
def test_the_rudder_of_the_tank_taken_for_positive_to_starboard(
    hsva, shared_data, datasets, tmp_path
):
    text = (datasets / "kvlcc2_hsva" / "campaign.toml").read_text(encoding="utf-8")
    wrong = text.replace('rudder_positive = "port"', 'rudder_positive = "starboard"')
    (tmp_path / "campaign.toml").write_text(wrong, encoding="utf-8")
    found = examine(open_campaign(tmp_path, data=shared_data))
    assert of(found, "signs", "opposite sign").severity == "error"
