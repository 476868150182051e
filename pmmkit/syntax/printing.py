"""Syntax trees as the text of Python, and what is common to writing them in other languages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pmmkit.syntax.tree import (
    Assign,
    Augmented,
    Binary,
    Call,
    Compare,
    Conditional,
    Do,
    Expression,
    For,
    Function,
    If,
    Leave,
    Logic,
    Member,
    Name,
    Number,
    Return,
    Several,
    Span,
    Statement,
    Subscript,
    Unary,
    Unwritable,
    While,
)
from pmmkit.syntax.words import ATOM, CHOICE, COMPARISON, NOT, OPERATORS, POWER, SIGN, SUM


@dataclass(frozen=True)
class Printed:
    """The text of an expression with its rank among the operators."""

    text: str
    rank: int = ATOM

    def within(self, rank: int) -> str:
        """The text as an operand."""
        return self.text if self.rank >= rank else f"({self.text})"

    def behind(self, rank: int) -> str:
        """The text as the operand behind a mark: in brackets where it starts with a sign."""
        return f"({self.text})" if self.text.startswith(("-", "+")) else self.within(rank)


class PythonPrinter:
    """Prints expressions as Python takes them; other languages change what differs."""

    def text(self, tree: Expression) -> str:
        """An expression."""
        return self.printed(tree).text

    def printed(self, tree: Expression) -> Printed:
        """An expression with its rank."""
        match tree:
            case Number(value=value):
                text = self.number(value)
                return Printed(text, SIGN if text.startswith("-") else ATOM)
            case Name(word=word):
                return Printed(word)
            case Unary(sign=sign, inner=inner):
                return self.unary(sign, self.printed(inner))
            case Binary(sign=sign, left=left, right=right):
                return self.binary(sign, self.printed(left), self.printed(right))
            case Logic(sign=sign, inner=inner):
                rank = OPERATORS[sign].rank
                parts = [self.printed(item).within(rank + 1) for item in inner]
                return Printed(self.mark(sign).join(parts), rank)
            case Compare(signs=signs, inner=inner):
                return self.comparison(signs, [self.printed(x).within(SUM) for x in inner])
            case Conditional(test=test, yes=yes, no=no):
                return self.choice(self.printed(test), self.printed(yes), self.printed(no))
            case Subscript(of=of, at=at):
                return self.item(of, at)
            case Call():
                return Printed(self.call(tree))
        return Printed(self.other(tree))

    def mark(self, sign: str) -> str:
        """An operator between two operands."""
        return f" {sign} "

    def number(self, value: float) -> str:
        """A number, with the fewest digits that give it again."""
        return repr(value).replace("inf", "1e309")

    def unary(self, sign: str, inner: Printed) -> Printed:
        """A sign before an operand."""
        if sign == "not":
            return Printed(f"not {inner.within(NOT)}", NOT)
        return Printed(f"{sign}{inner.within(SIGN)}", SIGN)

    def binary(self, sign: str, left: Printed, right: Printed) -> Printed:
        """Two operands; of equal ranks Python begins on the left, with powers on the right."""
        rank = OPERATORS[sign].rank
        if rank == POWER:
            return Printed(f"{left.within(ATOM)} ** {right.within(SIGN)}", POWER)
        return Printed(f"{left.within(rank)}{self.mark(sign)}{right.within(rank + 1)}", rank)

    def comparison(self, signs: Sequence[str], operands: Sequence[str]) -> Printed:
        """Operands in a chain."""
        more = zip(signs, operands[1:], strict=True)
        text = operands[0] + "".join(f"{self.mark(sign)}{operand}" for sign, operand in more)
        return Printed(text, COMPARISON)

    def choice(self, test: Printed, yes: Printed, no: Printed) -> Printed:
        """One of two values."""
        parts = yes.within(CHOICE + 1), test.within(CHOICE + 1), no.within(CHOICE)
        return Printed("{} if {} else {}".format(*parts), CHOICE)

    def item(self, of: Expression, at: Expression) -> Printed:
        """A place of a list."""
        inner = at.inner if isinstance(at, Several) and len(at.inner) > 1 else (at,)
        return Printed(f"{self.printed(of).within(ATOM)}[{', '.join(map(self.text, inner))}]")

    def call(self, tree: Call) -> str:
        """A function of arguments."""
        named = [f"{word}={self.text(value)}" for word, value in tree.named]
        inside = ", ".join([*map(self.text, tree.inner), *named])
        return f"{self.printed(tree.function).within(ATOM)}({inside})"

    def other(self, tree: Expression) -> str:
        """What only Python has words for."""
        match tree:
            case Member(of=of, word=word):
                return f"{self.printed(of).within(ATOM)}.{word}"
            case Span(low=low, high=high):
                ends = ("" if end is None else self.text(end) for end in (low, high))
                return ":".join(ends)
            case Several(inner=inner):
                return f"({', '.join(map(self.text, inner))}{',' * (len(inner) == 1)})"
        raise Unwritable("an expression that Python is not written for")


_PYTHON = PythonPrinter()


def python_lines(tree: Function | Sequence[Statement], *, mark: str = "") -> list[str]:
    """Statements, or a function without its docstring, as lines of Python.

    Parameters
    ----------
    tree : Function or sequence of Statement
        What is printed.
    mark : str
        What decorates a function.

    Returns
    -------
    list of str

    Raises
    ------
    Unwritable
        If a statement is `Stray`.

    Examples
    --------
    >>> from pmmkit.syntax import statements
    >>> python_lines(statements("y = (-x)**2 - (a - (b*c))"))
    ['y = (-x) ** 2 - (a - b * c)']
    """
    if not isinstance(tree, Function):
        return [line for item in tree for line in _statement(item)]
    usual = dict(tree.defaults)
    given = [f"{x}={_PYTHON.text(usual[x])}" if x in usual else x for x in tree.arguments]
    head = f"def {tree.name}({', '.join(given)}):"
    return [*([f"@{mark}"] if mark else []), head, *_within(tree.body)]


def _within(block: Sequence[Statement]) -> list[str]:
    return [f"    {line}" for line in python_lines(block)] or ["    pass"]


def _statement(node: Statement) -> list[str]:
    text = _PYTHON.text
    match node:
        case Assign(target=target, value=value):
            return [f"{_open(target)} = {_open(value)}"]
        case Augmented(target=target, sign=sign, value=value):
            return [f"{text(target)} {sign}= {text(value)}"]
        case Do(value=value):
            return [text(value)]
        case If(test=test, yes=yes, no=no):
            behind = ["else:", *_within(no)] if no else []
            return [f"if {text(test)}:", *_within(yes), *behind]
        case While(test=test, body=body, otherwise=no):
            behind = ["else:", *_within(no)] if no else []
            return [f"while {text(test)}:", *_within(body), *behind]
        case For(target=target, over=over, body=body, otherwise=no):
            behind = ["else:", *_within(no)] if no else []
            return [f"for {_open(target)} in {text(over)}:", *_within(body), *behind]
        case Leave(word=word):
            return [word]
        case Return(value=None):
            return ["return"]
        case Return(value=value) if value is not None:
            return [f"return {_open(value)}"]
    raise Unwritable("a statement that Python is not written for")


def _open(tree: Expression) -> str:
    """Values together without brackets, where Python needs none."""
    if isinstance(tree, Several) and len(tree.inner) > 1:
        return ", ".join(map(_PYTHON.text, tree.inner))
    return _PYTHON.text(tree)
