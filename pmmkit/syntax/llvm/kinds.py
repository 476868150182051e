"""Kinds of values that functions handle as LLVM has them, and values by their names there."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Final, Protocol

from pmmkit.syntax.c.kinds import identifier
from pmmkit.syntax.tree import Call, Expression, Unwritable


@dataclass(frozen=True)
class Kind:
    """A kind of value.

    `llvm`: its type. `size`: of a table, how many numbers it holds. `inner`: of what stands in a
    list, or of what a function returns together.
    """

    llvm: str
    size: int | None = None
    inner: tuple[Kind, ...] = ()

    @property
    def is_number(self) -> bool:
        """Whether one number is meant."""
        return self in (BOOL, INT, DOUBLE)


BOOL: Final = Kind("i1")
INT: Final = Kind("i64")
DOUBLE: Final = Kind("double")
NOTHING: Final = Kind("void")
LIST: Final = Kind("ptr", inner=(DOUBLE,))


@dataclass(frozen=True)
class Value:
    """A value by its name in LLVM, with its number where it is known and whole."""

    text: str
    kind: Kind
    known: int | None = None


_WIDTHS: Final = (BOOL, INT, DOUBLE)


def joined(first: Kind, second: Kind) -> Kind:
    """The kind that holds two.

    Examples
    --------
    >>> joined(INT, DOUBLE).llvm
    'double'
    """
    if first == second:
        return first
    if first.is_number and second.is_number:
        return max(first, second, key=_WIDTHS.index)
    if len(first.inner) == len(second.inner) > 1:
        return together(map(joined, first.inner, second.inner))
    if first.inner == second.inner and first.llvm == second.llvm == "ptr":
        return Kind("ptr", inner=first.inner)
    raise Unwritable("a name that stands for different kinds of values")


def together(kinds: Iterable[Kind]) -> Kind:
    """The kind of values that a function returns together."""
    inner = tuple(kinds)
    return Kind(f"{{{', '.join(kind.llvm for kind in inner)}}}", inner=inner)


def constant(value: float) -> Value:
    """A number; a fraction is written as its bits.

    Examples
    --------
    >>> constant(2).text, constant(0.5).text
    ('2', '0x3fe0000000000000')
    """
    if isinstance(value, bool):
        return Value("true" if value else "false", BOOL, int(value))
    if isinstance(value, int) and abs(value) < 2**63:
        return Value(str(int(value)), INT, int(value))
    return Value(f"0x{struct.unpack('>Q', struct.pack('>d', value))[0]:016x}", DOUBLE)


def variable(word: str) -> str:
    """The name in LLVM of a variable's place.

    Examples
    --------
    >>> variable("speed"), variable("δ")
    ('%speed.at', '%u3b4_.at')
    """
    return f"%{identifier(word)}.at"


class LlvmLibrary(Protocol):
    """What the text of a function asks of the program that it becomes a part of."""

    def function(
        self, function: FunctionType, kinds: tuple[Kind, ...], alias: str
    ) -> tuple[str, Kind]:
        """Name and kind of what is returned, of a function for arguments of some kinds."""

    def arguments(self, function: FunctionType, alias: str, tree: Call) -> tuple[Expression, ...]:
        """What a call gives each argument of a function."""

    def table(self, value: Sequence[Any]) -> Value:
        """Numbers that stand in a module."""

    def declared(self, result: str, name: str, rest: str) -> None:
        """Note a function of LLVM or of the C library."""

    def long_loop(self) -> str:
        """Mark of a loop over many places."""
