"""The few functions that effects are written in, for one instant and for arrays alike.

An effect's `force` uses only these, the operators of arithmetic and loops of fixed length. So the
same text runs on plain floats, compiled, and, by `over_arrays`, on whole histories at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from math import atan2, cos, exp, fabs, pi, sin, sqrt, tanh
from types import FunctionType, MappingProxyType
from typing import Any, Final

__all__ = [
    "atan2",
    "cos",
    "exp",
    "fabs",
    "interpolate",
    "interpolate_rows",
    "maximum",
    "minimum",
    "over_arrays",
    "pi",
    "rebound",
    "sin",
    "sqrt",
    "tanh",
    "where",
]


def where(condition: bool, yes: float, no: float) -> float:
    """One of two numbers; both are computed, so neither may fail."""
    return yes if condition else no


def maximum(a: float, b: float) -> float:
    """The larger of two numbers."""
    return a if a > b else b


def minimum(a: float, b: float) -> float:
    """The smaller of two numbers."""
    return a if a < b else b


def interpolate(x: float, xs: Sequence[float], ys: Sequence[float]) -> float:
    """Straight lines through points with ascending xs, constant beyond both ends.

    Examples
    --------
    >>> interpolate(1.5, (0.0, 1.0, 2.0), (5.0, 7.0, 8.0)), interpolate(9.0, (0.0, 1.0), (2.0, 3.0))
    (7.5, 3.0)
    """
    last = len(xs) - 1
    if not x > xs[0]:
        return ys[0]
    if x >= xs[last]:
        return ys[last]
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if xs[middle] <= x:
            low = middle
        else:
            high = middle
    slope = (ys[high] - ys[low]) / (xs[high] - xs[low])
    return slope * (x - xs[low]) + ys[low]


def interpolate_rows(
    x: float, xs: Sequence[float], y: float, ys: Sequence[float], rows: Sequence[float]
) -> float:
    """Straight lines both ways in a table, constant beyond its edges.

    Examples
    --------
    >>> table = (0.0, 1.0, 2.0, 10.0, 21.0, 32.0)
    >>> [interpolate_rows(x, (0.0, 4.0), 0.5, (0.0, 1.0, 2.0), table) for x in (0.0, 2.0, 9.0)]
    [0.5, 8.0, 15.5]
    """
    row, column = 0, 0
    while row < len(xs) - 2 and x > xs[row + 1]:
        row += 1
    while column < len(ys) - 2 and y > ys[column + 1]:
        column += 1
    down = minimum(maximum((x - xs[row]) / (xs[row + 1] - xs[row]), 0.0), 1.0)
    along = minimum(maximum((y - ys[column]) / (ys[column + 1] - ys[column]), 0.0), 1.0)
    at = row * len(ys) + column
    below = at + len(ys)
    first = rows[at] + along * (rows[at + 1] - rows[at])
    second = rows[below] + along * (rows[below + 1] - rows[below])
    return first + down * (second - first)


def _rows_of_arrays(x: Any, xs: Any, y: Any, ys: Any, rows: Any) -> Any:
    """`interpolate_rows` at many places at once."""
    import numpy as np

    table = np.reshape(rows, (len(xs), len(ys)))

    def cell(value: Any, ends: Any) -> tuple[Any, Any]:
        marks = np.asarray(ends, dtype=float)
        low = np.clip(np.searchsorted(marks, value) - 1, 0, marks.size - 2)
        share = (value - marks[low]) / (marks[low + 1] - marks[low])
        return low, np.clip(share, 0.0, 1.0)

    (row, down), (column, along) = cell(x, xs), cell(y, ys)
    first, second = (
        table[i, column] + along * (table[i, column + 1] - table[i, column]) for i in (row, row + 1)
    )
    return first + down * (second - first)


def over_arrays(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function of an effect, taking arrays.

    Examples
    --------
    >>> import numpy as np
    >>> def drag(v: float, area: float) -> float:
    ...     return where(v > 1.0, -area * v * fabs(v), 0.0)
    >>> over_arrays(drag)(np.array([0.5, 2.0]), 3.0)
    array([  0., -12.])
    """
    import numpy as np

    arrays: dict[str, Any] = {
        "atan2": np.arctan2,
        "cos": np.cos,
        "exp": np.exp,
        "fabs": np.abs,
        "sin": np.sin,
        "sqrt": np.sqrt,
        "tanh": np.tanh,
        "where": np.where,
        "maximum": np.maximum,
        "minimum": np.minimum,
        "interpolate": np.interp,
        "interpolate_rows": _rows_of_arrays,
    }
    made: Callable[..., Any] = rebound(function, arrays, lambda copy: copy)
    return made


_OWN: Final = {where, maximum, minimum, interpolate, interpolate_rows}


def rebound(
    function: Callable[..., Any], replaced: Mapping[str, Any], wrap: Callable[[Any], Any]
) -> Any:
    """A copy of a function in which the functions it calls are others.

    Parameters
    ----------
    function : callable
        A plain function of an effect.
    replaced : mapping
        What stands for the primitives, by name.
    wrap : callable
        Applied to each copy, innermost first; functions of pmmkit that are called get copies too.
    """
    assert isinstance(function, FunctionType)
    known = dict(function.__globals__)
    for name in function.__code__.co_names:
        used = known.get(name)
        if name in replaced and (used in _OWN or getattr(math, name, None) is used):
            known[name] = replaced[name]
        elif isinstance(used, FunctionType):
            known[name] = rebound(used, replaced, wrap)
    copied = FunctionType(
        function.__code__, known, function.__name__, function.__defaults__, function.__closure__
    )
    copied.__kwdefaults__ = function.__kwdefaults__
    return wrap(copied)


PRIMITIVES: Final = MappingProxyType({name: globals()[name] for name in __all__})
"""All of this by name: what stands here, a text of effects may use."""
