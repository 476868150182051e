"""What a job gives: content for programs, lines for people, and how it ends."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError

if TYPE_CHECKING:
    from pmmkit.intake import CheckFinding
    from pmmkit.models import Model

DONE: Final = 0
WRONG: Final = 1
"""Status of a job whose data, or whose request, is wrong."""
NOT_USABLE: Final = 3
"""Status of a job that did what was asked, with a result that is not usable."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a job did.

    Parameters
    ----------
    content : mapping
        For programs.
    lines : sequence of str
        For people.
    status : int
        Of its end: 0 done, 1 the data are wrong, 3 done but not usable.
    """

    content: Mapping[str, Any]
    lines: Sequence[str]
    status: int = DONE

    def then(self, *lines: str) -> Outcome:
        """The same with lines below."""
        return replace(self, lines=[*self.lines, *lines])


def written(
    folder: Path,
    results: Iterable[tuple[str, Any]],
    content: Mapping[str, Any],
    lines: Sequence[str],
) -> Outcome:
    """The outcome of a job that writes its results to a folder: all of them, or nothing."""
    from pmmkit.files import write_results

    files = write_results(folder, results)
    return Outcome(
        content={"out": str(folder), "files": files, **content},
        lines=[*lines, f"Results: {folder}"],
    )


def marked(outcome: Outcome, model: Model | str) -> Outcome:
    """What a job did with a model, or what was typed for one; where that was made by force, this
    stands above it. A structure has no force."""
    if isinstance(model, str):
        from pmmkit.conventions import STRUCTURES
        from pmmkit.models import load_model

        if model in STRUCTURES:
            return outcome
        model = load_model(model)
    why = model.not_usable
    if not why:
        return outcome
    content = {"not_usable": why, **outcome.content}
    return replace(outcome, content=content, lines=[why, "", *outcome.lines], status=NOT_USABLE)


def say(text: str = "") -> None:
    """Print a line, `text`, for the person at the keyboard while a job runs, on standard error."""
    print(text, file=sys.stderr)


def words_of(error: Exception) -> str:
    """What an `error` says to who types commands."""
    return error.said("command") if isinstance(error, DataError) else str(error)


def warned(findings: Iterable[CheckFinding]) -> list[str]:
    """What the checks said, each once."""
    return list(dict.fromkeys(f"{item.severity}: {item.message}" for item in findings))
