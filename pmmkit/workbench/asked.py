"""What a request must hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from pmmkit.errors import DataError

if TYPE_CHECKING:
    from starlette.requests import Request

LONGEST: Final = 2000
"""Characters of a text in a request."""
MANY: Final = 20
"""Texts in a list of a request."""


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


def given_texts(asked: Mapping[str, Any], name: str) -> tuple[str, ...]:
    """Texts, none if nothing is given.

    Raises
    ------
    DataError
        If it is no list of texts, or one of more than `MANY`.
    """
    value = asked.get(name) or []
    if not isinstance(value, list) or len(value) > MANY:
        raise DataError(f"{name} must be a list of at most {MANY} texts.")
    return tuple(given_text({name: item}, name) for item in value)


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


def place_in(asked: Mapping[str, Any]) -> int:
    """The place of the campaign that is meant, the first if none is named.

    Raises
    ------
    DataError
        If it is no whole number from zero up.
    """
    value = asked.get("of", 0)
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise DataError("of must be a whole number.")
    return value


def text_of(request: Request, name: str) -> str:
    """A text of the address that is not empty."""
    return given_text(dict(request.query_params), name)


def count_of(request: Request, name: str = "count") -> int | None:
    """A whole number of the address; None where there is none.

    Raises
    ------
    DataError
        If it is none.
    """
    given = request.query_params.get(name)
    if given is None:
        return None
    if not given.isascii() or not given.isdigit() or len(given) > 6:
        raise DataError(f"{name} must be a whole number.")
    return int(given)


def place_of(request: Request) -> int:
    """The place of the campaign that an address means, the first if none is named."""
    return count_of(request, "of") or 0


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
