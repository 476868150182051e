"""What a command says: text for people, one JSON object for programs."""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from difflib import get_close_matches
from itertools import accumulate
from typing import Any, Final

from pmmkit.actions import Outcome, say, words_of
from pmmkit.base import DataError
from pmmkit.presentation import printable

LINES: Final = 40
"""Rows of an error on a screen."""
COLUMNS: Final = 100
"""Characters of such a row."""
WIDEST: Final = 400
"""Characters of each problem where all together have more rows."""


def tell(outcome: Outcome, *, as_json: bool, quiet: bool = False) -> None:
    """The outcome on standard output: words unless `quiet`, or JSON, words on standard error."""
    for line in () if quiet else outcome.lines:
        print(printable(line, lines=True), file=sys.stderr if as_json else sys.stdout)
    if as_json:
        emit(outcome.content)


def emit(content: Mapping[str, Any]) -> None:
    """One JSON object on standard output."""
    from pmmkit.files import readable

    print(readable(content))


def tell_error(error: Exception, *, as_json: bool) -> None:
    """An error in words on standard error, and as JSON on standard output if asked for."""
    text = printable(words_of(error), lines=True) or type(error).__name__
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


def _rows(text: str) -> int:
    return sum(max(1, math.ceil(len(line) / COLUMNS)) for line in text.split("\n"))


def _on_a_screen(error: Exception, text: str) -> str:
    """The beginning of a long text, and the name of a file that holds all of it."""
    brief = error.said("command", WIDEST // 2) if isinstance(error, DataError) else text
    lines = [
        line if len(line) <= WIDEST else f"{line[: WIDEST - 1]}…"
        for line in printable(brief, lines=True).split("\n")
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


# What is said to somebody who mistyped a command.


def tell_usage(error: Any, given: Sequence[str], *, as_json: bool) -> None:
    """An error of usage in words on standard error, with an example; as JSON if asked for."""
    # typer puts the kind of its own error before a refused choice
    told = error.format_message().replace(": Value error, ", ": ")
    message = " ".join([printable(told, lines=True), *_hints(error, given)])
    if as_json:
        emit({"error": {"type": "usage", "message": message, "problems": []}})
    say(f"pmmkit: {message}")
    context = error.ctx
    if context is not None:
        for line in (context.get_usage(), context.command.epilog):
            if line:
                say(line)
        say(f"All options: {context.command_path} --help")


def _hints(error: Any, given: Sequence[str]) -> Iterator[str]:
    missing = type(error).__name__ == "MissingParameter"
    if missing and (told := getattr(error.param, "help", None)):
        yield told
    for word in _stray(given):
        yield f"For the manoeuvre write: pmmkit simulate MODEL --manoeuvre {word}."


def _stray(given: Sequence[str]) -> Iterator[str]:
    """Manoeuvres that stand where a command or an argument is expected."""
    from pmmkit.simulation import MANOEUVRES

    for ahead, word in zip(("", *given), given, strict=False):
        if not ahead.startswith("-") and not word.startswith("-"):
            plain = word.lower().replace("-", "_")
            yield from get_close_matches(plain, MANOEUVRES, n=1, cutoff=0.6)
