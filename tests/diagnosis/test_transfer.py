"""An effect of one kind of run: turns from zigzags, fast from slow, large rudder from small."""

from __future__ import annotations

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.diagnosis.findings import Nearest, Transfer
from pmmkit.diagnosis.free_running.transfer import kinds_of
from tests.support.zigzags import ASYMMETRY, SENSORS, SHIP, sailed


def test_an_effect_that_lowers_one_error_and_raises_another_is_narrow():
    both = Transfer(effect="rudder_stall", changes={"turns": 0.3, "zigzags": -0.4})
    assert both.is_narrow
    assert "it holds for this kind of run: zigzags" in str(both)
    for changes in ({"turns": -0.3, "zigzags": -0.4}, {"turns": 0.02, "zigzags": -0.4}, {}):
        wide = Transfer(effect="rudder_stall", changes=changes)
        assert not wide.is_narrow
        assert "kind of run" not in str(wide)


def test_records_of_small_and_of_large_angles_are_kinds():
    records = sailed(SHIP, 0)
    angles = [np.degrees(np.abs(item.delta).max()) for item in records]
    found = kinds_of(records)
    small, large = found["small rudder"], found["large rudder"]
    assert max(angles[j] for j in small) < min(angles[j] for j in large)
    assert sorted((*small, *large)) == [*range(len(records))]
    assert "turns" not in found


@pytest.mark.slow
def test_a_true_effect_is_advised():
    how = {"candidates": ["asymmetry", "fault_rudder_zero"], "most": 1, "sensors": SENSORS}
    found = pk.begin(SHIP, sailed(ASYMMETRY, 0), **how, spread=0.03).diagnose()
    (transfer,) = found.transfers
    assert max(transfer.changes.values()) < 0.05
    assert min(transfer.changes.values()) < -0.3
    assert [item.effect for item in found.proposed] == ["asymmetry"]
    assert found.to_dict()["transfers"] == [transfer.to_dict()]


def test_the_nearest_relative_of_records_is_told_in_the_unit_of_its_error():
    """The speed, which is a channel of captive tests too, came out in per cent of the forces."""
    near = Nearest(
        effects=("wind",), error_before=0.037, error_after=0.0277, error_level=np.nan,
        channel="speed", ratio=8.5,
    )  # fmt: skip
    assert "goes from 0.037 to 0.0277 m/s" in str(near)
