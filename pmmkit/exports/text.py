"""Names and numbers of generated programs."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Final

from pmmkit.base import Remedy, __version__, setting
from pmmkit.exports.comments import comment, plain
from pmmkit.syntax import FUNCTIONS

WHICH_SPEED: Final = Remedy("Say at which speed [m/s], such as {}.", (setting("speed", 8),))
"""Where values depend on the speed and none was given."""
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
    """Whether a text is already such a name."""
    return re.fullmatch(r"[A-Za-z]\w{0,62}", text, re.ASCII) is not None and (
        text.lower() not in _TAKEN
    )


def number(value: float) -> str:
    """A number with the fewest digits that give the same float again.

    Examples
    --------
    >>> number(0.1), number(float("inf")), number(float("nan"))
    ('0.1', 'Inf', 'NaN')
    """
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Inf" if value > 0 else "-Inf"
    return repr(float(value))


def row(values: Iterable[float]) -> str:
    """Numbers as a row of MATLAB, which takes commas between them."""
    return f"[{', '.join(map(number, values))}]"


def written_by(sign: str = "%") -> list[str]:
    """Lines of a comment that say which program wrote a file."""
    return comment(f"Written by pmmkit {__version__}.", sign)
