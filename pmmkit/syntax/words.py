"""Operators and functions of syntax trees: their ranks, and what each language calls them."""

from __future__ import annotations

import builtins
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Final, Literal

from pmmkit.syntax.tree import Call, Expression, Function, Member, Name, Number, Unwritable

CHOICE, OR, AND, NOT, COMPARISON, SUM, PRODUCT, SIGN, POWER, ATOM = range(10)
"""Ranks, the weakest first. Python, C and MATLAB agree on them but for three marks: ``not`` is as
strong as a sign in C and MATLAB, comparisons stand in a chain in Python alone, and powers in a row
are taken from the left in MATLAB, from the right in Python; C has no mark for powers."""
Outside = Mapping[str, Any]
"""Names of the module around a function."""


@dataclass(frozen=True)
class Operator:
    """An operator of two operands; empty where a language has no mark of that meaning."""

    rank: int
    c: str
    matlab: str
    compute: Callable[[Any, Any], Any]


OPERATORS: Final[Mapping[str, Operator]] = {
    "+": Operator(SUM, " + ", " + ", operator.add),
    "-": Operator(SUM, " - ", " - ", operator.sub),
    "*": Operator(PRODUCT, " * ", "*", operator.mul),
    "/": Operator(PRODUCT, " / ", "/", operator.truediv),
    "//": Operator(PRODUCT, "", "", operator.floordiv),
    "%": Operator(PRODUCT, "", "", operator.mod),
    "@": Operator(PRODUCT, "", "", operator.matmul),
    "**": Operator(POWER, "", "^", operator.pow),
    "==": Operator(COMPARISON, " == ", " == ", operator.eq),
    "!=": Operator(COMPARISON, " != ", " ~= ", operator.ne),
    "<": Operator(COMPARISON, " < ", " < ", operator.lt),
    "<=": Operator(COMPARISON, " <= ", " <= ", operator.le),
    ">": Operator(COMPARISON, " > ", " > ", operator.gt),
    ">=": Operator(COMPARISON, " >= ", " >= ", operator.ge),
    "and": Operator(AND, " && ", " && ", lambda a, b: a and b),
    "or": Operator(OR, " || ", " || ", lambda a, b: a or b),
}
"""``//`` and ``%`` go by the floor in Python; the marks of C do not, and functions of MATLAB are
rounded in other ways."""


@dataclass(frozen=True)
class Word:
    """A function that trees may call by a name.

    `home`: module whose function it is. `c, matlab`: what it is called there. Without a word C
    gets the function itself, translated. `count`: of arguments; 0 for two or more, which C and
    MATLAB take two at a time. `gives`: what C gets from it.
    """

    home: str
    c: str
    matlab: str
    count: int = 1
    gives: Literal["fraction", "whole", "truth"] = "fraction"


_ALIKE: Final = "acos asin atan ceil cos cosh exp floor log sin sinh sqrt tan tanh"
_PRIMITIVES: Final = "pmmkit.effects.primitives"
FUNCTIONS: Final[Mapping[str, Word]] = {
    **{name: Word("math", name, name) for name in _ALIKE.split()},
    **{name: Word("math", name, name, count=2) for name in ("atan2", "hypot")},
    **{name: Word("math", name, name, gives="truth") for name in ("isnan", "isfinite")},
    "fabs": Word("math", "fabs", "abs"),
    "pow": Word("math", "pow", "power", count=2),
    "abs": Word("builtins", "fabs", "abs"),
    "float": Word("builtins", "(double)", "double"),
    "int": Word("builtins", "(int)", "fix", gives="whole"),
    "max": Word("builtins", "larger", "max", count=0),
    "min": Word("builtins", "smaller", "min", count=0),
    "maximum": Word(_PRIMITIVES, "", "max", count=2),
    "minimum": Word(_PRIMITIVES, "", "min", count=2),
    "where": Word(_PRIMITIVES, "", "where", count=3),
    "interpolate": Word(_PRIMITIVES, "", "interpolate", count=3),
    "interpolate_rows": Word(_PRIMITIVES, "", "interpolate_rows", count=5),
}


def word_of(function: Any) -> str | None:
    """The name in `FUNCTIONS` of a function of Python, or None.

    Examples
    --------
    >>> import math
    >>> word_of(math.fabs), word_of(open)
    ('fabs', None)
    """
    name = getattr(function, "__name__", "")
    known = FUNCTIONS.get(name)
    return name if known and known.home == getattr(function, "__module__", "") else None


def outside_value(tree: Expression, outside: Outside) -> Any:
    """What a name, or a member of what has a name, stands for in a module; None if for nothing."""
    match tree:
        case Name(word=word):
            return outside.get(word)
        case Member(of=Name(word=word), word=member):
            return getattr(outside.get(word), member, None)
    return None


def called(tree: Call, outside: Outside) -> tuple[str, Any]:
    """The name of a function that is called, and the function."""
    match tree.function:
        case Name(word=word):
            return word, outside.get(word, getattr(builtins, word, None))
        case Member(of=Name(), word=word):
            return word, outside_value(tree.function, outside)
    raise Unwritable("a call of something else than a function by its name")


def counted(word: str, count: int) -> bool:
    """Whether a function of `FUNCTIONS` takes so many arguments.

    Examples
    --------
    >>> counted("log", 2), counted("max", 3)
    (False, True)
    """
    asked = FUNCTIONS[word].count
    return count == asked if asked else count > 1


def bound(known: Function, function: FunctionType, tree: Call) -> tuple[Expression, ...]:
    """What a call gives each argument of a function, what is left out filled in."""
    named = dict(tree.named)
    late = function.__defaults__ or ()
    usual = dict(zip(known.arguments[len(known.arguments) - len(late) :], late, strict=True))
    values: list[Expression] = []
    for place, own in enumerate(known.arguments):
        if place < len(tree.inner):
            values.append(tree.inner[place])
        elif own in named:
            values.append(named[own])
        elif isinstance(usual.get(own), int | float):
            values.append(Number(usual[own]))
        else:
            raise Unwritable("a call that leaves an argument out")
    if len(tree.inner) > len(values) or set(named) - set(known.arguments):
        raise Unwritable("a call with an argument that the function has not")
    return tuple(values)
