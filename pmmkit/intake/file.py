"""Looking at one file of measurements: layout, clock, columns, and what they probably are."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.base import CampaignError, Problem
from pmmkit.intake.blocks import blocks_of
from pmmkit.intake.guessing import Suggestion, bare_header, suggest, wrong_unit
from pmmkit.intake.seen import Clock, ColumnLook, FileLook, concerns, doubt_in, without_doubt
from pmmkit.intake.stacked import runs_in
from pmmkit.intake.under_way import rates_of, track_told
from pmmkit.numerics import ABSURD, Array, even_clock
from pmmkit.readers import (
    READERS,
    Options,
    Request,
    TextLayout,
    head_of,
    recognise,
    text_of,
    to_number,
)

# What the columns of a file probably are, and of what kind the file is.


def judged(look: FileLook, values: Mapping[int, Array], seams: Sequence[int] = ()) -> FileLook:
    """A look with what the columns probably are, their numbers, the clock and the kind of file."""
    headers = [without_doubt(column.header) for column in look.columns]
    units = [column.unit for column in look.columns]
    usual = READERS[look.format].usual(headers)
    found = suggest(headers, units, values, usual=usual)
    values = _told_evenly(values, [n for n, item in enumerate(found) if item and item.name == "t"])
    found = tuple(
        None if item and item.name == "t" and _no_clock(values.get(place)) else item
        for place, item in enumerate(found)
    )
    kind = _kind(headers, found, values, look.columns)
    if kind in ("table", "open water"):
        found = suggest(headers, units, values, table=True)
    elif kind == "history":
        found = track_told(found, headers, values)
    columns = tuple(
        _seen(_doubted(replace(column, suggestion=item), kind), values.get(column.position))
        for column, item in zip(look.columns, found, strict=True)
    )
    if kind == "table":
        columns = tuple(map(_swung, columns))
    look = replace(look, kind=kind, columns=columns)
    time = look.known.get("t") if kind == "history" else None
    if time is None or time.position not in values:
        return look
    look = replace(look, clock=clock_of(values[time.position], seams))
    return look if seams else _with_rates(look, values, time.position)


def _told_evenly(values: Mapping[int, Array], clocks: Sequence[int]) -> Mapping[int, Array]:
    """The numbers with even clocks in place of stamps that have too few digits."""
    even = {n: clock for n in clocks if n in values if (clock := even_clock(values[n])) is not None}
    return {**values, **even}


def _no_clock(numbers: Array | None) -> bool:
    """Whether numbers go back or stand still as often as not: T in a list of tests is a period."""
    return numbers is not None and len(numbers) > 1 and not np.mean(np.diff(numbers) > 0) > 0.5


def _swung(column: ColumnLook) -> ColumnLook:
    """Without an amplitude that is nought in every row: of tests that do not swing."""
    item = column.suggestion
    if item is None or "amplitude" not in item.name or (column.low, column.high) != (0.0, 0.0):
        return column
    return replace(column, suggestion=None, remark=_also(column, "0 in every row"))


def _with_rates(look: FileLook, values: Mapping[int, Array], clock: int) -> FileLook:
    """With a remark at columns that are the rate of another one."""
    others = {
        place: numbers
        for place, numbers in values.items()
        if place != clock and np.all(np.isfinite(numbers))
    }
    rates = rates_of(values[clock], others)
    columns = []
    for column in look.columns:
        other, factor = rates.get(column.position, (None, 1.0))
        if other is not None:
            times = "" if factor == 1.0 else f", times {factor:g}"
            said = f"the rate of {look.columns[other].label}{times}"
            column = replace(column, remark=_also(column, said))
        columns.append(column)
    return replace(look, columns=tuple(columns))


def _kind(
    headers: Sequence[str],
    found: Sequence[Suggestion | None],
    values: Mapping[int, Array],
    columns: Sequence[ColumnLook],
) -> str:
    folded = {header.lower().lstrip("10") for header in headers}
    if {"j", "kt", "kq"} <= folded:
        return "open water"
    names = {item.name for item in found if item}
    if "t" in names:
        return "history"
    rows = max((len(numbers) for numbers in values.values()), default=0)
    units = [column.unit for column in columns]
    as_table = {item.name for item in suggest(headers, units, values, table=True) if item}
    forces = {name.partition("_")[0] for name in as_table} & {"X", "Y", "N", "K"}
    settings = as_table & {"speed", "drift_deg", "rudder_deg", "heel_deg", "yaw_rate"}
    return "table" if forces and settings and rows < 5000 else "unknown"


def _doubted(column: ColumnLook, kind: str) -> ColumnLook:
    """Without what its header doubts, with a remark; also where name and unit do not agree."""
    said = doubt_in(column.title)
    if concerns(said, column.unit):
        remark = f"its header says {said!r}: left out unless you name it under [columns]"
        return replace(column, suggestion=None, remark=remark)
    if column.suggestion is not None:
        return column
    said = wrong_unit(column.header, column.unit, table=kind == "table")
    return replace(column, remark=said) if said else column


def _seen(column: ColumnLook, numbers: Array | None) -> ColumnLook:
    finite = None if numbers is None else numbers[np.isfinite(numbers)]
    if finite is None or not len(finite):
        return column if numbers is None else replace(column, remark=_also(column, "no numbers"))
    missing = len(numbers) - len(finite) if numbers is not None else 0
    return replace(
        column,
        numbers=True,
        low=float(finite.min()),
        high=float(finite.max()),
        mean=float(finite.mean()),
        first=float(finite[0]),
        remark=_also(column, f"{missing} without a number" if missing else ""),
    )


def _also(column: ColumnLook, said: str) -> str:
    """The remark on a column with another one."""
    return "; ".join(filter(None, (column.remark, said)))


def clock_of(time: Array, seams: Sequence[int] = ()) -> Clock | None:
    """Facts about a column of times; None for fewer than three.

    Examples
    --------
    >>> found = clock_of(np.array([0.0, 0.1, 0.2, 0.5, 0.5, 0.6]))
    >>> round(found.interval, 9), found.gaps, found.repeated, found.even
    (0.1, 1, 1, False)
    """
    finite = np.isfinite(time)
    if np.count_nonzero(finite) < 3:
        return None
    steps = np.diff(time)
    steps[[row - 1 for row in seams if 0 < row <= len(steps)]] = np.nan
    steps = steps[np.isfinite(steps)]
    forward = steps[steps > 0]
    interval = float(np.median(forward)) if len(forward) else 0.0
    gaps = steps > 1.5 * interval
    usual = steps[~gaps]
    return Clock(
        interval=interval,
        duration=float(np.ptp(time[finite])),
        even=bool(interval > 0 and np.all(np.abs(usual - interval) < 0.02 * interval)),
        gaps=int(np.count_nonzero(gaps)),
        repeated=int(np.count_nonzero(steps == 0)),
        backward=int(np.count_nonzero(steps < 0)),
        longest=float(steps.max()),
    )


# The numbers of a file that was looked at, as far as it can be read.


@dataclass(frozen=True, kw_only=True)
class Values:
    """Numbers of a file by position, how many rows there are, and what was wrong."""

    numbers: Mapping[int, Array] = field(default_factory=dict)
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()


def values_of(look: FileLook, positions: Sequence[int] | None = None) -> Values:
    """Numbers of the columns of a file, NaN where they are damaged, and the problems."""
    wanted = tuple(positions if positions is not None else _numeric(look))
    request = look.request
    reader = READERS[look.format]
    if look.blocks.mixed:
        return _of_runs(look, wanted)
    try:
        read = reader.columns(request, lambda _, width: [p for p in wanted if p < width])
    except CampaignError as error:
        return Values(numbers=_lenient(look, wanted), problems=_few(error.problems, request))
    numbers = dict(zip(read.positions, read.values, strict=True))
    time = look.known.get("t")
    clocks = () if time is None or look.kind != "history" else (time.position,)
    return Values(numbers=_told_evenly(numbers, clocks), notes=read.notes)


def _of_runs(look: FileLook, positions: Sequence[int]) -> Values:
    """The numbers of the rows that are runs or samples of them; the others are no damage."""
    cells = READERS[look.format].cells(look.request)
    taken = {line for block in look.blocks.runs for line in block.lines}
    kept = [place for place, line in enumerate(cells.lines) if line in taken]
    own = replace(
        cells,
        rows=tuple(cells.rows[place] for place in kept),
        lines=tuple(cells.lines[place] for place in kept),
    )
    _, _, problems = own.numbers(positions, look.request)
    numbers = {
        place: np.array([to_number(row[place], cells.decimal) for row in own.rows], dtype=float)
        for place in positions
    }
    return Values(numbers=numbers, problems=_few(problems, look.request), notes=cells.notes)


def _numeric(look: FileLook) -> list[int]:
    if look.layout is not None:
        return [place for place, numeric in enumerate(look.layout.numeric) if numeric]
    return [column.position for column in look.columns if column.numbers]


def _few(problems: Sequence[Problem], request: Request) -> tuple[Problem, ...]:
    """The first problems of a file, and how many more there are."""
    if len(problems) <= 3:
        return tuple(problems)
    return (*problems[:2], request.problem(f"and {len(problems) - 2} more problems."))


def _lenient(look: FileLook, positions: Sequence[int]) -> dict[int, Array]:
    """Columns of a damaged text file or sheet, NaN where there is no number; else nothing."""
    if look.has_sheets:
        cells = READERS[look.format].cells(look.request)
        found = {
            place: np.array([to_number(row[place]) for row in cells.rows], dtype=float)
            for place in positions
        }
    elif look.layout is not None:
        found = _lenient_text(look, look.layout, positions)
    else:
        return {}
    return {
        place: np.where(np.abs(numbers) < ABSURD, numbers, np.nan)
        for place, numbers in found.items()
    }


def _lenient_text(look: FileLook, layout: TextLayout, positions: Sequence[int]) -> dict[int, Array]:
    import pandas as pd

    try:
        table = pd.read_csv(
            look.path,
            header=None,
            names=list(range(len(layout.headers))),
            skiprows=layout.first_row - 1,
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            encoding=layout.encoding,
            encoding_errors="replace",
            on_bad_lines="skip",
            dtype=str,
        )
    except (ValueError, OSError, pd.errors.ParserError):
        return {}
    found = {}
    for place in positions:
        cells = table[place].astype(str)
        if layout.decimal != ".":
            cells = cells.str.replace(layout.decimal, ".", regex=False)
        found[place] = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
    return found


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
            return _texts(base, layout, numbers)
    try:
        if base.has_sheets:
            return _sheets(base, numbers)
        return _others(base, numbers)
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


def _texts(look: FileLook, layout: TextLayout, numbers: bool) -> tuple[FileLook, ...]:
    """A text file, or each of the runs that stand in it below each other."""
    units = layout.units or ("",) * len(layout.headers)
    columns = _columns(layout.headers, units, layout.numeric)
    look = replace(look, layout=layout, options=layout.options, columns=columns)
    bare = judged(look, {})
    runs = [
        replace(
            look,
            shown=", ".join((look.shown, *(f"{name} {value}" for name, value in where))),
            options=replace(look.options, where=where),
        )
        for where in runs_in(bare)
    ]
    if not numbers:
        return tuple(judged(item, {}) for item in runs) or (bare,)
    return tuple(map(with_numbers, runs or [look]))


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
    columns = _columns(cells.headers, ("",) * len(numeric), numeric)
    look = judged(replace(look, columns=columns, above=cells.above), {})
    if look.kind == "table":
        blocks = blocks_of(cells, look.columns)
        options = replace(look.options, last_row=blocks.last_row)
        look = replace(look, blocks=blocks, options=options)
    return with_numbers(look) if numbers else look


def _others(look: FileLook, numbers: bool) -> tuple[FileLook, ...]:
    """A container as a whole, or each of its groups where they hold the same columns."""
    groups = READERS[look.format].groups(look.request)
    if not groups:
        return (_other(look, numbers),)
    return tuple(
        _other(
            replace(
                look,
                shown=f"{look.shown}, group {group}",
                options=replace(look.options, group=group),
            ),
            numbers,
        )
        for group in groups
    )


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
