"""Show the library of ships."""

from __future__ import annotations

from typing import Final

from pmmkit.actions.outcome import Outcome
from pmmkit.actions.setting import settings

STAGE: Final = ("model", 1)
EXAMPLE: Final = "pmmkit ships"


@settings
class ShipsSettings:
    """What is asked."""


def ships(_: ShipsSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.models import load_model
    from pmmkit.models import ships as ships_ship_library

    found = [load_model(name) for name in ships_ship_library()]
    entries = [
        {
            "name": item.name,
            "title": item.title,
            "L": item.ship.L,
            "scale": item.scale,
            "parts": list(item.parts),
        }
        for item in found
    ]
    width = max(len(item.name) for item in found)
    lines = [f"{item.name:<{width}}  {item.title} (L = {item.ship.L:g} m)" for item in found]
    return Outcome(content={"ships": entries}, lines=lines)
