"""What a command says: text for people, one JSON object for programs."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.errors import DataError
from pmmkit.escaping import lines_of

if TYPE_CHECKING:
    from pmmkit.checks import CheckFinding


LINES: Final = 40
"""Lines of an error on a screen."""
WIDEST: Final = 400
"""Characters of such a line."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a command did: as JSON for programs, in lines for people, as the status of its end."""

    content: Mapping[str, Any]
    lines: Sequence[str]
    status: int = 0


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
    from pmmkit.json_text import readable

    print(readable(content))


def tell_error(error: Exception, *, as_json: bool) -> None:
    """An error in words on standard error, and as JSON on standard output if asked for.

    Parameters
    ----------
    error : Exception
        What went wrong.
    as_json : bool
        Whether the command was asked for JSON.
    """
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
    say(f"pmmkit: {_on_a_screen(text)}")


def words_of(error: Exception) -> str:
    """What an error says to who types commands."""
    return error.said("command") if isinstance(error, DataError) else str(error)


def _on_a_screen(text: str) -> str:
    """The beginning of a long text, and the name of a file that holds all of it."""
    lines = text.split("\n")
    shown = [line if len(line) <= WIDEST else f"{line[: WIDEST - 1]}…" for line in lines]
    if shown == lines and len(lines) <= LINES:
        return text
    try:
        handle, name = tempfile.mkstemp(prefix="pmmkit-", suffix=".txt", text=True)
        with open(handle, "w", encoding="utf-8", errors="replace") as file:
            file.write(f"{text}\n")
    except OSError as error:
        name = f"nowhere ({error.strerror})"
    return "\n".join([*shown[: LINES - 1], f"  … all {len(lines)} lines: {name}"])


def warned(findings: Iterable[CheckFinding]) -> list[str]:
    """What the checks said, each once."""
    return list(dict.fromkeys(f"{item.severity}: {item.message}" for item in findings))


def quoted(path: Path) -> str:
    """A path as it is typed."""
    text = str(path)
    return f'"{text}"' if " " in text else text
