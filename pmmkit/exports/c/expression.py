"""Expressions of Python as expressions of C."""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Final

from pmmkit.exports.c.kinds import (
    BOOL,
    DOUBLE,
    GRID,
    INT,
    LIST,
    TABLE,
    Kind,
    Library,
    Unwritable,
    identifier,
    joined,
    number,
)

_CHOICE, _OR, _AND, _COMPARISON, _SUM, _PRODUCT, _SIGN, _ATOM = range(8)
_OPERATORS: Final[Mapping[type[ast.operator], tuple[str, int, Callable[[int, int], float]]]] = {
    ast.Add: (" + ", _SUM, operator.add),
    ast.Sub: (" - ", _SUM, operator.sub),
    ast.Mult: (" * ", _PRODUCT, operator.mul),
    ast.Div: (" / ", _PRODUCT, operator.truediv),
}
_COMPARISONS: Final[Mapping[type[ast.cmpop], tuple[str, Callable[[int, int], bool]]]] = {
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
    ast.Lt: ("<", operator.lt),
    ast.LtE: ("<=", operator.le),
    ast.Gt: (">", operator.gt),
    ast.GtE: (">=", operator.ge),
}
_LARGEST: Final = 2**31 - 1
"""Whole number that C's int is sure to hold."""
_SAME: Final = (
    "acos asin atan atan2 ceil cos cosh exp fabs floor hypot log pow sin sinh sqrt tan tanh"
)
_FUNCTIONS: Final[Mapping[Any, tuple[str, Kind]]] = {
    **{getattr(math, name): (name, DOUBLE) for name in _SAME.split()},
    math.isnan: ("isnan", BOOL),
    math.isfinite: ("isfinite", BOOL),
    abs: ("fabs", DOUBLE),
    float: ("(double)", DOUBLE),
    int: ("(int)", INT),
}


@dataclass(frozen=True)
class Expression:
    """Text of an expression, its kind, its rank among the operators, its number where known."""

    text: str
    kind: Kind
    rank: int = _ATOM
    known: int | None = None
    count: str = ""

    def within(self, rank: int) -> str:
        """The text as an operand."""
        return self.text if self.rank >= rank else f"({self.text})"


