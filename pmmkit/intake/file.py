"""Looking at one file of measurements: layout, clock, columns, and what they probably are."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from pmmkit.base import CampaignError, Problem
from pmmkit.intake.blocks import blocks_of
from pmmkit.intake.columns import judged
from pmmkit.intake.guessing import bare_header
from pmmkit.intake.seen import ColumnLook, FileLook
from pmmkit.intake.values import Values, values_of
from pmmkit.readers import READERS, Options, Request, TextLayout, head_of, recognise, text_of

# Parts of a text file that is too large to be read whole.


LARGE: Final = 64_000_000
"""Size from which a text file is not read whole [bytes]."""
_PARTS: Final = (8_000_000, 4_000_000, 4_000_000)
"""Sizes of the beginning, the middle and the end that are read [bytes]."""


@dataclass(frozen=True, kw_only=True)
class Sample:
    """A text file, or whole lines from its beginning, middle and end.

    `path`: the file itself, or a temporary one with the lines. `seams`: lines of it, counted
    from 1, with which the later parts begin; empty for the file itself. `share`: size of the
    file over that of the lines.
    """

    path: Path
    seams: tuple[int, ...] = ()
    share: float = 1.0

    @property
    def partial(self) -> bool:
        """Whether lines were left out."""
        return bool(self.seams)


def seen_values(look: FileLook) -> Values:
    """The numbers of a file; of a large text those of its beginning, middle and end.

    Parameters
    ----------
    look : FileLook
        The file.

    Raises
    ------
    OSError
        If a large text cannot be read, or a temporary file cannot be written.
    """
    if look.layout is None or look.size < LARGE:
        return values_of(look)
    with sample_of(look.path) as sample:
        return values_of(replace(look, path=sample.path))


@contextmanager
def sample_of(path: Path) -> Iterator[Sample]:
    """A file if it is small, else a sample of its lines that is deleted at the end of the block."""
    size = path.stat().st_size
    if size < LARGE:
        yield Sample(path=path)
        return
    first, middle, last = _parts(path, size)
    seams = (first.count(b"\n") + 1, first.count(b"\n") + middle.count(b"\n") + 1)
    folder = Path(tempfile.mkdtemp(prefix="pmmkit-"))
    try:
        part = folder / f"sample{path.suffix}"
        part.write_bytes(first + middle + last)
        yield Sample(path=part, seams=seams, share=size / part.stat().st_size)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _parts(path: Path, size: int) -> tuple[bytes, bytes, bytes]:
    """Whole lines of the beginning, the middle and the end."""
    with path.open("rb") as stream:
        first = stream.read(_PARTS[0])
        stream.seek(size // 2)
        middle = stream.read(_PARTS[1])
        stream.seek(size - _PARTS[2])
        last = stream.read(_PARTS[2])
    return (
        first[: first.rfind(b"\n") + 1],
        middle[middle.find(b"\n") + 1 : middle.rfind(b"\n") + 1],
        last[last.find(b"\n") + 1 :],
    )


_TOP: Final = 200
"""Rows of a sheet by which columns of numbers are told."""


def look_at(path: Path, shown: str, *, numbers: bool = True) -> tuple[FileLook, ...]:
    """A file as far as it can be understood without being told anything; one look a sheet."""
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
    if name == "csv":
        layout = TextLayout.of(head)
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
    decoded = text_of(head)
    text = decoded[0] if decoded else head[:300].decode("latin-1")
    lines = [line for line in text.split("\n") if line.strip()][: 5 if decoded else 1]
    begins = "".join(f"\n    {_clipped(line)}" for line in lines)
    what = "rows of numbers in columns" if decoded else "text, nor any of the binary formats read"
    return request.problem(
        f"the layout is not known: there are no {what}. Expected: one of "
        f"{', '.join(READERS)}, text files with at least two rows of numbers between commas, "
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


def _text(look: FileLook, layout: TextLayout, numbers: bool) -> FileLook:
    """A text file."""
    units = layout.units or ("",) * len(layout.headers)
    columns = _columns(layout.headers, units, layout.numeric)
    look = replace(look, layout=layout, options=layout.options, columns=columns)
    return with_numbers(look) if numbers else judged(look, {})


def with_numbers(look: FileLook) -> FileLook:
    """A file of which layout and headers are known, with its numbers; of a large text a sample."""
    if look.layout is not None:
        return _text_numbers(look, look.layout)
    values = values_of(look)
    rows = max((len(column) for column in values.numbers.values()), default=0)
    look = replace(look, rows=rows, problems=values.problems, notes=values.notes)
    return judged(look, values.numbers)


def _text_numbers(look: FileLook, layout: TextLayout) -> FileLook:
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
    names = READERS[look.format].sheets(look.request)
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
        cells = READERS[look.format].cells(look.request)
    except CampaignError as error:
        return replace(look, problems=error.problems)
    numeric = [cells.mostly_numbers(place, _TOP) for place in range(len(cells.headers))]
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
    headers = READERS[look.format].names(look.request)
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
