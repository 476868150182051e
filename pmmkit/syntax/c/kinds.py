"""Kinds of values that a translated function handles, and how C writes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Final, Protocol

from pmmkit.syntax.tree import Call, Expression, Unwritable


@dataclass(frozen=True)
class ValueKind:
    """A kind of value.

    `name`: ``bool``, ``int``, ``double``, ``nothing``; ``list``: numbers that a function may
    change, by their address; ``table``: numbers that it only reads, with their count; ``grid``:
    tables of one length; ``tuple``: what a function returns together. `size`: of a tuple: how many
    numbers.
    """

    name: str
    size: int = 0

    @property
    def is_number(self) -> bool:
        """Whether one number is meant."""
        return self.name in ("bool", "int", "double")

    @property
    def text(self) -> str:
        """The type as C writes it, of numbers and of what functions return."""
        if self.name == "tuple":
            return f"struct numbers_{self.size}"
        return {"bool": "int", "nothing": "void"}.get(self.name, self.name)


BOOL: Final = ValueKind("bool")
INT: Final = ValueKind("int")
DOUBLE: Final = ValueKind("double")
LIST: Final = ValueKind("list")
TABLE: Final = ValueKind("table")
GRID: Final = ValueKind("grid")
NOTHING: Final = ValueKind("nothing")


class Library(Protocol):
    """What the text of a function asks of the program that it becomes a part of."""

    def function(
        self, function: FunctionType, kinds: tuple[ValueKind, ...], alias: str
    ) -> tuple[str, ValueKind]:
        """Name in C and kind of what is returned, of a function for arguments of some kinds."""

    def arguments(self, function: FunctionType, alias: str, tree: Call) -> tuple[Expression, ...]:
        """What a call gives each argument of a function."""

    def table(self, value: Sequence[Any], alias: str) -> str:
        """The name in C of numbers that stand in a module."""

    def tuple_of(self, size: int) -> ValueKind:
        """The kind of so many numbers that a function returns together."""


_KEYWORDS: Final = frozenset(
    (
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else"),
        *("enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register"),
        *("restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch"),
        *("typedef", "union", "unsigned", "void", "volatile", "while"),
        *("NAN", "INFINITY", "NULL", "larger", "smaller", "floored"),
    )
)
"""Words of C, and of the head of a program, that no name may be."""


def joined(first: ValueKind, second: ValueKind) -> ValueKind:
    """The kind that holds two.

    Examples
    --------
    >>> joined(INT, DOUBLE).name
    'double'
    """
    if first == second:
        return first
    if first.is_number and second.is_number:
        return DOUBLE if DOUBLE in (first, second) else INT
    raise Unwritable("a name that stands for different kinds of values")


def identifier(name: str) -> str:
    """A name of Python as one of C.

    Examples
    --------
    >>> identifier("speed"), identifier("short"), identifier("δ")
    ('speed', 'short_', 'u3b4_')
    """
    plain = "".join(x if x.isascii() else f"u{ord(x):x}_" for x in name)
    return f"{plain}_" if plain in _KEYWORDS else plain


def c_number(value: float) -> str:
    """A number as C writes it, with the fewest digits that give it again.

    Parameters
    ----------
    value : float or int

    Returns
    -------
    str

    Examples
    --------
    >>> c_number(2), c_number(0.1), c_number(1e16), c_number(float("-inf"))
    ('2', '0.1', '1e+16', '-INFINITY')
    """
    if isinstance(value, int):
        return str(int(value))
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value))
