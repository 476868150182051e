"""Expressions of Python as expressions of C."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Final

from pmmkit.syntax.c.kinds import (
    BOOL,
    DOUBLE,
    GRID,
    INT,
    LIST,
    TABLE,
    Library,
    ValueKind,
    c_number,
    identifier,
    joined,
)
from pmmkit.syntax.tree import (
    Binary,
    Call,
    Compare,
    Conditional,
    Logic,
    Member,
    Name,
    Number,
    Span,
    Stray,
    Subscript,
    Unary,
    Unwritable,
)
from pmmkit.syntax.tree import Expression as Tree
from pmmkit.syntax.words import (
    AND,
    ATOM,
    CHOICE,
    COMPARISON,
    FUNCTIONS,
    OPERATORS,
    OR,
    SIGN,
    SUM,
    called,
    counted,
    outside_value,
    word_of,
)

_LARGEST: Final = 2**31 - 1
"""Whole number that C's int is sure to hold."""
_GIVES: Final = {"fraction": DOUBLE, "whole": INT, "truth": BOOL}


@dataclass(frozen=True)
class Expression:
    """Text of an expression, its kind, its rank among the operators, its number where known."""

    text: str
    kind: ValueKind
    rank: int = ATOM
    known: int | None = None
    count: str = ""

    def within(self, rank: int) -> str:
        """The text as an operand."""
        return self.text if self.rank >= rank else f"({self.text})"


