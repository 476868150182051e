"""Text files of columns: comma, semicolon, tab or blanks between them.

The fast way lets pandas parse the numbers once the bytes are known to be well formed: every line
has the same number of fields, as many rows come out as there are lines, every number is finite.
Whatever is not so goes the careful way, line by line, which names each fault. Both give the same
numbers.
"""

from __future__ import annotations

import codecs
import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.errors import Problem
from pmmkit.runs.readers.base import (
    ABSURD,
    Array,
    Cells,
    Choose,
    Columns,
    Request,
    columns_of,
    to_number,
)

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
_SAMPLE: Final = 50
_BLANK_HEADER: Final = re.compile(
    r"(?:[^\s\[(]|\[[^\]]*\]|\([^)]*\))+(?:\s+(?:\[[^\]]*\]|\([^)]*\)))?"
)
"""A header among blanks, with the unit in brackets that may stand apart from it."""


@dataclass(frozen=True)
class _Text:
    """A text file taken apart: its header and the bytes below."""

    headers: tuple[str, ...] | None
    body: bytes
    first_line: int
    delimiter: str
    decimal: str
    line_ended: bool


def names(request: Request) -> tuple[str, ...]:
    """Headers of the file, empty strings where it has none."""
    text = _take_apart(request)
    return text.headers or ("",) * len(_fields(_lines(text.body)[0], text.delimiter))


def columns(request: Request, choose: Choose) -> Columns:
    """Some columns as numbers; columns that are not chosen are not parsed.

    Raises
    ------
    CampaignError
        With every line that has too many or too few fields and every cell that is empty, not a
        number, infinite or absurdly large; or because the text cannot be decoded.
    """
    text = _take_apart(request)
    width = len(text.headers or _fields(_lines(text.body[:65536])[0], text.delimiter))
    headers = text.headers or ("",) * width
    positions = tuple(choose(headers, width))
    if not _cut_off(text):
        values = _fast(text, positions, width)
        if values is not None:
            return Columns(headers=headers, positions=positions, values=values)
    return columns_of(_careful(text, width, request), positions, request)


def cells(request: Request) -> Cells:
    """All cells of a small file as text.

    Raises
    ------
    CampaignError
        If the file is empty or cannot be decoded, or if rows are not well formed.
    """
    text = _take_apart(request)
    width = len(text.headers or _fields(_lines(text.body)[0], text.delimiter))
    found = _careful(text, width, request)
    if found.problems:
        raise request.error(*found.problems)
    return found


def _take_apart(request: Request) -> _Text:
    options = request.options
    try:
        data = request.path.read_bytes()
    except OSError as error:
        raise request.error(request.problem(f"cannot be read: {error.strerror}.")) from error
    data = _as_utf8(data, request)
    if b"\r" in data and data.count(b"\r") != data.count(b"\r\n"):
        if b"\n" in data:
            stray = re.search(rb"\r(?!\n)", data)
            row = data.count(b"\n", 0, stray.start()) + 1 if stray else None
            if stray is None or stray.end() != len(data):
                raise request.error(
                    request.problem("there is a carriage return inside the line.", row=row)
                )
        else:
            data = data.replace(b"\r", b"\n")
    start, line = 0, 1
    while start < len(data) and (
        line <= options.skip_rows or not data[start : _end(data, start)].strip()
    ):
        start, line = _end(data, start) + 1, line + 1
    stop = _last(data)
    if start >= stop:
        skipped = f" below the {options.skip_rows} rows skipped" if options.skip_rows else ""
        raise request.error(request.problem(f"the file is empty{skipped}."))
    delimiter, decimal = _dialect(data[start : min(stop, start + 65536)], request)
    first = data[start : _end(data, start)]
    headers = None
    if _is_header(_fields(first, delimiter), decimal, request):
        headers = _headers(first, delimiter)
        start, line = _end(data, start) + 1, line + 1
        if start >= stop:
            raise request.error(
                request.problem("the file has a header and no rows of numbers below it.")
            )
    ended = any(end in data[stop:] for end in (b"\n", b"\r"))
    return _Text(headers, data[start:stop], line, delimiter, decimal, ended)


def _as_utf8(data: bytes, request: Request) -> bytes:
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
    plain = "az09,\n".encode(encoding) == b"az09,\n"
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
                    row=data.count(b"\n", 0, place) + 1 if plain and place is not None else None,
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
                row=data.count(b"\n", 0, nul) + 1,
            )
        )
    return data


def _end(data: bytes, start: int) -> int:
    found = data.find(b"\n", start)
    return len(data) if found < 0 else found


def _last(data: bytes) -> int:
    """Where the last line that holds something ends."""
    stop = len(data)
    while stop and data[stop - 1] in b"\r\n ":
        stop -= 1
    return stop


def _lines(body: bytes) -> list[bytes]:
    return body.split(b"\n")


def _fields(line: bytes, delimiter: str) -> list[str]:
    text = line.decode("utf-8", "replace").rstrip("\r\n")
    if delimiter == BLANKS:
        return text.removeprefix("#").split()
    return [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter), [""])]


def _headers(line: bytes, delimiter: str) -> tuple[str, ...]:
    text = line.decode("utf-8").strip().removeprefix("#").strip()
    if delimiter == BLANKS:
        return tuple(found[0] for found in _BLANK_HEADER.finditer(text))
    return tuple(_fields(text.encode(), delimiter))


