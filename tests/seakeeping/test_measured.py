"""Transfer functions from records: what was put in is found again within what is stated."""

from __future__ import annotations

import numpy as np
import pytest
from few_stations import thinned

from pmmkit.base import DataError
from pmmkit.seakeeping import Sea, hull_from_particulars, rao
from pmmkit.seakeeping.measured import MeasuredTransfer, beside, from_irregular, from_regular

SHIP = thinned(hull_from_particulars(name="model", L=4.0, B=0.7, d=0.25, block=0.65))
OMEGA = np.linspace(2.0, 8.0, 61)


@pytest.fixture(scope="module")
def computed():
    return rao(SHIP, speeds=1.2, headings_deg=[180.0, 0.0], omega=OMEGA)


def waves_met(omega, speed=1.2):
    return omega + omega**2 * speed / 9.81


@pytest.mark.slow
def test_regular_waves_give_amplitude_and_phase_within_their_uncertainty():
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 40.0, 0.02)
    off = []
    for _ in range(60):
        wave = 0.03 * np.cos(4.1 * t) + 0.001 * rng.normal(size=t.size)
        motion = 0.021 * np.cos(4.1 * t - 0.6) + 0.001 * rng.normal(size=t.size)
        found = from_regular(t, wave, motion, encounter=4.0)
        off.append((abs(found.transfer[0]) - 0.7) / found.std[0])
        assert np.angle(found.transfer[0]) == pytest.approx(-0.6, abs=0.02)
        assert found.encounter[0] == pytest.approx(4.1, abs=0.002)
    assert 0.6 < np.std(off) < 1.5
    assert abs(np.mean(off)) < 0.5


@pytest.mark.slow
def test_irregular_waves_give_back_the_computed_transfer_function(computed):
    """Waves and heave of 200 components each, met at speed; sampled and read by cross-spectra."""
    rng = np.random.default_rng(8)
    sea = Sea(Hs=0.08, Tp=1.6)
    t = np.arange(0.0, 900.0, 0.05)
    fine = np.linspace(2.1, 7.9, 400)
    size = np.sqrt(2 * sea.spectrum(fine) * (fine[1] - fine[0]))
    phase = rng.uniform(0, 2 * np.pi, fine.size)
    transfer = np.interp(fine, OMEGA, np.abs(computed.mode("heave")[0, 0]))
    lead = np.interp(fine, OMEGA, np.unwrap(np.angle(computed.mode("heave")[0, 0])))
    turns = np.multiply.outer(t, waves_met(fine)) + phase
    wave = np.cos(turns) @ size
    heave = np.cos(turns + lead) @ (size * transfer) + 5e-4 * rng.normal(size=t.size)
    found = beside(from_irregular(t, wave, heave, segments=12), computed, "heave", heading_deg=180)
    assert found.encounter.size > 10
    assert np.abs(found.measured - found.computed).mean() < 0.05
    assert np.median(np.abs(found.score)) < 3.0


def test_measured_beside_computed_says_what_is_off(computed):
    encounter = computed.encounter[0, 0, 10:40:10]
    heave = np.abs(computed.mode("heave")[0, 0, 10:40:10])
    found = MeasuredTransfer(
        encounter=encounter, transfer=(1.1 * heave).astype(complex), std=0.02 * heave
    )
    told = beside(found, computed, "heave", heading_deg=180)
    assert told.score == pytest.approx(np.full(3, 5.0), rel=1e-6)
    assert "+5.0" in str(told)


def test_what_records_cannot_tell_is_refused(computed):
    t = np.arange(0.0, 60.0, 0.05)
    noise = np.random.default_rng(1).normal(size=(2, t.size))
    with pytest.raises(DataError, match="even time steps"):
        from_irregular(np.cumsum(np.abs(noise[0])), *noise)
    with pytest.raises(DataError, match="share a frequency"):
        beside(
            MeasuredTransfer(encounter=np.ones(1), transfer=np.ones(1) + 0j, std=np.ones(1)),
            computed,
            "heave",
            heading_deg=0,
        )
    with pytest.raises(DataError, match="No measured frequency"):
        beside(
            MeasuredTransfer(encounter=np.array([90.0]), transfer=np.ones(1) + 0j, std=np.ones(1)),
            computed,
            "heave",
            heading_deg=180,
        )
