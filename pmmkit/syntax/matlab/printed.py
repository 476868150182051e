"""Syntax trees as expressions of MATLAB."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pmmkit.syntax.matlab.names import matlab_value
from pmmkit.syntax.printing import Printed, PythonPrinter
from pmmkit.syntax.tree import Call, Expression, Name, Number, Several, Unwritable
from pmmkit.syntax.words import AND, ATOM, COMPARISON, FUNCTIONS, OPERATORS, POWER, SIGN

_COLUMN: Final = "column"
"""A function of trees here: its arguments below each other, as `Several` has them in a row."""


def printed(tree: Expression) -> str:
    """An expression as MATLAB takes it.

    Examples
    --------
    >>> from pmmkit.syntax.reading import expression
    >>> printed(expression("-x[0]**2*(a - -b)/c**-y**2"))
    '-x(1)^2*(a - (-b))/c^(-y^2)'
    """
    return _MATLAB.text(tree)


class _MatlabPrinter(PythonPrinter):
    def mark(self, sign: str) -> str:
        if not OPERATORS[sign].matlab:
            raise Unwritable(f"an operator that MATLAB has not ({sign})")
        return OPERATORS[sign].matlab

    def number(self, value: float) -> str:
        whole = isinstance(value, int) and not isinstance(value, bool)
        return str(value) if whole else matlab_value(value)

    def unary(self, sign: str, inner: Printed) -> Printed:
        if sign == "+":
            return inner
        if sign == "not":
            return Printed(f"~{inner.within(ATOM)}", SIGN)
        return Printed(f"-{inner.behind(SIGN)}", SIGN)

    def binary(self, sign: str, left: Printed, right: Printed) -> Printed:
        rank = OPERATORS[sign].rank
        if rank == POWER:
            left, right = Printed(left.within(ATOM)), Printed(right.within(ATOM))
        return Printed(f"{left.within(rank)}{self.mark(sign)}{right.behind(rank + 1)}", rank)

    def comparison(self, signs: Sequence[str], operands: Sequence[str]) -> Printed:
        links = zip(operands[:-1], signs, operands[1:], strict=True)
        parts = [f"{first}{self.mark(sign)}{second}" for first, sign, second in links]
        return Printed(self.mark("and").join(parts), COMPARISON if len(parts) == 1 else AND)

    def item(self, of: Expression, at: Expression) -> Printed:
        if isinstance(of, Name) and isinstance(at, Number) and at.value >= 0:
            return Printed(f"{of.word}({int(at.value) + 1})")
        raise Unwritable("a table of its own")

    def call(self, tree: Call) -> str:
        texts = [self.text(item) for item in tree.inner]
        word = tree.function.word if isinstance(tree.function, Name) else ""
        if word == _COLUMN:
            return f"[{'; '.join(texts)}]"
        spelled = FUNCTIONS[word]
        if spelled.count:
            return f"{spelled.matlab}({', '.join(texts)})"
        text = texts[0]
        for other in texts[1:]:
            text = f"{spelled.matlab}({text}, {other})"
        return text

    def other(self, tree: Expression) -> str:
        if isinstance(tree, Several):
            return f"[{', '.join(map(self.text, tree.inner))}]"
        raise Unwritable("an expression without an equivalent")


_MATLAB: Final = _MatlabPrinter()
