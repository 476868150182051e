"""Python's text as syntax trees."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable
from functools import lru_cache
from types import FunctionType
from typing import Any, Final

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
    Stray,
    Subscript,
    Unary,
    Unwritable,
    While,
)

_BINARY: Final = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.MatMult: "@",
    ast.Pow: "**",
}
_UNARY: Final = {ast.USub: "-", ast.UAdd: "+", ast.Not: "not"}
_COMPARED: Final = {
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
}


def expression(text: str) -> Expression:
    """The tree of an expression.

    Parameters
    ----------
    text : str
        In Python's words.

    Returns
    -------
    Expression

    Examples
    --------
    >>> expression("x**2")
    Binary(sign='**', left=Name(word='x'), right=Number(value=2))
    """
    return _value(ast.parse(text, mode="eval").body)


def statements(text: str) -> tuple[Statement, ...]:
    """The trees of statements, one below the other.

    Parameters
    ----------
    text : str
        In Python's words.

    Returns
    -------
    tuple of Statement

    Examples
    --------
    >>> statements("y += 1")
    (Augmented(target=Name(word='y'), sign='+', value=Number(value=1)),)
    """
    return _block(ast.parse(text).body)


def functions(text: str) -> dict[str, Function]:
    """The functions of a module by their names.

    Parameters
    ----------
    text : str
        Of the module.

    Returns
    -------
    dict of str to Function
    """
    return {
        node.name: _function(node)
        for node in ast.parse(text).body
        if isinstance(node, ast.FunctionDef)
    }


@lru_cache(maxsize=512)
def function_of(function: Callable[..., Any]) -> Function:
    """The tree of a function whose text is kept in a file.

    Examples
    --------
    >>> function_of(textwrap.dedent).arguments
    ('text',)
    """
    try:
        (node,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    except (OSError, TypeError, SyntaxError, ValueError) as error:
        raise Unwritable("a function whose source text is not there") from error
    inside = isinstance(function, FunctionType) and function.__closure__
    if not isinstance(node, ast.FunctionDef) or inside:
        raise Unwritable("a function inside another")
    return _function(node)


def _function(node: ast.FunctionDef) -> Function:
    told = ast.get_docstring(node)
    given = [*node.args.posonlyargs, *node.args.args]
    late = node.args.defaults
    return Function(
        name=node.name,
        arguments=tuple(item.arg for item in given),
        body=_block(node.body if told is None else node.body[1:]),
        defaults=tuple(
            (item.arg, _value(value))
            for item, value in zip(given[len(given) - len(late) :], late, strict=True)
        ),
        told=told or "",
        plain=not (node.args.kwonlyargs or node.args.vararg or node.args.kwarg),
    )


def _block(block: list[ast.stmt]) -> tuple[Statement, ...]:
    return tuple(_statement(node) for node in block)


def _statement(node: ast.stmt) -> Statement:
    match node:
        case ast.Assign(targets=[target], value=value):
            return Assign(_value(target), _value(value))
        case ast.AnnAssign(target=target, value=ast.expr() as value):
            return Assign(_value(target), _value(value))
        case ast.AugAssign(target=target, op=op, value=value) if type(op) in _BINARY:
            return Augmented(_value(target), _BINARY[type(op)], _value(value))
        case ast.Expr(value=ast.Constant()) | ast.Pass():
            return Leave("pass")
        case ast.Expr(value=value):
            return Do(_value(value))
        case ast.If(test=test, body=yes, orelse=no):
            return If(_value(test), _block(yes), _block(no))
        case ast.While(test=test, body=body, orelse=no):
            return While(_value(test), _block(body), _block(no))
        case ast.For(target=target, iter=over, body=body, orelse=no):
            return For(_value(target), _value(over), _block(body), _block(no))
        case ast.Break():
            return Leave("break")
        case ast.Continue():
            return Leave("continue")
        case ast.Return(value=None):
            return Return(None)
        case ast.Return(value=ast.expr() as value):
            return Return(_value(value))
    return Stray(type(node).__name__)


def _values(items: list[ast.expr]) -> tuple[Expression, ...]:
    return tuple(_value(item) for item in items)


def _value(node: ast.expr) -> Expression:
    match node:
        case ast.Constant(value=bool() | int() | float() as value):
            return Number(value)
        case ast.Name(id=word):
            return Name(word)
        case ast.Attribute(value=value, attr=word):
            return Member(_value(value), word)
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _UNARY:
            return Unary(_UNARY[type(op)], _value(operand))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            return Binary(_BINARY[type(op)], _value(left), _value(right))
        case ast.BoolOp(op=op, values=values):
            return Logic("and" if isinstance(op, ast.And) else "or", _values(values))
        case ast.Compare(left=left, ops=ops, comparators=others):
            if all(type(op) in _COMPARED for op in ops):
                return Compare(tuple(_COMPARED[type(op)] for op in ops), _values([left, *others]))
        case ast.IfExp(test=test, body=yes, orelse=no):
            return Conditional(_value(test), _value(yes), _value(no))
        case ast.Subscript(value=value, slice=at):
            return Subscript(_value(value), _value(at))
        case ast.Slice(lower=low, upper=high, step=None):
            low_end, high_end = (None if end is None else _value(end) for end in (low, high))
            return Span(low_end, high_end)
        case ast.Tuple(elts=items):
            return Several(_values(items))
        case ast.Call(func=func, args=given, keywords=keywords):
            if all(item.arg is not None for item in keywords):
                named = tuple((str(item.arg), _value(item.value)) for item in keywords)
                return Call(_value(func), _values(given), named)
    return Stray(type(node).__name__)
