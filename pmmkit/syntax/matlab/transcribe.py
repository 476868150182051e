"""Functions written out for MATLAB, line by line and without branches.

Effects are written in the few words of `effects.primitives`. With the options of a model known,
what is left of most of them is a list of assignments: functions that they call are written out in
place, branches on options are decided, every intermediate result has a name of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import FunctionType
from typing import Any, Final

from pmmkit.syntax.matlab.names import matlab_value
from pmmkit.syntax.printing import Printed, PythonPrinter
from pmmkit.syntax.reading import expression, function_of
from pmmkit.syntax.tree import (
    Assign,
    Augmented,
    Binary,
    Call,
    Compare,
    Conditional,
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
    Statement,
    Subscript,
    Unary,
    Unwritable,
    While,
)
from pmmkit.syntax.words import (
    AND,
    ATOM,
    COMPARISON,
    FUNCTIONS,
    OPERATORS,
    POWER,
    SIGN,
    Outside,
    bound,
    called,
    counted,
    outside_value,
    word_of,
)

# Syntax trees as expressions of MATLAB.


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


@dataclass(frozen=True)
class MatlabLine:
    """One assignment, and what its comment says.

    Parameters
    ----------
    target : str
        The variable.
    meant : str, float, tuple of float or Expression
        Its value: an expression in Python's words, in which ``column(a, b)`` stands for values
        below each other, numbers, or a tree.
    note : str
        What its comment says.

    Examples
    --------
    >>> line = MatlabLine("U", "max(sqrt(u**2 + v**2), 1e-9)")
    >>> line.text, line.uses == {"max", "sqrt", "u", "v"}
    ('U = max(sqrt(u^2 + v^2), 1e-09);', True)
    """

    target: str
    meant: str | float | tuple[float, ...] | Expression
    note: str = ""

    @cached_property
    def value(self) -> Expression:
        """The value as a tree."""
        match self.meant:
            case str():
                return expression(self.meant)
            case tuple():
                return Several(tuple(Number(float(x)) for x in self.meant))
            case int() | float():
                return Number(float(self.meant))
        return self.meant

    @property
    def uses(self) -> frozenset[str]:
        """Names in the expression."""
        return self.value.names()

    @property
    def text(self) -> str:
        """The assignment as MATLAB takes it."""
        return f"{self.target} = {printed(self.value)};"


def transcribe(
    function: Callable[..., Any],
    arguments: Mapping[str, str | int],
    prefix: str,
    *,
    tree: Function | None = None,
) -> tuple[list[MatlabLine], list[Expression]]:
    """The assignments of a function, and expressions of what it returns.

    Parameters
    ----------
    function : callable
        In the words that C and MATLAB share with Python.
    arguments : mapping of str to str or int
        What each argument stands for: a variable, or a number that decides branches.
    prefix : str
        What names of variables begin with.
    tree : Function, optional
        The function as a tree, where its text is in no file.

    Returns
    -------
    lines : list of MatlabLine
    returned : list of Expression

    Raises
    ------
    Unwritable
        If MATLAB has no words for it, or a branch depends on a variable.

    Examples
    --------
    >>> from pmmkit.effects.roll import force
    >>> given = {name: name for name in function_of(force).arguments}
    >>> lines, (moment,) = transcribe(force, given | {"restoring": 1}, "roll")
    >>> [line.text for line in lines], MatlabLine("K", moment).text
    (['roll_heel = sin(phi);'],
     'K = -rho*g*volume*GM*roll_heel - (damping + damping_quadratic*abs(p))*p;')
    """
    writer = _Writer(prefix, {name for name in arguments.values() if isinstance(name, str)})
    given = {
        name: Name(value) if isinstance(value, str) else Number(value)
        for name, value in arguments.items()
    }
    returned = writer.run(function, tree or function_of(function), given)
    return writer.lines, returned


Known = dict[str, Expression]
"""What the variables of a function stand for: names, and numbers that are known."""
_NO_EQUIVALENT: Final = "an expression without an equivalent"


class _Writer:
    """Writes functions out one after the other; each variable is assigned once."""

    def __init__(self, prefix: str, taken: Iterable[str]) -> None:
        self.prefix = prefix
        self.taken = set(taken)
        self.lines: list[MatlabLine] = []

    def run(
        self, function: Callable[..., Any], tree: Function, given: Mapping[str, Expression]
    ) -> list[Expression]:
        """Write the body of a function; gives what it returns."""
        assert isinstance(function, FunctionType)
        returned = self._block(tree.body, dict(given), function.__globals__)
        if returned is None:
            raise Unwritable("a function that returns nothing")
        return returned

    def _block(
        self, block: Sequence[Statement], known: Known, outside: Outside
    ) -> list[Expression] | None:
        for statement in block:
            match statement:
                case Leave(word="pass"):
                    pass
                case Assign(target=Name(word=word), value=value):
                    self._assign(known, word, self._value(value, known, outside))
                case Assign(target=Several(inner=targets), value=value):
                    values = self._values(value, known, outside)
                    if len(values) != len(targets):
                        raise Unwritable("values that are not as many as their names")
                    for target, item in zip(targets, values, strict=True):
                        if not isinstance(target, Name):
                            raise Unwritable("a value put into a list")
                        self._assign(known, target.word, item)
                case Augmented(target=Name(word=word) as target, sign=sign, value=value):
                    whole = Binary(sign, target, value)
                    self._assign(known, word, self._value(whole, known, outside))
                case If(test=test, yes=yes, no=no):
                    chosen = yes if self._decided(test, known, outside) else no
                    returned = self._block(chosen, known, outside)
                    if returned is not None:
                        return returned
                case Return(value=value) if value is not None:
                    return self._values(value, known, outside)
                case For() | While():
                    raise Unwritable("a loop")
                case _:
                    raise Unwritable("a statement that has no equivalent")
        return None

    def _assign(self, known: Known, word: str, value: Expression) -> None:
        if isinstance(value, Name | Number):
            known[word] = value
            return
        base = target = f"{self.prefix}_{word.strip('_')}".strip("_")
        count = 1
        while target in self.taken:
            count += 1
            target = f"{base}_{count}"
        self.taken.add(target)
        self.lines.append(MatlabLine(target, value))
        known[word] = Name(target)

    def _values(self, tree: Expression, known: Known, outside: Outside) -> list[Expression]:
        """The values of a tuple, of a call, or of a single expression."""
        if isinstance(tree, Several):
            return [self._value(item, known, outside) for item in tree.inner]
        if isinstance(tree, Call):
            return self._call(tree, known, outside)
        return [self._value(tree, known, outside)]

    def _value(self, tree: Expression, known: Known, outside: Outside) -> Expression:
        match tree:
            case Number(value=value):
                return Number(float(value))
            case Name(word=word) if word in known:
                return known[word]
            case Name() | Member():
                found = outside_value(tree, outside)
                if found is math.pi:
                    return Name("pi")
                if isinstance(found, int | float):
                    return Number(float(found))
            case Unary(sign=sign, inner=inner):
                operand = self._value(inner, known, outside)
                if sign == "not" and isinstance(operand, Number):
                    return Number(float(not operand.value))
                return Unary(sign, operand)
            case Binary(sign=sign, left=left, right=right) if OPERATORS[sign].matlab:
                first = self._value(left, known, outside)
                return Binary(sign, first, self._value(right, known, outside))
            case Compare(signs=signs, inner=inner):
                return _compared(signs, [self._value(item, known, outside) for item in inner])
            case Logic(sign=sign, inner=inner):
                return self._joined(sign, inner, known, outside)
            case Conditional(test=test, yes=yes, no=no):
                asked = self._value(test, known, outside)
                if isinstance(asked, Number):
                    return self._value(yes if asked.value else no, known, outside)
                values = (self._value(item, known, outside) for item in (yes, no))
                return Call(Name("where"), (asked, *values))
            case Subscript(of=Name(word=word), at=Number() as place):
                if isinstance(known.get(word), Name):
                    return Subscript(known[word], place)
                raise Unwritable("a table of its own")
            case Subscript():
                raise Unwritable("a table of its own")
            case Call():
                found = self._call(tree, known, outside)
                if len(found) == 1:
                    return found[0]
        raise Unwritable(_NO_EQUIVALENT)

    def _joined(
        self, sign: str, inner: Sequence[Expression], known: Known, outside: Outside
    ) -> Expression:
        """What is joined by a word, without what is known."""
        settles = sign == "or"
        open_ones: list[Expression] = []
        for item in inner:
            value = self._value(item, known, outside)
            if not isinstance(value, Number):
                open_ones.append(value)
            elif bool(value.value) == settles:
                if not open_ones:
                    return Number(float(settles))
                open_ones.append(value)
                break
        if len(open_ones) > 1:
            return Logic(sign, tuple(open_ones))
        return open_ones[0] if open_ones else Number(float(not settles))

    def _decided(self, test: Expression, known: Known, outside: Outside) -> bool:
        decided = self._value(test, known, outside)
        if not isinstance(decided, Number):
            raise Unwritable("a branch that depends on the motion")
        return bool(decided.value)

    def _call(self, tree: Call, known: Known, outside: Outside) -> list[Expression]:
        name, function = called(tree, outside)
        word = word_of(function)
        if word is not None and FUNCTIONS[word].matlab:
            given = tuple(self._value(item, known, outside) for item in tree.inner)
            if tree.named or not counted(word, len(given)):
                raise Unwritable(f"the function {name} with other arguments than it takes here")
            return [Call(Name(word), given)]
        if not isinstance(function, FunctionType):
            raise Unwritable(f"the function {name}, which has no equivalent")
        own = function_of(function)
        values = zip(own.arguments, bound(own, function, tree), strict=True)
        given_to: Known = {}
        for argument, value in values:
            self._assign(given_to, argument, self._value(value, known, outside))
        return self.run(function, own, given_to)


def _compared(signs: tuple[str, ...], operands: Sequence[Expression]) -> Expression:
    """A chain of comparisons, decided where all is known."""
    values = [item.value for item in operands if isinstance(item, Number)]
    if len(values) < len(operands):
        return Compare(signs, tuple(operands))
    links = zip(signs, values[:-1], values[1:], strict=True)
    return Number(float(all(OPERATORS[sign].compute(a, b) for sign, a, b in links)))
