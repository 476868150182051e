"""Ships that the tests accept: the sets that a diagnosis named, kept as models."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from pmmkit.base import ModelError
from pmmkit.diagnosis import Diagnosis, Session, Together
from pmmkit.models import load_model, save_model
from pmmkit.views import Rival
from pmmkit.workbench.saved import find_result, save_result

RESULT: Final = "rivals"


def save_rivals(folder: Path, session: Session[Any], found: Diagnosis | Together) -> None:
    """Keep the sets that a diagnosis named and that can be sailed, each with its odds and ship."""
    effects = tuple(step.effect for step in session.steps)
    kept: list[dict[str, Any]] = []
    for names, odds in found.group:
        file = folder / f"rival_{len(effects)}_{len(kept)}.toml"
        with suppress(ModelError):
            save_model(session.evidence.rival(session.steps, names), file)
            kept.append({"effects": names, "odds": odds, "file": file.name})
    save_result(folder, RESULT, effects, kept)


def find_rivals(folder: Path, effects: tuple[str, ...]) -> tuple[Rival, ...]:
    """Ships that the tests accept beside the model with some effects.

    They are those of the last diagnosis that named any, while what was added since is part of one
    of its sets; none after other steps.
    """
    for count in range(len(effects), -1, -1):
        found = find_result(folder, RESULT, effects[:count])
        if not found:
            continue
        if not any(set(effects[count:]) <= set(item["effects"]) for item in found):
            return ()
        return tuple(
            Rival(
                effects=tuple(item["effects"]),
                odds=item["odds"],
                model=load_model(folder / item["file"]),
            )
            for item in found
        )
    return ()
