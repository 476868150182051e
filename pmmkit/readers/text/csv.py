"""Text files of columns: comma, semicolon, tab or blanks between them.

The fast way lets pandas parse the numbers once the bytes are known to be well formed: every line
has the same number of fields, as many rows come out as there are lines, every number is finite.
Whatever is not so goes the careful way, line by line, which names each fault. Both give the same
numbers.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from pmmkit.base import Problem
from pmmkit.numerics import ABSURD, Array
from pmmkit.readers.base import LISTED, Cells, Choose, Columns, Request, abridged, is_cell
from pmmkit.readers.text.heading import BLANKS, fields_of, line_end
from pmmkit.readers.text.splitting import Text, blocks, comments_left_out, cut_off, take_apart
from pmmkit.readers.text.stamps import elapsed, is_stamp, seconds_of


def names(request: Request) -> tuple[str, ...]:
    """Headers of the file, empty strings where it has none."""
    text = take_apart(request)
    return text.headers or ("",) * text.width


def columns(request: Request, choose: Choose) -> Columns:
    """Some columns as numbers; columns that are not chosen are not parsed.

    A large file is read in pieces; of each only the numbers are kept.
    """
    headers: tuple[str, ...] = ()
    positions: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()
    parts: list[Sequence[Array]] = []
    problems: list[Problem] = []
    stamped: frozenset[int] = frozenset()
    dropped = comments = 0
    for text in blocks(request):
        if not parts and not problems:
            headers = text.headers or ("",) * text.width
            positions = tuple(choose(headers, text.width))
            stamped = _stamped(text, positions)
            notes = text.notes
        comments += len(text.comments)
        text = _of_one_run(text, request)
        if text.stop <= text.start:
            continue
        values, missing, faults = _numbers(text, positions, request, stamped)
        dropped, problems = dropped + missing, [*problems, *faults]
        if len(problems) > LISTED:
            break
        parts.append(values)
    if problems:
        raise request.error(*abridged(problems, request))
    if not parts and request.options.where:
        said = " and ".join(f"{name} = {wanted}" for name, wanted in request.options.where)
        raise request.error(f"no row has {said}.")
    if not sum(len(part[0]) for part in parts if part):
        raise request.error("there are no rows of numbers.")
    return Columns(
        headers=headers,
        positions=positions,
        values=tuple(
            elapsed(column) if place in stamped else column
            for place, column in zip(positions, _joined(parts), strict=True)
        ),
        dropped=dropped,
        notes=(*notes, *comments_left_out(comments)),
    )


def numbers(text: Text, positions: Sequence[int], request: Request) -> Columns:
    """Some columns of a text that is taken apart."""
    values, dropped, problems = _numbers(text, positions, request)
    if problems:
        raise request.error(*abridged(problems, request))
    if values and not len(values[0]):
        raise request.error("there are no rows of numbers.")
    return Columns(
        headers=text.headers or ("",) * text.width,
        positions=tuple(positions),
        values=tuple(np.ascontiguousarray(column) for column in values),
        dropped=dropped,
        notes=text.told,
    )


def _numbers(
    text: Text, positions: Sequence[int], request: Request, stamped: Collection[int] = ()
) -> tuple[Sequence[Array], int, list[Problem]]:
    """The numbers of a text, rows that were dropped, what is wrong; instants in seconds."""
    values = None if cut_off(text) else _fast(text, positions, stamped)
    if values is not None:
        return values, 0, []
    cells = _in_seconds(_careful(text, request), stamped)
    table, dropped, problems = cells.numbers(positions, request)
    return tuple(table.T), dropped, problems


def _stamped(text: Text, positions: Sequence[int]) -> frozenset[int]:
    """Columns whose first row is an instant."""
    fields = fields_of(text.data[text.start : line_end(text.data, text.start)], text.delimiter)
    return frozenset(x for x in positions if x < len(fields) and is_stamp(fields[x]))


def _in_seconds(cells: Cells, stamped: Collection[int]) -> Cells:
    """Cells with instants in seconds; what is no instant stays as it is."""
    if not stamped or not cells.rows:
        return cells
    import pandas as pd

    columns = list(zip(*cells.rows, strict=True))
    for place in stamped:
        found = seconds_of(pd.Series(columns[place], dtype=str))
        columns[place] = tuple(
            text if math.isnan(number) else float(number)
            for text, number in zip(columns[place], found, strict=True)
        )
    return replace(cells, rows=tuple(zip(*columns, strict=True)))


def _of_one_run(text: Text, request: Request) -> Text:
    """The rows that are asked for by the values of columns; the others count as comments do."""
    if not request.options.where:
        return text
    numbers = text.numbers_of_lines
    kept = np.ones(len(numbers), bool)
    titles = Cells(headers=text.headers or (), rows=(), lines=())
    for name, wanted in request.options.where:
        place = titles.column_named(name)
        if place is None:
            raise request.error(titles.no_column(name, request))
        cells, codes = np.unique(column_of(text, place), return_inverse=True)
        kept &= np.array([is_cell(str(cell), wanted, text.decimal) for cell in cells])[codes]
    data = b"".join(line + b"\n" for line, own in zip(text.lines, kept, strict=True) if own)
    first = int(np.argmax(kept))
    others = (numbers[row] for row in np.flatnonzero(~kept) if row > first)
    return replace(
        text,
        data=data,
        start=0,
        stop=max(len(data) - 1, 0),
        first_line=numbers[first],
        comments=(*text.comments, *others),
    )


def column_of(text: Text, place: int) -> list[str]:
    """The cells of a column, empty where a line is too short."""
    fields = (_strict_fields(line, text.delimiter) for line in text.lines)
    return [row[place].strip() if place < len(row) else "" for row in fields]


def _joined(parts: Sequence[Sequence[Array]]) -> tuple[Array, ...]:
    """The columns of all pieces of the file, end to end."""
    if len(parts) == 1:
        return tuple(np.ascontiguousarray(column) for column in parts[0])
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def cells(request: Request) -> Cells:
    """All cells of a small file as text."""
    text = _of_one_run(take_apart(request), request)
    found = _careful(text, request)
    if found.problems:
        raise request.error(*found.problems)
    return found


def _fast(
    text: Text, positions: Sequence[int], stamped: Collection[int] = ()
) -> tuple[Array, ...] | None:
    """The numbers, or None where anything is not as it should be."""
    import pandas as pd

    width = text.width
    if text.data.find(b'"', text.start) >= 0 or not positions or width < 2:
        return None
    every = set(positions) == set(range(width))
    count = _well_formed(text, width, every=every)
    if count is None:
        return None
    buffer = io.BytesIO(text.data)
    buffer.seek(text.start)
    try:
        table = pd.read_csv(
            buffer,
            header=None,
            usecols=None if every else sorted(set(positions)),
            dtype={x: str if x in stamped else np.float64 for x in range(width)}
            if stamped
            else np.float64,
            na_filter=False,
            quoting=csv.QUOTE_NONE,
            decimal=text.decimal,
            low_memory=False,
            sep=r"\s+" if text.delimiter == BLANKS else text.delimiter,
        )
    except (ValueError, OverflowError):
        return None
    if len(table) != count:
        return None
    values = tuple(
        seconds_of(table[place])
        if place in stamped
        else np.ascontiguousarray(table[place].to_numpy())
        for place in positions
    )
    within = all(
        float(column.max()) <= ABSURD and float(column.min()) >= -ABSURD for column in values
    )
    return values if within else None


def _well_formed(text: Text, width: int, *, every: bool) -> int | None:
    """Number of lines if each has `width` fields (see below), else None.

    With `every` only the first line and the sum over all lines are checked: the parser refuses a
    line with more fields than the first one, so none can have fewer.
    """
    code = np.frombuffer(text.data, dtype=np.uint8, count=text.stop - text.start, offset=text.start)
    count = int(np.count_nonzero(code == 10)) + 1
    if text.delimiter == BLANKS:
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
    mark = ord(text.delimiter)
    if every:
        first = text.data.count(
            text.delimiter.encode(), text.start, line_end(text.data, text.start)
        )
        total = int(np.count_nonzero(code == mark))
        return count if first == width - 1 and total == count * first else None
    marks = np.flatnonzero((code == 10) | (code == mark))
    if len(marks) != count * width - 1:
        return None
    return count if bool(np.all(code[marks[width - 1 :: width]] == 10)) else None


def _careful(text: Text, request: Request) -> Cells:
    """Every line taken apart on its own."""
    width = text.width
    rows: list[tuple[str, ...]] = []
    lines: list[int] = []
    problems: list[Problem] = []
    places = text.numbers_of_lines
    for line, raw in zip(places, text.lines, strict=True):
        try:
            fields = _strict_fields(raw, text.delimiter)
        except csv.Error as error:
            problems.append(request.problem(f"the quotes do not match ({error}).", row=line))
            continue
        if not raw.strip() and request.options.missing == "drop":
            rows.append(("",) * width)
            lines.append(line)
        elif not raw.strip():
            problems.append(request.problem("the line is empty.", row=line))
        elif len(fields) != width:
            few = "few" if len(fields) < width else "many"
            problems.append(
                request.problem(f"{len(fields)} fields, too {few}: there are {width}.", row=line)
            )
        else:
            rows.append(tuple(fields))
            lines.append(line)
    if cut_off(text):
        problems.append(
            request.problem(
                "the last line has no line end and its last number fewer digits than the others: "
                "the file looks cut off.",
                row=places[-1],
                remedy="Copy it again; if it is complete, end the last line with a line end.",
            )
        )
    return Cells(
        headers=text.headers or ("",) * width,
        rows=tuple(rows),
        lines=tuple(lines),
        decimal=text.decimal,
        problems=tuple(problems),
        notes=text.told,
    )


def _strict_fields(line: bytes, delimiter: str) -> list[str]:
    text = line.decode("utf-8").rstrip("\r\n")
    if delimiter == BLANKS:
        return text.split()
    return next(csv.reader([text], delimiter=delimiter, strict=True), [""])
