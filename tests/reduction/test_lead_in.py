"""A carriage ramp before an oscillation and its stop after it: cut, and the truth comes out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import own_tank
import pytest
from own_tank import TRUTH, U, drift, sway, write, yaw

import pmmkit as pk
from pmmkit.campaigns.motion import counted
from pmmkit.conventions import Structure
from pmmkit.reduction import PreparedRun, View, reduce_campaign
from pmmkit.signals import Travel

OWN = Structure(name="little hull", derivatives=tuple(TRUTH))


def programme(cycles: float) -> tuple[own_tank.Test, ...]:
    """Drift, sway and yaw, the oscillations of so many cycles at speed."""
    return (
        *(drift(beta) for beta in (-8, -4, 0, 4, 8, 12)),
        *(sway(9.0, a, cycles) for a in (0.25, 0.4)),
        sway(13.0, 0.5, cycles),
        *(yaw(9.0, a, cycles) for a in (8.0, 13.0)),
        yaw(13.0, 11.0, cycles),
    )


def sigmas(folder: Path) -> dict[str, float]:
    """How many standard uncertainties each value lies from the truth."""
    table = reduce_campaign(pk.open_campaign(folder), structure=OWN, fn="pooled", check=False).table
    found = {
        name: float((table[name][0] - TRUTH[name]) / table.std[0][table.index(name)])
        for name in TRUTH
    }
    return {name: size for name, size in found.items() if np.isfinite(size)}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cycles", "columns", "lead"),
    [
        (1.6, ("U_carriage",), {"ramp": 3.0, "stop": 6.0}),
        (1.2, ("U_carriage",), {"rest": 1.0, "ramp": 5.0, "stop": 5.0}),
        (1.6, ("u", "v", "r"), {"ramp": 3.0, "stop": 6.0}),
        (2.3, (), {"rest": 2.0, "ramp": 4.0, "stop": 6.0}),
        (2.6, (), {"rest": 2.0, "ramp": 5.0}),
    ],
)
def test_a_ramp_and_a_stop_leave_the_truth(cycles, columns, lead, tmp_path):
    """By the carriage's speed, the hull's, and by the forces."""
    write(tmp_path / "c", programme(cycles), columns=columns, **lead)
    found = sigmas(tmp_path / "c")
    assert max(map(abs, found.values())) < 4.0, found
    assert np.sqrt(np.mean(np.square(list(found.values())))) < 1.7, found


@pytest.mark.slow
def test_without_the_cut_the_same_runs_mislead(tmp_path, monkeypatch):
    folder = write(tmp_path / "c", programme(1.6), columns=("U_carriage",), ramp=3.0, stop=6.0)
    whole = property(lambda record: Travel(0, record.times.size))
    monkeypatch.setattr(counted.TankRecord, "travel", whole)
    assert max(map(abs, sigmas(folder).values())) > 6.0


def test_what_was_cut_is_said(tmp_path):
    folder = write(tmp_path / "c", [sway(9.0, 0.4, 3.2)], rest=2.0, ramp=5.0, stop=5.0)
    campaign = pk.open_campaign(folder)
    result = PreparedRun.of(campaign.runs[0], campaign).result
    assert "the carriage speeds up" in result.window
    assert "the carriage stops" in result.window
    assert result.ramp
    assert result.cycles == 3 or result.cycles == 2


def test_the_phase_is_told_by_the_cycles_and_not_by_the_rest(tmp_path):
    """A rest at y = 0 before the swing would pull the phase of a fit to the whole record."""

    def late(columns):
        moving = columns["t"] >= 0
        return {"y": np.where(moving, columns["y"], 0.0), "psi": 0.0 * columns["t"]}

    folder = write(
        tmp_path / "c", [sway(9.0, 0.4, 3.2)], columns=("U_carriage",), extra=late,
        rest=3.0, ramp=4.0, noise=0.0,
    )  # fmt: skip
    campaign = pk.open_campaign(folder)
    run = campaign.runs[0]
    data = run.data
    times = data["t"].values
    record = np.stack([data[name].values for name in "XYN"])
    found = counted.TankRecord(run=run, data=data, times=times, forces=record, names="XYN").cycles()
    cut = slice(found.cycles.start, found.cycles.stop)
    np.testing.assert_allclose(found.theta[cut], 2 * np.pi / 9.0 * times[cut], atol=2e-3)


def test_cycles_that_are_asked_for_count_from_the_start_of_the_record(tmp_path):
    folder = write(tmp_path / "c", [sway(9.0, 0.4, 3.2)], columns=("U_carriage",), ramp=5.0)
    campaign = pk.open_campaign(folder)
    result = PreparedRun.of(campaign.runs[0], campaign, cycles=2).result
    assert result.window == "took cycle 2 of 3, as asked"
    assert result.ramp == ""


def test_a_diagnosis_counts_its_cycles_from_the_carriage_at_speed(tmp_path):
    """Its second cycle is one of the run, where the record's would be of the ramp."""
    folder = write(
        tmp_path / "c", [sway(9.0, 0.4, 5.3)], columns=("U_carriage",), rest=8.0, ramp=12.0
    )
    early, late = View.of(pk.open_campaign(folder))
    assert early.early
    assert early.t.size == pytest.approx(9.0 * own_tank.RATE, abs=1)
    level = 0.5 * own_tank.RHO * own_tank.L**2 * U**2 * TRUTH["Xuu"]
    for view in (early, late):
        assert view.force["X"][0] == pytest.approx(level, rel=0.05)


def test_a_static_run_is_cut_by_the_speed_too(tmp_path):
    """A ramp that the forces hardly show: a hull without resistance, turned by nothing."""
    folder = write(tmp_path / "c", [drift(0.0)], columns=("U_carriage",), rest=2.0, ramp=6.0)
    campaign = pk.open_campaign(folder)
    found = PreparedRun.of(campaign.runs[0], campaign)
    assert found.t[0] > -0.5
    assert "the carriage speeds up" in found.result.window
    np.testing.assert_allclose(found.motion.u, U, rtol=1e-3)
