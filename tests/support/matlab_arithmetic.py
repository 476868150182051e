"""Arithmetic of MATLAB, read by its own rules of precedence: an independent judge of exports.

Operators from the strongest: ``^`` (from the left, its exponent may carry a sign), unary minus and
``~``, ``* /``, ``+ -``, comparisons (from the left), ``&&``, ``||``. Division by zero gives Inf or
NaN, ``max`` and ``min`` pass over NaN. Source: MathWorks, MATLAB Language Reference, "Operator
Precedence".
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

_TOKEN: Final = re.compile(
    r"\s*((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[A-Za-z]\w*|[<>=~]=|&&|\|\||[-+*/^()<>,\[\];~])"
)
_RANKS: Final = {
    "||": 1,
    "&&": 2,
    **dict.fromkeys(("==", "~=", "<", "<=", ">", ">="), 3),
    **dict.fromkeys("+-", 4),
    **dict.fromkeys("*/", 5),
    "^": 7,
}
_SIGN: Final = 6


def _larger(a: float, b: float) -> float:
    return float(np.fmax(a, b))


def _smaller(a: float, b: float) -> float:
    return float(np.fmin(a, b))


def _interpolate(x: float, xs: Any, ys: Any) -> float:
    return float(np.interp(_larger(_smaller(x, xs[-1]), xs[0]), xs, ys))


FUNCTIONS: Final[dict[str, Callable[..., Any]]] = {
    **{name: getattr(np, name) for name in ("sqrt", "exp", "sin", "cos", "tan", "tanh", "hypot")},
    **{name: getattr(np, name) for name in ("abs", "sinh", "cosh", "floor", "ceil", "log")},
    **{name: getattr(np, f"arc{name[1:]}") for name in ("asin", "acos", "atan", "atan2")},
    "isnan": np.isnan,
    "isfinite": np.isfinite,
    "fix": np.trunc,
    "double": float,
    "max": _larger,
    "min": _smaller,
    "where": lambda condition, yes, no: yes if condition else no,
    "interpolate": _interpolate,
}


_CONSTANTS: Final = {"pi": math.pi, "Inf": math.inf, "NaN": math.nan}


def evaluated(text: str, names: Mapping[str, Any]) -> Any:
    """The value of an expression of MATLAB."""
    tokens, at = [], 0
    while text[at:].strip():
        found = _TOKEN.match(text, at)
        assert found, f"not arithmetic: {text[at:]!r}"
        tokens.append(found[1])
        at = found.end()
    with np.errstate(all="ignore"):
        value, rest = _operation(
            tokens, 0, {"pi": math.pi, "Inf": math.inf, "NaN": math.nan} | {**names}
        )
    assert not rest, f"left over: {rest}"
    return value


def _operation(tokens: list[str], rank: int, names: Mapping[str, Any]) -> tuple[Any, list[str]]:
    value, tokens = _operand(tokens, names)
    while tokens and _RANKS.get(tokens[0], 0) > rank:
        sign, tokens = tokens[0], tokens[1:]
        if sign == "^":
            other, tokens = _exponent(tokens, names)
        else:
            other, tokens = _operation(tokens, _RANKS[sign], names)
        value = _computed(sign, value, other)
    return value, tokens


def _exponent(tokens: list[str], names: Mapping[str, Any]) -> tuple[Any, list[str]]:
    if tokens[0] in "+-":
        value, rest = _exponent(tokens[1:], names)
        return (-value if tokens[0] == "-" else value), rest
    return _operand(tokens, names)


def _computed(sign: str, a: Any, b: Any) -> Any:
    a, b = np.float64(a), np.float64(b)
    return {
        "+": lambda: a + b, "-": lambda: a - b, "*": lambda: a * b, "/": lambda: a / b,
        "^": lambda: a**b, "==": lambda: a == b, "~=": lambda: a != b, "<": lambda: a < b,
        "<=": lambda: a <= b, ">": lambda: a > b, ">=": lambda: a >= b,
        "&&": lambda: bool(a) and bool(b), "||": lambda: bool(a) or bool(b),
    }[sign]()  # fmt: skip


def _operand(tokens: list[str], names: Mapping[str, Any]) -> tuple[Any, list[str]]:
    word, rest = tokens[0], tokens[1:]
    if word in ("-", "+", "~"):
        value, rest = _operation(rest, _SIGN, names)
        return {"-": lambda: -float(value), "~": lambda: float(not value)}.get(
            word, lambda: value
        )(), rest
    if word == "(":
        value, rest = _operation(rest, 0, names)
        assert rest[0] == ")"
        return value, rest[1:]
    if word == "[":
        return _listed(rest, names, "]")
    if word[0].isdigit() or word[0] == ".":
        return np.float64(word), rest
    if rest and rest[0] == "(":
        inside, rest = _listed(rest[1:], names, ")")
        if word in names:
            (place,) = inside
            assert place >= 1, "places count from 1"
            return names[word][int(place) - 1], rest
        return FUNCTIONS[word](*inside), rest
    return names[word], rest


def _listed(tokens: list[str], names: Mapping[str, Any], end: str) -> tuple[list[Any], list[str]]:
    values: list[Any] = []
    while True:
        value, tokens = _operation(tokens, 0, names)
        values.append(value)
        mark, tokens = tokens[0], tokens[1:]
        if mark == end:
            return values, tokens
        assert mark in ",;"
