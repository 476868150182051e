"""Check loads: known weights on the balance while the carriage stands, which tell its scale.

The load pulls the model as the water would, so the balance reads it with the sign of a force on the
hull. It may be stated as forces and moments, or as a side force at a station along the model.
"""

from __future__ import annotations

from typing import Final

from pmmkit.campaigns.setting import LENGTH, RATE, RunSetting, Told
from pmmkit.campaigns.test_kinds.kind import TestKind
from pmmkit.campaigns.test_kinds.steady import STRAIGHT


def _load(name: str, channel: str, word: str, unit: str, typical: float) -> RunSetting:
    """A load of one channel."""
    return RunSetting(
        name=name,
        unit=unit,
        meaning=f"known {word} on the model at rest, of a check load [{unit}]",
        where_needed=True,
        along=channel,
        told=Told(symbol=f"{channel} load", word=word, unit=f" {unit}", form="+.4g"),
        word=word,
        resolution=RATE,
        typical=typical,
    )


LOADS: Final = (
    _load("surge_load", "X", "surge load", "N", 20.0),
    _load("sway_load", "Y", "sway load", "N", 50.0),
    _load("yaw_load", "N", "yaw load", "N m", 50.0),
    _load("roll_load", "K", "roll load", "N m", 5.0),
)
SETTINGS: Final = (
    *LOADS,
    RunSetting(
        name="load_arm",
        unit="m",
        meaning="where `sway_load` pulls, forward of midship [m]",
        where_needed=True,
        told=Told(symbol="at", word="at", unit=" m", form="+.4g"),
        word="arm of the load",
        resolution=LENGTH,
        typical=1.0,
    ),
)
KINDS: Final = (
    TestKind(
        name="check_load",
        title="check load",
        family="steady",
        takes=tuple(item.name for item in SETTINGS),
        motion=STRAIGHT,
        at_rest=True,
    ),
)
