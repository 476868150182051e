"""Functions of effects in the form that compiled equations call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

from pmmkit.effects import primitives
from pmmkit.effects.primitives import rebound


def _compiled(function: Any) -> Any:
    return numba.njit(function, nogil=True, error_model="numpy", forceinline=True)


def use(function: Callable[..., Any]) -> Any:
    """A compiled copy of an effect's function and of all that it calls."""
    own = {
        name: _compiled(getattr(primitives, name))
        for name in ("where", "maximum", "minimum", "interpolate")
    }
    return rebound(function, own, _compiled)
