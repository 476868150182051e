"""What is said to somebody who mistyped a command."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from typing import Any

from pmmkit.actions import say
from pmmkit.cli.output import emit
from pmmkit.presentation import printable


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
