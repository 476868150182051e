"""Tests of a ship or model that sails by itself: their motion is a result, not a setting."""

from __future__ import annotations

from typing import Final

from pmmkit.campaigns.test_kinds.kind import TestKind

TURNING: Final = TestKind(
    name="turning",
    title="turning",
    family="free-running",
    of_standard=True,
    needs=("rudder",),
    codes=("TC",),
    phrase=r"\bturn(?:ing)?\b",
)
ZIGZAG: Final = TestKind(
    name="zigzag",
    title="zigzag",
    family="free-running",
    of_standard=True,
    needs=("rudder", "switch"),
    codes=("ZZ",),
    phrase=r"\bzig ?zag\b",
)
PULL_OUT: Final = TestKind(
    name="pull_out",
    title="pull out",
    family="free-running",
    takes=("rudder",),
    codes=("PO",),
    phrase=r"\bpull ?out\b",
)
SPIRAL: Final = TestKind(name="spiral", title="spiral", family="free-running", phrase=r"\bspiral\b")
STOPPING: Final = TestKind(
    name="stopping",
    title="stopping",
    family="free-running",
    of_standard=True,
    propeller_stops=True,
    codes=("CS",),
    phrase=r"\b(?:crash ?)?stop(?:ping)?\b",
)
STRAIGHT: Final = TestKind(
    name="straight", title="straight run", family="free-running", codes=("STR",)
)
WEAVE: Final = TestKind(
    name="weave",
    title="weave",
    family="free-running",
    needs=("rudder",),
    takes=("period",),
    codes=("WV",),
    phrase=r"\bweav(?:e|ing)\b",
)
ACCELERATING: Final = TestKind(
    name="accelerating",
    title="accelerating",
    family="free-running",
    codes=("ACC",),
    phrase=r"\baccelerating\b",
)
RANDOM: Final = TestKind(
    name="random",
    title="random",
    family="free-running",
    propeller_stops=True,
    phrase=r"\brandom\b|\bprbs\b",
)
KINDS: Final = (TURNING, ZIGZAG, PULL_OUT, SPIRAL, STOPPING, STRAIGHT, WEAVE, ACCELERATING, RANDOM)
