"""Measured manoeuvres with simulated or submitted ones over them: turning circles, zigzags."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from pmmkit.campaigns.test_kinds.free_running import TURNING
from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.plotting.histories import zigzag
from pmmkit.plotting.turns import trajectory
from pmmkit.simulation.track import Track
from pmmkit.trials import Trial

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FIRST: Final = "overshoot_1_deg"

Sailed = tuple[Trial, Track]
"""A manoeuvre as it was measured, and as something or somebody else has it."""


def overlays(sailed: Sequence[Sailed], *, other: str) -> dict[str, Figure]:
    """Turning circles to both sides, and the zigzag whose first overshoot is off most.

    Parameters
    ----------
    sailed : sequence of (Trial, Track)
        Each manoeuvre as measured, and the other one.
    other : str
        What the other one is.

    Returns
    -------
    dict of str to Figure
        ``turning_circles`` and ``zigzag``, as far as there are such tests.
    """
    found: dict[str, Figure] = {}
    turns = _each_side([item for item in sailed if kind_of(item[0].manoeuvre) is TURNING])
    if turns:
        found["turning_circles"] = trajectory(*_tracks(turns, other))
    weaves = [item for item in sailed if kind_of(item[0].manoeuvre).switches]
    if weaves:
        worst = max(weaves, key=_off)
        found[worst[0].manoeuvre] = zigzag(*_tracks([worst], other))
    return found


def _each_side(turns: Sequence[Sailed]) -> list[Sailed]:
    """The first turn to each side."""
    sides = {item[0].rudder_deg > 0: item for item in reversed(turns)}
    return [sides[side] for side in (True, False) if side in sides]


def _off(item: Sailed) -> float:
    """By how much the first overshoot is off [deg]."""
    measured, other = (one.metrics.get(_FIRST, math.nan) for one in item)
    return abs(other - measured) if math.isfinite(other - measured) else 0.0


def _tracks(items: Sequence[Sailed], other: str) -> tuple[list[Track], list[str]]:
    tracks: list[Track] = []
    names: list[str] = []
    for trial, track in items:
        tracks += [trial.ordered, track.ordered]
        names += [f"{trial.run}, measured", f"{trial.run}, {other}"]
    return tracks, names
