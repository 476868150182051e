"""Looking at one file of measurements: layout, clock, columns, and what they probably are."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, cast

import numpy as np

from pmmkit.errors import CampaignError, Problem
from pmmkit.runs.guessing import Suggestion, bare_header, rates_of, suggest
from pmmkit.runs.readers import FORMATS, Reader, head_of, recognise
from pmmkit.runs.readers.base import ABSURD, HEAD, Array, Options, Request, to_number
from pmmkit.runs.readers.layout import Layout, layout_of, text_of
from pmmkit.runs.sampling import LARGE, Sample, sample_of

FORMAT_WORDS: Final[Mapping[str, str]] = {
    "csv": "text of columns", "excel": "workbook", "pmmkit": "campaign saved by pmmkit",
    "openfoam": "OpenFOAM", "star-ccm+": "STAR-CCM+ export", "matlab": "MATLAB file",
    "tdms": "TDMS (LabVIEW)", "hdf5": "HDF5",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Clock:
    """The time of a history.

    Parameters
    ----------
    interval, duration : float
        Median step and whole length [in the unit of the column].
    even : bool
        Whether all steps differ by less than 2 % from the median, gaps apart.
    gaps, repeated, backward : int
        Steps longer than 1.5 intervals, of zero, and back in time.
    longest : float
        The longest step [in the unit of the column].
    """

    interval: float
    duration: float
    even: bool
    gaps: int
    repeated: int
    backward: int
    longest: float


@dataclass(frozen=True, kw_only=True)
class ColumnLook:
    """A column.

    Parameters
    ----------
    position : int
        Counted from 0.
    header : str
        As in the file, without its unit; empty where there is none.
    unit : str or None
        As stated in the file.
    title : str
        The whole header, by which a campaign file names it.
    numbers : bool
        Whether it holds numbers; if not, what follows is NaN.
    low, high, mean, first : float
        Of the finite numbers.
    suggestion : Suggestion or None
        What it probably is.
    remark : str
        What else is seen.
    """

    position: int
    header: str
    unit: str | None
    title: str
    numbers: bool = False
    low: float = np.nan
    high: float = np.nan
    mean: float = np.nan
    first: float = np.nan
    suggestion: Suggestion | None = None
    remark: str = ""

    @property
    def constant(self) -> bool:
        """Whether all numbers are the same."""
        return self.numbers and self.low == self.high

    @property
    def label(self) -> str:
        """Header, or the number of the column counted from 1."""
        return self.header or f"column {self.position + 1}"


@dataclass(frozen=True, kw_only=True)
class FileLook:
    """A file, or a sheet of a workbook.

    Parameters
    ----------
    path : Path
        Where it lies.
    shown : str
        Its name, relative to the folder that was looked at.
    format : str
        Name of the reader; empty where no reader knows it.
    size : int
        [bytes].
    kind : {"history", "table", "open water", "unknown"}
        Samples in time, rows that are runs, a table of propeller coefficients.
    rows : int
        Rows of numbers; an estimate where `sampled`.
    sampled : bool
        Whether only parts of a large file were read.
    options : Options
        What ``[source]`` must state to read it.
    layout : Layout or None
        Of text files.
    columns : tuple of ColumnLook
        All columns.
    clock : Clock or None
        Of a history.
    problems : tuple of Problem
        What keeps it from being read as it is.
    notes : tuple of str
        What the reader said.
    """

    path: Path
    shown: str
    format: str = ""
    size: int = 0
    kind: str = "unknown"
    rows: int = 0
    sampled: bool = False
    options: Options = field(default_factory=Options)
    layout: Layout | None = None
    columns: tuple[ColumnLook, ...] = ()
    clock: Clock | None = None
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def titles(self) -> tuple[str, ...]:
        """Headers as in the file."""
        return tuple(column.title for column in self.columns)

    @property
    def known(self) -> dict[str, ColumnLook]:
        """Columns by the name that is suggested for them."""
        return {column.suggestion.name: column for column in self.columns if column.suggestion}

    @property
    def request(self) -> Request:
        """How it is read."""
        return Request(path=self.path, shown=self.shown, options=self.options)


@dataclass(frozen=True, kw_only=True)
class Values:
    """Numbers of a file by position, how many rows there are, and what was wrong."""

    numbers: Mapping[int, Array] = field(default_factory=dict)
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()


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
    if name == "pmmkit":
        return (base,)
    if name == "csv":
        layout = layout_of(head, whole=len(head) < HEAD)
        if layout is not None:
            return (_text(replace(base, layout=layout, options=layout.options), numbers),)
    try:
        if name == "excel":
            return _sheets(base, numbers)
        return (_other(base, numbers),)
    except CampaignError as error:
        return (replace(base, problems=error.problems),)


def values_of(look: FileLook, positions: Sequence[int] | None = None) -> Values:
    """Numbers of the columns of a file, NaN where they are damaged, and the problems.

    Parameters
    ----------
    look : FileLook
        As `look_at` gave it.
    positions : sequence of int, optional
        Columns; by default all that hold numbers.
    """
    wanted = tuple(positions if positions is not None else _numeric(look))
    request = look.request
    reader = _reader(look.format)
    try:
        read = reader.columns(request, lambda _, width: [p for p in wanted if p < width])
    except CampaignError as error:
        return Values(numbers=_lenient(look, wanted), problems=_few(error.problems, request))
    return Values(numbers=dict(zip(read.positions, read.values, strict=True)), notes=read.notes)


def not_recognised(request: Request, head: bytes) -> Problem:
    """The problem of a file that no reader knows, with its first lines."""
    decoded = text_of(head, whole=len(head) < HEAD)
    text = decoded[0] if decoded else head[:300].decode("latin-1")
    lines = [line for line in text.split("\n") if line.strip()][: 5 if decoded else 1]
    begins = "".join(f"\n    {_clipped(line)}" for line in lines)
    what = "rows of numbers in columns" if decoded else "text, nor any of the binary formats read"
    return request.problem(
        f"the layout is not known: there are no {what}. Expected: one of "
        f"{', '.join(FORMATS)}, text files with at least two rows of numbers between commas, "
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


def _reader(name: str) -> Reader:
    return cast(Reader, importlib.import_module(FORMATS[name]))


def _numeric(look: FileLook) -> list[int]:
    if look.layout is not None:
        return [place for place, numeric in enumerate(look.layout.numeric) if numeric]
    return [column.position for column in look.columns if column.numbers]


def _text(look: FileLook, numbers: bool) -> FileLook:
    layout = look.layout
    assert layout is not None
    units = layout.units or ("",) * len(layout.headers)
    look = replace(look, columns=_columns(layout.headers, units, layout.numeric))
    if not numbers:
        return _judged(look, {})
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
    return _judged(look, values.numbers, seams)


def _total(rows: int, sample: Sample) -> int:
    return round(rows * sample.share)


def _sheets(look: FileLook, numbers: bool) -> tuple[FileLook, ...]:
    from pmmkit.runs.readers import excel

    names = excel.sheets(look.request)
    return tuple(
        _sheet(replace(look, options=replace(look.options, sheet=name)), len(names), numbers)
        for name in names
    )


def _sheet(look: FileLook, count: int, numbers: bool) -> FileLook:
    """A sheet, its header looked for as in a text file."""
    options = look.options
    shown = look.shown if count == 1 else f"{look.shown}, sheet {options.sheet}"
    look = replace(look, shown=shown)
    try:
        cells = _reader("excel").cells(
            replace(look.request, options=replace(options, header=False))
        )
    except CampaignError as error:
        return replace(look, problems=error.problems)
    lines = dict(zip(cells.lines, cells.rows, strict=True))
    top = [
        "\t".join("" if cell is None else str(cell).replace("\n", " ").replace("\t", " ")
                  for cell in lines.get(number, ()))
        for number in range(1, min(max(lines, default=0), 200) + 1)
    ]  # fmt: skip
    layout = layout_of("\n".join(top).encode(), whole=True)
    if layout is None:
        return _with_problem(look, "the sheet has no rows of numbers in columns.")
    taken = replace(
        options,
        skip_rows=layout.options.skip_rows,
        header=layout.readable_header,
        sheet=None if count == 1 else options.sheet,
    )
    units = layout.units or ("",) * len(layout.headers)
    look = replace(look, options=taken, columns=_columns(layout.headers, units, layout.numeric))
    if not numbers:
        return _judged(look, {})
    values = values_of(look, [place for place, is_number in enumerate(layout.numeric) if is_number])
    rows = max((len(column) for column in values.numbers.values()), default=0)
    return _judged(replace(look, rows=rows, problems=values.problems), values.numbers)


def _other(look: FileLook, numbers: bool) -> FileLook:
    """A file of a format whose reader tells its headers."""
    headers = _reader(look.format).names(look.request)
    columns = _columns(headers, ("",) * len(headers), (True,) * len(headers))
    look = replace(look, columns=columns)
    if not numbers:
        return _judged(look, {})
    values = values_of(look)
    rows = max((len(column) for column in values.numbers.values()), default=0)
    look = replace(look, rows=rows, problems=values.problems, notes=values.notes)
    return _judged(look, values.numbers)


def _columns(
    titles: Sequence[str], units: Sequence[str], numeric: Sequence[bool]
) -> tuple[ColumnLook, ...]:
    bare = [bare_header(title, unit) for title, unit in zip(titles, units, strict=True)]
    return tuple(
        ColumnLook(position=place, header=header, unit=unit, title=titles[place], numbers=number)
        for place, ((header, unit), number) in enumerate(zip(bare, numeric, strict=True))
    )


def _few(problems: Sequence[Problem], request: Request) -> tuple[Problem, ...]:
    """The first problems of a file, and how many more there are."""
    if len(problems) <= 3:
        return tuple(problems)
    return (*problems[:2], request.problem(f"and {len(problems) - 2} more problems."))


def _lenient(look: FileLook, positions: Sequence[int]) -> dict[int, Array]:
    """Columns of a damaged text file or sheet, NaN where there is no number; else nothing."""
    if look.format == "excel":
        cells = _reader("excel").cells(look.request)
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


def _lenient_text(look: FileLook, layout: Layout, positions: Sequence[int]) -> dict[int, Array]:
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


def _judged(look: FileLook, values: Mapping[int, Array], seams: Sequence[int] = ()) -> FileLook:
    """With what the columns probably are, their numbers, the clock and the kind of file."""
    headers = [column.header for column in look.columns]
    units = [column.unit for column in look.columns]
    usual = getattr(_reader(look.format), "USUAL", {})
    found = suggest(headers, units, values, usual=usual)
    kind = _kind(headers, found, values, look.columns)
    if kind in ("table", "open water"):
        found = suggest(headers, units, values, table=True)
    columns = tuple(
        _seen(replace(column, suggestion=item), values.get(column.position))
        for column, item in zip(look.columns, found, strict=True)
    )
    look = replace(look, kind=kind, columns=columns)
    time = look.known.get("t") if kind == "history" else None
    if time is None or time.position not in values:
        return look
    look = replace(look, clock=clock_of(values[time.position], seams))
    return look if seams else _with_rates(look, values, time.position)


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
            column = replace(column, remark="; ".join(filter(None, (column.remark, said))))
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


def _seen(column: ColumnLook, numbers: Array | None) -> ColumnLook:
    finite = None if numbers is None else numbers[np.isfinite(numbers)]
    if finite is None or not len(finite):
        return column if numbers is None else replace(column, remark="no numbers")
    missing = len(numbers) - len(finite) if numbers is not None else 0
    return replace(
        column,
        numbers=True,
        low=float(finite.min()),
        high=float(finite.max()),
        mean=float(finite.mean()),
        first=float(finite[0]),
        remark=f"{missing} without a number" if missing else "",
    )


def clock_of(time: Array, seams: Sequence[int] = ()) -> Clock | None:
    """Facts about a column of times; None for fewer than three.

    Parameters
    ----------
    time : array (n,)
        Times; those that are not finite are left out.
    seams : sequence of int
        Rows before which rows were left out; the steps to them do not count.

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
