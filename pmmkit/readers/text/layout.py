"""How a text file of columns is laid out, told from its beginning.

Unlike `pmmkit.readers.text.splitting`, which reads a file as the campaign file states it, this
finds out what the campaign file should state: lines above the header, encoding, delimiter, decimal
sign, header, a line of units.
"""

from __future__ import annotations

import codecs
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from pmmkit.conventions import is_unit
from pmmkit.readers.base import HEAD, Options, mostly_numbers, to_number
from pmmkit.readers.text.decoding import likely_encoding, with_e
from pmmkit.readers.text.heading import (
    BLANKS,
    CANDIDATES,
    count_numbers,
    fields_of,
    names_in,
    within,
)
from pmmkit.readers.text.stamps import is_stamp

_SAMPLE: Final = 24
"""Lines on which delimiters and decimal signs are tried."""


@dataclass(frozen=True, kw_only=True)
class TextLayout:
    """The layout of a text file of columns.

    Parameters
    ----------
    encoding : str
        ``utf-8``, ``utf-16``, or what `likely_encoding` tells.
    delimiter, decimal : str
        What stands between fields (a blank for any number of blanks or tabs); decimal sign.
    header_line : int or None
        Line of the names, counted from 1; None where there is none.
    first_row : int
        Line of the first row of numbers.
    headers : tuple of str
        Names, empty strings where there is no header.
    units : tuple of str
        Units that stand in a line of their own between names and numbers; else empty.
    numeric : tuple of bool
        Which columns hold numbers.
    """

    encoding: str
    delimiter: str
    decimal: str
    header_line: int | None
    first_row: int
    headers: tuple[str, ...]
    units: tuple[str, ...]
    numeric: tuple[bool, ...]

    @classmethod
    def of(cls, head: bytes, *, whole: bool | None = None) -> TextLayout | None:
        r"""The layout of a text file, or None if no rows of numbers are found.

        Parameters
        ----------
        head : bytes
            The first bytes of the file.
        whole : bool, optional
            Whether that is all of it; else its last line, which may be cut, is left out. By default
            told by their number.

        Examples
        --------
        >>> text = "Test 7, 2024\n\nTime;Fx\ns;kN\n0,0;1,5\n0,1;1,6\n0,2;1,4\n"
        >>> found = TextLayout.of(text.encode())
        >>> found.delimiter, found.decimal, found.header_line, found.headers, found.units
        (';', ',', 3, ('Time', 'Fx'), ('s', 'kN'))
        """
        decoded = text_of(head, whole=whole)
        if decoded is None:
            return None
        text, encoding = decoded
        lines = text.split("\n")
        filled = [line.encode() for line in lines if line.strip()]
        late = filled[len(filled) // 2 :] if len(filled) > 3 else filled[-2:]
        sample = late[:: max(1, len(late) // _SAMPLE)]
        found = _dialect(sample) or _dialect(filled[-4:])
        if found is None:
            return None
        delimiter, decimal, width = found
        rows = [fields_of(line.encode(), delimiter) for line in lines]
        first = next(
            (
                number
                for number, fields in enumerate(rows)
                if _is_row(fields, width, decimal) and _goes_on(rows[number + 1 :], width, decimal)
            ),
            None,
        )
        if first is None:
            return None
        body = [fields for fields in rows[first : first + 200] if _is_row(fields, width, decimal)]
        header_line, headers, units = _names(lines[:first], width, delimiter)
        if len(body) < 2 and (header_line is None or width < 3):
            return None
        return cls(
            encoding=encoding,
            delimiter=delimiter,
            decimal=decimal,
            header_line=header_line,
            first_row=first + 1,
            headers=headers or ("",) * width,
            units=units,
            numeric=tuple(
                mostly_numbers(cells, decimal) or all(map(is_stamp, cells))
                for cells in zip(*body, strict=True)
            ),
        )

    @property
    def options(self) -> Options:
        """How the reader of text files is told to read it."""
        return Options(
            format="csv",
            skip_rows=(self.header_line or self.first_row) - 1,
            encoding=None if self.encoding == "utf-8" else self.encoding,
            delimiter=self.delimiter,
            decimal=self.decimal,
            header=self.header_line is not None,
            units_row=True if self.units else None,
        )


def text_of(head: bytes, *, whole: bool | None = None) -> tuple[str, str] | None:
    """The text of a beginning of a file with unix line ends, and its encoding; None if binary.

    Parameters
    ----------
    head : bytes
        The first bytes of the file.
    whole : bool, optional
        Whether that is all of it; by default told by their number.
    """
    if whole is None:
        whole = len(head) < HEAD
    head = with_e(head)
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = "utf-16"
        text = head[: len(head) // 2 * 2].decode(encoding, "replace")
    elif b"\0" in head:
        return None
    else:
        encoding = "utf-8"
        kept = head if whole else head[: max(head.rfind(b"\n"), head.rfind(b"\r")) + 1]
        try:
            text = kept.removeprefix(codecs.BOM_UTF8).decode()
        except UnicodeDecodeError:
            encoding = likely_encoding(kept)
            text = kept.decode(encoding, "replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if not whole and "\n" in text:
        text = text[: text.rindex("\n")]
    return text, encoding


def _dialect(sample: Sequence[bytes]) -> tuple[str, str, int] | None:
    """Delimiter, decimal sign and width with which most cells are numbers."""
    best, chosen = 0.5, None
    for delimiter, decimal in CANDIDATES:
        rows = [fields_of(line, delimiter) for line in sample]
        counts = [len(row) for row in rows]
        width = max(counts, key=lambda count: (counts.count(count), count), default=0)
        if width < 2:
            continue
        whole = [row for row in rows if _is_row(row, width, decimal)]
        cells = [cell for row in whole for cell in row]
        if not cells:
            continue
        numbers = sum(to_number(cell, decimal) is not None for cell in cells)
        score = len(whole) / len(rows) * numbers / len(cells)
        if score > best:
            best, chosen = score, (delimiter, decimal, width)
    return chosen


def _is_row(fields: Sequence[str], width: int, decimal: str) -> bool:
    if len(fields) != width:
        return False
    filled = [cell for cell in fields if cell]
    numbers = count_numbers(filled, decimal)
    return numbers > len(filled) / 2 if width > 2 else numbers == len(filled) > 0


def _goes_on(rows: Sequence[Sequence[str]], width: int, decimal: str) -> bool:
    """Whether the rows below are of the same kind, as far as there are any."""
    below = [fields for fields in rows[:6] if any(fields)][:3]
    return not below or any(_is_row(fields, width, decimal) for fields in below)


def _names(
    above: Sequence[str], width: int, delimiter: str
) -> tuple[int | None, tuple[str, ...], tuple[str, ...]]:
    """Line and names of the header above the first row, and the units between them."""
    units: tuple[str, ...] = ()
    for number in range(len(above), 0, -1):
        line = above[number - 1]
        if not line.strip(" \t#;,"):
            continue
        cells = within(fields_of(line.encode(), delimiter), width)
        if not units and number > 1 and len(cells) == width and all(map(_is_unit, cells)):
            units = tuple(cell.strip("[]() ") for cell in cells)
            continue
        names = tuple(within(names_in(line.encode(), width, delimiter), width))
        if len(names) != width and delimiter != BLANKS:
            names = tuple(name for name in names if name)
        if len(names) != width:
            return None, (), ()
        return number, names, units
    return None, (), ()


def _is_unit(text: str) -> bool:
    bare = text.strip()
    bracketed = bare[:1] + bare[-1:] in ("[]", "()")
    return bracketed or is_unit(bare.strip("[]() "))
