"""Text of unknown origin in generated programs: comments that cannot end."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from typing import Final

_WIDTH: Final = 80
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
_ORDERS: Final = re.compile(r"(coding|\b(?:vim?|ex))(?=[:=])", re.IGNORECASE)
"""What Python and editors take for an order although it stands in a comment."""


def plain(text: str) -> str:
    """A text as one line of printable ASCII.

    Letters that ASCII has not are spelled, all else becomes a question mark; line breaks of any
    kind become blanks, so that a text put behind a comment sign stays in the comment.

    Parameters
    ----------
    text : str
        Any text, such as a title out of a file.

    Returns
    -------
    str

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


def comment(text: str, sign: str = "%") -> list[str]:
    """A text as lines of a comment, in which it gives no orders to editors or to Python.

    Parameters
    ----------
    text : str
        Any text.
    sign : str
        What a comment starts with.

    Returns
    -------
    list of str

    Examples
    --------
    >>> comment("One line.")
    ['% One line.']
    >>> comment("coding: utf-7", "#")
    ['# coding : utf-7']
    """
    lead = f"{sign} "
    lines = textwrap.wrap(
        _ORDERS.sub(r"\1 ", plain(text)),
        _WIDTH - len(lead),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [lead + line for line in lines] or [sign]
