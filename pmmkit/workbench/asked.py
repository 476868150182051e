"""What a request must hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from pmmkit.errors import DataError

LONGEST: Final = 2000
"""Characters of a text in a request."""


def given_text(asked: Mapping[str, Any], name: str) -> str:
    """A text that is not empty.

    Raises
    ------
    DataError
        If it is none, or longer than `LONGEST`.
    """
    value = asked.get(name)
    if not isinstance(value, str) or not value or len(value) > LONGEST or "\0" in value:
        raise DataError(f"{name} must be a text.")
    return value


def revision_of(asked: Mapping[str, Any]) -> int:
    """The state that the page has seen.

    Raises
    ------
    DataError
        If it is no whole number.
    """
    value = asked.get("revision")
    if not isinstance(value, int) or isinstance(value, bool):
        raise DataError("revision must be a whole number.")
    return value


def given_number(asked: Mapping[str, Any], name: str) -> float:
    """A finite number.

    Raises
    ------
    DataError
        If it is none.
    """
    value = asked.get(name)
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise DataError(f"{name} must be a number.")
    return float(value)
