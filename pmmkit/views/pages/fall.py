"""How the error of what is left out falls with each step."""

from __future__ import annotations

from typing import Any

from pmmkit.diagnosis import Fall
from pmmkit.views.pages.numbers import short


def fall_page(fall: Fall) -> dict[str, Any]:
    """The waterfall: a row per step."""
    if len(fall.campaigns) > 1:
        return {
            "campaigns": [
                {**fall_page(fall.only(name)), "title": name, "steps": _steps(fall, name)}
                for name in fall.campaigns
            ]
        }
    return {
        "unit": fall.unit,
        "of": fall.of,
        "how": fall.how,
        "remarks": list(fall.remarks()),
        "useless": list(fall.useless),
        "steps": _steps(fall, fall.campaigns[0]),
    }


def _steps(fall: Fall, name: str) -> list[dict[str, Any]]:
    """The errors of one campaign after each step."""
    of, units = fall.told[name].of, fall.units(name)
    errors = {x: fall.errors(x, name) for x in fall.quantities(name)}
    levels = fall.levels(of, name)
    return [
        {
            "step": step,
            "error": short(errors[of][place]),
            "level": short(levels[place]),
            "channels": {
                x: {"error": short(own[place]), "unit": units[x]}
                for x, own in errors.items()
                if units[x] != "%"
            },
        }
        for place, step in enumerate(fall.steps)
    ]
