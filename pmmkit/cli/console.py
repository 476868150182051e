"""What a command says: text for people, one JSON object for programs."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pmmkit.errors import DataError


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a command did: as JSON for programs, in lines for people."""

    content: Mapping[str, Any]
    lines: Sequence[str]


def say(text: str = "") -> None:
    """A line for the person at the keyboard, on standard error."""
    print(text, file=sys.stderr)


def plain(value: Any) -> Any:
    """A value as JSON can hold it: no NaN, no infinity, no arrays.

    Examples
    --------
    >>> plain({"a": float("nan"), "b": (1, 2.5)})
    {'a': None, 'b': [1, 2.5]}
    """
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


def emit(content: Mapping[str, Any]) -> None:
    """One JSON object on standard output."""
    print(json_text(content))


def json_text(content: Any) -> str:
    """Content as JSON text, the same on every machine."""
    return json.dumps(plain(content), indent=2, allow_nan=False)


def tell_error(error: Exception, *, as_json: bool) -> None:
    """An error in words on standard error, and as JSON on standard output if asked for.

    Parameters
    ----------
    error : Exception
        What went wrong.
    as_json : bool
        Whether the command was asked for JSON.
    """
    text = str(error)
    if as_json:
        problems = error.problems if isinstance(error, DataError) else ()
        emit(
            {
                "error": {
                    "type": type(error).__name__,
                    "message": text or type(error).__name__,
                    "problems": [asdict(problem) for problem in problems],
                }
            }
        )
    say(f"pmmkit: {text or type(error).__name__}")
