"""Symmetry of port and starboard: which parts of a force an effect, or an error of it, can have."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.system import FEATURES, CandidateColumns, System, is_even
from pmmkit.diagnosis.captive.whitening import Places
from pmmkit.reduction import View

PRESENT: Final = 0.01
"""Share of its square from which a parity counts as one that an effect has."""
Parity = bool
"""True: Y and N odd, X even, as a symmetric ship has them; False: the other."""
BOTH: Final[frozenset[Parity]] = frozenset((True, False))


def mirrored(view: View) -> View:
    """A run in a mirror: sway, yaw, rudder, heel and heading turned over."""
    m = view.motion
    turned = {
        name: -getattr(m, name) for name in ("v", "r", "p", "phi", "vdot", "rdot", "pdot", "delta")
    }
    return replace(
        view, motion=m.with_(**turned), heading=-view.heading, expected=MappingProxyType({})
    )


def parities(system: System, block: CandidateColumns) -> frozenset[Parity]:
    """Parities that an effect has: those of its columns in a motion and in its mirror."""
    if block.candidate.each_run:
        return BOTH
    squares = {True: 0.0, False: 0.0}
    seen = {(view.run.test, round(view.speed, 6)): view for view in system.views}
    scale = {channel.name: channel.scale for channel in system.channels}
    views = list(seen.values())
    both = (
        block.candidate.along(own, system.base, block.value)
        for own in (views, [mirrored(view) for view in views])
    )
    for view, here, there in zip(views, *both, strict=True):
        for name in here:
            other = there[name] if is_even(name) else -there[name]
            unit = scale[name] * view.speed**2
            for own, part in ((True, here[name] + other), (False, here[name] - other)):
                squares[own] += float(np.sum((0.5 * part / unit) ** 2))
    whole = sum(squares.values())
    return frozenset(own for own, square in squares.items() if square > PRESENT * whole) or BOTH


def floor_places(system: System, wanted: frozenset[Parity]) -> Places:
    """Places of the smooth floor's features of some parities."""
    at = np.arange(system.floor_columns.start, system.floor_columns.stop)
    of_ship = (at - system.floor_columns.start) % FEATURES < FEATURES // 2
    places: Places = at[[parity in wanted for parity in of_ship.tolist()]]
    return places
