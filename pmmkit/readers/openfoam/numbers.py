"""The rows of one OpenFOAM file as numbers.

A file is read in blocks. Brackets are taken away and pandas parses what is left, once brackets and
fields have been counted; a block in which anything is not as it should be is taken apart line by
line, which names each fault.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.base import Problem
from pmmkit.numerics import ABSURD, Array
from pmmkit.readers.base import LISTED, Request, abridged, fault, to_number
from pmmkit.readers.openfoam.header import RowLayout

BLOCK: Final = 1 << 21
"""Bytes that are parsed at a time."""

_BLANKS: Final = bytes.maketrans(b"\t\r", b"  ")
_BRACKETS: Final = bytes.maketrans(b"()\t\r", b"    ")
_ENDS: Final = b" \t\r\n\0"


@dataclass(frozen=True, kw_only=True)
class FileRows:
    """Columns of one file.

    `values (k, n)`: the columns that were asked for, a row each. `dropped`: rows without a
    value that were left out. `notes`: what was left out besides.
    """

    values: Array
    dropped: int
    notes: tuple[str, ...]


def read_rows(request: Request, layout: RowLayout, wanted: Sequence[int]) -> FileRows:
    """Some columns of a file, every row checked."""
    columns = sorted({0, *(place % layout.width for place in wanted)})
    found: list[Array] = []
    problems: list[Problem] = []
    notes: list[str] = []
    dropped, line = 0, layout.first_line
    for block in _blocks(request, layout, notes):
        values = _fast(block, layout, columns)
        if values is None:
            values, lost, faults = _careful(block, line, layout, columns, request)
            dropped += lost
            problems += faults
            if len(problems) > LISTED:
                break
        found.append(values)
        line += _count(block, b"\n")
    if problems:
        raise request.error(*abridged(problems, request))
    table = np.concatenate(found, axis=1) if found else np.empty((len(columns), 0))
    if layout.local:
        table = _paired(table, notes, request)
        columns = [*columns, *(place + layout.width for place in columns)]
    step = 2 if layout.local else 1
    first = None if dropped else layout.first_line
    _check_times(table[0], first, step, request)
    return FileRows(
        values=table[[columns.index(place) for place in wanted]],
        dropped=dropped,
        notes=tuple(notes),
    )


def _blocks(request: Request, layout: RowLayout, notes: list[str]) -> Iterator[bytes]:
    """The rows in blocks of whole lines; a last row that is cut off is left out and noted."""
    rest = b""
    try:
        with request.path.open("rb") as stream:
            stream.seek(layout.start)
            while data := stream.read(BLOCK):
                data = rest + data
                cut = data.rstrip(_ENDS).rfind(b"\n") + 1
                if cut:
                    yield data[:cut]
                rest = data[cut:]
                if len(rest) > BLOCK:
                    raise request.error("a line has no end: the file is damaged.")
    except OSError as error:
        raise request.unreadable(error) from error
    last = rest.rstrip(_ENDS)
    if not last:
        return
    ended = b"\n" in rest[len(last) :]
    whole = (len(_fields(last)), last.count(b"("), last.count(b")")) == (
        layout.width,
        layout.brackets,
        layout.brackets,
    )
    short = len(_fields(last)) < layout.width
    if short or not (ended or (whole and layout.brackets)):
        notes.append(f"{request.shown}: the last row is cut off and was left out")
    else:
        yield last + b"\n"


def _count(data: bytes, sign: bytes) -> int:
    """How often a byte occurs; four times as fast as ``bytes.count``."""
    return int(np.count_nonzero(np.frombuffer(data, dtype=np.uint8) == ord(sign)))


def _fields(line: bytes) -> list[bytes]:
    return line.translate(_BRACKETS).split()


def _fast(block: bytes, layout: RowLayout, columns: Sequence[int]) -> Array | None:
    """The columns of a block, or None where anything is not as it should be."""
    import pandas as pd

    count = _count(block, b"\n")
    brackets = count * layout.brackets
    if _count(block, b"(") != brackets or _count(block, b")") != brackets:
        return None
    text = block.translate(_BRACKETS) if brackets else block.translate(_BLANKS)
    code = np.frombuffer(text, dtype=np.uint8)
    gap = code <= 32
    if np.count_nonzero(gap[1:] > gap[:-1]) != count * layout.width:
        return None
    last = layout.width - 1
    used = sorted({*columns, last})
    try:
        table = pd.read_csv(
            io.BytesIO(text),
            header=None,
            usecols=used,
            dtype=np.float64,
            quoting=csv.QUOTE_NONE,
            sep=" ",
            skipinitialspace=True,
            low_memory=False,
        )
    except (ValueError, OverflowError):
        return None
    if len(table) != count:
        return None
    values = np.stack([table[place].to_numpy() for place in used])
    if not float(np.abs(values).max()) <= ABSURD:
        return None
    return values if last in columns else values[:-1]


def _careful(
    block: bytes, first: int, layout: RowLayout, columns: Sequence[int], request: Request
) -> tuple[Array, int, list[Problem]]:
    """Every line taken apart on its own."""
    rows: list[list[float]] = []
    problems: list[Problem] = []
    drop = request.options.missing == "drop"
    dropped = 0
    for line, raw in enumerate(block[:-1].split(b"\n"), start=first):
        fields = [field.decode("utf-8", "replace") for field in _fields(raw)]
        why = _misshapen(raw, len(fields), layout)
        if why is not None:
            problems.append(request.problem(why, row=line))
            continue
        numbers = [to_number(fields[place]) for place in columns]
        problems += [
            request.problem(reason, row=line, column=layout.title(place))
            for place, number in zip(columns, numbers, strict=True)
            if (reason := fault(number, fields[place]))
            and not (drop and number is not None and math.isnan(number))
        ]
        if any(number is None or math.isnan(number) for number in numbers):
            dropped += 1
        else:
            rows.append([number for number in numbers if number is not None])
        if len(problems) > LISTED + 1:
            break
    return np.array(rows, float).reshape(len(rows), len(columns)).T, dropped, problems


def _misshapen(raw: bytes, count: int, layout: RowLayout) -> str | None:
    if not raw.strip():
        return "the line is empty."
    if b"\0" in raw:
        return "there are zero bytes: the file is damaged."
    if count != layout.width:
        few = "few" if count < layout.width else "many"
        return f"{count} numbers, too {few}: by the header there are {layout.width}."
    if (raw.count(b"("), raw.count(b")")) != (layout.brackets, layout.brackets):
        return f"the brackets do not match: there should be {layout.brackets} pairs."
    return None


def _paired(table: Array, notes: list[str], request: Request) -> Array:
    """Each time's two rows side by side; a last time without its second row is left out."""
    if table.shape[1] % 2:
        notes.append(f"{request.shown}: the last time lacks its local row and was left out")
        table = table[:, :-1]
    ours, theirs = table[:, ::2], table[:, 1::2]
    apart = np.flatnonzero(ours[0] != theirs[0])
    if len(apart):
        raise request.error(
            f"by the header each time has two rows, the second in local axes; the "
            f"{int(apart[0]) + 1}. pair has the times {ours[0][apart[0]]:.10g} and "
            f"{theirs[0][apart[0]]:.10g}."
        )
    return np.concatenate([ours, theirs])


def _check_times(times: Array, first: int | None, step: int, request: Request) -> None:
    """Refuse times that do not rise; rows begin in line `first`, `step` lines for each time."""
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        raise request.error(
            *abridged(
                [
                    request.problem(
                        f"the time does not rise: {times[place + 1]:.10g} follows "
                        f"{times[place]:.10g}.",
                        row=None if first is None else first + step * (place + 1),
                        remedy="A computation that was started again has a folder of its own for "
                        "each start; files that were joined by hand must be taken apart.",
                    )
                    for place in back[: 10 * LISTED].tolist()
                ],
                request,
            )
        )
