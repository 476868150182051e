"""The command line of each step: what a person would type to get the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pmmkit.conventions import STRUCTURES
from pmmkit.models import load_model
from pmmkit.workbench.offered import Actions
from pmmkit.workbench.saved import OWN, STEPS, WorkbenchState, model_file


def command_lines(state: WorkbenchState, folder: Path, action: Actions) -> list[dict[str, str]]:
    """What was done so far, as commands."""
    tests = tuple(map(Path, state.campaigns))
    data = Path(state.data) if state.data else None
    own = folder / OWN if (folder / OWN).is_file() else None
    found: list[dict[str, str]] = []

    def add(what: str, effect: str = "", name: str = "", **settings: Any) -> None:
        line = action(name or what).typed(**settings)
        found.append({"what": what, "effect": effect, "line": line})

    base = state.model
    if not base or base in STRUCTURES:
        reduced = folder / "reduced"
        add(
            "reduce",
            campaign=tests[0],
            structure=base or None,
            fn="pooled",
            parts=state.parts or None,
            force=_by_force(model_file(folder, ())),
            out=reduced,
            data=data,
        )
        base = str(reduced / "model.toml")
    for place in tests:
        add("compare", model=base, campaign=place, data=data)
    told: dict[str, Any] = {"data": data, "own": own, **state.settings}
    add("diagnose", model=base, campaigns=tests, **told)
    told["fit"] = tests
    model = base
    for number, step in enumerate(state.steps, start=1):
        made = model_file(folder, state.effects[:number])
        named = ("@".join(filter(None, (step.effect, step.campaign))),)
        add("add", step.effect, model=model, effects=named, target=made, why=step.note, **told)
        model = str(made)
    if state.steps:
        steps, made = folder / STEPS, Path("replayed.toml")
        add("replay", name="add", model=base, steps=steps, target=made, **told)
    return found


def _by_force(base: Path) -> bool:
    """Whether a base was made of derivatives that are not usable, as the page does and says."""
    return base.is_file() and bool(load_model(base).not_usable)
