"""What noise alone leaves of records that were left out, beside what a true model leaves."""

from __future__ import annotations

import math

import pytest

import pmmkit as pk
from pmmkit.diagnosis.loop.records import free_running
from tests.support.free_tank.campaigns import Setup, write

SHIP = "kvlcc2-l7"


def fall(folder, seed):
    """Of a campaign that hides nothing, by the ship herself: an independent program made it."""
    tests = pk.open_campaign(write(Setup(case="none", runs=3, seed=seed, ship=SHIP), folder))
    return free_running(pk.load_model(SHIP), tests, floor=None, candidates=[], own=()).fall(())


@pytest.mark.slow
def test_a_true_model_leaves_what_noise_alone_gives(tmp_path):
    """Two campaigns; in ten the ratio was 1.07 (position), .98 (heading), 1.06 (speed)."""
    falls = [fall(tmp_path, seed) for seed in (0, 1)]
    for name in ("position", "heading", "speed"):
        left = math.hypot(*(own.errors(name)[0] for own in falls))
        level = math.hypot(*(own.levels(name)[0] for own in falls))
        assert left / level == pytest.approx(1.0, abs=0.35), name
    again = fall(tmp_path / "again", 0)
    for name in again.quantities():
        assert again.levels(name) == falls[0].levels(name), "the same records have the same level"
        assert again.levels(name)[0] > 0.0


@pytest.mark.slow
def test_what_a_current_moves_is_no_noise_once_it_is_known(tmp_path):
    """Fixes of .01 m beside a log look like such of .3 m until the current is in the fit."""
    setup = Setup(case="current", size=3.0, runs=3, seed=4, ship=SHIP)
    tests = pk.open_campaign(write(setup, tmp_path))
    session = pk.begin(pk.load_model(SHIP), tests, candidates=["current"])
    fall = session.add("current").fall()
    before, after = fall.errors("position")
    level = fall.levels("position")[-1]
    assert before > 1.0
    assert level < 0.1
    assert 0.3 < after / level < 2.0
    (found,) = session.diagnose().findings
    assert found.errors["position"] == pytest.approx((before, after), rel=0.05)
