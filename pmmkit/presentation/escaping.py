"""Text of unknown origin inside other languages: comments, strings and cells that cannot end.

Names, titles and notes come out of files. Here is one function for each language into which they
are written; JSON has its own in the standard library.
"""

from __future__ import annotations

import base64
import hashlib
import html
import re
import textwrap
import unicodedata
from pathlib import PurePath
from typing import Final

WIDTH: Final = 80
PYTHON_FIRST: Final = "# -*- coding: ascii -*-"
"""First line of a Python file: it settles the encoding, whatever a later comment says of it."""
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
_TOML: Final = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
_SIGNS: Final = "=+\\-@＝＋－＠"
_FORMULA: Final = re.compile(rf"(?<![^;\t\r\n])(?='* *[{_SIGNS}])|\A(?='*[\t\r])")
"""Places where a formula could begin: at the start, and where some separate cells elsewhere."""
_MARKED: Final = re.compile(rf"(?<![^;\t\r\n])'(?='* *[{_SIGNS}])|\A'(?='*[\t\r])")
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


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


def comment(text: str, sign: str = "%") -> list[str]:
    """A text as lines of a comment, in which it gives no orders to editors or to Python.

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
    >>> comment("coding: utf-7", "#")
    ['# coding : utf-7']
    """
    lead = f"{sign} "
    lines = textwrap.wrap(
        _ORDERS.sub(r"\1 ", plain(text)),
        WIDTH - len(lead),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [lead + line for line in lines] or [sign]


def matlab_string(text: str) -> str:
    """A text in quotes for MATLAB and Octave.

    Examples
    --------
    >>> matlab_string("Froude's law")
    "'Froude''s law'"
    """
    quoted = plain(text).replace("'", "''")
    return f"'{quoted}'"


def toml_string(text: str) -> str:
    """A text in quotes for TOML; what is no text in UTF-8 becomes the sign for that.

    Examples
    --------
    >>> print(toml_string('Tank "A"'))
    "Tank \\"A\\""
    """
    body = "".join(
        _TOML.get(char) or (f"\\u{ord(char):04x}" if ord(char) < 32 or ord(char) == 127 else char)
        for char in text
    )
    return f'"{_encodable(body)}"'


def toml_comment(text: str) -> str:
    """A text that may stand behind # in TOML: one line without control characters.

    Examples
    --------
    >>> toml_comment("drift" + chr(10) + "speed = 9")
    'drift speed = 9'
    """
    return printable(text)


def safe_cell(text: str) -> str:
    """A text as a cell of a table that no spreadsheet computes; numbers stay as they are.

    Parameters
    ----------
    text : str
        Any text. A stroke goes before what could begin a formula (`text_of_cell` takes it away).

    Examples
    --------
    >>> safe_cell("=1+1"), safe_cell("-4"), safe_cell("SD_+4"), safe_cell("'=1")
    ("'=1+1", '-4', 'SD_+4', "''=1")
    """
    return text if _NUMBER.fullmatch(text) else _FORMULA.sub("'", text)


def text_of_cell(cell: str) -> str:
    """The text that `safe_cell` made a cell of.

    Examples
    --------
    >>> text_of_cell("'=1+1"), text_of_cell("-4"), text_of_cell("'quoted'")
    ('=1+1', '-4', "'quoted'")
    """
    return _MARKED.sub("", cell)


def printable(text: str) -> str:
    """A text without line breaks and control characters, for one line of a terminal.

    Examples
    --------
    >>> printable("two\\nlines")
    'two lines'
    """
    return text if text.isprintable() else "".join(x if x.isprintable() else " " for x in text)


def lines_of(text: str) -> str:
    """A text of several lines without anything that could steer a terminal.

    Examples
    --------
    >>> lines_of("two" + chr(10) + "lines" + chr(27) + "[2J")
    'two\\nlines [2J'
    """
    return "\n".join(map(printable, text.split("\n")))


def html_text(text: str) -> str:
    """A text as HTML.

    Examples
    --------
    >>> html_text("a <b>")
    'a &lt;b&gt;'
    """
    return html.escape(printable(text))


def figure_text(text: str) -> str:
    r"""A text in a figure, where $ would begin mathematics.

    Examples
    --------
    >>> print(figure_text("5 $"))
    5 \$
    """
    return _encodable(printable(text)).replace("$", r"\$")


def _encodable(text: str) -> str:
    """A text without the halves of letters that UTF-8 does not have."""
    return text.encode("utf-8", "replace").decode("utf-8")


def quoted(path: PurePath) -> str:
    """A path as it is typed.

    Examples
    --------
    >>> quoted(PurePath("my tests/run 1")), quoted(PurePath("tests"))
    ('"my tests/run 1"', 'tests')
    """
    text = str(path)
    return f'"{text}"' if " " in text else text


def content_hash(text: str) -> str:
    """A script or a style sheet as a content security policy names it.

    Examples
    --------
    >>> content_hash("")
    "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
    """
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
