"""The command line of each step: what a person would type to get the same."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Final

from pmmkit.conventions import STRUCTURES
from pmmkit.models import Step, load_model
from pmmkit.workbench.saved import OWN, STEPS, WorkbenchState, model_file

PROGRAM: Final = "pmmkit"


def command_lines(state: WorkbenchState, folder: Path, structure: str) -> list[dict[str, str]]:
    """What was done so far, as commands."""
    tests = [shlex.quote(place) for place in state.campaigns]
    fitted = " ".join(f"--fit {place}" for place in tests)
    more = f" --data {shlex.quote(state.data)}" if state.data else ""
    own = f" --own {_quoted(folder / OWN)}" if (folder / OWN).is_file() else ""
    told = own + "".join(f" --{name} {value:g}" for name, value in state.settings.items())
    found: list[dict[str, str]] = []
    model = shlex.quote(state.model)
    if not state.model or state.model in STRUCTURES:
        base = folder / "reduced"
        lent = f" --parts {shlex.quote(state.parts)}" if state.parts else ""
        lent += " --force" if _by_force(model_file(folder, ())) else ""
        line = f"reduce {tests[0]} --structure {state.model or structure} --fn pooled{lent}"
        found.append(_line("reduce", f"{line} --out {_quoted(base)}{more}"))
        model = _quoted(base / "model.toml")
    found += [_line("compare", f"compare {model} {place}{more}") for place in tests]
    found.append(_line("diagnose", f"diagnose {model} {' '.join(tests)}{told}{more}"))
    for number, step in enumerate(state.steps, start=1):
        made = _quoted(model_file(folder, state.effects[:number]))
        found.append(_added(step, model, fitted, made, f"{told}{more}"))
        model = made
    if state.steps:
        first = found[0]["what"] == "reduce"
        base_model = (
            _quoted(folder / "reduced" / "model.toml") if first else shlex.quote(state.model)
        )
        steps = _quoted(folder / STEPS)
        line = f"add {base_model} --steps {steps} {fitted} -o replayed.toml{told}{more}"
        found.append(_line("replay", line))
    return found


def _added(step: Step, model: str, fitted: str, made: str, more: str) -> dict[str, str]:
    why = f" --why {shlex.quote(step.note)}" if step.note else ""
    effect = step.effect + (f"@{shlex.quote(step.campaign)}" if step.campaign else "")
    line = f"add {model} {effect} {fitted} -o {made}{why}{more}"
    return _line("add", line, step.effect)


def _by_force(base: Path) -> bool:
    """Whether a base was made of derivatives that are not usable, as the page does and says."""
    return base.is_file() and bool(load_model(base).not_usable)


def _line(what: str, line: str, effect: str = "") -> dict[str, str]:
    return {"what": what, "effect": effect, "line": f"{PROGRAM} {line}"}


def _quoted(path: Path) -> str:
    return shlex.quote(str(path))
