"""Where two answers differ."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Any

DUST = 1e-2
"""A number of a list may differ by the tolerance times this share of the largest beside it: sums
that cancel leave digits that mean nothing."""
NOTHING = 1e-13
"""Smaller numbers are zero: what one processor rounds to it another does not."""
ROUNDING = 1e-14
"""The same beside numbers under other keys, over the largest of them."""


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


def differences(old: Any, new: Any, tolerance: float, place: str = "") -> Iterator[Difference]:
    """Where two plain answers differ.

    Parameters
    ----------
    old, new : plain values
        As `values.plain` gives them.
    tolerance : float
        Relative, of numbers.
    place : str
        Keys that lead here.
    """
    yield from _differences(old, new, tolerance, 0.0, place)


def _differences(
    old: Any, new: Any, tolerance: float, floor: float, place: str
) -> Iterator[Difference]:
    """`floor` is the least difference that counts."""
    if isinstance(old, dict) and isinstance(new, dict):
        least = ROUNDING * max(_largest(old.values()), _largest(new.values()))
        for key in dict.fromkeys([*old, *new]):
            here = f"{place}.{key}" if place else str(key)
            if key not in new:
                yield Difference(here, old[key], "nothing")
            elif key not in old:
                yield Difference(here, "nothing", new[key])
            else:
                yield from _differences(old[key], new[key], tolerance, least, here)
    elif _is_text(old) and _is_text(new):
        for way, a, b, c, d in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
            if way != "equal":
                yield Difference(f"{place}[{a}]", " / ".join(old[a:b]), " / ".join(new[c:d]))
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield Difference(f"{place} (entries)", len(old), len(new))
        share = max(tolerance * DUST, ROUNDING)
        least = share * max(_largest(old), _largest(new))
        for number, (one, other) in enumerate(zip(old, new, strict=False)):
            yield from _differences(one, other, tolerance, least, f"{place}[{number}]")
    elif _is_number(old) and _is_number(new):
        larger = max(abs(old), abs(new))
        if abs(old - new) > max(tolerance * larger, floor, NOTHING):
            yield Difference(place, old, new, abs(new - old) / larger)
    elif type(old) is not type(new) or old != new:
        yield Difference(place, old, new)


def _is_text(value: Any) -> bool:
    """Whether it is a text by lines."""
    return isinstance(value, list) and bool(value) and all(isinstance(x, str) for x in value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _largest(values: Any) -> float:
    return max((abs(x) for x in values if _is_number(x)), default=0.0)


def _short(value: Any) -> str:
    told = str(value)
    return told if len(told) <= 120 else f"{told[:117]}..."
