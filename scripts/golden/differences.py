"""Answers as plain values, and where two of them differ."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Any

DIGITS = 12
"""Significant digits that are kept."""
LONG = 40
"""Lists of more entries than this are kept at `THINNED` of them, evenly, and by their length."""
THINNED = 12
DUST = 1e-3
"""A number may differ by the tolerance times this share of the largest number beside it: sums that
cancel leave digits that mean nothing."""


@dataclass(frozen=True)
class Difference:
    """One place at which two answers differ.

    Parameters
    ----------
    place : str
        Keys that lead there.
    old, new : object
        What stood there, and what stands there now.
    change : float
        Relative change; infinite where it is no number.
    """

    place: str
    old: Any
    new: Any
    change: float = math.inf

    def __str__(self) -> str:
        by = "" if math.isinf(self.change) else f"  ({self.change:.2g} of it)"
        return f"{self.place}: {_short(self.old)} -> {_short(self.new)}{by}"


def plain(value: Any) -> Any:
    """A value as JSON holds it: numbers rounded, long lists thinned, keys as text."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, str) or value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else str(value)
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (Sequence, frozenset, set)):
        items = sorted(value, key=str) if isinstance(value, (frozenset, set)) else list(value)
        if len(items) <= LONG or any(isinstance(item, str) for item in items):
            return [plain(item) for item in items]
        at = [round(k * (len(items) - 1) / (THINNED - 1)) for k in range(THINNED)]
        return {"entries": len(items), "at": {str(k): plain(items[k]) for k in at}}
    return str(value)


def lines_of(text: str) -> dict[str, Any]:
    """A long text by the number of its lines and a sum of each, which say what line moved."""
    lines = text.splitlines()
    return {"lines": len(lines), "sums": " ".join(f"{zlib.crc32(x.encode()):08x}" for x in lines)}


def differences(old: Any, new: Any, tolerance: float, place: str = "") -> Iterator[Difference]:
    """Where two plain answers differ.

    Parameters
    ----------
    old, new : plain values
        As `plain` gives them.
    tolerance : float
        Relative, of numbers.
    place : str
        Keys that lead here.
    """
    yield from _differences(old, new, tolerance, 0.0, place)


def _differences(
    old: Any, new: Any, tolerance: float, beside: float, place: str
) -> Iterator[Difference]:
    if isinstance(old, dict) and isinstance(new, dict):
        size = max(_largest(old.values()), _largest(new.values()))
        for key in dict.fromkeys([*old, *new]):
            here = f"{place}.{key}" if place else str(key)
            if key not in new:
                yield Difference(here, old[key], "nothing")
            elif key not in old:
                yield Difference(here, "nothing", new[key])
            else:
                yield from _differences(old[key], new[key], tolerance, size, here)
    elif _is_text(old) and _is_text(new):
        for way, a, b, c, d in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
            if way != "equal":
                yield Difference(f"{place}[{a}]", " / ".join(old[a:b]), " / ".join(new[c:d]))
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield Difference(f"{place} (entries)", len(old), len(new))
        size = max(_largest(old), _largest(new))
        for number, (one, other) in enumerate(zip(old, new, strict=False)):
            yield from _differences(one, other, tolerance, size, f"{place}[{number}]")
    elif _is_number(old) and _is_number(new):
        larger = max(abs(old), abs(new))
        if abs(old - new) > tolerance * max(larger, DUST * beside):
            yield Difference(place, old, new, abs(new - old) / larger)
    elif old != new:
        yield Difference(place, old, new)


def _is_text(value: Any) -> bool:
    """Whether it is a text by lines."""
    return isinstance(value, list) and bool(value) and all(isinstance(x, str) for x in value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _largest(values: Any) -> float:
    return max((abs(x) for x in values if _is_number(x)), default=0.0)


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 120 else f"{text[:117]}..."