class Writer:
    """Writes expressions.

    `program`: that holds the functions and tables that they name. `kinds`: of the names of the
    function, as they become known. `outside`: names of its module.
    """

    def __init__(
        self, program: Library, kinds: Mapping[str, ValueKind], outside: Mapping[str, Any]
    ) -> None:
        self._program = program
        self._kinds = kinds
        self._outside = outside

    def of(self, tree: Tree) -> Expression:
        """An expression."""
        match tree:
            case Number(value=value):
                return _constant(value)
            case Name(word=word):
                return self._name(word)
            case Member():
                found = outside_value(tree, self._outside)
                if isinstance(found, int | float):
                    return _constant(found)
                raise Unwritable("an expression that C is not written for (Attribute)")
            case Unary(sign="not", inner=inner):
                return Expression(f"!{self._numeric(inner).within(ATOM)}", BOOL, SIGN)
            case Unary(sign=sign, inner=inner):
                return self._signed(sign, self._numeric(inner))
            case Binary(sign=sign, left=left, right=right):
                return self._operation(sign, self._numeric(left), self._numeric(right))
            case Logic(sign=sign, inner=inner):
                return self._both_or_either(sign, inner)
            case Compare(signs=signs, inner=inner):
                return self._comparison(signs, [self._numeric(item) for item in inner])
            case Conditional(test=test, yes=yes, no=no):
                decided = self.of(test).known
                if decided is not None:
                    return self.of(yes if decided else no)
                a, b = self._numeric(yes), self._numeric(no)
                asked = self._numeric(test).within(OR)
                text = f"{asked} ? {a.within(OR)} : {b.within(OR)}"
                return Expression(text, joined(a.kind, b.kind), CHOICE)
            case Subscript(of=whole, at=at):
                return self._item(self.of(whole), at)
            case Call():
                return self._call(tree)
        kind = tree.kind if isinstance(tree, Stray) else type(tree).__name__
        raise Unwritable(f"an expression that C is not written for ({kind})")

    def _numeric(self, tree: Tree) -> Expression:
        found = self.of(tree)
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

    def _signed(self, sign: str, inner: Expression) -> Expression:
        if sign == "+":
            return inner
        kind = INT if inner.kind == BOOL else inner.kind
        known = None if inner.known is None else -inner.known
        return Expression(f"-{inner.within(ATOM)}", kind, SIGN, known)

    def _operation(self, sign: str, a: Expression, b: Expression) -> Expression:
        whole = DOUBLE not in (a.kind, b.kind)
        if sign == "**":
            return Expression(f"pow({a.text}, {b.text})", DOUBLE)
        if sign == "//" and whole and b.known != 0:
            return Expression(f"floored({a.text}, {b.text})", INT)
        own = OPERATORS[sign]
        if not own.c:
            raise Unwritable(f"an operator that C is not written for ({sign})")
        kind = INT if whole and sign != "/" else DOUBLE
        known = None
        if kind == INT and a.known is not None and b.known is not None:
            known = int(own.compute(a.known, b.known))
            if abs(known) > _LARGEST:
                return _constant(known)
        first = a.within(own.rank)
        if sign == "/" and whole:
            first = f"(double){a.within(ATOM)}"
        return Expression(f"{first}{own.c}{b.within(own.rank + 1)}", kind, own.rank, known)

    def _both_or_either(self, sign: str, values: tuple[Tree, ...]) -> Expression:
        own = OPERATORS[sign]
        settles = int(sign == "or")
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
        return Expression(own.c.join(x.within(own.rank + 1) for x in parts), BOOL, own.rank)

    def _comparison(self, signs: tuple[str, ...], items: list[Expression]) -> Expression:
        texts = [item.within(SUM) for item in items]
        parts = [f"{texts[i]}{OPERATORS[sign].c}{texts[i + 1]}" for i, sign in enumerate(signs)]
        rank = COMPARISON if len(parts) == 1 else AND
        return Expression(OPERATORS["and"].c.join(parts), BOOL, rank, _decided(signs, items))

    def _item(self, whole: Expression, place: Tree) -> Expression:
        if isinstance(place, Span):
            return self._slice(whole, place)
        at = self._numeric(place)
        if at.kind == DOUBLE or (at.known is not None and at.known < 0):
            raise Unwritable("a place in a list that is no whole number from 0 on")
        if whole.kind == GRID:
            return Expression(f"{whole.text}[{at.text}]", TABLE, count=whole.count)
        if whole.kind not in (LIST, TABLE):
            raise Unwritable("a place in what is no list")
        return Expression(f"{whole.text}[{at.text}]", DOUBLE)

    def _slice(self, whole: Expression, place: Span) -> Expression:
        if whole.kind != LIST or place.low is None or place.high is None:
            raise Unwritable("a part of a list that has no two ends")
        low, high = self._numeric(place.low), self._numeric(place.high)
        if low.known is None or high.known is None:
            raise Unwritable("a part of a list whose length is not known beforehand")
        return Expression(f"{whole.text} + {low.known}", TABLE, count=str(high.known - low.known))

    def _call(self, tree: Call) -> Expression:
        name, function = called(tree, self._outside)
        if isinstance(function, FunctionType):
            return self._own_call(name, function, tree)
        given = [self.of(item) for item in tree.inner]
        if function is len and len(given) == 1 and given[0].count and given[0].kind == TABLE:
            count = given[0].count
            return Expression(count, INT, known=int(count) if count.isdecimal() else None)
        word = word_of(function)
        if (
            word is None
            or tree.named
            or not counted(word, len(given))
            or not all(x.kind.is_number for x in given)
        ):
            raise Unwritable(f"the function {name}, which C is not written for")
        spelled = FUNCTIONS[word]
        if spelled.count:
            text = f"{spelled.c}({', '.join(item.text for item in given)})"
        else:
            text = given[0].text
            for item in given[1:]:
                text = f"{spelled.c}({text}, {item.text})"
        return Expression(text, _GIVES[spelled.gives])

    def _own_call(self, name: str, function: FunctionType, tree: Call) -> Expression:
        values = [self.of(item) for item in self._program.arguments(function, name, tree)]
        kinds = tuple(item.kind for item in values)
        own, returned = self._program.function(function, kinds, name)
        texts = [
            text
            for item in values
            for text in ([item.text, item.count] if item.kind == TABLE else [item.text])
        ]
        return Expression(f"{own}({', '.join(texts)})", returned)


def _decided(signs: tuple[str, ...], items: list[Expression]) -> int | None:
    """What a comparison of known whole numbers gives."""
    known = [item.known for item in items]
    found = True
    for sign, first, second in zip(signs, known[:-1], known[1:], strict=True):
        if first is None or second is None:
            return None
        found = found and OPERATORS[sign].compute(first, second)
    return int(found)


def _constant(value: float) -> Expression:
    if isinstance(value, int) and abs(value) > _LARGEST:
        value = float(value)
    text = c_number(value)
    kind = BOOL if isinstance(value, bool) else INT if isinstance(value, int) else DOUBLE
    rank = SIGN if text.startswith("-") else ATOM
    return Expression(text, kind, rank, int(value) if kind == INT else None)
