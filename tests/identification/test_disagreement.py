"""Sensors that say different motions: each is shown as it is.

Records come from a tank of free-running ships that shares no code with the package: its log and its
compass go through the water, its fixes over the ground.
"""

from __future__ import annotations

import numpy as np
import pytest
from free_tank.campaigns import Setup, hidden_in, write
from hypothesis import given
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.diagnosis.free_running.question import records_of
from pmmkit.identification import Smoothed
from pmmkit.identification.smoother import local_lines

SHIP = pk.load_model("kvlcc2-l7")


def records(case, folder, size=1.0):
    setup = Setup(case=case, size=size, runs=3, seed=2, ship="kvlcc2-l7")
    return setup, records_of(pk.open_campaign(write(setup, folder)), SHIP)


@pytest.mark.parametrize("case", ["current", "log", "heading", "antenna"])
def test_what_a_record_shows_is_what_its_sensors_show(case, tmp_path):
    """One motion would leave the fixes out: of a current of .04 m/s by 2 m in two minutes."""
    made = Smoothed.references(SHIP, records(case, tmp_path)[1])
    assert any(item.disagrees for item in made)
    for item in (item for item in made if item.disagrees):
        for name, noise in {"x": 0.01, "y": 0.01, "psi": 0.0018}.items():
            off = item.record.measured[name] - item.motion[name]
            assert np.sqrt(np.nanmean(off**2)) < 1.3 * noise, (case, name)


@pytest.mark.parametrize("case", ["none", "wind", "asymmetry", "clock"])
def test_sensors_that_agree_are_smoothed_together(case, tmp_path):
    assert not any(item.disagrees for item in Smoothed.references(SHIP, records(case, tmp_path)[1]))


def test_a_few_wild_fixes_are_no_disagreement(tmp_path):
    record = records("none", tmp_path)[1][0]
    x = record.measured["x"].copy()
    x[100:1000:100] += 50.0
    (made,) = Smoothed.references(SHIP, [record.with_(measured={**record.measured, "x": x})])
    (clean,) = Smoothed.references(SHIP, [record])
    assert not made.disagrees
    assert np.abs(made.motion["x"] - clean.motion["x"]).max() < 0.02


def test_a_still_water_model_is_off_by_the_whole_drift(tmp_path):
    """Fixes drift by the current times the time; u, v and heading know nothing of it."""
    setup, made = records("current", tmp_path, size=3.0)
    campaign = pk.open_campaign(write(setup, tmp_path / "again"))
    drift = np.hypot(*hidden_in(setup).current)
    for item, run in zip(made, pk.compare(SHIP, campaign).free, strict=True):
        whole = drift * (item.t - item.t[0])
        error = run.errors()["position"].error
        assert np.sqrt(np.mean(np.sum(error**2, axis=0))) == pytest.approx(
            np.sqrt(np.mean(whole**2)), rel=0.15
        )


@given(
    slope=st.floats(-3, 3),
    start=st.floats(-100, 100),
    gaps=st.lists(st.integers(0, 59), max_size=40),
    steps=st.lists(st.floats(0.05, 0.4), min_size=60, max_size=60),
)
def test_straight_lines_through_a_straight_line_are_itself(slope, start, gaps, steps):
    """However uneven the instants are, and wherever values are missing between others."""
    t = np.cumsum(steps)
    values = start + slope * t
    holed = values.copy()
    holed[[gap for gap in gaps if 0 < gap < 59]] = np.nan
    lines, share = local_lines(t, holed, 1.0)
    assert lines == pytest.approx(values, abs=1e-6)
    assert np.all(share > 0.0)
    assert np.all(share <= 5.0)


def test_lines_keep_the_share_of_white_noise_that_they_say():
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 4000.0, 0.1)
    lines, share = local_lines(t, rng.normal(size=len(t)), 3.0)
    assert np.var(lines) == pytest.approx(share.mean(), rel=0.05)
    assert share.mean() == pytest.approx(1 / 31, rel=0.02)
