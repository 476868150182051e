"""Plain values as strict JSON text.

Exactly and back (`to_json`, `from_json`): tuples, arrays, dates and NaN included; or for others to
read (`readable`).
"""

from __future__ import annotations

import datetime
import json
import math
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

import numpy as np

from pmmkit.base import CampaignError


def to_json(value: Any) -> str:
    """A `value` as JSON text in ASCII.

    What JSON does not have is written as an object with one key that starts with ``$``:
    ``$float`` (nan, inf), ``$tuple``, ``$set``, ``$array``, ``$date``, ``$time``, ``$datetime``,
    ``$items`` (mappings whose keys are not all plain text). Paths become text.

    Raises
    ------
    CampaignError
        If a value is of a type that has no place in a file.

    Examples
    --------
    >>> to_json({"factor": float("nan"), "runs": ("a", "b")})
    '{"factor":{"$float":"nan"},"runs":{"$tuple":["a","b"]}}'
    >>> from_json(to_json(("a", 1, 1.0)))
    ('a', 1, 1.0)
    """
    return json.dumps(_encode(value), allow_nan=False, separators=(",", ":"))


def plain(value: Any) -> Any:
    """A `value` as JSON can hold it: no NaN, no infinity, no arrays; there is no way back.

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


def readable(content: Any) -> str:
    """The `content` as JSON text for others, the same on every machine; NaN becomes null."""
    return json.dumps(plain(content), indent=2, allow_nan=False)


def from_json(text: str) -> Any:
    """The value that `to_json` wrote as a `text`."""
    return _decode(json.loads(text))


def _encode(value: Any) -> Any:
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else {"$float": str(float(value))}
    if isinstance(value, Mapping):
        if all(isinstance(key, str) and not key.startswith("$") for key in value):
            return {str(key): _encode(item) for key, item in value.items()}
        return {"$items": [[_encode(key), _encode(item)] for key, item in value.items()]}
    if isinstance(value, list):
        return [_encode(item) for item in value]
    return _encode_tagged(value)


def _encode_tagged(value: Any) -> Any:
    if isinstance(value, tuple):
        return {"$tuple": [_encode(item) for item in value]}
    if isinstance(value, (set, frozenset)):
        return {"$set": sorted((_encode(item) for item in value), key=json.dumps)}
    if isinstance(value, np.generic) and value.dtype.kind in "biufU":
        return _encode(value.item())
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufU":
        return {"$array": _encode(value.tolist()), "dtype": value.dtype.str}
    if isinstance(value, datetime.datetime):
        return {"$datetime": value.isoformat()}
    if isinstance(value, datetime.date):
        return {"$date": value.isoformat()}
    if isinstance(value, datetime.time):
        return {"$time": value.isoformat()}
    if isinstance(value, PurePath):
        return value.as_posix()
    raise CampaignError(
        f"{value!r} ({type(value).__name__}) cannot be kept in a file: use numbers, text, lists, "
        f"mappings or dates."
    )


def _decode(value: Any) -> Any:
    if isinstance(value, list):
        return [_decode(item) for item in value]
    if not isinstance(value, dict):
        return value
    tag = next(iter(value), "")
    if not tag.startswith("$"):
        return {key: _decode(item) for key, item in value.items()}
    content = value[tag]
    match tag:
        case "$float":
            return float(content)
        case "$tuple":
            return tuple(_decode(content))
        case "$set":
            return frozenset(_decode(content))
        case "$items":
            return {_decode(key): _decode(item) for key, item in content}
        case "$array":
            return np.array(_decode(content), dtype=value["dtype"])
        case "$datetime":
            return datetime.datetime.fromisoformat(content)
        case "$date":
            return datetime.date.fromisoformat(content)
        case "$time":
            return datetime.time.fromisoformat(content)
    raise CampaignError(f"The file holds a value marked {tag!r}, which is not known here.")
