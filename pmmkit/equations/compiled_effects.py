"""Functions of effects in the form that compiled equations call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numba

from pmmkit.effects import PRIMITIVES, rebound

_WITHIN: Final[dict[str, Any]] = {
    "nogil": True,
    "error_model": "numpy",
    "forceinline": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}


def inner(function: Any) -> Any:
    """A function that only compiled ones call; what Python would need to call it is left out."""
    return numba.njit(function, **_WITHIN)


def use(function: Callable[..., Any], **others: Any) -> Any:
    """A compiled copy of an effect's function and of all that it calls."""
    own = {name: inner(PRIMITIVES[name]) for name in ("where", "maximum", "minimum", "interpolate")}
    return rebound(function, own | others, inner)
