"""Criteria of IMO MSC.137(76) beside the measures of a trial."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from pmmkit.campaigns.test_kinds.free_running import STOPPING, TURNING
from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.metrics import Criterion, criteria
from pmmkit.simulation.imo import LARGE, SHORTEST, Verdict, judge, turning_conditions

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
    size = abs(rudder_deg)
    asked = [pair for pair in criteria() if _applies(pair[1], test, size, switch_deg)]
    own_first = sorted(asked, key=lambda pair: pair[1].manoeuvre != test)
    kind = kind_of(test)
    if kind is TURNING:
        conditions = turning_conditions(rudder_deg, conditions, ".1f")
    elif kind is STOPPING:
        conditions += (LARGE,)
    words = kind.title
    if kind.turns_rudder:
        words += f" {size:.0f}" + (f"/{switch_deg:.0f}" if kind.switches else "°")
        words += f", to {'starboard' if rudder_deg > 0 else 'port'}"
    found = []
    for metric, criterion in own_first:
        verdict = judge(
            metric,
            criterion,
            metrics,
            L=L,
            speed=speed,
            scale=f"as measured, L = {L:.4g} m",
            manoeuvre=words,
            conditions=conditions,
        )
        spread = std.get(verdict.metric, math.nan)
        if math.isfinite(verdict.value) and spread > 0:
            probability = 0.5 * (1.0 + math.erf(verdict.margin / spread / math.sqrt(2.0)))
            verdict = replace(verdict, probability=probability)
        found.append(verdict)
    return tuple(found)


def _applies(criterion: Criterion, test: str, rudder: float, switch: float) -> bool:
    """Whether a run is the test of a criterion: the manoeuvre, and its angles within reach."""
    if test not in (criterion.manoeuvre, *criterion.shown_by):
        return False
    if not kind_of(test).switches:
        return True
    settings = criterion.settings
    heading = settings.get("switch_deg", settings.get("heading_deg", math.nan))
    return abs(rudder - settings["rudder_deg"]) < 1.0 and abs(switch - heading) < 0.5


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
