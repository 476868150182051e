"""Answers as plain values that a small file holds: rounded, and long ones thinned."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

DIGITS = 12
"""Significant digits that are kept."""
LONG = 40
"""Lists of more entries than this are kept at `THINNED` of them, evenly, and by their sums."""
THINNED = 12
MASKED = {"seconds": "SECONDS", "fingerprint": "FINGERPRINT"}
"""Keys of what no two machines agree about."""
WHOLE = 400
"""Lines up to which a text is kept and not only its digest."""


def plain(value: Any) -> Any:
    """A value as JSON holds it.

    Parameters
    ----------
    value : object
        Mappings, sequences, arrays, numbers, texts; others by their text.

    Returns
    -------
    object
        Numbers rounded to `DIGITS`, long lists thinned, long lists of records as columns; how long
        something took is not kept, nor a digest of numbers to their last digit.

    Examples
    --------
    >>> plain({"Yv": (-0.1 - 0.2, float("nan")), 3: "told"})
    {'Yv': [-0.3, 'nan'], '3': 'told'}
    """
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {
            str(key): MASKED[key] if key in MASKED else plain(item) for key, item in value.items()
        }
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (frozenset, set)):
        return plain(sorted(value, key=str))
    if isinstance(value, Sequence):
        items = list(value)
        if len(items) <= LONG or all(isinstance(item, str) for item in items):
            return [plain(item) for item in items]
        return _records(items) if all(isinstance(x, Mapping) for x in items) else column(items)
    return str(value)


def column(items: Sequence[Any]) -> Any:
    """A column of a table: whole where it is short, else some of it and sums of all of it."""
    if len(items) <= LONG:
        return [plain(item) for item in items]
    at = [round(k * (len(items) - 1) / (THINNED - 1)) for k in range(THINNED)]
    found: dict[str, Any] = {"entries": len(items), "some": [plain(items[k]) for k in at]}
    if any(isinstance(item, str) for item in items):
        told = (item if isinstance(item, str) else "" for item in items)
        found["sha256"] = _sha256("\n".join(told))
    numbers = [x for x in _flat(items) if isinstance(x, (int, float)) and math.isfinite(x)]
    if not numbers:
        return found
    # What is above zero and what is below apart: such sums cancel nothing, and see a sign.
    sums = (math.fsum(max(x, 0.0) for x in numbers), math.fsum(min(x, 0.0) for x in numbers))
    return found | {"numbers": len(numbers), "sums": plain(sums)}


def text(told: str) -> Any:
    """A text by line; one that is long by its digest, as `digest` has it."""
    return told.splitlines() if told.count("\n") < WHOLE else digest(told)


def digest(told: str) -> dict[str, Any]:
    """A text by the number of its lines and its SHA-256."""
    return {"lines": len(told.splitlines()), "sha256": _sha256(told)}


def _records(items: Sequence[Mapping[Any, Any]]) -> dict[str, Any]:
    """Records of the same keys, column by column."""
    keys = dict.fromkeys(key for item in items for key in item)
    return {
        "records": len(items),
        "columns": {str(key): column([item.get(key) for item in items]) for key in keys},
    }


def _flat(items: Any) -> Iterator[Any]:
    """All entries of nested lists."""
    for item in items:
        if isinstance(item, Mapping):
            yield from _flat(item.values())
        elif isinstance(item, Sequence) and not isinstance(item, str):
            yield from _flat(item)
        else:
            yield item


def _sha256(told: str) -> str:
    return hashlib.sha256(told.encode()).hexdigest()[:24]
