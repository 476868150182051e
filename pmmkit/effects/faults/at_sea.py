"""Faults of a free-running ship's instruments: they change what is shown, not how it sails."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

from pmmkit.effects.definition import Effect
from pmmkit.effects.faults.fault import size
from pmmkit.effects.seen import ANTENNA, CLOCK_LAG, HEADING_OFFSET, LOG_GAIN, Move, Vessel

ON_A_CARRIAGE: Final = "a carriage knows its position and speed; a rig holds the heading"
Moves = Callable[[Vessel], Mapping[str, Move]]


def _shown(name: str, unit: float, typical: Callable[[Vessel], float]) -> Moves:
    """One value that the channels show wrongly, with its usual size for a vessel."""

    def moves(vessel: Vessel) -> Mapping[str, Move]:
        values = MappingProxyType({name: unit})
        return {name: Move(values=values, typical=typical(vessel))}

    return moves


def _antenna(vessel: Vessel) -> Mapping[str, Move]:
    """Somewhere else on the ship than midship."""
    return {
        ANTENNA[0]: Move(values=MappingProxyType({ANTENNA[0]: 1.0}), typical=0.1 * vessel.ship.L),
        ANTENNA[1]: Move(values=MappingProxyType({ANTENNA[1]: 1.0}), typical=0.2 * vessel.ship.B),
    }


def _fault(name: str, summary: str, moves: Moves, check: str, **more: Any) -> Effect:
    return Effect(
        name=name,
        family="instruments",
        kind="fault",
        summary=summary,
        moves=moves,
        sources=("ittc_7.5-04-02-01",),
        check=check,
        not_captive=ON_A_CARRIAGE,
        **more,
    )


EFFECTS: Final = (
    _fault(
        "fault_clock_lag",
        "The clock of the positions is late beside that of the other instruments.",
        _shown(CLOCK_LAG, 1.0, lambda vessel: 0.05 * vessel.ship.L / vessel.speed),
        "the instants of both receivers on one screen",
        parameters=(size(CLOCK_LAG, "s", 1.0, "by which positions are late"),),
    ),
    _fault(
        "fault_antenna",
        "The antenna of the positions does not stand at midship.",
        _antenna,
        "the place of the antenna with a tape",
        parameters=(
            size(ANTENNA[0], "m", 15.0, "forward of midship"),
            size(ANTENNA[1], "m", 5.0, "starboard of the centreline"),
        ),
        in_words="Position of the antenna",
    ),
    _fault(
        "fault_heading_offset",
        "The heading is shown off by a constant angle.",
        _shown(HEADING_OFFSET, math.radians(1.0), lambda _: 1.0),
        "the heading beside a quay of known direction",
        parameters=(size(HEADING_OFFSET, "deg", 1.0, "shown too much"),),
    ),
    _fault(
        "fault_log",
        "The velocities through the water are shown too large by a share.",
        _shown(LOG_GAIN, 1.0, lambda _: 0.02),
        "a run over a measured mile and back",
        parameters=(size(LOG_GAIN, "-", 0.02, "of the velocity"),),
        in_words="Gain of the speed log",
    ),
)
