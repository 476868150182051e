"""Records of motions from files: what kind of waves, what was measured, and what explains it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from few_stations import thinned

from pmmkit.base import DataError
from pmmkit.seakeeping import Loading, hull_from_particulars, rao
from pmmkit.seakeeping.explanation import explained
from pmmkit.seakeeping.measured import MeasuredTransfer
from pmmkit.seakeeping.records import read_record, together

SHIP = thinned(hull_from_particulars(name="model", L=4.0, B=0.7, d=0.25, block=0.65))
GIVEN = Loading.of(SHIP, GM=0.04, kxx=0.25, kyy=1.0, kzz=1.0, roll_damping=0.05)
OMEGA = np.linspace(2.0, 8.0, 61)


@pytest.fixture(scope="module")
def given():
    return rao(SHIP, speeds=1.2, headings_deg=180.0, omega=OMEGA, loading=GIVEN)


def measured_of(found, modes, every=4, std=0.01):
    """What a tank would measure of a ship, without noise."""
    at = slice(5, -5, every)
    return {
        name: MeasuredTransfer(
            encounter=found.encounter[0, 0, at],
            transfer=found.mode(name)[0, 0, at],
            std=np.full(found.encounter[0, 0, at].size, std),
        )
        for name in modes
    }


def written(path, omega, *, heave, head="t [s],wave [mm],heave [mm],pitch [deg],force [N]"):
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 60.0, 0.05)
    size = 0.03 / np.sqrt(len(omega))
    phase = rng.uniform(0, 6.28, len(omega))
    wave = sum(size * np.cos(w * t + p) for w, p in zip(omega, phase, strict=True))
    columns = [t, 1e3 * wave, 1e3 * heave * wave, np.degrees(0.5 * wave), 0 * t]
    noise = [0 * t, *(0.002 * rng.normal(size=t.size) for _ in range(3)), 0 * t]
    np.savetxt(path, np.column_stack(columns) + np.column_stack(noise), delimiter=",", header=head,
               comments="")  # fmt: skip
    return path


@pytest.mark.slow
def test_units_and_scale_of_a_record(tmp_path):
    """A model of 1:25: times five times as long, lengths 25 times as large, angles as they are."""
    file = written(tmp_path / "run.csv", [4.0], heave=0.8)
    small, large = (read_record(file, scale=scale) for scale in (1.0, 25.0))
    assert np.abs(small.wave).max() == pytest.approx(0.03, rel=1e-2)
    assert small.motions.keys() == {"heave", "pitch"}
    np.testing.assert_allclose(large.t, 5 * small.t)
    np.testing.assert_allclose(large.wave, 25 * small.wave)
    np.testing.assert_allclose(large.motions["pitch"], small.motions["pitch"])
    kind, found = large.transfer()
    assert kind == "regular"
    assert found["heave"].encounter[0] == pytest.approx(4.0 / 5, rel=1e-3)
    assert abs(found["heave"].transfer[0]) == pytest.approx(0.8, abs=0.005)
    assert abs(found["pitch"].transfer[0]) == pytest.approx(0.5 / 25, abs=1e-4)


def test_waves_of_many_lengths_are_not_regular(tmp_path):
    file = written(tmp_path / "run.csv", np.linspace(3.0, 6.0, 60), heave=0.8)
    kind, found = read_record(file).transfer()
    assert kind == "irregular"
    off = np.abs(np.abs(found["heave"].transfer) - 0.8) / found["heave"].std
    assert np.median(off) < 2.0


@pytest.mark.parametrize(
    ("head", "says"),
    [
        ("t,elevation,heave,pitch,a", "no column wave"),
        ("t,wave,a,b,c", "no column any motion"),
        ("t,wave,heave [kN],pitch,c", "heave is in m"),
        ("t,wave,heave,Heave [mm],c", "heave stands in more than one"),
        ("wave,t,heave,pitch,c", "rise"),
    ],
)
def test_a_record_that_cannot_be_understood_says_what_to_write(head, says, tmp_path):
    file = written(tmp_path / "run.csv", [4.0], heave=0.8, head=head)
    with pytest.raises(DataError, match=says):
        read_record(file)


def test_runs_in_regular_waves_stand_together_in_rising_frequency():
    runs = [
        {
            "heave": MeasuredTransfer(
                encounter=np.array([w]), transfer=np.array([1.0 + 0j]), std=np.ones(1)
            )
        }
        for w in (5.0, 3.0, 4.0)
    ]
    assert together(runs)["heave"].encounter.tolist() == [3.0, 4.0, 5.0]


@pytest.mark.slow
def test_a_wrong_radius_of_gyration_is_found(given):
    """A model that was swung badly: 12 % of its radius of gyration in pitch are missing."""
    true = rao(
        SHIP, speeds=1.2, headings_deg=180.0, omega=OMEGA, loading=replace(GIVEN, kyy=1.12),
        strips=given.strips,
    )  # fmt: skip
    found = explained(measured_of(true, ("heave", "pitch")), given)
    assert found.best is not None
    assert found.best.name == "kyy"
    assert found.best.after == pytest.approx(1.12, abs=0.01)
    assert found.best.misfit < 0.01 < found.misfit
    assert "1.12" in str(found)


@pytest.mark.slow
def test_a_wrong_damping_of_roll_is_not_taken_for_a_radius():
    beam = {"speeds": 0.0, "headings_deg": 90.0, "omega": np.linspace(1.5, 5.0, 71)}
    own = rao(SHIP, loading=GIVEN, **beam)
    true = rao(SHIP, loading=replace(GIVEN, roll_damping=0.09), strips=own.strips, **beam)
    found = explained(measured_of(true, ("roll",), every=2), own)
    assert found.best is not None
    assert found.best.name == "roll_damping"
    assert found.best.after == pytest.approx(0.09, abs=0.01)


def test_what_is_right_needs_no_explanation(given):
    found = explained(measured_of(given, ("heave", "pitch")), given)
    assert found.best is None
    assert "no number" in repr(found)


@pytest.mark.slow
def test_strips_of_another_hull_are_not_taken(given):
    other = thinned(hull_from_particulars(name="model", L=4.0, B=0.8, d=0.25, block=0.65))
    own = rao(other, speeds=1.2, omega=OMEGA)
    lent = rao(other, speeds=1.2, omega=OMEGA, strips=given.strips)
    np.testing.assert_array_equal(own.motion, lent.motion)
