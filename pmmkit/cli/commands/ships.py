"""``pmmkit ships``."""

from __future__ import annotations

from typing import Final

from pmmkit.cli.output import Outcome

EXAMPLE: Final = "pmmkit ships"


def ships() -> Outcome:
    """The library of ships."""
    from pmmkit import ship_library
    from pmmkit.models import load_model

    found = [load_model(name) for name in ship_library.ships()]
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
