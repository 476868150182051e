"""The body of one function as lines of C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pmmkit.syntax.c.expression import Expression, Writer
from pmmkit.syntax.c.kinds import (
    BOOL,
    DOUBLE,
    INT,
    LIST,
    NOTHING,
    Library,
    ValueKind,
    identifier,
    joined,
)
from pmmkit.syntax.tree import (
    Assign,
    Augmented,
    Call,
    Do,
    For,
    Function,
    If,
    Leave,
    Name,
    Return,
    Several,
    Statement,
    Stray,
    Subscript,
    Unwritable,
    While,
)
from pmmkit.syntax.tree import Expression as Tree


class Body:
    """Lines of a function, and the kind of what it returns.

    A first pass finds the kinds of all names, for a name may stand for a whole number at first and
    for a fraction later; the second writes.

    `program`: that holds the functions that this one calls. `arguments`: its arguments in their
    order. `outside`: names of its module.
    """

    def __init__(
        self,
        program: Library,
        tree: Function,
        arguments: Mapping[str, ValueKind],
        outside: Mapping[str, Any],
    ) -> None:
        self.returned = NOTHING
        self._read = _read(tree)
        self._arguments = dict(arguments)
        self._kinds = dict(arguments)
        self._vectors: dict[str, int] = {}
        self._program = program
        before: dict[str, ValueKind] | None = None
        while before != self._kinds:
            before = dict(self._kinds)
            self._expressions = Writer(program, self._kinds, outside)
            self._count = 0
            written = self._block(tree.body)
        own = [name for name in self._kinds if name not in arguments]
        self.lines = [*self._declared(own), *written]

    def _declared(self, names: Sequence[str]) -> list[str]:
        lines = [f"double {identifier(x)}[{size}] = {{0.0}};" for x, size in self._vectors.items()]
        for kind in (INT, BOOL, DOUBLE):
            mine = [identifier(x) for x in names if self._kinds[x] == kind]
            for first in range(0, len(mine), 8):
                lines.append(f"{kind.text} {', '.join(mine[first : first + 8])};")
        return lines

    def _block(self, block: Sequence[Statement]) -> list[str]:
        return [line for statement in block for line in self._statement(statement)]

    def _inner(self, block: Sequence[Statement]) -> list[str]:
        return [f"    {line}" for line in self._block(block)]

    def _statement(self, node: Statement) -> list[str]:
        match node:
            case Leave(word="pass"):
                return []
            case Leave(word=word):
                return [f"{word};"]
            case Do(value=Call() as call):
                return [f"{self._expressions.of(call).text};"]
            case Assign(target=target, value=value):
                return self._assigned(target, value)
            case Augmented(target=target, sign="+" | "-" | "*" | "/" as sign, value=value):
                return self._changed(target, sign, value)
            case If(test=test, yes=yes, no=no):
                return self._branches(test, yes, no)
            case While(test=test, body=body, otherwise=()):
                return [f"while ({self._expressions.of(test).text}) {{", *self._inner(body), "}"]
            case For(
                target=Name(word=name),
                over=Call(function=Name(word="range"), inner=limits, named=()),
                body=body,
                otherwise=(),
            ):
                return self._loop(name, limits, body)
            case Return(value=value):
                return self._return(value)
        kind = node.kind if isinstance(node, Stray) else type(node).__name__
        raise Unwritable(f"a statement that C is not written for ({kind})")

    def _branches(self, test: Tree, yes: Sequence[Statement], no: Sequence[Statement]) -> list[str]:
        asked = self._expressions.of(test)
        if asked.known is not None:
            return self._block(yes if asked.known else no)
        lines = [f"if ({asked.text}) {{", *self._inner(yes)]
        if no:
            lines += ["} else {", *self._inner(no)]
        return [*lines, "}"]

    def _loop(self, name: str, limits: Sequence[Tree], body: Sequence[Statement]) -> list[str]:
        ends = [self._expressions.of(item) for item in limits]
        if any(item.kind != INT for item in ends) or len(ends) > 2:
            raise Unwritable("a loop over something else than whole numbers in ascending order")
        first = ends[0].text if len(ends) == 2 else "0"
        own = identifier(name)
        if name in self._kinds:
            raise Unwritable("a loop over a name that has another meaning")
        self._kinds[name] = INT
        inner = self._inner(body)
        del self._kinds[name]
        last = ends[-1].text
        bound = "" if ends[-1].known is not None else f", {own}_end = {last}"
        limit = last if not bound else f"{own}_end"
        return [f"for (int {own} = {first}{bound}; {own} < {limit}; {own}++) {{", *inner, "}"]

    def _return(self, value: Tree | None) -> list[str]:
        if value is None:
            return ["return;"]
        if isinstance(value, Several) and len(value.inner) > 1:
            items = [self._expressions.of(item) for item in value.inner]
            self._returns(self._program.tuple_of(len(items)))
            texts = ", ".join(self._number(item) for item in items)
            return [f"return (struct numbers_{len(items)}){{{texts}}};"]
        only = value.inner[0] if isinstance(value, Several) else value
        found = self._expressions.of(only)
        self._returns(found.kind)
        return [f"return {found.text};"]

    def _returns(self, kind: ValueKind) -> None:
        self.returned = kind if self.returned == NOTHING else joined(self.returned, kind)

    @staticmethod
    def _number(value: Expression) -> str:
        if not value.kind.is_number:
            raise Unwritable("a list among numbers")
        return value.text

    def _assigned(self, target: Tree, value: Tree) -> list[str]:
        if isinstance(target, Several):
            return self._several(target.inner, value)
        if isinstance(target, Name):
            if target.word not in self._read and not any(
                isinstance(node, Call) for node in value.nodes()
            ):
                return []
            if self._vector(target.word, value):
                return []
        found = self._expressions.of(value)
        return [f"{self._place(target, found)} = {found.text};"]

    def _vector(self, name: str, value: Tree) -> bool:
        """Whether a name is given room for numbers."""
        match value:
            case Call(function=Name(word="vector"), inner=(size,)):
                found = self._expressions.of(size)
                if found.known is None or self._vectors.get(name, found.known) != found.known:
                    raise Unwritable("a list whose length is not known beforehand")
                self._vectors[name] = int(found.known)
                self._kinds[name] = LIST
                return True
        return False

    def _place(self, target: Tree, found: Expression) -> str:
        if isinstance(target, Name):
            self._named(target.word, found.kind)
            return identifier(target.word)
        if isinstance(target, Subscript):
            place = self._expressions.of(target)
            if self._expressions.of(target.of).kind != LIST or not found.kind.is_number:
                raise Unwritable("a value put where there is no place for it")
            return place.text
        raise Unwritable("an assignment to something else than a name or a place in a list")

    def _named(self, name: str, kind: ValueKind) -> None:
        known = self._kinds.get(name)
        if not kind.is_number or (known is not None and not known.is_number):
            raise Unwritable("a name for a list that is there already")
        self._kinds[name] = kind if known is None else joined(known, kind)
        if name in self._arguments and self._kinds[name] != known:
            raise Unwritable("an argument that becomes a fraction")

    def _several(self, targets: Sequence[Tree], value: Tree) -> list[str]:
        if isinstance(value, Call):
            return self._unpacked(targets, value)
        if not isinstance(value, Several) or len(value.inner) != len(targets):
            raise Unwritable("values that are not as many as their names")
        pairs = list(zip(targets, value.inner, strict=True))
        if not _entangled(targets, value.inner):
            return [line for target, item in pairs for line in self._assigned(target, item)]
        self._count += 1
        lines, after = [], []
        for place, (target, item) in enumerate(pairs):
            found = self._expressions.of(item)
            held = f"held_{self._count}_{place}"
            lines.append(f"const {found.kind.text} {held} = {self._number(found)};")
            after.append(f"{self._place(target, found)} = {held};")
        return ["{", *(f"    {line}" for line in (*lines, *after)), "}"]

    def _unpacked(self, targets: Sequence[Tree], call: Call) -> list[str]:
        found = self._expressions.of(call)
        if len(targets) == 1 and found.kind.is_number:
            return [f"{self._place(targets[0], found)} = {found.text};"]
        if found.kind.name != "tuple" or found.kind.size != len(targets):
            raise Unwritable("values that are not as many as their names")
        self._count += 1
        held = f"held_{self._count}"
        one = Expression(held, DOUBLE)
        places = [
            f"{self._place(target, one)} = {held}.v{place};"
            for place, target in enumerate(targets)
            if not isinstance(target, Name) or target.word in self._read
        ]
        first = f"const {found.kind.text} {held} = {found.text};"
        return ["{", *(f"    {line}" for line in (first, *places)), "}"]

    def _changed(self, target: Tree, sign: str, value: Tree) -> list[str]:
        found = self._expressions.of(value)
        if sign == "/" and found.kind != DOUBLE:
            found = Expression(f"(double)({found.text})", DOUBLE)
        return [f"{self._place(target, found)} {sign}= {found.text};"]


def _read(tree: Function) -> frozenset[str]:
    """Names whose values are looked at: all but those that are only put there."""
    found: frozenset[str] = frozenset()
    for node in tree.nodes():
        match node:
            case Assign(target=target, value=value):
                found |= value.names() | _places(target)
            case Augmented(target=target, value=value):
                found |= target.names() | value.names()
            case Do(value=value) | While(test=value) | If(test=value) | For(over=value):
                found |= value.names()
            case Return(value=value) if value is not None:
                found |= value.names()
    return found


def _places(target: Tree) -> frozenset[str]:
    """Names that say where a value is put."""
    if isinstance(target, Several):
        return frozenset().union(*map(_places, target.inner))
    return target.names() if isinstance(target, Subscript) else frozenset()


def _entangled(targets: Sequence[Tree], values: Sequence[Tree]) -> bool:
    """Whether a value reads what an earlier one of the same assignment has changed."""
    changed: set[str] = set()
    for target, value in zip(targets, values, strict=True):
        if changed & value.names():
            return True
        changed |= (target.of if isinstance(target, Subscript) else target).names()
    return False
