"""What the sections of a draft are written with: values as TOML, comments, open questions."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, Final

from pmmkit.escaping import toml_comment, toml_string

_LISTED: Final = 6


class Todo:
    """What is open, the same question about many runs asked once."""

    def __init__(self) -> None:
        self._single: list[str] = []
        self._runs: dict[str, list[str]] = {}

    def add(self, text: str) -> None:
        """A question about the whole campaign."""
        if text not in self._single:
            self._single.append(text)

    def of_run(self, text: str, run_id: str) -> None:
        """A question about a run."""
        self._runs.setdefault(text, []).append(run_id)

    @property
    def open_runs(self) -> set[str]:
        """Runs and tables about which something is asked."""
        return {run_id for ids in self._runs.values() for run_id in ids}

    def all(self) -> list[str]:
        """Everything that is open."""
        asked = list(self._single)
        for text, ids in self._runs.items():
            more = f" and {len(ids) - _LISTED} more" if len(ids) > _LISTED else ""
            asked.append(f"{text}: {', '.join(ids[:_LISTED])}{more}.")
        return asked


def aligned(left: str, note: str) -> str:
    """A line with its comment, the comments of a section below each other."""
    return f"{left:<32} # {toml_comment(note)}" if note else left


def commented(text: str) -> list[str]:
    """A longer text as lines of comment."""
    return textwrap.wrap(toml_comment(text), 98, initial_indent="# ", subsequent_indent="# ")


def toml(value: Any) -> str:
    r"""A value as TOML.

    Examples
    --------
    >>> print(toml({"name": 'Fx "total"', "column": 2, "scale": -1.0, "header": False}))
    { name = "Fx \"total\"", column = 2, scale = -1.0, header = false }
    """
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(float(value)) if isinstance(value, float) else repr(int(value))
