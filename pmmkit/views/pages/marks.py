"""Where in a record stands what the checks speak of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from pmmkit.intake import FLAT_SAMPLES
from pmmkit.numerics import Array
from pmmkit.views.pages.numbers import short

MOST: Final = 40
"""Marks of a record."""
GAP: Final = 1.5
"""Steps of time over the usual one that are a gap."""


def marks_of(
    t: Array,
    columns: Mapping[str, Array],
    findings: Sequence[Mapping[str, Any]],
    *,
    steady: bool = True,
) -> list[dict[str, Any]]:
    """The places of a record, [s] from its first sample, of what the checks found there.

    t [s].

    Examples
    --------
    >>> t = np.array([0.0, 0.1, 0.2, 5.0, 5.1])
    >>> found = {"check": "time stamps", "severity": "warning", "message": "1 gap"}
    >>> [(mark["from"], mark["to"]) for mark in marks_of(t, {}, [found])]
    [(0.2, 5.0)]
    """
    found = []
    for item in findings:
        for channel, start, stop in _places(t, columns, item, steady):
            found.append(
                {
                    "from": short(start - t[0]),
                    "to": short(stop - t[0]),
                    "channel": channel,
                    "text": item["message"],
                    "severity": item["severity"],
                }
            )
    return found[:MOST]


def _places(
    t: Array, columns: Mapping[str, Array], item: Mapping[str, Any], steady: bool
) -> Iterator[tuple[str, float, float]]:
    if item["check"] == "time stamps":
        yield from _clock(t)
    for channel in item.get("channels", ()):
        values = columns.get(channel)
        if values is None:
            continue
        numbers = item.get("numbers", {})
        if item["check"] == "saturation":
            yield from ((channel, *span) for span in _flat(t, values, numbers["level"]))
        elif "step" in numbers and steady:
            at = _step(t, values)
            yield channel, at, at


def _clock(t: Array) -> Iterator[tuple[str, float, float]]:
    """Gaps, and places where time stands or goes back."""
    steps = np.diff(t)
    forward = steps[steps > 0]
    usual = float(np.median(forward)) if len(forward) else 0.0
    for place in np.flatnonzero((steps > GAP * usual) | (steps <= 0)):
        low, high = sorted((float(t[place]), float(t[place + 1])))
        yield "", low, high


def _flat(t: Array, values: Array, level: float) -> Iterator[tuple[float, float]]:
    """Stretches in which a channel stands at a level."""
    at = np.isclose(values, level, rtol=1e-9, atol=0.0)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], at.astype(np.int8), [0]))))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start >= FLAT_SAMPLES:
            yield float(t[start]), float(t[stop - 1])


def _step(t: Array, values: Array) -> float:
    """Where the means before and after differ most for their number: the zero jumped there."""
    count = len(values)
    before = np.cumsum(values)[:-1]
    sizes = np.arange(1, count)
    left, right = before / sizes, (values.sum() - before) / (count - sizes)
    gain = (right - left) ** 2 * sizes * (count - sizes)
    return float(t[int(np.argmax(gain)) + 1])
