"""Taking a text file apart: encoding, comments, header, where and how the numbers stand."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.runs.readers.base import Request
from pmmkit.runs.readers.decoding import cut_apart, decoded, unix_ends
from pmmkit.runs.readers.heading import (
    BLANKS,
    CANDIDATES,
    Heading,
    comment_marks,
    fields_of,
    find_heading,
    headers_of,
    line_end,
    looks_like_row,
)

__all__ = [
    "BLANKS",
    "CANDIDATES",
    "Text",
    "cut_off",
    "fields_of",
    "headers_of",
    "line_end",
    "surely_whole",
    "take_apart",
]

_SAMPLE: Final = 20


@dataclass(frozen=True, kw_only=True)
class Text:
    """A text file taken apart.

    Parameters
    ----------
    headers : tuple of str or None
        Names in the header; None where there is none.
    data : bytes
        The whole file as UTF-8, without comments among the rows.
    start, stop : int
        Where in `data` the rows of numbers begin and end, line ends after them left out.
    first_line : int
        Line of the file, counted from 1, in which the rows begin.
    delimiter, decimal : str
        What stands between fields (a blank for any number of blanks or tabs); decimal sign.
    comments : tuple of int
        Lines of the file, counted from 1, below the first of the rows that held comments.
    notes : tuple of str
        What was left out or found out.
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
        count = self.data.count(b"\n", self.start, self.stop) + 1 + len(self.comments)
        every = np.arange(self.first_line, self.first_line + count)
        return [int(line) for line in np.setdiff1d(every, self.comments)]

    @property
    def width(self) -> int:
        """Number of columns."""
        if self.headers is not None:
            return len(self.headers)
        end = min(line_end(self.data, self.start), self.stop)
        return len(fields_of(self.data[self.start : end], self.delimiter))


def take_apart(request: Request) -> Text:
    """Read a text file and find out how it is written.

    Raises
    ------
    CampaignError
        If it is empty, has no rows of numbers, cannot be decoded or holds zero bytes.
    """
    options = request.options
    if options.widths is not None and options.delimiter is not None:
        raise request.error(
            request.problem("widths and delimiter are both stated; a file has one or the other.")
        )
    try:
        data = request.path.read_bytes()
    except OSError as error:
        raise request.error(request.problem(f"cannot be read: {error.strerror}.")) from error
    text = decoded(data, request)
    data = unix_ends(text.data, request)
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
        raise request.error(request.problem(f"the file is empty{skipped}."))
    heading = find_heading(data, start, stop, line, request)
    notes = heading.notes
    if text.doubt is not None:
        if not data[heading.start :].isascii():
            raise request.error(text.doubt)
        notes = (*notes, "the heading is not UTF-8 and was read as cp1252")
    data, comments = _without_comments(data, stop, heading, request)
    if comments:
        notes = (*notes, f"{len(comments)} lines of comments among the rows left out")
    return Text(
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
    """Where the last line that holds something ends."""
    stop = len(data)
    while stop and data[stop - 1] in b"\r\n ":
        stop -= 1
    return stop


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
    pattern = re.compile(
        rb"[^" + re.escape(text.decimal.encode()) + rb"eE]*(?:"
        + re.escape(text.decimal.encode()) + rb"(\d*))?(?:[eE][+-]?(\d*))?"
    )  # fmt: skip
    return [
        (len(found[1] or b""), len(found[2] or b""))
        for line in text.data[max(text.start, text.stop - 65536) : text.stop].split(b"\n")[
            -_SAMPLE:
        ]
        if (fields := fields_of(line, text.delimiter))
        and (found := pattern.fullmatch(fields[-1].encode()))
    ]
