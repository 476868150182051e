"""Criteria of IMO resolution MSC.137(76) for a turning circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from pmmkit.errors import DataError
from pmmkit.simulation.track import Track

SOURCE: Final = "IMO MSC.137(76), 2002"
TURNING_LIMITS: Final = (("advance", 4.5), ("tactical_diameter", 5.0))
RUDDER_DEG: Final = 35.0
SHORTEST: Final = 100.0


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """One criterion applied to one track.

    Parameters
    ----------
    criterion : str
        What is limited.
    limit, value : float
        In ship lengths.
    margin : float
        Limit less value: positive where the criterion is met.
    passed : bool or None
        None where the track does not reach that far.
    conditions : tuple of str
        Conditions of the standard that this track does not meet, or does not show.
    scale : str
        At which scale and propulsion point the track is.
    """

    criterion: str
    limit: float
    value: float
    margin: float
    passed: bool | None
    conditions: tuple[str, ...]
    scale: str


def imo_turning(track: Track) -> list[Verdict]:
    """Turning ability: advance at most 4.5 L, tactical diameter at most 5 L.

    Parameters
    ----------
    track : Track
        A turning circle.

    Returns
    -------
    list of Verdict
        With the conditions of the standard that the track does not meet or does not show.

    Raises
    ------
    DataError
        If the track is no turning circle.

    References
    ----------
    IMO resolution MSC.137(76), Standards for ship manoeuvrability, 2002.

    Examples
    --------
    >>> from pmmkit.simulation import simulate
    >>> [(v.criterion, v.limit, v.passed) for v in imo_turning(simulate("s175", speed=9.0))]
    [('advance', 4.5, True), ('tactical_diameter', 5.0, True)]
    """
    if track.manoeuvre != "turning":
        raise DataError(f"The criteria are for a turning circle, not for {track.manoeuvre!r}.")
    conditions = _conditions(track)
    verdicts = []
    for name, limit in TURNING_LIMITS:
        value = track.metrics.get(f"{name}_L", math.nan)
        verdicts.append(
            Verdict(
                criterion=name,
                limit=limit,
                value=value,
                margin=limit - value,
                passed=None if math.isnan(value) else value <= limit,
                conditions=conditions,
                scale=track.scale,
            )
        )
    return verdicts


def _conditions(track: Track) -> tuple[str, ...]:
    found = []
    if abs(abs(track.rudder_deg) - RUDDER_DEG) > 0.5:
        found.append(
            f"The standard asks for 35° of rudder or the largest permissible; this is "
            f"{abs(track.rudder_deg):g}°."
        )
    if track.L < SHORTEST:
        found.append(
            f"The standard is for ships of 100 m and more; this track is of L = {track.L:.4g} m."
        )
    found.append(
        f"The approach speed ({track.speed:.4g} m/s, Fn {track.Fn:.3f}) must be at least 90 % of "
        f"the speed at 85 % of the engine's output, which the model does not state."
    )
    side = "starboard" if track.rudder_deg > 0 else "port"
    found.append(f"The standard asks for turns to both sides; this is the one to {side}.")
    return tuple(found)
