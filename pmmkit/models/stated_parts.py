"""What a campaign file can state of the propeller and the rudder."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import did_you_mean
from pmmkit.effects import CATALOGUE, Effect, Parameter

OPEN_WATER: Final = "open_water"
"""The tested curves: a table of the lists J, KT and KQ, or the name of a CSV file."""


@dataclass(frozen=True, kw_only=True)
class StatedSection:
    """What a section of a campaign file can state of a part.

    `effect_name`: the effect whose values it states. `geometry`: what is known of the part
    besides the values of the effect: estimates take it. `wanted`: what a turn depends on most.
    `more_words`: keys that take a word, besides the options of the effect. `curve`: whether it
    may hold tested curves.
    """

    name: str
    effect_name: str
    geometry: tuple[Parameter, ...]
    wanted: tuple[str, ...]
    more_words: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))
    curve: bool = False

    @property
    def effect(self) -> Effect:
        """The effect whose values it states."""
        return CATALOGUE[self.effect_name]

    @property
    def numbers(self) -> dict[str, Parameter]:
        """The numbers that it can state, by key.

        Examples
        --------
        >>> SECTIONS["rudder"].numbers["area"].unit
        'm2'
        """
        return {item.name: item for item in (*self.effect.parameters, *self.geometry)}

    @property
    def words(self) -> dict[str, tuple[str, ...]]:
        """The keys that take a word, with the words."""
        return {**self.effect.options, **self.more_words}

    def problems(self, stated: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """What is wrong with what the section states: keys, and what to say of them.

        The key is empty where the section holds nothing.

        Examples
        --------
        >>> list(SECTIONS["propeller"].problems({"D": -0.2, "diametr": 0.2}))[0]
        ('D', 'must be at least 1e-06 m, it is -0.2.')
        """
        numbers, words = self.numbers, self.words
        if not stated:
            wanted = [item for item in self.effect.parameters if item.name in self.wanted]
            told = ", ".join(f"{item.name} ({item.text}) [{item.unit}]" for item in wanted)
            yield (
                "",
                f"states nothing. Write what is known, such as {told}, or take the section away.",
            )
        for key, value in stated.items():
            if key == OPEN_WATER and self.curve:
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


_PROPELLER: Final = StatedSection(
    name="propeller",
    effect_name="propeller",
    geometry=(
        Parameter(
            name="P_over_D", text="pitch over diameter, for the Wageningen B series", low=1e-6
        ),
        Parameter(
            name="area_ratio", text="expanded blade area over disc area, for the same", low=1e-6
        ),
        Parameter(name="blades", text="number of blades, for the same", default=4.0, low=1.0),
        Parameter(name="KT_factor", text="factor of the column KT of `open_water`", default=1.0),
        Parameter(name="KQ_factor", text="factor of the column KQ of `open_water`", default=1.0),
    ),
    wanted=("D", "t", "wp"),
    more_words=MappingProxyType({"propulsion_point": ("model", "ship")}),
    curve=True,
)
_RUDDER: Final = StatedSection(
    name="rudder",
    effect_name="rudder_mmg",
    geometry=(
        Parameter(name="area_movable", text="area of the part that turns", unit="m2", low=1e-9),
        Parameter(
            name="area_lateral", text="area with the horn, seen from the side", unit="m2", low=1e-9
        ),
        Parameter(name="area_total", text="another word for `area_lateral`", unit="m2", low=1e-9),
        Parameter(name="area_wetted", text="wetted area", unit="m2", low=1e-9),
        Parameter(name="height", text="height, for the lift slope", unit="m", low=1e-6),
        Parameter(
            name="full_length",
            text="length of the ship, for the rate of its steering gear",
            unit="m",
            low=1e-6,
        ),
    ),
    wanted=("area", "rate_deg_s"),
)
SECTIONS: Final[Mapping[str, StatedSection]] = MappingProxyType(
    {section.name: section for section in (_PROPELLER, _RUDDER)}
)
"""Sections of a campaign file that state a part, by name."""


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
