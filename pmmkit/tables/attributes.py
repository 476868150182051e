"""What every file of a derivative table holds besides its rows, as plain data."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array

KIND: Final = "pmmkit derivative table"
SCHEMA: Final = 1
NESTED: Final = ("convention", "ship", "water", "notes", "provenance")
"""Attributes that hold more than a text or a number."""


def plain(value: Any) -> Any:
    """A value as JSON can hold it; what JSON does not know becomes text."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else repr(value)
    if value is None or isinstance(value, bool | int | str):
        return value
    return str(value)


def digest(words: Mapping[str, Any], arrays: Sequence[Array], counts: NDArray[np.int64]) -> str:
    """SHA-256 over words, arrays and counts; the same on every machine."""
    text = json.dumps(words, sort_keys=True, separators=(",", ":"))
    total = hashlib.sha256(text.encode())
    for array in arrays:
        tidy = np.where(np.isnan(array), np.nan, array + 0.0)
        total.update(np.ascontiguousarray(tidy, dtype="<f8").tobytes())
    total.update(np.ascontiguousarray(counts, dtype="<i8").tobytes())
    return total.hexdigest()


def flat(attributes: Mapping[str, Any]) -> dict[str, str | int]:
    """Attributes for files that know only texts and numbers: nested entries as JSON."""
    return {key: json.dumps(value) if key in NESTED else value for key, value in attributes.items()}
