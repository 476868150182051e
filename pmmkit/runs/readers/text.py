"""Taking a text file apart: encoding, header, delimiter, decimal sign, where the numbers stand."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import BinaryIO, Final

import numpy as np

from pmmkit.errors import CampaignError
from pmmkit.runs.readers.base import Request, to_number

BLANKS: Final = " "
_CANDIDATES: Final = (
    (";", "."),
    (";", ","),
    ("\t", "."),
    ("\t", ","),
    (",", "."),
    (BLANKS, "."),
    (BLANKS, ","),
)
_SAMPLE: Final = 20
BLOCK: Final = 1 << 22
"""Bytes of a large file that are read at once."""
_BLANK_HEADER: Final = re.compile(
    r"(?:[^\s\[(]|\[[^\]]*\]|\([^)]*\))+(?:\s+(?:\[[^\]]*\]|\([^)]*\)))?"
)
"""A header among blanks, with the unit in brackets that may stand apart from it."""


@dataclass(frozen=True, kw_only=True)
class Text:
    """A text file, or a piece of it, taken apart.

    Parameters
    ----------
    headers : tuple of str or None
        Names in the header; None where there is none.
    data : bytes
        Its text as UTF-8.
    start, stop : int
        Where in `data` the rows of numbers begin and end, line ends after them left out.
    first_line : int
        Line of the file, counted from 1, in which the rows begin.
    delimiter, decimal : str
        What stands between fields (a blank for any number of blanks or tabs); decimal sign.
    """

    headers: tuple[str, ...] | None
    data: bytes
    start: int
    stop: int
    first_line: int
    delimiter: str
    decimal: str

    @property
    def lines(self) -> list[bytes]:
        """The rows of numbers."""
        return self.data[self.start : self.stop].split(b"\n")

    @property
    def width(self) -> int:
        """Number of columns."""
        if self.headers is not None:
            return len(self.headers)
        end = min(line_end(self.data, self.start), self.stop)
        return len(fields_of(self.data[self.start : end], self.delimiter))


def take_apart(request: Request) -> Text:
    """Read a text file whole and find out how it is written.

    Raises
    ------
    CampaignError
        If it is empty, has no rows of numbers, cannot be decoded or holds zero bytes.
    """
    try:
        data = request.path.read_bytes()
    except OSError as error:
        raise _unreadable(error, request) from error
    return _taken_apart(data, request)


def blocks(request: Request) -> Iterator[Text]:
    """A text file in pieces of whole lines, so that a large one is never in memory whole.

    Blank lines at the end of a piece go to the next one. The last piece is large enough to tell
    by it whether the file was cut off.

    Raises
    ------
    CampaignError
        As `take_apart`.
    """
    encoding = request.options.encoding or "utf-8"
    try:
        size = request.path.stat().st_size
        if size < 2 * BLOCK or not _keeps_line_ends(encoding):
            yield take_apart(request)
            return
        with request.path.open("rb") as stream:
            yield from _pieces(stream, request)
    except OSError as error:
        raise _unreadable(error, request) from error


def _pieces(stream: BinaryIO, request: Request) -> Iterator[Text]:
    data, line = stream.read(BLOCK), 1
    if _line_feeds(data) <= request.options.skip_rows:
        yield _taken_apart(data + stream.read(), request)
        return
    first: Text | None = None
    while data:
        ahead = stream.read(BLOCK)
        if len(ahead) < BLOCK:
            part, data = data + ahead, b""
        else:
            stop = data.rfind(b"\n", 0, _last(data)) + 1
            part, data = data[:stop], data[stop:] + ahead
        if not part:
            continue
        if first is None:
            piece = _taken_apart(part, request)
            first = replace(piece, headers=piece.headers or ("",) * piece.width, data=b"")
        else:
            text = _with_plain_ends(_as_utf8(part, request, line), request, line)
            piece = replace(first, data=text, start=0, stop=_last(text), first_line=line)
        yield piece
        line += _line_feeds(part)


def _line_feeds(data: bytes) -> int:
    return int(np.count_nonzero(np.frombuffer(data, dtype=np.uint8) == 10))


def _taken_apart(data: bytes, request: Request) -> Text:
    options = request.options
    data = _with_plain_ends(_as_utf8(data, request), request)
    start, line = 0, 1
    while start < len(data) and (
        line <= options.skip_rows or not data[start : line_end(data, start)].strip()
    ):
        start, line = line_end(data, start) + 1, line + 1
    stop = _last(data)
    if start >= stop:
        skipped = f" below the {options.skip_rows} rows skipped" if options.skip_rows else ""
        raise request.error(request.problem(f"the file is empty{skipped}."))
    delimiter, decimal = _dialect(data[start : min(stop, start + 65536)], request)
    first = data[start : line_end(data, start)]
    headers = None
    if _is_header(fields_of(first, delimiter), decimal, request):
        headers = _headers(first, delimiter)
        start, line = line_end(data, start) + 1, line + 1
        if start >= stop:
            raise request.error(
                request.problem("the file has a header and no rows of numbers below it.")
            )
    return Text(
        headers=headers,
        data=data,
        start=start,
        stop=stop,
        first_line=line,
        delimiter=delimiter,
        decimal=decimal,
    )


def _unreadable(error: OSError, request: Request) -> CampaignError:
    return request.error(request.problem(f"cannot be read: {error.strerror}."))


def _keeps_line_ends(encoding: str) -> bool:
    """Whether the line ends of a text in this encoding are those of its bytes."""
    return "az09,\n".encode(encoding) == b"az09,\n"


def _with_plain_ends(data: bytes, request: Request, line: int = 1) -> bytes:
    """The text with line ends that hold a line feed; refuses a stray carriage return."""
    if b"\r" not in data or data.count(b"\r") == data.count(b"\r\n"):
        return data
    if b"\n" not in data and line == 1:
        return data.replace(b"\r", b"\n")
    stray = re.search(rb"\r(?!\n)", data)
    if stray is None or stray.end() != len(data):
        row = line + data.count(b"\n", 0, stray.start()) if stray else None
        raise request.error(request.problem("there is a carriage return inside the line.", row=row))
    return data


def _as_utf8(data: bytes, request: Request, line: int = 1) -> bytes:
    """The text as UTF-8 without a byte order mark; refuses what is not text."""
    encoding = request.options.encoding or "utf-8"
    if not data:
        raise request.error(request.problem("the file is empty (0 bytes)."))
    if request.options.encoding is None and data.startswith(
        (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    ):
        raise request.error(
            request.problem("the text is UTF-16.", remedy='Write encoding = "utf-16" in [source].')
        )
    plain = _keeps_line_ends(encoding)
    if not (plain and data.isascii()):
        try:
            decoded = data.decode(encoding)
        except UnicodeError as error:
            place = error.start if isinstance(error, UnicodeDecodeError) else None
            raise request.error(
                request.problem(
                    f"the text is not {encoding}."
                    if place is None
                    else f"byte {data[place]:#04x} is not {encoding} text.",
                    row=data.count(b"\n", 0, place) + line if plain and place is not None else None,
                    remedy='State the right one in [source], e.g. encoding = "cp1252".',
                )
            ) from error
        data = data if codecs.lookup(encoding).name == "utf-8" else decoded.encode()
    data = data.removeprefix(codecs.BOM_UTF8)
    nul = data.find(b"\0")
    if nul >= 0:
        raise request.error(
            request.problem(
                "there are zero bytes: the file is damaged or not plain text.",
                row=data.count(b"\n", 0, nul) + line,
            )
        )
    return data


def line_end(data: bytes, start: int) -> int:
    """Where the line that begins at `start` ends."""
    found = data.find(b"\n", start)
    return len(data) if found < 0 else found


def _last(data: bytes) -> int:
    """Where the last line that holds something ends."""
    stop = len(data)
    while stop and data[stop - 1] in b"\r\n ":
        stop -= 1
    return stop


def fields_of(line: bytes, delimiter: str) -> list[str]:
    """The fields of a line, without the blanks around them."""
    text = line.decode("utf-8", "replace").rstrip("\r\n")
    if delimiter == BLANKS:
        return text.removeprefix("#").split()
    if '"' not in text:
        return [cell.strip() for cell in text.split(delimiter)]
    return [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter), [""])]


def _headers(line: bytes, delimiter: str) -> tuple[str, ...]:
    text = line.decode("utf-8").strip().removeprefix("#").strip()
    if delimiter == BLANKS:
        return tuple(found[0] for found in _BLANK_HEADER.finditer(text))
    return tuple(fields_of(text.encode(), delimiter))


def _dialect(text: bytes, request: Request) -> tuple[str, str]:
    """Delimiter and decimal sign: as stated, else what makes most cells of the top numbers."""
    options = request.options
    sample = [line for line in text.split(b"\n")[1 : _SAMPLE + 1] if line.strip()]
    sample = sample or text.split(b"\n")[:1]
    best, chosen = -1.0, (options.delimiter or ",", options.decimal or ".")
    for delimiter, decimal in _CANDIDATES:
        if options.delimiter not in (None, delimiter) or options.decimal not in (None, decimal):
            continue
        rows = [fields_of(line, delimiter) for line in sample]
        counts = sorted(len(row) for row in rows)
        width = counts[len(counts) // 2]
        if width < 2:
            continue
        listed = [cell for row in rows for cell in row]
        numbers = sum(to_number(cell, decimal) is not None for cell in listed)
        score = counts.count(width) / len(counts) * numbers / len(listed)
        if score > best:
            best, chosen = score, (delimiter, decimal)
        if score == 1.0:
            break
    return chosen


def _is_header(top: Sequence[str], decimal: str, request: Request) -> bool:
    if request.options.header is not None:
        return request.options.header
    numbers = sum(bool(cell) and to_number(cell, decimal) is not None for cell in top)
    if numbers == 0:
        return True
    if numbers == len([cell for cell in top if cell]):
        return False
    if numbers * 2 < len(top):
        return True
    raise request.error(
        request.problem(
            "the first line mixes numbers and text: it is a header or a damaged row.",
            row=request.options.skip_rows + 1,
            remedy="Say which in [source]: header = true or header = false.",
        )
    )


def cut_off(text: Text) -> bool:
    """Whether a last line without line end looks shorter in its last number than the others."""
    if any(end in text.data[text.stop :] for end in (b"\n", b"\r")):
        return False
    pattern = re.compile(
        rb"[^" + re.escape(text.decimal.encode()) + rb"eE]*(?:"
        + re.escape(text.decimal.encode()) + rb"(\d*))?(?:[eE][+-]?(\d*))?"
    )  # fmt: skip
    tails = [
        (len(found[1] or b""), len(found[2] or b""))
        for line in text.data[max(text.start, text.stop - 65536) : text.stop].split(b"\n")[
            -_SAMPLE:
        ]
        if (fields := fields_of(line, text.delimiter))
        and (found := pattern.fullmatch(fields[-1].encode()))
    ]
    if len(tails) < 3:
        return False
    return any(tails[-1][part] < min(tail[part] for tail in tails[1:-1]) for part in (0, 1))
