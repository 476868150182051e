"""Bytes of a text file as UTF-8 with unix line ends, and columns of fixed width taken apart."""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from pmmkit.base import Problem
from pmmkit.presentation import letters
from pmmkit.readers.base import Request

CUT: Final = "\x01"
"""Stands between columns of fixed width once they are taken apart."""
_MARKS: Final = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_WINDOWS: Final = "cp1252"
_EASTERN: Final = ("cp932", "euc_jp", "cp949", "gb18030")
_SIGNS: Final = frozenset("°²³µ·±×ß・")
_SCRIPTS: Final = (
    ("\u3041", "\u30ff", 0.8),
    ("\u4e00", "\u9fff", 0.2),
    ("\uac00", "\ud7a3", 0.2),
    ("\u00c0", "\u00ff", 0.3),
    ("\uff61", "\uff9f", -1.0),
)
"""First and last letter of kana, kanji, hangul, Latin with accents and kana of half width, and
what it says for an encoding that a text has them."""


def marked(data: bytes) -> str | None:
    """The encoding that a byte order mark tells, None for UTF-8 and where there is none."""
    return next((name for mark, name in _MARKS if data.startswith(mark)), None)


def likely_encoding(data: bytes) -> str:
    """The encoding in which a text that is not UTF-8 probably is.

    Told by the letters that it would have: those that stand in names of channels and tests, kana,
    and so on, against signs that no heading has.

    Examples
    --------
    >>> [likely_encoding("横力 [N・m]".encode(name)) for name in ("cp932", "euc_jp")]
    ['cp932', 'euc_jp']
    >>> likely_encoding("Längskraft 20 °C".encode("cp1252"))
    'cp1252'
    """
    scores = {name: _likeliness(data, name) for name in (_WINDOWS, *_EASTERN)}
    return max(scores, key=lambda name: scores[name])


def _likeliness(data: bytes, encoding: str) -> float:
    """How usual the letters of a text are in an encoding, in the mean from -1 to 1."""
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        return -0.9 if encoding == _WINDOWS else -1.0
    beyond = [letter for letter in text if not letter.isascii()]
    return sum(map(_usual, beyond)) / max(1, len(beyond))


def _usual(letter: str) -> float:
    if letter in letters() or letter in _SIGNS:
        return 1.0
    for first, last, worth in _SCRIPTS:
        if first <= letter <= last:
            return worth
    return -0.5


def keeps_line_ends(encoding: str) -> bool:
    """Whether the line ends of a text in this encoding are those of its bytes."""
    return "az09,\n".encode(encoding) == b"az09,\n"


_FORTRAN: Final = re.compile(rb"(\d*\.\d*)[dD]([+-]\d\d)")


def with_e(data: bytes) -> bytes:
    """A text with E where Fortran writes D before the power of ten, as long as it was.

    Examples
    --------
    >>> with_e(b" 1.25D-01 run3D-2")
    b' 1.25E-01 run3D-2'
    """
    if any(_signed(data, letter) for letter in (b"D", b"d")):
        return _FORTRAN.sub(rb"\1E\2", data)
    return data


def _signed(data: bytes, letter: bytes) -> bool:
    """Whether a sign follows a letter somewhere.

    The last such letter is found many times as fast as a pair of bytes is, and most texts have it
    in their heading alone.
    """
    stop = data.rfind(letter) + 2
    return any(data.find(letter + sign, 0, stop) >= 0 for sign in (b"+", b"-"))


def decoded(data: bytes, request: Request, line: int = 1) -> tuple[bytes, Problem | None]:
    """The text in the encoding stated, or that of its byte order mark, or UTF-8, or cp1252."""
    if not data:
        raise request.error("the file is empty (0 bytes).")
    encoding = request.options.encoding or marked(data) or "utf-8"
    doubt = None
    plain = keeps_line_ends(encoding)
    if not (plain and data.isascii()):
        try:
            text = data.decode(encoding)
        except UnicodeError as error:
            doubt = _not_decoded(data, encoding, error, line if plain else None, request)
            if encoding != "utf-8" or request.options.encoding is not None:
                raise request.error(doubt) from error
            try:
                text = data.decode(_WINDOWS)
            except UnicodeDecodeError:
                raise request.error(doubt) from error
        if doubt is not None or codecs.lookup(encoding).name != "utf-8":
            data = text.encode()
    data = data.removeprefix(codecs.BOM_UTF8)
    nul = data.find(b"\0")
    if nul >= 0:
        raise request.error(
            "there are zero bytes: the file is damaged or not plain text.",
            row=data.count(b"\n", 0, nul) + line,
        )
    return with_e(data), doubt


def _not_decoded(
    data: bytes, encoding: str, error: UnicodeError, line: int | None, request: Request
) -> Problem:
    place = error.start if isinstance(error, UnicodeDecodeError) else None
    other = likely_encoding(data)
    named = f'e.g. encoding = "{other}"' if other != encoding else "it is none of the usual ones"
    return request.problem(
        f"the text is not {encoding}."
        if place is None
        else f"byte {data[place]:#04x} is not {encoding} text.",
        row=data.count(b"\n", 0, place) + line if line and place is not None else None,
        remedy=f"State the right one in [source], {named}.",
    )


def unix_ends(data: bytes, request: Request, line: int = 1) -> bytes:
    """The text with line feeds at its line ends, those after carriage returns included.

    `line` is the line of the file, counted from 1, in which the text begins.
    """
    if b"\r" not in data or data.count(b"\r") == data.count(b"\r\n"):
        return data
    if b"\n" not in data and line == 1:
        return data.replace(b"\r", b"\n")
    stray = re.search(rb"\r(?!\n)", data)
    if stray is None or stray.end() != len(data):
        row = data.count(b"\n", 0, stray.start()) + line if stray else None
        raise request.error("there is a carriage return inside the line.", row=row)
    return data


def cut_apart(data: bytes, widths: Sequence[int]) -> bytes:
    r"""Lines of columns of fixed width with ``CUT`` between the columns.

    Examples
    --------
    >>> cut_apart(b" 0.00-12.5\n 0.10\n", (5, 5)).replace(CUT.encode(), b"|")
    b' 0.00|-12.5\n 0.10|\n'
    """
    kind, encoding = ("u1", "ascii") if data.isascii() else ("<u4", "utf-32-le")
    code = np.frombuffer(data.decode().encode(encoding), dtype=kind)
    ends = np.append(np.flatnonzero(code == 10), len(code))
    starts = np.concatenate([[0], ends[:-1] + 1])
    filled = np.flatnonzero(code > 32)
    before = np.searchsorted(filled, starts)
    after = np.searchsorted(filled, ends)
    some = after > before
    starts, ends, after = starts[some], ends[some], after[some]
    edges = np.cumsum(widths)
    inner = np.minimum(starts[:, None] + edges[:-1], ends[:, None])
    beyond = starts + sum(widths)
    longer = filled[after - 1] >= beyond
    places = np.sort(np.append(inner.ravel(), beyond[longer]))
    cut = np.insert(code, places, ord(CUT))
    return cut.tobytes().decode(encoding).encode()
