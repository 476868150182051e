"""Looking at one file of measurements: layout, clock, columns, and what they probably are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from pmmkit.errors import CampaignError, Problem
from pmmkit.inspection.blocks import blocks_of
from pmmkit.inspection.columns import judged
from pmmkit.inspection.guessing import bare_header
from pmmkit.inspection.sampling import LARGE, Sample, sample_of
from pmmkit.inspection.seen import ColumnLook, FileLook
from pmmkit.inspection.values import values_of
from pmmkit.readers import Options, Request, reader_of, readers, recognise
from pmmkit.readers.base import HEAD, head_of
from pmmkit.readers.text import DelimitedText
from pmmkit.readers.text.layout import Layout, layout_of, mostly_numbers, text_of

_TOP: Final = 200
"""Rows of a sheet by which columns of numbers are told."""


def look_at(path: Path, shown: str, *, numbers: bool = True) -> tuple[FileLook, ...]:
    """A file as far as it can be understood without being told anything; one look a sheet.

    Parameters
    ----------
    path : Path
        File, or a folder that is one measurement (an OpenFOAM case).
    shown : str
        Its name for messages.
    numbers : bool
        False looks at the beginning only: format, layout and headers.

    Returns
    -------
    tuple of FileLook
        Never empty; a file that cannot be read has `problems`. Campaigns that pmmkit saved have
        no columns.
    """
    base = FileLook(path=path, shown=shown)
    try:
        head = head_of(path)
        base = replace(base, size=_size(path))
    except OSError as error:
        return (_with_problem(base, f"cannot be read: {error.strerror}."),)
    if not head and not path.is_dir():
        return (_with_problem(base, "the file is empty (0 bytes)."),)
    name = recognise(path)
    if name is None:
        return (replace(base, problems=(not_recognised(base.request, head),)),)
    base = replace(base, format=name, options=Options(format=name))
    if base.is_campaign:
        return (base,)
    if name == DelimitedText.name:
        layout = layout_of(head, whole=len(head) < HEAD)
        if layout is not None:
            return (_text(base, layout, numbers),)
    try:
        if base.has_sheets:
            return _sheets(base, numbers)
        return (_other(base, numbers),)
    except CampaignError as error:
        return (replace(base, problems=error.problems),)


def not_recognised(request: Request, head: bytes) -> Problem:
    """The problem of a file that no reader knows, with its first lines."""
    decoded = text_of(head, whole=len(head) < HEAD)
    text = decoded[0] if decoded else head[:300].decode("latin-1")
    lines = [line for line in text.split("\n") if line.strip()][: 5 if decoded else 1]
    begins = "".join(f"\n    {_clipped(line)}" for line in lines)
    what = "rows of numbers in columns" if decoded else "text, nor any of the binary formats read"
    return request.problem(
        f"the layout is not known: there are no {what}. Expected: one of "
        f"{', '.join(readers())}, text files with at least two rows of numbers between commas, "
        f"semicolons, tabs or blanks. It begins:{begins}",
        remedy="\n  If it is text of columns, state skip_rows, delimiter and decimal in [source].",
    )


def _clipped(line: str) -> str:
    """A line that is safe to print."""
    shown = "".join(char if char.isprintable() else repr(char)[1:-1] for char in line[:100])
    return f"{shown[:100]} …" if len(line) > 100 or len(shown) > 100 else shown


def _with_problem(look: FileLook, message: str) -> FileLook:
    return replace(look, problems=(look.request.problem(message),))


def _size(path: Path) -> int:
    if path.is_file():
        return path.stat().st_size
    return sum(part.stat().st_size for part in path.rglob("*") if part.is_file())


def _text(look: FileLook, layout: Layout, numbers: bool) -> FileLook:
    """A text file."""
    units = layout.units or ("",) * len(layout.headers)
    columns = _columns(layout.headers, units, layout.numeric)
    look = replace(look, layout=layout, options=layout.options, columns=columns)
    return with_numbers(look) if numbers else judged(look, {})


def with_numbers(look: FileLook) -> FileLook:
    """A file of which layout and headers are known, with its numbers; of a large text a sample.

    Parameters
    ----------
    look : FileLook
        As `look_at` gave it, with its columns.
    """
    if look.layout is not None:
        return _text_numbers(look, look.layout)
    values = values_of(look)
    rows = max((len(column) for column in values.numbers.values()), default=0)
    look = replace(look, rows=rows, problems=values.problems, notes=values.notes)
    return judged(look, values.numbers)


def _text_numbers(look: FileLook, layout: Layout) -> FileLook:
    if layout.encoding == "utf-16" and look.size >= LARGE:
        return _with_problem(look, "UTF-16 text of this size is not looked into.")
    try:
        with sample_of(look.path) as sample:
            values = values_of(replace(look, path=sample.path))
    except OSError as error:
        return _with_problem(look, f"cannot be read: {error.strerror}.")
    rows = max((len(column) for column in values.numbers.values()), default=0)
    seams = tuple(line - layout.first_row for line in sample.seams)
    look = replace(
        look,
        rows=_total(rows, sample),
        sampled=sample.partial,
        problems=() if sample.partial and not values.numbers else values.problems,
        notes=values.notes,
    )
    return judged(look, values.numbers, seams)


def _total(rows: int, sample: Sample) -> int:
    return round(rows * sample.share)


def _sheets(look: FileLook, numbers: bool) -> tuple[FileLook, ...]:
    names = reader_of(look.format).sheets(look.request)
    return tuple(
        _sheet(replace(look, options=replace(look.options, sheet=name)), len(names), numbers)
        for name in names
    )


def _sheet(look: FileLook, count: int, numbers: bool) -> FileLook:
    """A sheet as its reader finds the table in it."""
    shown = look.shown if count == 1 else f"{look.shown}, sheet {look.options.sheet}"
    options = replace(look.options, sheet=None if count == 1 else look.options.sheet)
    look = replace(look, shown=shown, options=options)
    try:
        cells = reader_of(look.format).cells(look.request)
    except CampaignError as error:
        return replace(look, problems=error.problems)
    numeric = [
        mostly_numbers([row[place] for row in cells.rows[:_TOP]], cells.decimal)
        for place in range(len(cells.headers))
    ]
    if sum(numeric) < 2:
        return _with_problem(look, "the sheet has no rows of numbers in columns.")
    look = judged(replace(look, columns=_columns(cells.headers, ("",) * len(numeric), numeric)), {})
    if look.kind == "table":
        blocks = blocks_of(cells, look.columns)
        options = replace(look.options, last_row=blocks.last_row)
        look = replace(look, blocks=blocks, options=options)
    return with_numbers(look) if numbers else look


def _other(look: FileLook, numbers: bool) -> FileLook:
    """A file of a format whose reader tells its headers."""
    headers = reader_of(look.format).names(look.request)
    columns = _columns(headers, ("",) * len(headers), (True,) * len(headers))
    look = replace(look, columns=columns)
    return with_numbers(look) if numbers else judged(look, {})


def _columns(
    titles: Sequence[str], units: Sequence[str], numeric: Sequence[bool]
) -> tuple[ColumnLook, ...]:
    bare = [bare_header(title, unit) for title, unit in zip(titles, units, strict=True)]
    return tuple(
        ColumnLook(position=place, header=header, unit=unit, title=titles[place], numbers=number)
        for place, ((header, unit), number) in enumerate(zip(bare, numeric, strict=True))
    )
