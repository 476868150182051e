"""Names and values of MATLAB."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Final

from pmmkit.syntax.comments import plain
from pmmkit.syntax.words import FUNCTIONS

_TAKEN: Final = frozenset(
    {
        "break",
        "case",
        "catch",
        "classdef",
        "continue",
        "do",
        "else",
        "elseif",
        "end",
        "end_try_catch",
        "endfor",
        "endfunction",
        "endif",
        "endswitch",
        "endwhile",
        "for",
        "function",
        "global",
        "if",
        "otherwise",
        "parfor",
        "persistent",
        "return",
        "spmd",
        "switch",
        "try",
        "until",
        "unwind_protect",
        "while",
        *(word.matlab for word in FUNCTIONS.values()),
        "error",
        "inf",
        "interp1",
        "interp2",
        "length",
        "nan",
        "nargin",
        "pi",
        "table",
        "ui",
        "x",
        "xdot",
    }
)
"""Words of MATLAB and Octave, and functions that the generated text calls."""


def matlab_name(text: str, stem: str = "model") -> str:
    """A name that MATLAB and Octave accept for a function or a variable.

    Parameters
    ----------
    text : str
        What is to be named.
    stem : str
        What the name begins with where the text alone makes none.

    Returns
    -------
    str

    Examples
    --------
    >>> matlab_name("kvlcc2-l7"), matlab_name("7 m"), matlab_name("x'); system('rm")
    ('kvlcc2_l7', 'model_7_m', 'x_system_rm')
    """
    name = re.sub(r"[^A-Za-z0-9]+", "_", plain(text)).strip("_")
    if not name or not name[0].isalpha() or name.lower() in _TAKEN:
        name = f"{stem}_{name}".rstrip("_")
    return name[:63].rstrip("_")


def is_matlab_name(text: str) -> bool:
    """Whether a text is a name that MATLAB and Octave accept.

    Parameters
    ----------
    text : str

    Returns
    -------
    bool
    """
    return re.fullmatch(r"[A-Za-z]\w{0,62}", text, re.ASCII) is not None and (
        text.lower() not in _TAKEN
    )


def matlab_value(value: str | float | Sequence[float]) -> str:
    """A text, a number or a row of numbers as MATLAB takes it.

    Parameters
    ----------
    value : str, float or sequence of float
        Numbers get the fewest digits that give the same float again.

    Returns
    -------
    str

    Examples
    --------
    >>> matlab_value(0.1), matlab_value([2, float("inf"), float("nan")]), matlab_value("Ship's")
    ('0.1', '[2.0, Inf, NaN]', "'Ship''s'")
    """
    if isinstance(value, str):
        quoted = plain(value).replace("'", "''")
        return f"'{quoted}'"
    if isinstance(value, Sequence):
        return f"[{', '.join(map(matlab_value, value))}]"
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Inf" if value > 0 else "-Inf"
    return repr(float(value))
