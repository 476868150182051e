"""What the seas of records tell, and what they do not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model
from pmmkit.numerics import Array

ONE_SEA: Final = 1.2
"""Ratio of peak periods up to which one table of drift stands for both."""
ONE_SIDE: Final = math.radians(30.0)
_TURNING: Final = math.radians(20.0)  # by which a wind changes enough to be told from waves


def sea_notes(model: Model, records: Sequence[FreeRecord]) -> tuple[str, ...]:
    """What a reader must know of waves in records: their period, and the wind beside them.

    Parameters
    ----------
    model : Model
        With a part for waves, else there is nothing to say.
    records : sequence of FreeRecord
        Those that are used.

    Returns
    -------
    tuple of str
        That the table is for waves of another period; that wind and waves come from one side, so
        that their forces are not told apart.
    """
    waves = model.in_role("waves")
    stated = [item for item in records if item.wave_height is not None]
    if not waves or not stated:
        return ()
    periods = {item.wave_period for item in stated if item.wave_period is not None}
    other = other_period(model, sorted(periods), "the records state")
    notes = [other] if other else []
    if all(_one_side(item) for item in stated):
        notes.append(
            "Wind and waves come from one side in all records: their forces are not told apart. "
            "Swell from another side, a change of the wind, or a wind that the model knows does."
        )
    return tuple(notes)


def other_period(model: Model, periods: Sequence[float], told: str) -> str:
    """That the drift of a model is for waves of another period; empty where it is not.

    Parameters
    ----------
    model : Model
        With a part for waves.
    periods : sequence of float
        Peak periods of what it sails in [s].
    told : str
        Words before these periods.
    """
    (waves, *_) = model.in_role("waves")
    made_for = model.parts[waves].values.get("Tp", 0.0)
    if not isinstance(made_for, float) or made_for <= 0.0:
        return ""
    off = [f"{x:g} s" for x in periods if not 1 / ONE_SEA <= x / made_for <= ONE_SEA]
    if not off:
        return ""
    return (
        f"The model's drift of waves is for a peak period of {made_for:g} s, {told} "
        f"{', '.join(off)}: make the table anew for their sea (pmmkit seakeeping --tp)."
    )


def _one_side(record: FreeRecord) -> bool:
    """Whether a steady wind blows from where the waves come."""
    wind, waves, blows = record.wind_direction, record.wave_direction, record.wind_speed
    if wind is None or waves is None or blows is None or not np.any(blows > 0.0):
        return False
    mean = _mean(wind)
    steady = float(np.sqrt(np.mean(_between(wind, mean) ** 2))) < _TURNING
    return steady and abs(float(_between(np.array([mean]), _mean(waves))[0])) < ONE_SIDE


def _mean(angles: Array) -> float:
    return float(np.angle(np.mean(np.exp(1j * angles))))


def _between(angles: Array, other: float) -> Array:
    return np.asarray(np.angle(np.exp(1j * (angles - other))))
