"""What a workbench keeps in its folder, to be found again: state, steps, models, results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError, PmmkitError
from pmmkit.diagnosis import read_session
from pmmkit.effects import Effect, own_effects, own_effects_text
from pmmkit.files import CAMPAIGN, readable, write_text
from pmmkit.models import Step

STATE: Final = "workbench.json"
STEPS: Final = "steps.toml"
OWN: Final = "own.toml"
"""Effects of the user's own, as ``--own`` reads them."""
OPENED: Final = "opened"
"""Result that holds the hash of the campaign file from which base and steps were made."""
SCHEMA: Final = 1


@dataclass(frozen=True, kw_only=True)
class WorkbenchState:
    """What a workbench is about, and how far it has come.

    Parameters
    ----------
    campaign, model, data : str
        What was opened: path of a campaign, of a model file or name of a library ship, and folder
        of the measurements or nothing.
    parts : str
        Library ship or model file that lends propeller and rudder to a base that is reduced from
        the tests; nothing for what the campaign file states and estimates.
    also : tuple of str
        Paths of other campaigns of the same ship.
    noise, floor : float, optional
        As for `begin`.
    revision : int
        Grows with each change: a page that saw an older one is told so.
    steps : tuple of Step
        What was added.
    """

    campaign: str
    model: str
    data: str = ""
    parts: str = ""
    also: tuple[str, ...] = ()
    noise: float | None = None
    floor: float | None = None
    revision: int = 0
    steps: tuple[Step, ...] = ()

    @property
    def campaigns(self) -> tuple[str, ...]:
        """All that were opened."""
        return (self.campaign, *self.also)

    @property
    def settings(self) -> dict[str, float]:
        """Noise and floor, where they were given."""
        both = {"noise": self.noise, "floor": self.floor}
        return {name: value for name, value in both.items() if value is not None}

    def is_about(self, other: WorkbenchState) -> bool:
        """Whether the same was opened; a model that the other does not name is the same."""
        mine, theirs = ([Path(x).resolve() for x in own.campaigns] for own in (self, other))
        same = mine == theirs
        alike = (self.data, self.settings) == (other.data, other.settings)
        lent = other.parts in ("", self.parts)
        return same and alike and lent and other.model in ("", self.model)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of what was added."""
        return tuple(step.effect for step in self.steps)

    def with_steps(self, steps: tuple[Step, ...]) -> WorkbenchState:
        """The next state."""
        return replace(self, steps=steps, revision=self.revision + 1)


def save_state(folder: Path, state: WorkbenchState) -> None:
    """Write a state; `steps.toml` is written by the session that took the steps."""
    kept = asdict(replace(state, steps=()))
    del kept["steps"]
    write_text(folder / STATE, readable({"schema": SCHEMA, **kept, "count": len(state.steps)}))


def find_state(folder: Path) -> WorkbenchState | None:
    """The state that was saved in a folder; None where there is none."""
    path = folder / STATE
    if not path.is_file():
        return None
    try:
        kept = json.loads(path.read_text("utf-8"))
        texts = {name: kept[name] for name in ("campaign", "model", "data")}
        texts["parts"] = kept.get("parts", "")
        also = tuple(kept.get("also", ()))
        revision, count = kept["revision"], kept["count"]
        numbers = {name: kept.get(name) for name in ("noise", "floor")}
        whole = all(isinstance(x, str) for x in (*texts.values(), *also))
        whole = whole and all(x is None or isinstance(x, float) for x in numbers.values())
        if not (whole and isinstance(revision, int) and isinstance(count, int)):
            raise DataError(f"{path} is damaged.")
        steps = read_session(folder / STEPS).steps[:count] if count else ()
    except (OSError, ValueError, KeyError, TypeError, PmmkitError) as error:
        raise DataError(
            f"{path} is damaged ({error}). Delete the folder {folder} to begin anew."
        ) from error
    return WorkbenchState(**texts, **numbers, also=also, revision=revision, steps=steps)


def steps_of(folder: Path, effects: Sequence[str]) -> tuple[Step, ...]:
    """The steps that added these effects."""
    steps = read_session(folder / STEPS).steps if effects else ()
    if tuple(step.effect for step in steps[: len(effects)]) != tuple(effects):
        raise DataError(f"{folder / STEPS} was changed from outside. Reload the page.")
    return steps[: len(effects)]


def own_of(folder: Path) -> tuple[Effect, ...]:
    """The user's own effects."""
    return own_effects(folder / OWN) if (folder / OWN).is_file() else ()


def save_own(folder: Path, effects: Sequence[Effect]) -> None:
    """Write own effects to be read by `own_of`, and by the commands."""
    write_text(folder / OWN, own_effects_text(effects))


def stamp_of(campaign: Path) -> tuple[int, int]:
    """When a campaign file was changed, and its size; zeros where there is none."""
    try:
        found = (campaign / CAMPAIGN.file if campaign.is_dir() else campaign).stat()
    except OSError:
        return (0, 0)
    return found.st_mtime_ns, found.st_size


def model_file(folder: Path, effects: tuple[str, ...], of: int | None = None) -> Path:
    """The model after some steps; of several campaigns also as each of them has it."""
    return folder / f"model_{len(effects)}{'' if of is None else f'_of_{of}'}.toml"


def of_campaign(name: str, of: int) -> str:
    """The name of a result that is of one campaign: of the first it has no number."""
    return f"{name}-{of}" if of else name


def save_result(folder: Path, name: str, effects: tuple[str, ...], content: Any) -> None:
    """Keep a result for as long as the same effects are added."""
    write_text(
        folder / f"{name}_{len(effects)}.json",
        readable({"schema": SCHEMA, "effects": effects, "content": content}),
    )


def find_result(folder: Path, name: str, effects: tuple[str, ...]) -> Any:
    """A result that was kept; None where there is none for these effects."""
    try:
        kept = json.loads((folder / f"{name}_{len(effects)}.json").read_text("utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(kept, dict) or kept.get("effects") != list(effects):
        return None
    return kept.get("content")
