"""What a campaign file can state of the propeller and the rudder."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import did_you_mean
from pmmkit.effects import PROPELLER, RUDDER_MMG, Effect, Parameter

SECTIONS: Final[Mapping[str, Effect]] = MappingProxyType(
    {PROPELLER.name: PROPELLER, "rudder": RUDDER_MMG}
)
"""Sections of a campaign file, with the effect whose values they state."""
GEOMETRY: Final[Mapping[str, tuple[Parameter, ...]]] = MappingProxyType(
    {
        PROPELLER.name: (
            Parameter(
                name="P_over_D", text="pitch over diameter, for the Wageningen B series", low=1e-6
            ),
            Parameter(
                name="area_ratio", text="expanded blade area over disc area, for the same", low=1e-6
            ),
            Parameter(name="blades", text="number of blades, for the same", default=4.0, low=1.0),
            Parameter(
                name="KT_factor", text="factor of the column KT of `open_water`", default=1.0
            ),
            Parameter(
                name="KQ_factor", text="factor of the column KQ of `open_water`", default=1.0
            ),
        ),
        "rudder": (
            Parameter(name="area_movable", text="area of the part that turns", unit="m2", low=1e-9),
            Parameter(
                name="area_lateral",
                text="area with the horn, seen from the side",
                unit="m2",
                low=1e-9,
            ),
            Parameter(
                name="area_total", text="another word for `area_lateral`", unit="m2", low=1e-9
            ),
            Parameter(name="area_wetted", text="wetted area", unit="m2", low=1e-9),
            Parameter(name="height", text="height, for the lift slope", unit="m", low=1e-6),
            Parameter(
                name="full_length",
                text="length of the ship, for the rate of its steering gear",
                unit="m",
                low=1e-6,
            ),
        ),
    }
)
"""What is known of a propeller or rudder besides the values of the effect: estimates take it."""
WORDS: Final[Mapping[str, Mapping[str, tuple[str, ...]]]] = MappingProxyType(
    {PROPELLER.name: {"propulsion_point": ("model", "ship")}, "rudder": {}}
)
"""Keys that take a word."""
WANTED: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {PROPELLER.name: ("D", "t", "wp"), "rudder": ("area", "rate_deg_s")}
)
"""What a turn depends on most."""
OPEN_WATER: Final = "open_water"
"""The tested curves: a table of the lists J, KT and KQ, or the name of a CSV file."""


def numbers_of(section: str) -> dict[str, Parameter]:
    """The numbers that a section can state, by key.

    Examples
    --------
    >>> numbers_of("rudder")["area"].unit
    'm2'
    """
    return {item.name: item for item in (*SECTIONS[section].parameters, *GEOMETRY[section])}


def words_of(section: str) -> dict[str, tuple[str, ...]]:
    """The keys of a section that take a word, with the words."""
    return {**SECTIONS[section].options, **WORDS[section]}


def problems_of(section: str, stated: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What is wrong with what a section states: keys, and what to say of them.

    The key is empty where the section holds nothing.

    Examples
    --------
    >>> list(problems_of("propeller", {"D": -0.2, "diametr": 0.2}))[0]
    ('D', 'must be at least 1e-06 m, it is -0.2.')
    """
    numbers, words = numbers_of(section), words_of(section)
    if not stated:
        wanted = [item for item in SECTIONS[section].parameters if item.name in WANTED[section]]
        told = ", ".join(f"{item.name} ({item.text}) [{item.unit}]" for item in wanted)
        yield "", f"states nothing. Write what is known, such as {told}, or take the section away."
    for key, value in stated.items():
        if key == OPEN_WATER and section == PROPELLER.name:
            fault = _fault_of_curve(value)
        elif key in words:
            right = value in words[key]
            fault = "" if right else f"must be {' or '.join(words[key])}, it is {value!r}."
        elif key in numbers:
            fault = _fault(numbers[key], value)
        else:
            fault = f"is not known{did_you_mean(key, [*numbers, *words]) or '.'}"
        if fault:
            yield key, fault


def _fault_of_curve(value: Any) -> str:
    if isinstance(value, str):
        return ""
    if not isinstance(value, Mapping):
        return f"must be a table or the name of a file, it is {value!r}."
    lists = Parameter(name=OPEN_WATER, text="", table=True)
    return next((fault for one in value.values() if (fault := _fault(lists, one))), "")


def _fault(item: Parameter, value: Any) -> str:
    unit = "" if item.unit == "-" else f" {item.unit}"
    values = value if item.table and isinstance(value, list) else [value]
    for one in values:
        if isinstance(one, bool) or not isinstance(one, int | float) or not math.isfinite(one):
            return f"must be {'a list of numbers' if item.table else 'a number'}, it is {one!r}."
        if not item.low <= one <= item.high:
            side, limit = ("least", item.low) if one < item.low else ("most", item.high)
            return f"must be at {side} {limit:g}{unit}, it is {one:g}."
    return ""
