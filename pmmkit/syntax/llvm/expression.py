"""Expressions of Python as instructions of LLVM."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping, Sequence
from types import FunctionType
from typing import Any, Final

from pmmkit.syntax.llvm.kinds import (
    BOOL,
    DOUBLE,
    INT,
    LIST,
    NOTHING,
    Kind,
    LlvmLibrary,
    Value,
    constant,
    joined,
    variable,
)
from pmmkit.syntax.tree import (
    Binary,
    Call,
    Compare,
    Conditional,
    Expression,
    Logic,
    Member,
    Name,
    Number,
    Several,
    Span,
    Stray,
    Subscript,
    Unary,
    Unwritable,
)
from pmmkit.syntax.words import OPERATORS, called, counted, outside_value, word_of

_COMPARED: Final = {
    "==": ("eq", "oeq"),
    "!=": ("ne", "une"),
    "<": ("slt", "olt"),
    "<=": ("sle", "ole"),
    ">": ("sgt", "ogt"),
    ">=": ("sge", "oge"),
}
"""Of whole numbers, and of fractions: with what is not a number all but != is false."""
_OF_INTS: Final = {"+": "add nsw", "-": "sub nsw", "*": "mul nsw"}
_OF_DOUBLES: Final = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
_INTRINSIC: Final = ("sqrt", "fabs", "exp", "log", "sin", "cos", "pow", "floor", "ceil")
"""Functions of which LLVM knows what they do; others are those of the C library."""
_BITS: Final = {
    "bits": ("bitcast double {} to i64", DOUBLE, INT),
    "of_bits": ("bitcast i64 {} to double", INT, DOUBLE),
    "bits_of_both": ("and i64 {}, {}", INT, INT),
    "bits_of_one": ("xor i64 {}, {}", INT, INT),
    "bits_moved": ("shl i64 {}, {}", INT, INT),
}
"""Functions that are one instruction."""
_OWN: Final[Mapping[str, Collection[str]]] = {
    "pmmkit.equations.lane_functions": _BITS,
    "pmmkit.equations.stand_ins": ("vector", "part"),
}
"""Functions that are not translated but written as what they do, by their modules."""


class LlvmWriter:
    """Writes expressions, as instructions one below the other.

    `program`: that holds the functions and tables that they name. `kinds`: of the names of the
    function, as they become known. `outside`: names of its module. `lines`: what is written;
    `room`: what stands at the head of the function.
    """

    def __init__(
        self, program: LlvmLibrary, kinds: dict[str, Kind], outside: Mapping[str, Any]
    ) -> None:
        self._program = program
        self._kinds = kinds
        self._outside = outside
        self._count = 0
        self._choices = 0
        self._label = "begin"
        self.lines: list[str] = []
        self.room: list[str] = []

    def new(self, line: str) -> str:
        """Write an instruction; the name of what it gives."""
        self._count += 1
        self.lines.append(f"%t{self._count} = {line}")
        return f"%t{self._count}"

    def load(self, place: str, kind: Kind) -> Value:
        """What stands at an address."""
        return Value(self.new(f"load {kind.llvm}, ptr {place}"), kind)

    def store(self, value: Value, place: str) -> None:
        """Put a value at an address."""
        self.lines.append(f"store {value.kind.llvm} {value.text}, ptr {place}")

    def put(self, word: str, value: Value) -> None:
        """Put a value under a name; under ``_`` nothing is looked for."""
        if word != "_":
            known = self._kinds.get(word)
            kind = self._kinds[word] = value.kind if known is None else joined(known, value.kind)
            self.store(self.cast(value, kind), variable(word))

    def labels(self, *words: str) -> list[str]:
        """Names of blocks of instructions that are still to be written."""
        self._count += 1
        return [f"{word}.{self._count}" for word in words]

    def begin(self, label: str) -> None:
        """Begin a block."""
        self.lines.append(f"{label}:")
        self._label = label

    def go(self, label: str) -> None:
        """End a block where another goes on."""
        self.lines.append(f"br label %{label}")

    def leave(self, line: str) -> None:
        """End a block for good: nothing comes to the one that follows in the text."""
        self.lines.append(line)
        self.begin(self.labels("dead")[0])

    def branch(self, test: Value, yes: str, no: str) -> None:
        """End a block where one of two others goes on."""
        self.lines.append(f"br i1 {test.text}, label %{yes}, label %{no}")

    def apart(self, value: Value) -> list[Value]:
        """Values that a function returned together."""
        if value.kind.is_number:
            return [value]
        if value.kind.llvm == "ptr":
            raise Unwritable("a list where several values are wanted")
        whole = f"{value.kind.llvm} {value.text}"
        return [
            Value(self.new(f"extractvalue {whole}, {place}"), kind)
            for place, kind in enumerate(value.kind.inner)
        ]

    def cast(self, value: Value, kind: Kind) -> Value:
        """A value as one of a kind that holds it."""
        if value.kind.llvm == kind.llvm:
            return value
        if not value.kind.is_number or not kind.is_number or kind == BOOL:
            raise Unwritable("a value of another kind than its place")
        if value.known is not None:
            return constant(float(value.known) if kind == DOUBLE else value.known)
        word = "zext" if kind == INT else "uitofp" if value.kind == BOOL else "sitofp"
        return Value(self.new(f"{word} {value.kind.llvm} {value.text} to {kind.llvm}"), kind)

    def _double(self, value: Value) -> str:
        return self.cast(value, DOUBLE).text

    def number(self, tree: Expression) -> Value:
        """An expression that is one number."""
        found = self.of(tree)
        if not found.kind.is_number:
            raise Unwritable("a list where a number is wanted")
        return found

    def truth(self, tree: Expression) -> Value:
        """An expression that is true or not."""
        found = self.of(tree)
        if found.kind != BOOL:
            raise Unwritable("a choice between numbers by their truth")
        return found

    def of(self, tree: Expression) -> Value:
        """An expression."""
        match tree:
            case Number(value=value):
                return constant(value)
            case Name(word=word):
                return self._name(word)
            case Member():
                found = outside_value(tree, self._outside)
                if isinstance(found, int | float):
                    return constant(found)
            case Unary(sign="not", inner=inner):
                return Value(self.new(f"xor i1 {self.truth(inner).text}, true"), BOOL)
            case Unary(sign="-", inner=inner):
                return self._negative(self.number(inner))
            case Unary(sign="+", inner=inner):
                return self.number(inner)
            case Binary(sign=sign, left=left, right=right):
                return self.operation(sign, self.number(left), self.number(right))
            case Logic(sign=sign, inner=inner):
                return self._both_or_either(sign, inner)
            case Compare(signs=signs, inner=inner):
                return self._comparison(signs, [self.number(item) for item in inner])
            case Conditional(test=test, yes=yes, no=no):
                return self._choice(test, yes, no)
            case Several(inner=inner):
                return self._list([self.number(item) for item in inner])
            case Subscript(of=of, at=at):
                place, kind = self.address(self.of(of), at)
                return self.load(place, kind) if kind.is_number else Value(place, kind)
            case Call():
                return self._call(tree)
        kind_of = tree.kind if isinstance(tree, Stray) else type(tree).__name__
        raise Unwritable(f"an expression that is not written ({kind_of})")

    def _name(self, word: str) -> Value:
        if word in self._kinds:
            return self.load(variable(word), self._kinds[word])
        value = self._outside.get(word)
        if isinstance(value, int | float):
            return constant(value)
        if isinstance(value, tuple | list) and value:
            return self._program.table(value)
        raise Unwritable(f"the name {word!r}, of which nothing is known")

    def _negative(self, inner: Value) -> Value:
        if inner.kind == DOUBLE:
            return Value(self.new(f"fneg double {inner.text}"), DOUBLE)
        return self.operation("-", constant(0), inner)

    def operation(self, sign: str, a: Value, b: Value) -> Value:
        """What an operator makes of two numbers."""
        if sign == "**":
            return self._power(a, b)
        whole = DOUBLE not in (a.kind, b.kind)
        if whole and sign != "/":
            if a.known is not None and b.known is not None:
                return constant(int(OPERATORS[sign].compute(a.known, b.known)))
            a, b = self.cast(a, INT), self.cast(b, INT)
            if sign in _OF_INTS:
                return Value(self.new(f"{_OF_INTS[sign]} i64 {a.text}, {b.text}"), INT)
            if sign == "//" and (b.known or 0) > 0:
                return self._floored(a.text, b.text)
        elif sign in _OF_DOUBLES:
            line = f"{_OF_DOUBLES[sign]} double {self._double(a)}, {self._double(b)}"
            return Value(self.new(line), DOUBLE)
        raise Unwritable(f"an operator that is not written ({sign})")

    def _floored(self, a: str, b: str) -> Value:
        """The quotient rounded down, of a divisor above zero."""
        rest = self.new(f"srem i64 {a}, {b}")
        below = self.new(f"icmp slt i64 {rest}, 0")
        share = self.new(f"sdiv i64 {a}, {b}")
        less = self.new(f"sext i1 {below} to i64")
        return Value(self.new(f"add nsw i64 {share}, {less}"), INT)

    def _power(self, a: Value, b: Value) -> Value:
        """A power; whole ones are products, squared one after another."""
        if b.known is None:
            return self._intrinsic("pow", [a, b])
        value, left = self._double(a), abs(b.known)
        found = ""
        while left:
            if left & 1:
                found = self.new(f"fmul double {found}, {value}") if found else value
            left >>= 1
            if left:
                value = self.new(f"fmul double {value}, {value}")
        found = found or constant(1.0).text
        if b.known < 0:
            found = self.new(f"fdiv double {constant(1.0).text}, {found}")
        return Value(found, DOUBLE)

    def _both_or_either(self, sign: str, values: Sequence[Expression]) -> Value:
        """What the last value is that is looked at."""
        (end,) = self.labels("settled")
        ways = []
        found = constant(sign == "and")
        for item in values:
            if found.known is None:
                (more,) = self.labels("more")
                ways.append(f"[{found.text}, %{self._label}]")
                self.branch(found, *((end, more) if sign == "or" else (more, end)))
                self.begin(more)
            elif bool(found.known) == (sign == "or"):
                break
            found = self.truth(item)
        if not ways:
            return found
        ways.append(f"[{found.text}, %{self._label}]")
        self.go(end)
        self.begin(end)
        return Value(self.new(f"phi i1 {', '.join(ways)}"), BOOL)

    def _comparison(self, signs: Sequence[str], items: Sequence[Value]) -> Value:
        found = ""
        if all(item.known is not None for item in items):
            known = [item.known for item in items]
            pairs = zip(signs, known[:-1], known[1:], strict=True)
            return constant(all(OPERATORS[sign].compute(a, b) for sign, a, b in pairs))
        for place, sign in enumerate(signs):
            a, b = items[place], items[place + 1]
            if DOUBLE in (a.kind, b.kind):
                line = f"fcmp {_COMPARED[sign][1]} double {self._double(a)}, {self._double(b)}"
            else:
                a, b = self.cast(a, INT), self.cast(b, INT)
                line = f"icmp {_COMPARED[sign][0]} i64 {a.text}, {b.text}"
            one = self.new(line)
            found = self.new(f"and i1 {found}, {one}") if found else one
        return Value(found, BOOL)

    def _choice(self, test: Expression, yes: Expression, no: Expression) -> Value:
        asked = self.truth(test)
        if asked.known is not None:
            return self.number(yes if asked.known else no)
        if _is_quick(yes) and _is_quick(no):
            a, b = self.number(yes), self.number(no)
            kind = joined(a.kind, b.kind)
            a, b = self.cast(a, kind), self.cast(b, kind)
            ways = f"{kind.llvm} {a.text}, {kind.llvm} {b.text}"
            return Value(self.new(f"select i1 {asked.text}, {ways}"), kind)
        then, other, after = self.labels("then", "other", "after")
        self.branch(asked, then, other)
        self._choices += 1
        chosen = f"chosen.{self._choices}"
        for label, tree in ((then, yes), (other, no)):
            self.begin(label)
            self.put(chosen, self.number(tree))
            self.go(after)
        self.begin(after)
        return self._name(chosen)

    def address(self, whole: Value, at: Expression) -> tuple[str, Kind]:
        """Address of a place in a list, and the kind of what stands there."""
        if whole.kind.llvm != "ptr":
            raise Unwritable("a place in what is no list")
        (inner,) = whole.kind.inner
        if isinstance(at, Span):
            if at.low is None or at.high is None or not inner.is_number:
                raise Unwritable("a part of a list that has no two ends")
            low, high = self.number(at.low).known, self.number(at.high).known
            if low is None or high is None:
                raise Unwritable("a part of a list whose length is not known beforehand")
            return self._moved(whole, inner, str(low)), Kind("ptr", high - low, (inner,))
        place = self.number(at)
        if place.kind != INT:
            raise Unwritable("a place in a list that is no whole number")
        if place.known is not None and place.known < 0:
            if whole.kind.size is None:
                raise Unwritable("a place before the first of a list")
            place = constant(whole.kind.size + place.known)
        if inner.is_number:
            return self._moved(whole, inner, place.text), inner
        row = self.operation("*", place, constant(inner.size or 0))
        return self._moved(whole, inner.inner[0], row.text), inner

    def _moved(self, whole: Value, inner: Kind, by: str) -> str:
        return self.new(f"getelementptr inbounds {inner.llvm}, ptr {whole.text}, i64 {by}")

    def _list(self, items: Sequence[Value]) -> Value:
        """Numbers under one name."""
        room = self._vector(constant(len(items)))
        for place, item in enumerate(items):
            self.store(self.cast(item, DOUBLE), self._moved(room, DOUBLE, str(place)))
        return room

    def _vector(self, size: Value) -> Value:
        """Room for numbers, all zero."""
        self._count += 1
        room = f"%room{self._count}"
        if size.known is None:
            raise Unwritable("a list whose length is not known beforehand")
        self.room.append(f"{room} = alloca [{size.known} x double], align 64")
        length = 8 * size.known
        self._program.declared("void", "llvm.memset.p0.i64", "(ptr, i8, i64, i1)")
        self.lines.append(
            f"call void @llvm.memset.p0.i64(ptr align 64 {room}, i8 0, i64 {length}, i1 false)"
        )
        return Value(room, LIST)

    def _call(self, tree: Call) -> Value:
        name, function = called(tree, self._outside)
        if name in _OWN.get(getattr(function, "__module__", ""), ()):
            return self._own_word(name, tree.inner)
        if isinstance(function, FunctionType):
            return self._own_call(name, function, tree)
        given = [self.of(item) for item in tree.inner]
        if function is len and len(given) == 1 and given[0].kind.size is not None:
            return constant(given[0].kind.size)
        word = word_of(function)
        if (
            word is None
            or tree.named
            or not counted(word, len(given))
            or not all(item.kind.is_number for item in given)
        ):
            raise Unwritable(f"the function {name}, which is not written")
        return self._known_call(word, given)

    def _own_word(self, name: str, inner: Sequence[Expression]) -> Value:
        if name == "vector":
            return self._vector(self.number(inner[0]))
        if name == "part":
            whole, first = self.of(inner[0]), self.number(inner[1])
            return Value(self._moved(whole, DOUBLE, first.text), LIST)
        line, takes, gives = _BITS[name]
        values = [self.cast(self.number(item), takes).text for item in inner]
        return Value(self.new(line.format(*values)), gives)

    def _known_call(self, word: str, given: Sequence[Value]) -> Value:
        if word in ("max", "min"):
            found = given[0]
            for item in given[1:]:
                kind = joined(found.kind, item.kind)
                a, b = self.cast(found, kind), self.cast(item, kind)
                over = self._comparison((">" if word == "max" else "<",), [b, a])
                line = f"select i1 {over.text}, {kind.llvm} {b.text}, {kind.llvm} {a.text}"
                found = Value(self.new(line), kind)
            return found
        if word == "float":
            return self.cast(given[0], DOUBLE)
        if word == "int":
            return self._whole(given[0])
        value = self._double(given[0])
        if word == "isnan":
            return Value(self.new(f"fcmp uno double {value}, {value}"), BOOL)
        if word == "isfinite":
            rest = self.new(f"fsub double {value}, {value}")
            return Value(self.new(f"fcmp ord double {rest}, {rest}"), BOOL)
        if word in ("floor", "ceil"):
            return self._whole(self._intrinsic(word, given))
        word = "fabs" if word == "abs" else word
        if word in _INTRINSIC:
            return self._intrinsic(word, given)
        # That of the C library has another name there.
        word = "_hypot" if word == "hypot" and sys.platform == "win32" else word
        return self._outer(word, given, " nounwind memory(none)")

    def _whole(self, value: Value) -> Value:
        if value.kind != DOUBLE:
            return self.cast(value, INT)
        return Value(self.new(f"fptosi double {value.text} to i64"), INT)

    def _intrinsic(self, word: str, given: Sequence[Value]) -> Value:
        return self._outer(f"llvm.{word}.f64", given, "")

    def _outer(self, name: str, given: Sequence[Value], told: str) -> Value:
        kinds = ", ".join(["double"] * len(given))
        self._program.declared("double", name, f"({kinds}){told}")
        values = ", ".join(f"double {self._double(item)}" for item in given)
        return Value(self.new(f"call double @{name}({values})"), DOUBLE)

    def _own_call(self, name: str, function: FunctionType, tree: Call) -> Value:
        values = [self.of(item) for item in self._program.arguments(function, name, tree)]
        kinds = tuple(item.kind for item in values)
        own, returned = self._program.function(function, kinds, name)
        given = ", ".join(f"{item.kind.llvm} {item.text}" for item in values)
        if returned == NOTHING:
            self.lines.append(f"call void @{own}({given})")
            return Value("", NOTHING)
        return Value(self.new(f"call {returned.llvm} @{own}({given})"), returned)


def _is_quick(tree: Expression) -> bool:
    """Whether a value may be computed that is not asked for: it reads no list and calls nothing.

    Loops without branches are made vectors of.
    """
    return not any(isinstance(node, Subscript | Call | Logic) for node in tree.nodes())
