"""The conditions of the standard beside those of a trial, as recorded and as stated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pmmkit.campaigns.run import Campaign
from pmmkit.simulation.imo.conditions import (
    Condition,
    approach_condition,
    current_condition,
    depth_condition,
    draught_condition,
    length_condition,
    sea_condition,
    wind_condition,
)
from pmmkit.trials.current import Current


def trial_conditions(
    campaign: Campaign, *, speed: float, wind: float | None, current: Current | None
) -> tuple[Condition, ...]:
    """What the standard asks of a trial, and what this one was.

    Parameters
    ----------
    campaign : Campaign
        Gives ship, water and what ``[imo]`` states: sea state, wind, draughts, the speed at 85 %
        of the engine's output.
    speed : float
        Of the approach [m/s].
    wind : float or None
        Mean true wind as measured [m/s].
    current : Current or None
        That was removed.
    """
    ship, stated = campaign.ship, campaign.imo
    shown = ""
    if current is not None:
        shown = f"{current.speed:.2f} m/s to {current.direction_deg:03.0f}°, removed"
    draught = mean_draught(stated, ship.d)
    return (
        length_condition(ship.L),
        depth_condition(campaign.water.depth, draught),
        wind_condition(wind, stated.get("wind_beaufort")),
        sea_condition(stated.get("sea_state")),
        current_condition(current is not None, shown),
        draught_condition(draught, stated.get("full_load_draught")),
        approach_condition(speed, stated.get("speed_85")),
    )


def mean_draught(stated: Mapping[str, Any], otherwise: float) -> float:
    """Mean draught as tried [m]: that of the stated ends, else the other one.

    Examples
    --------
    >>> mean_draught({"draught_fore": 9.0, "draught_aft": 11.0}, 20.8), mean_draught({}, 20.8)
    (10.0, 20.8)
    """
    fore, aft = stated.get("draught_fore"), stated.get("draught_aft")
    return otherwise if fore is None or aft is None else 0.5 * (fore + aft)
