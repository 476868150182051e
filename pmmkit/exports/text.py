"""Texts and numbers of generated programs: plain ASCII, nothing of a file's text can be run."""

from __future__ import annotations

import math
import re
import textwrap
import unicodedata
from collections.abc import Iterable
from typing import Final

from pmmkit.version import __version__

WIDTH: Final = 80
_LETTERS: Final = str.maketrans(
    {
        "ø": "o",
        "Ø": "O",
        "æ": "ae",
        "Æ": "Ae",
        "ß": "ss",
        "đ": "d",
        "ł": "l",
        "Ł": "L",
        "α": "alpha",
        "β": "beta",
        "γ": "gamma",
        "δ": "delta",
        "ε": "epsilon",
        "ζ": "zeta",
        "η": "eta",
        "κ": "kappa",
        "λ": "lambda",
        "ρ": "rho",
        "τ": "tau",
        "φ": "phi",
        "ψ": "psi",
        "ω": "omega",
        "π": "pi",
        "∇": "nabla",
        "Δ": "Delta",
        "Λ": "Lambda",
        "√": "sqrt",
        "²": "^2",
        "³": "^3",
        "⁴": "^4",
        "°": " deg",
        "·": "*",
        "×": "x",
        "–": "-",
        "—": "-",
        "−": "-",
        "’": "'",
        "‘": "'",
        "“": '"',
        "”": '"',
    }
)
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
        "abs",
        "atan2",
        "cos",
        "error",
        "exp",
        "inf",
        "interp1",
        "interpolate",
        "length",
        "max",
        "min",
        "nan",
        "nargin",
        "pi",
        "sin",
        "sqrt",
        "table",
        "tanh",
        "ui",
        "where",
        "x",
        "xdot",
    }
)
"""Words of MATLAB and Octave, and functions that the generated text calls."""


def plain(text: str) -> str:
    """A text as one line of printable ASCII.

    Letters that ASCII has not are spelled, all else becomes a question mark; line breaks of any
    kind become blanks, so that a text put behind a comment sign stays in the comment.

    Parameters
    ----------
    text : str
        Any text, such as a title out of a file.

    Examples
    --------
    >>> plain("Strøm-Tejsen, 35°" + chr(10) + "delete all")
    'Strom-Tejsen, 35 deg delete all'
    """
    spelled = unicodedata.normalize("NFKD", text.translate(_LETTERS))
    kept = (letter for letter in spelled if not unicodedata.combining(letter))
    marked = "".join(
        letter if " " <= letter <= "~" else " " if letter.isspace() else "?" for letter in kept
    )
    return " ".join(marked.split())


def matlab_name(text: str, stem: str = "model") -> str:
    """A name that MATLAB and Octave accept for a function or a variable.

    Parameters
    ----------
    text : str
        What the name is made of.
    stem : str
        What it starts with where the text does not start with a letter.

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


def matlab_string(text: str) -> str:
    """A text in quotes for MATLAB.

    Examples
    --------
    >>> matlab_string("Froude's law")
    "'Froude''s law'"
    """
    quoted = plain(text).replace("'", "''")
    return f"'{quoted}'"


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


def comment(text: str, sign: str = "%") -> list[str]:
    """A text as lines of a comment.

    Parameters
    ----------
    text : str
        Any text.
    sign : str
        What a comment starts with.

    Examples
    --------
    >>> comment("One line.")
    ['% One line.']
    """
    lead = f"{sign} "
    lines = textwrap.wrap(
        plain(text), WIDTH - len(lead), break_long_words=False, break_on_hyphens=False
    )
    return [lead + line for line in lines] or [sign]


def written_by(sign: str = "%") -> list[str]:
    """Lines of a comment that say which program wrote a file."""
    return comment(f"Written by pmmkit {__version__}.", sign)
