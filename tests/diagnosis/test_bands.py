"""How far a model may be off on records left out: what the others leave unknown, no more."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.diagnosis.free_running.diagnose import free_system
from pmmkit.diagnosis.free_running.left_out import band, left_out_windows
from pmmkit.identification import Prior
from tests.support.zigzags import ASYMMETRY, KNOWN, SENSORS, SHIP, SPEED, sailed

NAMES = ("asymmetry",)


@pytest.fixture(scope="module")
def fit():
    """The truth fitted to zigzags whose values are known to 5 %."""
    prior = Prior.of(SHIP, KNOWN, SPEED, spread=0.05)
    records = sailed(ASYMMETRY, 5)
    return free_system(SHIP, records, prior=prior, candidates=NAMES, sensors=SENSORS).fit(NAMES)


@pytest.mark.slow
def test_a_band_grows_from_the_start_of_each_window(fit):
    stretch, _ = left_out_windows(fit, 0)
    found = band(fit, 0)
    assert found.shape == (len(stretch.record), len(stretch.channels))
    heading = found[:, stretch.channels.index("psi")]
    for begin, end in zip(stretch.begins[:-1], stretch.begins[1:], strict=True):
        assert heading[end - 1] > heading[begin] > 0.0


@pytest.mark.slow
def test_a_band_holds_what_is_measured(fit):
    inside = []
    for record in range(3):
        stretch, shown = left_out_windows(fit, record)
        for channel, name in enumerate(stretch.channels):
            off = shown[:, channel] - stretch.record.measured[name]
            std = np.hypot(band(fit, record)[:, channel], SENSORS[name])
            inside.append(float(np.nanmean(np.abs(off) < 1.96 * std)))
    assert 0.85 < np.mean(inside) < 0.99
    assert min(inside) > 0.7


@pytest.mark.slow
def test_a_band_without_the_effect_is_wider(fit):
    base = free_system(
        SHIP,
        sailed(ASYMMETRY, 5),
        prior=Prior.of(SHIP, KNOWN, SPEED, spread=0.05),
        candidates=NAMES,
        sensors=SENSORS,
    ).fit(())
    rate = fit.place.question.stretches[0].channels.index("r")
    assert np.median(band(base, 0)[:, rate]) > 1.5 * np.median(band(fit, 0)[:, rate])
