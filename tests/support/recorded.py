"""A simulated track as a free-running record, with the noise of its sensors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pmmkit import FreeRecord, Track


def recorded(
    track: Track,
    sensors: Mapping[str, float],
    rng: np.random.Generator,
    *,
    name: str,
    speed: float,
    zero: float = 0.0,
    depth: float | None = None,
) -> FreeRecord:
    """The record; the rudder column shows less than there is by `zero` [rad]."""
    measured = {
        channel: getattr(track, channel) + std * rng.normal(size=len(track))
        for channel, std in sensors.items()
    }
    return FreeRecord(
        name=name,
        t=track.t,
        delta=track.delta - zero,
        turns=track.n,
        measured=measured,
        speed=speed,
        depth=depth,
    )
