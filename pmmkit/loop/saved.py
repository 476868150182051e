"""Files of steps, as `Session.save` writes them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pmmkit.effects.catalogue import is_fault
from pmmkit.errors import ModelError
from pmmkit.files import write_text
from pmmkit.models.records import FileReader, entries
from pmmkit.models.step import Step
from pmmkit.models.store import read_steps
from pmmkit.toml_files import read_toml, toml_text


@dataclass(frozen=True, kw_only=True)
class SavedSession:
    """What a file of steps holds.

    Parameters
    ----------
    floor : float
        What is too small to matter, over the rms force of a channel.
    steps : tuple of Step
        Effects and faults in the order in which they were added.
    campaign : str
        Title of the tests.
    """

    floor: float
    steps: tuple[Step, ...]
    campaign: str = ""

    def save(self, path: str | Path) -> None:
        """Write it as TOML, all or nothing."""
        data: dict[str, Any] = {
            "session": {"campaign": self.campaign, "floor": self.floor},
            "steps": [entries(step) for step in self.steps],
        }
        write_text(Path(path), toml_text(data))


def read_session(path: str | Path) -> SavedSession:
    """The steps of a file, checked.

    Parameters
    ----------
    path : str or path
        Of this release or of the first, whose ``[session]`` has the lists ``effects`` and ``why``.

    Raises
    ------
    ModelError
        If the file is damaged or of another kind.
    """
    data = read_toml(Path(path))
    head = data.get("session")
    floor = head.get("floor") if isinstance(head, dict) else None
    if not isinstance(head, dict) or not isinstance(floor, float):
        raise ModelError(f"{path} is no session: [session] needs the number floor.")
    reader = FileReader(str(path))
    steps = _first_release(head, str(path)) if "effects" in head else read_steps(reader, data)
    for number, step in enumerate(steps, start=1):
        if step.action not in ("effect_added", "fault_corrected") or not step.effect:
            reader.fault(f"steps.{number} adds no effect: a session has no other steps.")
    if reader.problems:
        raise ModelError(reader.problems, title="This is no session")
    title = head.get("campaign")
    return SavedSession(floor=floor, steps=steps, campaign=title if isinstance(title, str) else "")


def _first_release(head: dict[str, Any], path: str) -> tuple[Step, ...]:
    """Steps from a list of effects and one of remarks."""
    lists = [head.get(name) for name in ("effects", "why")]
    texts = [x for x in lists if isinstance(x, list) and all(isinstance(t, str) for t in x)]
    if len(texts) != 2 or len(texts[0]) != len(texts[1]):
        raise ModelError(
            f"{path} is no session: its lists effects and why must be texts of equal number."
        )
    return tuple(
        Step(
            action="fault_corrected" if is_fault(effect) else "effect_added",
            effect=effect,
            note=why,
        )
        for effect, why in zip(*texts, strict=True)
    )
