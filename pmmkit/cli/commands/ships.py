"""``pmmkit ships``."""

from __future__ import annotations

from typing import Final

from pmmkit.cli.output import Outcome

EXAMPLE: Final = "pmmkit ships"


def ships() -> Outcome:
    """The library of ships."""
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
