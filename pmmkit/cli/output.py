"""What a command says: text for people, one JSON object for programs."""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import accumulate
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError
from pmmkit.presentation import lines_of

if TYPE_CHECKING:
    from pmmkit.intake import CheckFinding
    from pmmkit.models import Model

NOT_USABLE: Final = 3
"""Status of a command that did what was asked, with a result that is not usable."""

LINES: Final = 40
"""Rows of an error on a screen."""
COLUMNS: Final = 100
"""Characters of such a row."""
WIDEST: Final = 400
"""Characters of each problem where all together have more rows."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a command did: as JSON for programs, in lines for people, as the status of its end."""

    content: Mapping[str, Any]
    lines: Sequence[str]
    status: int = 0


def marked(outcome: Outcome, model: Model | str) -> Outcome:
    """What a command did with a model, or what was typed for one; where that was made by force,
    this stands above it. A structure has no force."""
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


def tell(outcome: Outcome, *, as_json: bool, quiet: bool = False) -> None:
    """The outcome on standard output: words unless `quiet`, or JSON, words on standard error."""
    for line in () if quiet else outcome.lines:
        print(line, file=sys.stderr if as_json else sys.stdout)
    if as_json:
        emit(outcome.content)


def say(text: str = "") -> None:
    """A line for the person at the keyboard, on standard error."""
    print(text, file=sys.stderr)


def emit(content: Mapping[str, Any]) -> None:
    """One JSON object on standard output."""
    from pmmkit.files import readable

    print(readable(content))


def tell_error(error: Exception, *, as_json: bool) -> None:
    """An error in words on standard error, and as JSON on standard output if asked for."""
    text = lines_of(words_of(error)) or type(error).__name__
    if as_json:
        problems = error.problems if isinstance(error, DataError) else ()
        emit(
            {
                "error": {
                    "type": type(error).__name__,
                    "message": text,
                    "problems": [
                        {**asdict(problem), "remedy": problem.advice("command")}
                        for problem in problems
                    ],
                }
            }
        )
    say(f"pmmkit: {text if _rows(text) <= LINES else _on_a_screen(error, text)}")


def words_of(error: Exception) -> str:
    """What an error says to who types commands."""
    return error.said("command") if isinstance(error, DataError) else str(error)


def _rows(text: str) -> int:
    return sum(max(1, math.ceil(len(line) / COLUMNS)) for line in text.split("\n"))


def _on_a_screen(error: Exception, text: str) -> str:
    """The beginning of a long text, and the name of a file that holds all of it."""
    brief = error.said("command", WIDEST // 2) if isinstance(error, DataError) else text
    lines = [
        line if len(line) <= WIDEST else f"{line[: WIDEST - 1]}…"
        for line in lines_of(brief).split("\n")
    ]
    try:
        handle, name = tempfile.mkstemp(prefix="pmmkit-", suffix=".txt", text=True)
        with open(handle, "w", encoding="utf-8", errors="replace") as file:
            file.write(f"{text}\n")
    except OSError as problem:
        name = f"nowhere ({problem.strerror})"
    return "\n".join([*_first_rows(lines, LINES - 1), f"  … all of it: {name}"])


def _first_rows(lines: Sequence[str], most: int) -> list[str]:
    """As many lines from the first as have so many rows."""
    rows = accumulate(_rows(line) for line in lines)
    return [line for line, reached in zip(lines, rows, strict=True) if reached <= most]


def warned(findings: Iterable[CheckFinding]) -> list[str]:
    """What the checks said, each once."""
    return list(dict.fromkeys(f"{item.severity}: {item.message}" for item in findings))
