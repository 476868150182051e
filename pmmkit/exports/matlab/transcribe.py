"""The function of an effect written out for MATLAB, line by line and without branches.

Effects are written in the few words of `effects.primitives`. With the options of a model known,
what is left of most of them is a list of assignments: functions that they call are written out in
place, branches on options are decided, every intermediate result has a name of its own.
"""

from __future__ import annotations

import ast
import inspect
import math
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import FunctionType
from typing import Any, Final

from pmmkit.effects import primitives
from pmmkit.exports.text import number

_SUM, _PRODUCT, _ATOM = 1, 2, 3
_OPERATORS: Final[Mapping[type[ast.operator], tuple[str, int]]] = {
    ast.Add: (" + ", _SUM),
    ast.Sub: (" - ", _SUM),
    ast.Mult: ("*", _PRODUCT),
    ast.Div: ("/", _PRODUCT),
}
_COMPARISONS: Final[Mapping[type[ast.cmpop], tuple[str, Callable[[Any, Any], bool]]]] = {
    ast.Eq: ("==", lambda a, b: a == b),
    ast.NotEq: ("~=", lambda a, b: a != b),
    ast.Lt: ("<", lambda a, b: a < b),
    ast.LtE: ("<=", lambda a, b: a <= b),
    ast.Gt: (">", lambda a, b: a > b),
    ast.GtE: (">=", lambda a, b: a >= b),
}
_FUNCTIONS: Final[Mapping[Any, str]] = {
    math.atan2: "atan2",
    math.cos: "cos",
    math.exp: "exp",
    math.fabs: "abs",
    math.sin: "sin",
    math.sqrt: "sqrt",
    math.tanh: "tanh",
    primitives.maximum: "max",
    primitives.minimum: "min",
    primitives.where: "where",
    primitives.interpolate: "interpolate",
    primitives.interpolate_rows: "interpolate_rows",
}
_WORD: Final = re.compile(r"(?<![\w.])[A-Za-z]\w*")


