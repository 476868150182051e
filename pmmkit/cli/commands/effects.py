"""``pmmkit effects``."""

from __future__ import annotations

from typing import Final

from pmmkit.cli.output import Outcome

EXAMPLE: Final = "pmmkit effects"


def effects() -> Outcome:
    """The catalogue of effects that models are made of."""
    from pmmkit.effects.catalogue import catalogue

    found = catalogue().values()
    entries = [
        {
            "name": item.name,
            "family": item.family,
            "kind": item.kind,
            "summary": item.summary,
            "source": item.source,
            "parameters": [part.name for part in item.parameters],
            "usual_sizes": {part.name: part.typical for part in item.coefficients},
            "check": item.check,
            "enters_a_model": not item.faulty,
        }
        for item in found
    ]
    width = max(len(item.name) for item in found)
    lines = []
    for title, faults in (("Effects", False), ("Faults of a measurement", True)):
        lines += [f"{title}:"] + [
            f"  {item.name:<{width}}  {item.summary}" for item in found if item.faulty is faults
        ]
    return Outcome(content={"effects": entries}, lines=lines)
