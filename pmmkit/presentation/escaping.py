"""Text of unknown origin on a terminal, in the cells of tables and in figures."""

from __future__ import annotations

import re
from pathlib import PurePath
from typing import Final

_SIGNS: Final = "=+\\-@＝＋－＠"
_FORMULA: Final = re.compile(rf"(?<![^;\t\r\n])(?='* *[{_SIGNS}])|\A(?='*[\t\r])")
"""Places where a formula could begin: at the start, and where some separate cells elsewhere."""
_MARKED: Final = re.compile(rf"(?<![^;\t\r\n])'(?='* *[{_SIGNS}])|\A'(?='*[\t\r])")
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


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
    """The text that `safe_cell` made a `cell` of.

    Examples
    --------
    >>> text_of_cell("'=1+1"), text_of_cell("-4"), text_of_cell("'quoted'")
    ('=1+1', '-4', "'quoted'")
    """
    return _MARKED.sub("", cell)


def printable(text: str, *, lines: bool = False) -> str:
    """A text without control characters, for one line of a terminal or for several.

    Parameters
    ----------
    text : str
        Any text.
    lines : bool
        Whether its line breaks stay.

    Examples
    --------
    >>> text = "two" + chr(10) + "lines" + chr(27) + "[2J"
    >>> printable(text), printable(text, lines=True)
    ('two lines [2J', 'two\\nlines [2J')
    """
    if lines:
        return "\n".join(map(printable, text.split("\n")))
    return text if text.isprintable() else "".join(x if x.isprintable() else " " for x in text)


def figure_text(text: str) -> str:
    r"""A `text` in a figure, where $ would begin mathematics.

    Examples
    --------
    >>> print(figure_text("5 $"))
    5 \$
    """
    return printable(text).encode("utf-8", "replace").decode("utf-8").replace("$", r"\$")


def quoted(path: PurePath) -> str:
    """A `path` as it is typed.

    Examples
    --------
    >>> quoted(PurePath("my tests/run 1")), quoted(PurePath("tests"))
    ('"my tests/run 1"', 'tests')
    """
    text = str(path)
    return f'"{text}"' if " " in text else text
