"""What stands above the numbers of a text file: a preamble, names, units; and how they are set."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from pmmkit.conventions import is_unit, split_unit
from pmmkit.readers.base import Request, to_number
from pmmkit.readers.text.decoding import CUT
from pmmkit.readers.text.stamps import is_date, is_stamp

BLANKS: Final = " "
COMMENTS: Final = ("#", "%", "!", "//")
"""What a line begins with that holds no numbers, where the campaign file does not say."""
CANDIDATES: Final = (
    (";", "."),
    (";", ","),
    ("\t", "."),
    ("\t", ","),
    (",", "."),
    (BLANKS, "."),
    (BLANKS, ","),
)
"""Delimiters and decimal signs that are tried, in this order."""
_FIXED: Final = ((CUT, "."), (CUT, ","))
_SAMPLE: Final = 20
_TOP: Final = 65536
_ROWS: Final = 3
"""Rows of numbers of one width that are taken for the beginning of the table."""
_BLANK_HEADER: Final = re.compile(
    r"(?:[^\s\[(]|\[[^\]]*\]|\([^)]*\))+(?:\s+(?:\[[^\]]*\]|\([^)]*\)))?"
)
"""A header among blanks, with the unit in brackets that may stand apart from it."""
_BLANK_UNIT: Final = re.compile(r"\[[^\]]*\]|\([^)]*\)|\S+")
_MARKS: Final = (*COMMENTS, "C", "c", "*")
"""What stands apart before names in a line that is a comment, of Fortran too."""
_GROUPED: Final = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")


@dataclass(frozen=True, kw_only=True)
class Heading:
    """Where the rows begin, what their columns are called and how they are written.

    `headers`: names, with their units in brackets where a line of units says so; None without
    names. `start, line`: where in the text, and in which line counted from 1, the rows begin.
    `delimiter, decimal`: what stands between fields; decimal sign. `notes`: what was left out
    above.
    """

    headers: tuple[str, ...] | None
    start: int
    line: int
    delimiter: str
    decimal: str
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Line:
    """A line at the top of a file that holds something; of a comment what follows its mark."""

    number: int
    start: int
    stop: int
    text: bytes
    comment: bool


@dataclass(frozen=True)
class _Table:
    """Where the first row of numbers stands among the lines, and how it is written."""

    index: int
    width: int
    delimiter: str
    decimal: str


def find_heading(data: bytes, start: int, stop: int, line: int, request: Request) -> Heading:
    """Find names and units and the first row.

    Names stand in the first line, or in the last of the comments above the rows. Where the file
    cannot be read so and ``skip_rows`` is not stated, the first rows of numbers of one width are
    looked for, and the line above them is taken for the names.
    """
    for count in (_SAMPLE + 4, -1):
        lines = _top(data, start, stop, line, request, count)
        plain = [item for item in lines if not item.comment]
        delimiter, decimal = _dialect([item.text for item in plain], request)
        lines = _as_wide(lines, delimiter, decimal)
        plain = [item for item in lines if not item.comment]
        as_usual = _reads(plain, delimiter, decimal, request)
        if as_usual and decimal == ".":
            break
    if not plain:
        raise request.error("there are comments and no rows of numbers.")
    if not request.options.skip_rows and not as_usual:
        table = _rows_of_numbers(plain, request, whole=plain[-1].stop >= stop)
        if table is not None and _has_preamble(plain, table, request):
            return _below_preamble(lines, plain, table, request)
    first = plain[0]
    _refuse_grouped([item.text for item in plain], delimiter, decimal, request)
    top = fields_of(first.text, delimiter)
    commented = lines[: lines.index(first)] if _all_numbers(top, decimal) else []
    commented = _without_remarks(commented, len(top), delimiter)
    names = _names(commented, len(top), delimiter, decimal, request)
    if names is not None or not _is_header(first, delimiter, decimal, request):
        return Heading(
            headers=names,
            start=first.start,
            line=first.number,
            delimiter=delimiter,
            decimal=decimal,
        )
    below = plain[1] if len(plain) > 1 else first
    width, last = len(fields_of(below.text, delimiter)), first
    headers = names_in(first.text, width, delimiter)
    if request.options.units_row and len(plain) == 1:
        raise request.error("there is no line of units below the names.")
    if len(plain) > 1 and _is_units(plain[1], len(headers), delimiter, decimal, request):
        last = plain[1]
        headers = _with_units(headers, last, delimiter, request)
    if last.stop >= stop:
        raise request.error("the file has a header and no rows of numbers below it.")
    return Heading(
        headers=headers,
        start=last.stop + 1,
        line=last.number + 1,
        delimiter=delimiter,
        decimal=decimal,
    )


def line_end(data: bytes, start: int) -> int:
    """Where the line that begins at `start` ends."""
    found = data.find(b"\n", start)
    return len(data) if found < 0 else found


def fields_of(line: bytes, delimiter: str) -> list[str]:
    """The fields of a line, without the blanks around them."""
    text = line.decode("utf-8", "replace").rstrip("\r\n")
    if delimiter == BLANKS:
        return text.split()
    if '"' not in text:
        return [cell.strip() for cell in text.split(delimiter)]
    return [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter), [""])]


def headers_of(line: bytes, delimiter: str) -> tuple[str, ...]:
    """The names in a header line, a comment sign before them left out."""
    text = line.decode("utf-8").strip().removeprefix("#").strip()
    if delimiter == BLANKS:
        return tuple(found[0] for found in _BLANK_HEADER.finditer(text))
    return tuple(fields_of(text.encode(), delimiter))


def names_in(line: bytes, width: int, delimiter: str) -> tuple[str, ...]:
    """The names in a header line of so many columns, a mark of a comment apart left out.

    Examples
    --------
    >>> names_in(b"C   TIME[S]  FX[N]", 2, BLANKS)
    ('TIME[S]', 'FX[N]')
    """
    names = headers_of(line, delimiter)
    marked = len(names) == width + 1 and names[0] in _MARKS
    return names[1:] if marked else names


def within(fields: Sequence[str], width: int) -> list[str]:
    """The fields without empty ones beyond a width: what a delimiter at the end of a line leaves.

    Examples
    --------
    >>> within(["time", "X", ""], 2), within(["time", "", "X"], 2)
    (['time', 'X'], ['time', '', 'X'])
    """
    found = list(fields)
    while len(found) > width and not found[-1]:
        found.pop()
    return found


def comment_marks(request: Request) -> tuple[str, ...]:
    """What comments begin with."""
    return COMMENTS if request.options.comment is None else (request.options.comment,)


def looks_like_row(line: bytes, width: int, delimiter: str, decimal: str) -> bool:
    """Whether a line has as many fields as the table and half of them or more are numbers."""
    fields = fields_of(line, delimiter)
    return len(fields) == width and 2 * count_numbers(fields, decimal) >= width


def _top(
    data: bytes, start: int, stop: int, line: int, request: Request, count: int
) -> list[_Line]:
    """The first lines of a file, at most `count` if that is not -1, without those left blank."""
    marks = tuple(mark.encode() for mark in comment_marks(request))
    end = min(stop, line_end(data, start + _TOP))
    top = data[start:end].split(b"\n", count)
    found = []
    for number, text in enumerate(top if count < 0 else top[:count], start=line):
        place = start
        start += len(text) + 1
        if text.strip():
            mark = next((mark for mark in marks if text.startswith(mark)), b"")
            found.append(_Line(number, place, start - 1, text[len(mark) :], bool(mark)))
    return found


def _as_wide(lines: Sequence[_Line], delimiter: str, decimal: str) -> list[_Line]:
    """The lines, those of texts without delimiters at their end beyond the width of the rows."""
    if delimiter in (BLANKS, CUT):
        return list(lines)
    rows = [fields_of(line.text, delimiter) for line in lines]
    widths = Counter(len(row) for row in rows if len(row) > 1 and _all_numbers(row, decimal))
    if not widths:
        return list(lines)
    (width, _), *_ = widths.most_common(1)
    return [
        line
        if _all_numbers(row, decimal) or len(row) <= width
        else replace(line, text=_cut_to(line.text, delimiter, len(row) - len(within(row, width))))
        for line, row in zip(lines, rows, strict=True)
    ]


def _cut_to(text: bytes, delimiter: str, surplus: int) -> bytes:
    """A line without its last fields, which are empty."""
    return text.rsplit(delimiter.encode(), surplus)[0] if surplus else text


def _candidates(request: Request) -> list[tuple[str, str]]:
    options = request.options
    return [
        (delimiter, decimal)
        for delimiter, decimal in (CANDIDATES if options.widths is None else _FIXED)
        if options.delimiter in (None, delimiter) and options.decimal in (None, decimal)
    ]


def _dialect(lines: Sequence[bytes], request: Request) -> tuple[str, str]:
    """Delimiter and decimal sign: as stated, else what makes most cells of the top numbers."""
    options = request.options
    sample = lines[1 : _SAMPLE + 1] or lines[:1]
    best, chosen = -1.0, (options.delimiter or ",", options.decimal or ".")
    for delimiter, decimal in _candidates(request):
        if delimiter != BLANKS and not any(delimiter.encode() in line for line in sample):
            continue
        rows = [fields_of(line, delimiter) for line in sample]
        counts = sorted(len(row) for row in rows)
        width = counts[len(counts) // 2] if counts else 0
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


def _refuse_grouped(lines: Sequence[bytes], delimiter: str, decimal: str, request: Request) -> None:
    """Refuse commas of which it cannot be told whether they group thousands."""
    if decimal != "," or request.options.decimal is not None:
        return
    cells = [cell for line in lines for cell in fields_of(line, delimiter)]
    commas = [cell for cell in cells if "," in cell and to_number(cell, ",") is not None]
    if commas and all(_GROUPED.fullmatch(cell) for cell in commas):
        whole, part = commas[0].split(",", 1)
        raise request.error(
            f"{commas[0]!r} is {whole}.{part} with a decimal comma and {whole}{part} with "
            "thousands separators; nothing in the first rows tells which.",
            remedy='Write decimal = "," in [source], or export without thousands separators.',
        )


def count_numbers(fields: Sequence[str], decimal: str) -> int:
    """How many fields are numbers, or dates and instants."""
    return sum(
        bool(cell) and (to_number(cell, decimal) is not None or is_stamp(cell) or is_date(cell))
        for cell in fields
    )


def _reads(lines: Sequence[_Line], delimiter: str, decimal: str, request: Request) -> bool:
    """Whether the first line and the one below it (and units) are header and row, or two rows."""
    if not lines:
        return False
    top = fields_of(lines[0].text, delimiter)
    below = 1
    if len(lines) > 1 and _is_units(lines[1], len(top), delimiter, decimal, request):
        below = 2
    if len(lines) <= below:
        return True
    row = fields_of(lines[below].text, delimiter)
    return len(row) == len(top) and all(to_number(cell, decimal) is not None for cell in row)


def _rows_of_numbers(lines: Sequence[_Line], request: Request, *, whole: bool) -> _Table | None:
    """The first rows that are all numbers and of one width, in the dialect that reads most."""
    best, found = 0, None
    for delimiter, decimal in _candidates(request):
        rows = [fields_of(line.text, delimiter) for line in lines]
        widths = [len(row) if _all_numbers(row, decimal) else 0 for row in rows]
        for index, width in enumerate(widths):
            run = widths[index : index + _ROWS]
            enough = len(run) == _ROWS or (whole and len(run) > 1)
            if width > 1 and enough and set(run) == {width}:
                count = widths.count(width)
                if count > best:
                    best, found = count, _Table(index, width, delimiter, decimal)
                break
    return found


def _all_numbers(row: Sequence[str], decimal: str) -> bool:
    filled = [cell for cell in row if cell]
    return (
        bool(row[:1] and row[0])
        and 2 * len(filled) >= len(row)
        and all(to_number(cell, decimal) is not None for cell in filled)
    )


def _has_preamble(lines: Sequence[_Line], table: _Table, request: Request) -> bool:
    """Whether more stands above the rows than names and units, and not names and damaged rows."""
    dialect = table.delimiter, table.decimal
    units = table.index > 1 and _is_units(lines[table.index - 1], table.width, *dialect, request)
    if table.index < 2 + units:
        return False
    top, below = (fields_of(line.text, table.delimiter) for line in lines[:2])
    named = len(top) == table.width and 2 * count_numbers(top, table.decimal) < len(top)
    return not (named and count_numbers(below, table.decimal))


def _below_preamble(
    lines: Sequence[_Line], plain: Sequence[_Line], table: _Table, request: Request
) -> Heading:
    first = plain[table.index]
    above = lines[: lines.index(first)]
    delimiter, decimal = table.delimiter, table.decimal
    damaged = [
        request.problem(
            f"the line looks like a damaged row: rows of {table.width} numbers begin only in row "
            f"{first.number}.",
            row=line.number,
            remedy="Copy the file again, or state skip_rows in [source].",
        )
        for line in above
        if looks_like_row(line.text, table.width, delimiter, decimal)
        or (line is above[-1] and _may_be_row(line, table, request))
    ]
    if damaged:
        raise request.error(*damaged)
    above = _without_remarks(above, table.width, delimiter)
    if _names_too_high(above, table, request):
        raise request.error(
            f"rows {above[-2].number} and {above[-1].number} may both be the names of the columns.",
            row=above[-1].number,
            remedy=f"State in [source] skip_rows = {above[-2].number} if the names are in row "
            f"{above[-1].number}, or skip_rows = {above[-2].number - 1} and units_row = true "
            f"if units are; else row {above[-1].number} is damaged.",
        )
    _refuse_grouped([line.text for line in plain[table.index :]], delimiter, decimal, request)
    names = _names(above, table.width, delimiter, decimal, request)
    title = "no line of names above them" if names is None else "the names just above them"
    return Heading(
        headers=names,
        start=first.start,
        line=first.number,
        delimiter=delimiter,
        decimal=decimal,
        notes=(f"rows of numbers found to begin in line {first.number}, {title}",),
    )


def _may_be_row(line: _Line, table: _Table, request: Request) -> bool:
    """Whether the line above the rows may be one: as wide with a number, or half of it numbers."""
    fields = fields_of(line.text, table.delimiter)
    count = count_numbers(fields, table.decimal)
    if len(fields) == table.width:
        return count > 0 and request.options.header is None
    return count > 1 and 2 * count >= len(fields)


def _names_too_high(above: Sequence[_Line], table: _Table, request: Request) -> bool:
    """Whether what looks like names stands two lines above the rows and is not above units."""
    if len(above) < 2 or _is_units(above[-1], table.width, table.delimiter, table.decimal, request):
        return False
    names = headers_of(above[-2].text, table.delimiter)
    return len(names) == table.width and all(names) and not count_numbers(names, table.decimal)


def _without_remarks(lines: Sequence[_Line], width: int, delimiter: str) -> list[_Line]:
    """The lines without comments that cannot be names or units."""
    return [
        line
        for line in lines
        if not line.comment or len(names_in(line.text, width, delimiter)) == width
    ]


def _names(
    above: Sequence[_Line], width: int, delimiter: str, decimal: str, request: Request
) -> tuple[str, ...] | None:
    """Names in the last line above the rows, or in the one above a line of units."""
    if request.options.header is False or not above:
        return None
    units = len(above) > 1 and _is_units(above[-1], width, delimiter, decimal, request)
    line = above[-2] if units else above[-1]
    headers = names_in(line.text, width, delimiter)
    if len(headers) != width or (
        2 * count_numbers(headers, decimal) >= width and request.options.header is None
    ):
        return None
    return _with_units(headers, above[-1], delimiter, request) if units else headers


def _units(line: _Line, delimiter: str) -> list[str]:
    """The cells of a line of units, without brackets."""
    cells = (
        _BLANK_UNIT.findall(line.text.decode("utf-8").strip())
        if delimiter == BLANKS
        else fields_of(line.text, delimiter)
    )
    return [cell[1:-1].strip() if cell[:1] + cell[-1:] in ("[]", "()") else cell for cell in cells]


def _is_units(line: _Line, width: int, delimiter: str, decimal: str, request: Request) -> bool:
    """Whether a line holds units: as stated, else no number and nothing but known units."""
    if request.options.units_row is not None:
        return request.options.units_row
    cells = _units(line, delimiter)
    if len(cells) != width or not any(cells) or count_numbers(cells, decimal):
        return False
    return all(map(is_unit, cells))


def _with_units(
    headers: Sequence[str], line: _Line, delimiter: str, request: Request
) -> tuple[str, ...]:
    units = _units(line, delimiter)
    if len(units) != len(headers):
        raise request.error(
            f"the line of units has {len(units)} fields, the names are {len(headers)}.",
            row=line.number,
        )
    pairs = [
        (header, split_unit(header)[1], unit) for header, unit in zip(headers, units, strict=True)
    ]
    problems = [
        request.problem(
            f"the name says {own!r}, the line of units {unit!r}.", row=line.number, column=header
        )
        for header, own, unit in pairs
        if own is not None and unit not in ("", own)
    ]
    if problems:
        raise request.error(*problems)
    return tuple(
        f"{header} [{unit}]" if unit and own is None else header for header, own, unit in pairs
    )


def _is_header(line: _Line, delimiter: str, decimal: str, request: Request) -> bool:
    """Whether a line holds names: as stated, else by how many of its fields are numbers."""
    if request.options.header is not None:
        return request.options.header
    top = fields_of(line.text, delimiter)
    numbers = count_numbers(top, decimal)
    if numbers == 0:
        return True
    if numbers == len([cell for cell in top if cell]):
        return False
    if numbers * 2 < len(top):
        return True
    raise request.error(
        "the first line mixes numbers and text: it is a header or a damaged row.",
        row=line.number,
        remedy="Say which in [source]: header = true or header = false.",
    )