def _dialect(text: bytes, request: Request) -> tuple[str, str]:
    """Delimiter and decimal sign: as stated, else what makes most cells of the top numbers."""
    options = request.options
    sample = [line for line in _lines(text)[1 : _SAMPLE + 1] if line.strip()]
    sample = sample or _lines(text)[:1]
    best, chosen = -1.0, (options.delimiter or ",", options.decimal or ".")
    for delimiter, decimal in _CANDIDATES:
        if options.delimiter not in (None, delimiter) or options.decimal not in (None, decimal):
            continue
        rows = [_fields(line, delimiter) for line in sample]
        counts = sorted(len(row) for row in rows)
        width = counts[len(counts) // 2]
        listed = [cell for row in rows for cell in row]
        numbers = sum(to_number(cell, decimal) is not None for cell in listed)
        alike = sum(count == width for count in counts) / len(counts)
        score = alike * numbers / max(len(listed), 1) if width > 1 else 0.0
        if score > best:
            best, chosen = score, (delimiter, decimal)
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


def _cut_off(text: _Text) -> bool:
    """Whether a last line without line end looks shorter in its last number than the others."""
    if text.line_ended:
        return False
    pattern = re.compile(
        rb"[^" + re.escape(text.decimal.encode()) + rb"eE]*(?:"
        + re.escape(text.decimal.encode()) + rb"(\d*))?(?:[eE][+-]?(\d*))?"
    )  # fmt: skip
    tails = [
        (len(found[1] or b""), len(found[2] or b""))
        for line in _lines(text.body[-65536:])[-_SAMPLE:]
        if (fields := _fields(line, text.delimiter))
        and (found := pattern.fullmatch(fields[-1].encode()))
    ]
    if len(tails) < 3:
        return False
    return any(tails[-1][part] < min(tail[part] for tail in tails[1:-1]) for part in (0, 1))


def _fast(text: _Text, positions: Sequence[int], width: int) -> tuple[Array, ...] | None:
    """The numbers, or None where anything is not as it should be."""
    import pandas as pd

    body = text.body
    if b'"' in body or not positions or width < 2:
        return None
    every = set(positions) == set(range(width))
    count = _well_formed(body, text.delimiter, width, every=every)
    if count is None:
        return None
    try:
        table = pd.read_csv(
            io.BytesIO(body),
            header=None,
            usecols=None if every else sorted(set(positions)),
            dtype=np.float64,
            quoting=csv.QUOTE_NONE,
            decimal=text.decimal,
            low_memory=False,
            sep=r"\s+" if text.delimiter == BLANKS else text.delimiter,
        )
    except (ValueError, OverflowError):
        return None
    if len(table) != count:
        return None
    values = tuple(np.ascontiguousarray(table[place].to_numpy()) for place in positions)
    within = all(
        float(column.max()) <= ABSURD and float(column.min()) >= -ABSURD for column in values
    )
    return values if within else None


def _well_formed(body: bytes, delimiter: str, width: int, *, every: bool) -> int | None:
    """Number of lines if each has `width` fields (see below), else None.

    With `every` only the sum over all lines is checked: the parser refuses a line with more fields
    than the first one, so none can have fewer.
    """
    code = np.frombuffer(body, dtype=np.uint8)
    count = int(np.count_nonzero(code == 10)) + 1
    if delimiter == BLANKS:
        if np.any((code > 127) | ((code < 32) & (code != 10) & (code != 13) & (code != 9))):
            return None
        gap = code <= 32
        starts = ~gap
        starts[1:] &= gap[:-1]
        where = np.flatnonzero(starts)
        if len(where) != count * width:
            return None
        line = np.searchsorted(np.flatnonzero(code == 10), where[::width])
        last = np.searchsorted(np.flatnonzero(code == 10), where[width - 1 :: width])
        whole = np.array_equal(line, np.arange(count)) and np.array_equal(line, last)
        return count if whole else None
    if every:
        total = int(np.count_nonzero(code == ord(delimiter)))
        return count if total == count * (width - 1) and _first_is(body, delimiter, width) else None
    marks = np.flatnonzero((code == 10) | (code == ord(delimiter)))
    if len(marks) != count * width - 1:
        return None
    return count if bool(np.all(code[marks[width - 1 :: width]] == 10)) else None


def _first_is(body: bytes, delimiter: str, width: int) -> bool:
    return body.count(delimiter.encode(), 0, _end(body, 0)) == width - 1


def _careful(text: _Text, width: int, request: Request) -> Cells:
    rows: list[tuple[str, ...]] = []
    lines: list[int] = []
    problems: list[Problem] = []
    for line, raw in enumerate(_lines(text.body), start=text.first_line):
        try:
            fields = _strict_fields(raw, text.delimiter)
        except csv.Error as error:
            problems.append(request.problem(f"the quotes do not match ({error}).", row=line))
            continue
        if not raw.strip():
            problems.append(request.problem("the line is empty.", row=line))
        elif len(fields) != width:
            few = "few" if len(fields) < width else "many"
            problems.append(
                request.problem(f"{len(fields)} fields, too {few}: there are {width}.", row=line)
            )
        else:
            rows.append(tuple(fields))
            lines.append(line)
    if _cut_off(text):
        problems.append(
            request.problem(
                "the last line has no line end and its last number fewer digits than the others: "
                "the file looks cut off.",
                row=text.first_line + text.body.count(b"\n"),
                remedy="Copy it again; if it is complete, end the last line with a line end.",
            )
        )
    return Cells(
        headers=text.headers or ("",) * width,
        rows=tuple(rows),
        lines=tuple(lines),
        decimal=text.decimal,
        problems=tuple(problems),
    )


def _strict_fields(line: bytes, delimiter: str) -> list[str]:
    text = line.decode("utf-8").rstrip("\r\n")
    if delimiter == BLANKS:
        return text.split()
    return next(csv.reader([text], delimiter=delimiter, strict=True), [""])
