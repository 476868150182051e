"""Show the catalogue of effects that models are made of."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome
from pmmkit.actions.setting import setting, settings

if TYPE_CHECKING:
    from pmmkit.effects import Effect

STAGE: Final = ("model", 4)
EXAMPLE: Final = "pmmkit effects crossflow_drag"


@settings
class EffectsSettings:
    """What is asked."""

    names: tuple[str, ...] = setting(
        "Effects of which all is told, or parts of their names.", default=(), argument=True
    )


def effects(job: EffectsSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.effects import CATALOGUE

    asked = list(dict.fromkeys(x for name in job.names or ("",) for x in _named(name)))
    found = [CATALOGUE[name] for name in asked]
    whole = job.names and len(found) <= len(job.names)
    return Outcome(
        content={"effects": [_content(item) for item in found]},
        lines="\n\n".join(map(str, found)).split("\n") if whole else _list(found),
    )


def _named(text: str) -> list[str]:
    """The effect of a name, else those whose names hold it."""
    from pmmkit.effects import CATALOGUE

    every = CATALOGUE
    word = text.lower()
    return [word] if word in every else [x for x in every if word in x] or [CATALOGUE[text].name]


def _list(found: Iterable[Effect]) -> list[str]:
    listed = list(found)
    width = max(len(item.name) for item in listed)
    lines = []
    for title, faults in (("Effects", False), ("Faults of a measurement", True)):
        some = [item for item in listed if item.faulty is faults]
        lines += [f"{title}:"] * bool(some)
        lines += [f"  {item.name:<{width}}  {item.summary}" for item in some]
    return lines


def _content(item: Effect) -> dict[str, Any]:
    return {
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
