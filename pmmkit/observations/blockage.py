"""Blockage of the tank: how much faster the water passes the model than the carriage says."""

from __future__ import annotations

from pmmkit.campaigns.run import Campaign


def speed_increase(campaign: Campaign, speed: float) -> float | None:
    """Mean increase of the water's speed beside the model, as a share of the carriage's.

    One-dimensional continuity with the lowered surface: m/(1 - m - Fh²), m the model's midship
    section over the tank's and Fh the Froude number on the tank's depth. A mean over the section:
    a first estimate, not a wall correction of moments.

    Parameters
    ----------
    campaign : Campaign
        Its water must hold tank_width and tank_depth.
    speed : float
        Carriage speed [m/s].

    Returns
    -------
    float or None
        Share; None where the tank is not stated or the flow is critical.

    Examples
    --------
    >>> from pmmkit.ship import Ship, Water
    >>> ship = Ship(name="m", L=6.9, B=1.25, d=.45, volume=3.1, mass=3100., Izz=9500.)
    >>> tank = Water(tank_width=14.0, tank_depth=6.0)
    >>> round(speed_increase(Campaign(title="", ship=ship, water=tank, runs=()), 1.17), 5)
    0.0069
    """
    water, ship = campaign.water, campaign.ship
    depth = water.depth or water.tank_depth
    if water.tank_width is None or depth is None:
        return None
    section = ship.B * ship.d / (water.tank_width * depth)
    room = 1 - section - speed**2 / (water.g * depth)
    return section / room if room > 0 else None
