"""The body of one function as instructions of LLVM."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from pmmkit.syntax.llvm.expression import LlvmWriter
from pmmkit.syntax.llvm.kinds import (
    INT,
    NOTHING,
    Kind,
    LlvmLibrary,
    Value,
    constant,
    joined,
    together,
    variable,
)
from pmmkit.syntax.tree import (
    Assign,
    Augmented,
    Call,
    Do,
    Expression,
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

_LONG: Final = 8
"""Passes from which on a loop is one over lanes, which are to become vectors."""


class LlvmBody:
    """Instructions of a function, and the kind of what it returns.

    They are written again until the kinds of all names are known: a name may stand for a whole
    number at first and for a fraction later.

    `program`: that holds the functions that this one calls. `given`: kinds of its arguments in
    their order. `outside`: names of its module.
    """

    def __init__(
        self,
        program: LlvmLibrary,
        tree: Function,
        given: Sequence[Kind],
        outside: Mapping[str, Any],
    ) -> None:
        self.returned = NOTHING
        self._program = program
        self._kinds = dict(zip(tree.arguments, given, strict=True))
        self._leave: list[dict[str, str]] = []
        before: Any = None
        while before != (self._kinds, self.returned):
            before = dict(self._kinds), self.returned
            self._write = LlvmWriter(program, self._kinds, outside)
            self._block(tree.body)
        taken = []
        for place, (name, kind) in enumerate(zip(tree.arguments, given, strict=True)):
            if self._kinds[name].llvm != kind.llvm:
                raise Unwritable("an argument that becomes a fraction")
            taken.append(f"store {kind.llvm} %a{place}, ptr {variable(name)}")
        room = [f"{variable(name)} = alloca {kind.llvm}" for name, kind in self._kinds.items()]
        end = "ret void" if self.returned == NOTHING else "unreachable"
        self.lines = ["begin:", *room, *self._write.room, *taken, *self._write.lines, end]

    def _block(self, block: Sequence[Statement]) -> None:
        for item in block:
            self._statement(item)

    def _statement(self, node: Statement) -> None:
        write = self._write
        match node:
            case Leave(word="pass"):
                pass
            case Leave(word=word):
                write.leave(f"br label %{self._leave[-1][word]}")
            case Do(value=Call() as call):
                write.of(call)
            case Assign(target=target, value=value):
                self._assigned(target, value)
            case Augmented(target=target, sign=sign, value=value):
                self._changed(target, sign, value)
            case If(test=test, yes=yes, no=no):
                self._branches(write.truth(test), yes, no)
            case While(test=test, body=body, otherwise=no):
                head, inside, other, after = write.labels("head", "inside", "other", "after")
                write.go(head)
                write.begin(head)
                write.branch(write.truth(test), inside, other)
                write.begin(inside)
                self._inside(body, again=head, after=after)
                write.go(head)
                self._otherwise(other, no, after)
            case For(
                target=Name(word=word),
                over=Call(function=Name(word="range"), inner=limits, named=()),
                body=body,
                otherwise=no,
            ):
                self._range(word, limits, body, no)
            case Return(value=None):
                write.leave("ret void")
            case Return(value=value) if value is not None:
                self._return(value)
            case _:
                kind = node.kind if isinstance(node, Stray) else type(node).__name__
                raise Unwritable(f"a statement that is not written ({kind})")

    def _branches(self, test: Value, yes: Sequence[Statement], no: Sequence[Statement]) -> None:
        write = self._write
        if test.known is not None:
            self._block(yes if test.known else no)
            return
        then, other, after = write.labels("then", "other", "after")
        write.branch(test, then, other)
        for label, block in ((then, yes), (other, no)):
            write.begin(label)
            self._block(block)
            write.go(after)
        write.begin(after)

    def _inside(self, body: Sequence[Statement], *, again: str, after: str) -> None:
        """What stands in a loop."""
        self._leave.append({"continue": again, "break": after})
        self._block(body)
        self._leave.pop()

    def _otherwise(self, label: str, no: Sequence[Statement], after: str) -> None:
        """What is done where a loop ends by itself."""
        self._write.begin(label)
        self._block(no)
        self._write.go(after)
        self._write.begin(after)

    def _range(
        self,
        word: str,
        limits: Sequence[Expression],
        body: Sequence[Statement],
        no: Sequence[Statement],
    ) -> None:
        write = self._write
        ends = [write.number(item) for item in limits]
        if any(item.kind != INT for item in ends):
            raise Unwritable("a loop over something else than whole numbers")
        first, last = ends[:2] if len(ends) > 1 else (constant(0), ends[0])
        step = ends[2].known if len(ends) > 2 else 1
        if not step:
            raise Unwritable("a loop whose step is not known beforehand")
        head, inside, again, other, after = write.labels(
            "head", "inside", "again", "other", "after"
        )
        at = f"%at.{head}"
        write.room.append(f"{at} = alloca i64")
        write.store(first, at)
        write.go(head)
        write.begin(head)
        now = write.load(at, INT)
        goes_on = write.new(f"icmp {'slt' if step > 0 else 'sgt'} i64 {now.text}, {last.text}")
        write.lines.append(f"br i1 {goes_on}, label %{inside}, label %{other}")
        write.begin(inside)
        write.put(word, now)
        self._inside(body, again=again, after=after)
        write.go(again)
        write.begin(again)
        write.store(write.operation("+", now, constant(step)), at)
        passes = write.operation("-", last, first).known or 0
        mark = self._program.long_loop() if passes // step >= _LONG else ""
        write.lines.append(f"br label %{head}{mark}")
        self._otherwise(other, no, after)

    def _return(self, value: Expression) -> None:
        write = self._write
        if isinstance(value, Several) and len(value.inner) > 1:
            items = [write.number(item) for item in value.inner]
            self._returns(together(item.kind for item in items))
            text = "poison"
            for place, (item, kind) in enumerate(zip(items, self.returned.inner, strict=True)):
                own = write.cast(item, kind)
                text = write.new(
                    f"insertvalue {self.returned.llvm} {text}, {kind.llvm} {own.text}, {place}"
                )
        else:
            found = write.number(value.inner[0] if isinstance(value, Several) else value)
            self._returns(found.kind)
            text = write.cast(found, self.returned).text
        write.leave(f"ret {self.returned.llvm} {text}")

    def _returns(self, kind: Kind) -> None:
        self.returned = kind if self.returned == NOTHING else joined(self.returned, kind)

    def _assigned(self, target: Expression, value: Expression) -> None:
        if not isinstance(target, Several):
            self._put(target, self._write.of(value))
            return
        if isinstance(value, Several):
            items = [self._write.of(item) for item in value.inner]
        else:
            items = self._write.apart(self._write.of(value))
        if len(items) != len(target.inner):
            raise Unwritable("values that are not as many as their names")
        for place, item in zip(target.inner, items, strict=True):
            self._put(place, item)

    def _put(self, target: Expression, value: Value) -> None:
        if isinstance(target, Name):
            self._write.put(target.word, value)
        else:
            place, kind = self._place(target)
            self._write.store(self._write.cast(value, kind), place)

    def _changed(self, target: Expression, sign: str, value: Expression) -> None:
        write = self._write
        if isinstance(target, Name):
            write.put(target.word, write.operation(sign, write.of(target), write.number(value)))
        else:
            place, kind = self._place(target)
            found = write.operation(sign, write.load(place, kind), write.number(value))
            write.store(write.cast(found, kind), place)

    def _place(self, target: Expression) -> tuple[str, Kind]:
        if isinstance(target, Subscript):
            place, kind = self._write.address(self._write.of(target.of), target.at)
            if kind.is_number:
                return place, kind
        raise Unwritable("a value put where there is no place for it")
