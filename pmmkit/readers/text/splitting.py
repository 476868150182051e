"""Taking a text file apart: encoding, comments, header, where and how the numbers stand."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import BinaryIO, Final

import numpy as np

from pmmkit.readers.base import Request
from pmmkit.readers.text.decoding import cut_apart, decoded, keeps_line_ends, marked, unix_ends
from pmmkit.readers.text.heading import (
    BLANKS,
    Heading,
    comment_marks,
    fields_of,
    find_heading,
    line_end,
    looks_like_row,
)

__all__ = [
    "BLANKS",
    "Text",
    "blocks",
    "comments_left_out",
    "cut_off",
    "fields_of",
    "line_end",
    "surely_whole",
    "take_apart",
]

_SAMPLE: Final = 20
BLOCK: Final = 1 << 22
"""Bytes of a large file that are read at once."""


@dataclass(frozen=True, kw_only=True)
class Text:
    """A text file, or a piece of it, taken apart.

    `headers`: names in the header; None where there is none. `data`: its text as UTF-8, without
    comments among the rows. `start, stop`: where in `data` the rows of numbers begin and end,
    line ends after them left out. `first_line`: line of the file, counted from 1, in which the
    rows begin. `delimiter, decimal`: what stands between fields (a blank for any number of
    blanks or tabs); decimal sign. `comments`: lines of the file, counted from 1, below the
    first of the rows that held comments. `notes`: what was left out or found out.
    """

    headers: tuple[str, ...] | None
    data: bytes
    start: int
    stop: int
    first_line: int
    delimiter: str
    decimal: str
    comments: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def lines(self) -> list[bytes]:
        """The rows of numbers."""
        return self.data[self.start : self.stop].split(b"\n")

    @property
    def numbers_of_lines(self) -> list[int]:
        """Line of the file, counted from 1, of each of the rows."""
        count = self.data.count(b"\n", self.start, self.stop) + 1
        every = np.arange(self.first_line, self.first_line + count + len(self.comments))
        return [int(line) for line in np.setdiff1d(every, self.comments)[:count]]

    @property
    def told(self) -> tuple[str, ...]:
        """The notes, and how many comments there were."""
        return (*self.notes, *comments_left_out(len(self.comments)))

    @property
    def width(self) -> int:
        """Number of columns."""
        if self.headers is not None:
            return len(self.headers)
        end = min(line_end(self.data, self.start), self.stop)
        return len(fields_of(self.data[self.start : end], self.delimiter))


def take_apart(request: Request) -> Text:
    """Read a text file whole and find out how it is written."""
    return _taken_apart(request.read(), request)[0]


def blocks(request: Request) -> Iterator[Text]:
    """A text file in pieces of whole lines, so that a large one is never in memory whole.

    Blank lines at the end of a piece go to the next one. The last piece is large enough to tell
    by it whether the file was cut off.
    """
    encoding = request.options.encoding or "utf-8"
    try:
        size = request.path.stat().st_size
        if size < 2 * BLOCK or request.options.widths or not keeps_line_ends(encoding):
            yield take_apart(request)
            return
        with request.path.open("rb") as stream:
            yield from _pieces(stream, request)
    except OSError as error:
        raise request.unreadable(error) from error


def _pieces(stream: BinaryIO, request: Request) -> Iterator[Text]:
    data, line = stream.read(BLOCK), 1
    if _line_feeds(data) <= request.options.skip_rows or marked(data) is not None:
        yield _taken_apart(data + stream.read(), request)[0]
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
            piece, heading = _taken_apart(part, request)
            heading = replace(heading, headers=piece.headers or ("",) * piece.width, start=0)
            first = replace(piece, headers=heading.headers, data=b"", notes=())
        else:
            plain, doubt = decoded(part, request, line)
            if doubt is not None:
                raise request.error(doubt)
            text = unix_ends(plain, request, line)
            text, comments = _without_comments(
                text, _last(text), replace(heading, line=line), request
            )
            piece = replace(
                first, data=text, start=0, stop=_last(text), first_line=line, comments=comments
            )
        yield piece
        line += _line_feeds(part)


def _line_feeds(data: bytes) -> int:
    return int(np.count_nonzero(np.frombuffer(data, dtype=np.uint8) == 10))


def _taken_apart(data: bytes, request: Request) -> tuple[Text, Heading]:
    options = request.options
    if options.widths is not None and options.delimiter is not None:
        raise request.error("widths and delimiter are both stated; a file has one or the other.")
    plain, doubt = decoded(data, request)
    data = unix_ends(plain, request)
    start, line = 0, 1
    while start < len(data) and (
        line <= options.skip_rows or not data[start : line_end(data, start)].strip()
    ):
        start, line = line_end(data, start) + 1, line + 1
    if options.widths is not None:
        data, start = cut_apart(data[start:], options.widths), 0
    stop = _last(data)
    if start >= stop:
        skipped = f" below the {options.skip_rows} rows skipped" if options.skip_rows else ""
        raise request.error(f"the file is empty{skipped}.")
    heading = find_heading(data, start, stop, line, request)
    notes = heading.notes
    if doubt is not None:
        if not data[heading.start :].isascii():
            raise request.error(doubt)
        notes = (*notes, "the heading is not UTF-8 and was read as cp1252")
    if empty := sum(bool(row.strip(b"\r ")) for row in data[stop:].split(b"\n")):
        notes = (*notes, f"the file ends in {empty} rows without a number; they are not read")
    data, comments = _without_comments(data, stop, heading, request)
    taken = Text(
        headers=heading.headers,
        data=data,
        start=heading.start,
        stop=_last(data),
        first_line=heading.line,
        delimiter=heading.delimiter,
        decimal=heading.decimal,
        comments=comments,
        notes=notes,
    )
    return taken, heading


def comments_left_out(count: int) -> tuple[str, ...]:
    """The note on comments among the rows, if there are any."""
    return (f"comments among the rows left out: {count} lines",) if count else ()


def _without_comments(
    data: bytes, stop: int, heading: Heading, request: Request
) -> tuple[bytes, tuple[int, ...]]:
    """The text without comments among its rows, and the lines of the file where they stood.

    Where the campaign file does not say what comments begin with, a line that looks like a row
    behind the sign stays: it is more likely a damaged row.
    """
    marks = [mark.encode() for mark in comment_marks(request)]
    if all(data.find(mark[:1], heading.start, stop) < 0 for mark in marks):
        return data, ()
    top = data[heading.start : line_end(data, heading.start)]
    width = len(heading.headers or fields_of(top, heading.delimiter))
    code = np.frombuffer(data, np.uint8, count=stop - heading.start, offset=heading.start)
    begins = np.append(0, np.flatnonzero(code == 10) + 1)
    likely = np.flatnonzero(np.isin(code[begins], [mark[0] for mark in marks]))
    kept, numbers, place = [], [], 0
    for index in likely.tolist():
        begin = heading.start + int(begins[index])
        end = line_end(data, begin)
        mark = next((mark for mark in marks if data.startswith(mark, begin)), None)
        if mark is None or (
            request.options.comment is None
            and looks_like_row(
                data[begin + len(mark) : end], width, heading.delimiter, heading.decimal
            )
        ):
            continue
        numbers.append(heading.line + index)
        kept.append(data[place:begin])
        place = min(end + 1, len(data))
    return b"".join([*kept, data[place:]]), tuple(numbers)


def _last(data: bytes) -> int:
    """Where the last line that holds something ends; spreadsheets end files in bare delimiters."""
    stop = len(data)
    while True:
        while stop and data[stop - 1] in b"\r\n ":
            stop -= 1
        begin = data.rfind(b"\n", 0, stop) + 1
        if not stop or data[begin:stop].strip(b",; \t\r"):
            return stop
        stop = begin


def cut_off(text: Text) -> bool:
    """Whether a last line without line end looks shorter in its last number than the others."""
    if _ended(text):
        return False
    tails = _digits(text)
    if len(tails) < 3:
        return False
    return any(tails[-1][part] < min(tail[part] for tail in tails[1:-1]) for part in (0, 1))


def surely_whole(text: Text) -> bool:
    """Whether the last line has a line end, or decimals as many as those above it have."""
    if _ended(text):
        return True
    tails = _digits(text)
    return len(tails) > 2 and any(tails[-1]) and len(set(tails[1:])) == 1


def _ended(text: Text) -> bool:
    return any(end in text.data[text.stop :] for end in (b"\n", b"\r"))


def _digits(text: Text) -> list[tuple[int, int]]:
    """Decimals and digits of the exponent in the last number of each of the last lines."""
    sign = re.escape(text.decimal)
    pattern = re.compile(rf"[^{sign}eE]*(?:{sign}([0-9]*))?(?:[eE][+-]?([0-9]*))?")
    return [
        (len(found[1] or ""), len(found[2] or ""))
        for line in text.data[max(text.start, text.stop - 65536) : text.stop].split(b"\n")[
            -_SAMPLE:
        ]
        if (fields := fields_of(line, text.delimiter)) and (found := pattern.fullmatch(fields[-1]))
    ]
