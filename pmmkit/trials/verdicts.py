"""Criteria of IMO MSC.137(76) beside the measures of a trial."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from pmmkit.simulation.imo import (
    INITIAL_LIMIT,
    OVERSHOOT_20,
    RUDDER_DEG,
    SHORTEST,
    STOPPING_LIMIT,
    TURNING_LIMITS,
    Verdict,
    zigzag_limits,
)

CALM: Final = 10.7
"""Upper end of Beaufort 5 [m/s]: the standard asks for calm weather."""
DEEP: Final = 4.0
"""Depth over draught of deep water in the standard."""


def verdicts_of(
    test: str,
    metrics: Mapping[str, float],
    std: Mapping[str, float],
    *,
    L: float,
    speed: float,
    rudder_deg: float,
    switch_deg: float = math.nan,
    conditions: tuple[str, ...] = (),
) -> tuple[Verdict, ...]:
    """Every criterion that a run of that kind is judged by.

    Parameters
    ----------
    test : str
        ``turning``, ``zigzag`` or ``stopping``.
    metrics, std : mapping of str to float
        Of the trial.
    L, speed : float
        Ship length [m], test speed [m/s].
    rudder_deg, switch_deg : float
        Rudder angle, and heading at which a zigzag switches [deg].
    conditions : tuple of str
        What the run does not fulfil.

    Returns
    -------
    tuple of Verdict
        With the probability that the criterion is met, from the standard uncertainty.

    Examples
    --------
    >>> found = verdicts_of("stopping", {"track_reach_L": 14.2}, {"track_reach_L": 0.1}, L=170.0,
    ...                     speed=7.25, rudder_deg=0.0)
    >>> [(item.criterion, item.limit, item.passed, round(item.probability, 6)) for item in found]
    [('track_reach', 15.0, True, 1.0)]
    """
    asked: list[tuple[str, str, float, str]] = []
    first, second = zigzag_limits(L, speed)
    size = abs(rudder_deg)
    if test == "turning":
        asked = [(name, f"{name}_L", limit, "L") for name, limit in TURNING_LIMITS]
        if abs(size - RUDDER_DEG) > 0.5:
            conditions = (
                f"The standard asks for 35° of rudder or the largest permissible; this is "
                f"{size:.1f}°.",
                *conditions,
            )
        side = "starboard" if rudder_deg > 0 else "port"
        conditions += (f"The standard asks for turns to both sides; this is the one to {side}.",)
    elif test == "zigzag" and abs(size - 10.0) < 1.0 and abs(switch_deg - 10.0) < 0.5:
        asked = [
            ("first_overshoot_10_10", "overshoot_1_deg", first, "deg"),
            ("second_overshoot_10_10", "overshoot_2_deg", second, "deg"),
            ("initial_turning", "initial_turning_distance_L", INITIAL_LIMIT, "L"),
        ]
    elif test == "zigzag" and abs(size - 20.0) < 1.0 and abs(switch_deg - 20.0) < 0.5:
        asked = [("first_overshoot_20_20", "overshoot_1_deg", OVERSHOOT_20, "deg")]
    elif test == "stopping":
        asked = [("track_reach", "track_reach_L", STOPPING_LIMIT, "L")]
        conditions += ("The administration may allow up to 20 L for ships of large displacement.",)
    words = {"turning": f"turning {size:.0f}°", "zigzag": f"zigzag {size:.0f}/{switch_deg:.0f}"}
    to = "" if test == "stopping" else f", to {'starboard' if rudder_deg > 0 else 'port'}"
    found = []
    for criterion, metric, limit, unit in asked:
        value, spread = metrics.get(metric, math.nan), std.get(metric, math.nan)
        probability = None
        if math.isfinite(value) and spread > 0:
            probability = 0.5 * (1.0 + math.erf((limit - value) / spread / math.sqrt(2.0)))
        found.append(
            Verdict(
                criterion=criterion,
                limit=limit,
                value=value,
                margin=limit - value,
                passed=None if math.isnan(value) else value <= limit,
                conditions=conditions,
                scale=f"as measured, L = {L:.4g} m",
                unit=unit,
                manoeuvre=words.get(test, test) + to,
                probability=probability,
            )
        )
    return tuple(found)


def conditions_of(
    *, L: float, draught: float, depth: float | None, wind: float | None, current_known: bool
) -> tuple[str, ...]:
    """Conditions of the standard that a trial does not fulfil, or that its record does not show.

    Parameters
    ----------
    L, draught : float
        Of the ship [m].
    depth, wind : float or None
        Of the water [m]; mean true wind [m/s].
    current_known : bool
        Whether the current was removed.

    Examples
    --------
    >>> conditions_of(L=170.0, draught=5.1, depth=15.0, wind=5.0, current_known=True)[0]
    'The standard asks for deep water, more than 4 draughts; this is 2.9.'
    """
    found = []
    if L < SHORTEST:
        found.append(f"The standard is for ships of 100 m and more; this one has L = {L:.4g} m.")
    if depth is not None and depth < DEEP * draught:
        found.append(
            f"The standard asks for deep water, more than 4 draughts; this is "
            f"{depth / draught:.1f}."
        )
    if wind is not None and wind > CALM:
        found.append(f"The standard asks for calm weather; the wind is {wind:.1f} m/s.")
    if not current_known:
        found.append("The current is not known: the lengths are over ground.")
    found.append(
        "The approach speed must be at least 90 % of the speed at 85 % of the engine's output, "
        "and the ship loaded and on even keel; the record does not show that."
    )
    return tuple(found)
