"""What is said of the seas of records: another period, wind and waves from one side."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit import FreeRecord
from pmmkit.identification import sea_notes
from pmmkit.models import Part, load_model

CALM = load_model("s175-3dof")
VALUES = {
    "Hs": 3.0, "Tp": 10.0, "angle_deg": (0.0, 180.0), "DX": (-0.01, 0.01), "DY": (0.0, 0.0),
    "DN": (0.0, 0.0),
}  # fmt: skip
PART = Part(effect="wave_drift", values=VALUES, options={"coefficients": "table"})
ROUGH = CALM.with_(parts={**CALM.parts, "wave_drift": PART})
T = np.arange(0.0, 200.0)


def record(*, period=10.0, sea=0.4, wind=0.4, blows=8.0, **changes):
    still = 0.0 * T
    made = FreeRecord(name="a", t=T, delta=still, turns=still, measured={"psi": still}, speed=7.0)
    return made.with_(
        wave_height=3.0 + still,
        wave_direction=sea + still,
        wave_period=period,
        wind_speed=blows + still,
        wind_direction=wind + still,
    ).with_(**changes)


@pytest.mark.parametrize(
    ("records", "words"),
    [
        ([record(wind=2.0), record(period=11.5, wind=2.5)], []),
        ([record(wind=2.0), record(period=7.0, wind=2.0)], ["state 7 s"]),
        ([record(), record(wind=0.7)], ["one side"]),
        ([record(wind=0.4 + 2 * np.pi), record(sea=6.5, wind=0.2, period=20.0)], ["20 s", "one"]),
        ([record(), record(wind=2.5)], []),
        ([record(wind_direction=0.4 + 0.01 * T)], []),
        ([record(blows=0.0)], []),
        ([record(wind_direction=None, wind_speed=None)], []),
    ],
    ids=["swell", "period", "one side", "both", "one with swell", "it turns", "calm", "unknown"],
)
def test_what_is_said_of_seas(records, words):
    notes = sea_notes(ROUGH, records)
    assert len(notes) == len(words)
    assert all(word in note for word, note in zip(words, notes, strict=True))


def test_nothing_is_said_of_waves_that_the_model_has_no_place_for():
    assert sea_notes(CALM, [record()]) == ()
    assert sea_notes(ROUGH, [record(wave_height=None, wave_direction=None)]) == ()