class Writer:
    """Writes expressions.

    Parameters
    ----------
    program : Library
        That holds the functions and tables that they name.
    kinds : mapping of str to Kind
        Of the names of the function, as they become known.
    outside : mapping
        Names of its module.
    """

    def __init__(
        self, program: Library, kinds: Mapping[str, Kind], outside: Mapping[str, Any]
    ) -> None:
        self._program = program
        self._kinds = kinds
        self._outside = outside

    def of(self, node: ast.expr) -> Expression:
        """An expression.

        Raises
        ------
        Unwritable
            If C is not written for it.
        """
        match node:
            case ast.Constant(value=bool() | int() | float() as value):
                return _constant(value)
            case ast.Name(id=name):
                return self._name(name)
            case ast.Attribute(value=ast.Name(id=name), attr=attr):
                found = getattr(self._outside.get(name), attr, None)
                if isinstance(found, int | float):
                    return _constant(found)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self._numeric(operand)
                known = None if inner.known is None else -inner.known
                return Expression(f"-{inner.within(_ATOM)}", inner.kind, _SIGN, known)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return Expression(f"!{self._numeric(operand).within(_ATOM)}", BOOL, _SIGN)
            case ast.BinOp(left=left, op=op, right=right):
                return self._operation(left, op, right)
            case ast.BoolOp(op=op, values=values):
                return self._both_or_either(op, values)
            case ast.Compare(left=left, ops=ops, comparators=others):
                return self._comparison(left, ops, others)
            case ast.IfExp(test=test, body=yes, orelse=no):
                decided = self.of(test).known
                if decided is not None:
                    return self.of(yes if decided else no)
                a, b = self._numeric(yes), self._numeric(no)
                asked = self._numeric(test).within(_OR)
                text = f"{asked} ? {a.within(_OR)} : {b.within(_OR)}"
                return Expression(text, joined(a.kind, b.kind), _CHOICE)
            case ast.Subscript(value=value, slice=place):
                return self._item(self.of(value), place)
            case ast.Call():
                return self._call(node)
        raise Unwritable(f"an expression that C is not written for ({type(node).__name__})")

    def _numeric(self, node: ast.expr) -> Expression:
        found = self.of(node)
        if not found.kind.is_number:
            raise Unwritable("a list where a number is wanted")
        return found

    def _name(self, name: str) -> Expression:
        own = identifier(name)
        if name in self._kinds:
            kind = self._kinds[name]
            return Expression(own, kind, count=f"{own}_count" if kind == TABLE else "")
        value = self._outside.get(name)
        if isinstance(value, int | float):
            return _constant(value)
        if isinstance(value, tuple | list) and value:
            rows = value if isinstance(value[0], tuple | list) else [value]
            equal = len({len(row) for row in rows}) == 1
            if equal and all(isinstance(x, int | float) for row in rows for x in row):
                text = self._program.table(value, name)
                flat = rows[0] is not value[0]
                return Expression(text, TABLE if flat else GRID, count=str(len(rows[0])))
        raise Unwritable(f"the name {name!r}, of which C knows nothing")

    def _operation(self, left: ast.expr, op: ast.operator, right: ast.expr) -> Expression:
        a, b = self._numeric(left), self._numeric(right)
        whole = DOUBLE not in (a.kind, b.kind)
        if isinstance(op, ast.Pow):
            return Expression(f"pow({a.text}, {b.text})", DOUBLE)
        if isinstance(op, ast.FloorDiv) and whole and b.known is not None and b.known > 0:
            return Expression(f"{a.within(_PRODUCT)} / {b.within(_SIGN)}", INT, _PRODUCT)
        if type(op) not in _OPERATORS:
            raise Unwritable(f"an operator that C is not written for ({type(op).__name__})")
        sign, rank, compute = _OPERATORS[type(op)]
        first = a.within(rank)
        if isinstance(op, ast.Div) and whole:
            first = f"(double){a.within(_ATOM)}"
        kind = DOUBLE if isinstance(op, ast.Div) or not whole else INT
        known = None
        if kind == INT and a.known is not None and b.known is not None:
            known = int(compute(a.known, b.known))
        return Expression(f"{first}{sign}{b.within(rank + 1)}", kind, rank, known)

    def _both_or_either(self, op: ast.boolop, values: list[ast.expr]) -> Expression:
        rank, sign = (_AND, " && ") if isinstance(op, ast.And) else (_OR, " || ")
        settles = int(isinstance(op, ast.Or))
        parts = []
        for item in values:
            found = self._numeric(item)
            if found.kind != BOOL:
                raise Unwritable("a choice between numbers by their truth")
            if found.known == settles:
                parts.append(found)
                break
            if found.known is None:
                parts.append(found)
        if not parts or parts[0].known is not None:
            known = parts[0].known if parts else 1 - settles
            return Expression(str(known), BOOL, known=known)
        return Expression(sign.join(item.within(rank + 1) for item in parts), BOOL, rank)

    def _comparison(
        self, left: ast.expr, ops: list[ast.cmpop], others: list[ast.expr]
    ) -> Expression:
        if not all(type(op) in _COMPARISONS for op in ops):
            raise Unwritable("a comparison that C is not written for")
        items = [self._numeric(item) for item in (left, *others)]
        texts = [item.within(_SUM) for item in items]
        parts = [
            f"{texts[i]} {_COMPARISONS[type(op)][0]} {texts[i + 1]}" for i, op in enumerate(ops)
        ]
        rank = _COMPARISON if len(parts) == 1 else _AND
        return Expression(" && ".join(parts), BOOL, rank, _decided(ops, items))

    def _item(self, whole: Expression, place: ast.expr) -> Expression:
        if isinstance(place, ast.Slice):
            return self._slice(whole, place)
        at = self._numeric(place)
        if at.kind == DOUBLE or (at.known is not None and at.known < 0):
            raise Unwritable("a place in a list that is no whole number from 0 on")
        if whole.kind == GRID:
            return Expression(f"{whole.text}[{at.text}]", TABLE, count=whole.count)
        if whole.kind not in (LIST, TABLE):
            raise Unwritable("a place in what is no list")
        return Expression(f"{whole.text}[{at.text}]", DOUBLE)

    def _slice(self, whole: Expression, place: ast.Slice) -> Expression:
        if whole.kind != LIST or place.lower is None or place.upper is None or place.step:
            raise Unwritable("a part of a list that has no two ends")
        low, high = self._numeric(place.lower), self._numeric(place.upper)
        if low.known is None or high.known is None:
            raise Unwritable("a part of a list whose length is not known beforehand")
        return Expression(f"{whole.text} + {low.known}", TABLE, count=str(high.known - low.known))

    def _call(self, node: ast.Call) -> Expression:
        name, function = self._called(node.func)
        given = [self.of(item) for item in node.args]
        if isinstance(function, FunctionType):
            return self._own_call(name, function, given, node.keywords)
        if function is len and len(given) == 1 and given[0].count and given[0].kind == TABLE:
            count = given[0].count
            return Expression(count, INT, known=int(count) if count.isdecimal() else None)
        if function in (max, min) and len(given) > 1 and all(x.kind.is_number for x in given):
            word = "larger" if function is max else "smaller"
            text = given[0].text
            for item in given[1:]:
                text = f"{word}({text}, {item.text})"
            return Expression(text, DOUBLE)
        if function in _FUNCTIONS and all(x.kind.is_number for x in given):
            word, kind = _FUNCTIONS[function]
            inside = ", ".join(item.text for item in given)
            return Expression(f"{word}({inside})", kind)
        raise Unwritable(f"the function {name}, which C is not written for")

    def _called(self, func: ast.expr) -> tuple[str, Any]:
        match func:
            case ast.Name(id=name):
                return name, self._outside.get(name, getattr(builtins, name, None))
            case ast.Attribute(value=ast.Name(id=name), attr=attr):
                return attr, getattr(self._outside.get(name), attr, None)
        raise Unwritable("a call of something else than a function by its name")

    def _own_call(
        self,
        name: str,
        function: FunctionType,
        given: list[Expression],
        keywords: list[ast.keyword],
    ) -> Expression:
        values = self._bound(function, given, keywords)
        kinds = tuple(item.kind for item in values)
        own, returned = self._program.function(function, kinds, name)
        texts = [
            text
            for item in values
            for text in ([item.text, item.count] if item.kind == TABLE else [item.text])
        ]
        return Expression(f"{own}({', '.join(texts)})", returned)

    def _bound(
        self, function: Callable[..., Any], given: list[Expression], keywords: list[ast.keyword]
    ) -> list[Expression]:
        """The arguments of a call in the order of the function, defaults filled in."""
        named = {item.arg: self.of(item.value) for item in keywords if item.arg is not None}
        values = []
        for place, (own, parameter) in enumerate(inspect.signature(function).parameters.items()):
            if place < len(given):
                values.append(given[place])
            elif own in named:
                values.append(named[own])
            elif isinstance(parameter.default, int | float):
                values.append(_constant(parameter.default))
            else:
                raise Unwritable("a call that leaves an argument out")
        return values


def _decided(ops: Sequence[ast.cmpop], items: Sequence[Expression]) -> int | None:
    """What a comparison of known whole numbers gives."""
    known = [item.known for item in items]
    found = True
    for op, first, second in zip(ops, known[:-1], known[1:], strict=True):
        if first is None or second is None:
            return None
        found = found and _COMPARISONS[type(op)][1](first, second)
    return int(found)


def _constant(value: float) -> Expression:
    if isinstance(value, int) and abs(value) > _LARGEST:
        value = float(value)
    text = number(value)
    kind = BOOL if isinstance(value, bool) else INT if isinstance(value, int) else DOUBLE
    rank = _SIGN if text.startswith("-") else _ATOM
    return Expression(text, kind, rank, int(value) if kind == INT else None)
