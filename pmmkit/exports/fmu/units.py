"""Units as powers of the base units."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from types import MappingProxyType
from typing import Final

_BASE: Final = MappingProxyType(
    {
        "1": ({}, 1.0),
        "m": ({"m": 1}, 1.0),
        "kg": ({"kg": 1}, 1.0),
        "s": ({"s": 1}, 1.0),
        "rad": ({"rad": 1}, 1.0),
        "deg": ({"rad": 1}, math.pi / 180),
        "min": ({"s": 1}, 60.0),
        "kn": ({"m": 1, "s": -1}, 1852 / 3600),
        "N": ({"kg": 1, "m": 1, "s": -2}, 1.0),
        "W": ({"kg": 1, "m": 2, "s": -3}, 1.0),
    }
)
_FACTOR: Final = re.compile(r"([a-zA-Z]+|1)(\d*)")
SHOWN: Final = MappingProxyType(
    {"rad": ("deg",), "rad/s": ("deg/s",), "m/s": ("kn",), "1/s": ("1/min",)}
)
"""Other units in which programs may show values of a unit; the first is proposed for angles."""


def modelica(unit: str) -> str:
    """A unit as Modelica and FMI write it.

    Examples
    --------
    >>> modelica("N m"), modelica("kg m2"), modelica("m/s")
    ('N.m', 'kg.m2', 'm/s')
    """
    return unit.replace(" ", ".")


def elements(unit: str) -> tuple[dict[str, int], float]:
    """Powers of kg, m, s and rad in a unit, and the factor that leads to them.

    Examples
    --------
    >>> elements("N m/min")
    ({'kg': 1, 'm': 2, 's': -3}, 0.01666...)
    """
    powers: dict[str, int] = {}
    factor = 1.0
    for side, part in zip((1, -1), unit.split("/"), strict=False):
        for name, power in _FACTOR.findall(part):
            own, size = _BASE[name]
            times = side * int(power or 1)
            factor *= size**times
            for base, exponent in own.items():
                powers[base] = powers.get(base, 0) + times * exponent
    return {base: power for base, power in powers.items() if power}, factor


def used(units: Iterable[str]) -> list[str]:
    """The units that must be defined, each once, in an order that depends on nothing else."""
    return sorted(set(units) - {"", "-"})