class Unwritable(Exception):
    """What an effect does that a list of assignments cannot say."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """One assignment, and what its comment says."""

    target: str
    text: str
    note: str = ""

    @property
    def uses(self) -> frozenset[str]:
        """Names in the expression."""
        return frozenset(_WORD.findall(self.text))


@dataclass(frozen=True, kw_only=True)
class _Value:
    """An expression with its rank among the operators, and its number where it is known."""

    text: str
    rank: int = _ATOM
    known: float | None = None

    def within(self, rank: int) -> str:
        return self.text if self.rank >= rank else f"({self.text})"


def transcribe(
    function: Callable[..., Any], arguments: Mapping[str, str | int], prefix: str
) -> tuple[list[Line], list[str]]:
    """The assignments of a function, and expressions of what it returns.

    Parameters
    ----------
    function : callable
        The `force` of an effect.
    arguments : mapping
        For each of its arguments the name of a variable, or the index of an option.
    prefix : str
        What the names of its own variables start with.

    Returns
    -------
    list of Line, list of str

    Raises
    ------
    Unwritable
        If it holds a loop, a table of its own or a branch that depends on the motion.

    Examples
    --------
    >>> from pmmkit.effects.roll import force
    >>> names = {name: name for name in inspect.signature(force).parameters}
    >>> lines, (moment,) = transcribe(force, names | {"restoring": 1}, "roll")
    >>> [(line.target, line.text) for line in lines], moment
    ([('roll_heel', 'sin(phi)')],
     '-rho*g*volume*GM*roll_heel - (damping + damping_quadratic*abs(p))*p')
    """
    writer = _Writer(prefix, {name for name in arguments.values() if isinstance(name, str)})
    bound = {
        name: _Value(text=value) if isinstance(value, str) else _constant(value)
        for name, value in arguments.items()
    }
    returned = writer.run(function, bound)
    return writer.lines, [value.text for value in returned]


def needed(lines: Sequence[Line], wanted: Iterable[str]) -> list[Line]:
    """The assignments on which some variables depend, in their order."""
    alive, kept = set(wanted), []
    for line in reversed(lines):
        if line.target in alive:
            alive.discard(line.target)
            alive |= line.uses
            kept.append(line)
    return kept[::-1]


def _constant(value: float) -> _Value:
    return _Value(text=number(value), known=value)


def _apart(text: str) -> str:
    """An operand that starts with a sign in brackets; two signs in a row mean something else."""
    return f"({text})" if text.startswith("-") else text


class _Writer:
    """Writes functions out one after the other; each variable is assigned once."""

    def __init__(self, prefix: str, taken: Iterable[str]) -> None:
        self.prefix = prefix
        self.taken = set(taken)
        self.lines: list[Line] = []

    def run(self, function: Callable[..., Any], bound: Mapping[str, _Value]) -> list[_Value]:
        """Write the body of a function; gives what it returns."""
        assert isinstance(function, FunctionType)
        body = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        assert isinstance(body, ast.FunctionDef)
        returned = self._block(body.body, dict(bound), function.__globals__)
        assert returned is not None
        return returned

    def _block(
        self, block: Sequence[ast.stmt], known: dict[str, _Value], outside: Mapping[str, Any]
    ) -> list[_Value] | None:
        for statement in block:
            match statement:
                case ast.Expr(value=ast.Constant()):
                    pass
                case ast.Assign(targets=[ast.Name(id=name)], value=value):
                    self._assign(known, name, self._value(value, known, outside))
                case ast.Assign(targets=[ast.Tuple(elts=targets)], value=value):
                    values = self._values(value, known, outside)
                    for target, item in zip(targets, values, strict=True):
                        assert isinstance(target, ast.Name)
                        self._assign(known, target.id, item)
                case ast.AugAssign(target=ast.Name(id=name) as old, op=op, value=value):
                    whole = ast.BinOp(ast.Name(old.id, ast.Load()), op, value)
                    self._assign(known, name, self._value(whole, known, outside))
                case ast.If(test=test, body=yes, orelse=no):
                    chosen = yes if self._decided(test, known, outside) else no
                    returned = self._block(chosen, known, outside)
                    if returned is not None:
                        return returned
                case ast.Return(value=ast.expr() as value):
                    return self._values(value, known, outside)
                case ast.For():
                    raise Unwritable("a loop")
                case _:
                    raise Unwritable("a statement that has no equivalent")
        return None

    def _assign(self, known: dict[str, _Value], name: str, value: _Value) -> None:
        if value.text.isidentifier() or value.known is not None:
            known[name] = value
            return
        base = target = f"{self.prefix}_{name.strip('_')}".strip("_")
        count = 1
        while target in self.taken:
            count += 1
            target = f"{base}_{count}"
        self.taken.add(target)
        self.lines.append(Line(target=target, text=value.text))
        known[name] = _Value(text=target)

    def _values(
        self, node: ast.expr, known: dict[str, _Value], outside: Mapping[str, Any]
    ) -> list[_Value]:
        """The values of a tuple, of a call, or of a single expression."""
        if isinstance(node, ast.Tuple):
            return [self._value(item, known, outside) for item in node.elts]
        if isinstance(node, ast.Call):
            return self._call(node, known, outside)
        return [self._value(node, known, outside)]

    def _value(
        self, node: ast.expr, known: dict[str, _Value], outside: Mapping[str, Any]
    ) -> _Value:
        match node:
            case ast.Constant(value=int() | float() as value):
                return _constant(value)
            case ast.Name(id=name) if name in known:
                return known[name]
            case ast.Name(id=name) if outside.get(name) is math.pi:
                return _Value(text="pi")
            case ast.Name(id=name) if isinstance(outside.get(name), int | float):
                return _constant(outside[name])
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self._value(operand, known, outside)
                return _Value(text=f"-{_apart(inner.within(_PRODUCT))}", rank=_PRODUCT)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
                sign, rank = _OPERATORS[type(op)]
                first = self._value(left, known, outside).within(rank)
                second = _apart(self._value(right, known, outside).within(rank + 1))
                return _Value(text=f"{first}{sign}{second}", rank=rank)
            case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _COMPARISONS:
                sign, decide = _COMPARISONS[type(op)]
                a, b = self._value(left, known, outside), self._value(right, known, outside)
                decided = None
                if a.known is not None and b.known is not None:
                    decided = float(decide(a.known, b.known))
                return _Value(text=f"{a.text} {sign} {b.text}", rank=0, known=decided)
            case ast.IfExp(test=test, body=yes, orelse=no):
                chosen = yes if self._decided(test, known, outside) else no
                return self._value(chosen, known, outside)
            case ast.Subscript(value=ast.Name(id=name), slice=ast.Constant(value=int() as place)):
                if name in known:
                    return _Value(text=f"{known[name].text}({place + 1})")
            case ast.Call():
                (only,) = self._call(node, known, outside)
                return only
        raise Unwritable(
            "a table of its own"
            if isinstance(node, ast.Subscript)
            else "an expression without an equivalent"
        )

    def _decided(
        self, test: ast.expr, known: dict[str, _Value], outside: Mapping[str, Any]
    ) -> bool:
        decided = self._value(test, known, outside).known
        if decided is None:
            raise Unwritable("a branch that depends on the motion")
        return bool(decided)

    def _call(
        self, node: ast.Call, known: dict[str, _Value], outside: Mapping[str, Any]
    ) -> list[_Value]:
        assert isinstance(node.func, ast.Name)
        function = outside[node.func.id]
        given = [self._value(item, known, outside) for item in node.args]
        if function in _FUNCTIONS:
            inside = ", ".join(value.text for value in given)
            return [_Value(text=f"{_FUNCTIONS[function]}({inside})")]
        bound = dict(zip(inspect.signature(function).parameters, given, strict=False))
        for keyword in node.keywords:
            assert keyword.arg is not None
            bound[keyword.arg] = self._value(keyword.value, known, outside)
        for name, value in list(bound.items()):
            self._assign(bound, name, value)
        return self.run(function, bound)
