"""What every reader is asked and what it gives back."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Final, Literal

import numpy as np

from pmmkit.base import CampaignError, Problem, Remedy, Way, did_you_mean
from pmmkit.conventions import split_unit
from pmmkit.files import Origin
from pmmkit.numerics import ABSURD, Array

Cell = str | float | None
Choose = Callable[[tuple[str, ...], int], Sequence[int]]
"""Given the headers (empty where the file has none) and the number of columns: positions wanted."""

Plain = str | float | int | bool
Wanted = Plain | Sequence[Plain]
"""The value of a cell, or several of which it may have any."""
_BRACES: Final = re.compile(r"\{([^{}]*)\}")
ROW: Final = "row"
"""In braces: the row of the file."""
_FILLED: Final = re.compile(r"(.+):0([1-9]\d?)")
"""A column whose whole numbers stand with at least so many digits: ``Run:04`` is 0101."""

HEAD: Final = 65536
"""Bytes at the beginning of a file by which its format is recognised."""
WITHHELD: Final = (
    "this holds no measurements that are known. Nothing of it is shown, for it lies outside the "
    "folder of the campaign."
)
_BESIDE: Final = Remedy(
    "Correct the path; or put the file beside the campaign file, or name its folder with {}, to be "
    "told what is wrong with it.",
    (Way.setting("data"),),
)
LISTED: Final = 10
"""Problems of one kind listed in full before the rest are only counted."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """How a file is to be read: the ``[source]`` table of a campaign file.

    Parameters
    ----------
    format : str or None
        Name of a reader; None goes by the file's suffix (Excel, HDF5) and else is ``csv``.
    skip_rows : int
        Lines above the header.
    last_row : int or None
        Last row of a sheet that is read, counted from 1.
    encoding, delimiter, decimal : str or None
        Text files; None means UTF-8, and found from the first lines.
    header : bool or None
        Whether there is a line of names; None finds out.
    units_row : bool or None
        Whether a line of units follows the names; None finds out.
    comment : str or None
        What lines begin with that hold no numbers; None goes by the usual signs.
    widths : tuple of int or None
        Widths of the columns of a text file without delimiters [characters].
    order : tuple of str
        Files of one run in the order in which they were computed: the later one counts.
    sheet : str, int or None
        Sheet of a workbook by name, or by its place counted from 1.
    group : str or None
        Group (struct, run) of an HDF5, MATLAB or TDMS file.
    where : tuple of pairs
        Column and value of the rows of a text that belong to the run.
    sample_rate : float or None
        Samples a second [Hz] of files without a column of time.
    missing : {"error", "drop"}
        What to do with rows that lack a value in a column that is used.
    nondimensional : str or None
        System in which the forces are non-dimensional.
    in_phase_with : str or None
        What the in-phase parts of harmonics are in phase with.
    """

    format: str | None = None
    skip_rows: int = 0
    last_row: int | None = None
    encoding: str | None = None
    delimiter: str | None = None
    decimal: str | None = None
    header: bool | None = None
    units_row: bool | None = None
    comment: str | None = None
    widths: tuple[int, ...] | None = None
    order: tuple[str, ...] = ()
    sheet: str | int | None = None
    group: str | None = None
    where: tuple[tuple[str, Plain], ...] = ()
    sample_rate: float | None = None
    missing: Literal["error", "drop"] = "error"
    nondimensional: str | None = None
    in_phase_with: str | None = None


@dataclass(frozen=True, kw_only=True)
class Request:
    """A file to be read.

    Parameters
    ----------
    path : Path
        Where it lies.
    shown : str
        Its name for messages, as the campaign file writes it.
    run : str or None
        The run it is read for.
    options : Options
        How to read it.
    origin : Origin or None
        What stands behind its URL; `path` then is only a name until it is copied to this machine.
    withheld : bool
        Whether messages keep back what stands in the file: the campaign file points somewhere
        outside of its folders, and nothing there is known for measurements.
    """

    path: Path
    shown: str
    run: str | None = None
    options: Options = field(default_factory=Options)
    origin: Origin | None = None
    withheld: bool = False

    def inside(self, path: Path) -> Request:
        """The request for one of the files that are meant: itself, in the folder, or beside it."""
        if path == self.path:
            return self
        whole = self.path.is_dir()
        folder = self.shown if whole else self.shown.rpartition("/")[0]
        name = path.relative_to(self.path if whole else self.path.parent).as_posix()
        return replace(self, path=path, shown=f"{folder.rstrip('/')}/{name}" if folder else name)

    def problem(
        self,
        message: str,
        *,
        row: int | str | None = None,
        column: str | None = None,
        remedy: str | Remedy | None = None,
    ) -> Problem:
        """A problem of this file."""
        if self.withheld:
            return Problem(message=WITHHELD, file=self.shown, run=self.run, remedy=_BESIDE)
        return Problem(
            message=message, file=self.shown, run=self.run, row=row, column=column, remedy=remedy
        )

    def error(
        self,
        *problems: Problem | str,
        row: int | str | None = None,
        column: str | None = None,
        remedy: str | Remedy | None = None,
    ) -> CampaignError:
        """The error that tells the problems of this file; a text is one, as of `problem`."""
        listed = list(
            dict.fromkeys(
                self.problem(item, row=row, column=column, remedy=remedy)
                if isinstance(item, str)
                else item
                for item in problems
            )
        )
        title = None if len(listed) == 1 else f"{self.shown} cannot be read"
        return CampaignError(listed, title=title)

    def absent(self, what: str, wanted: str, there: Sequence[str]) -> CampaignError:
        """The error of a part of the file that is asked for and is not there."""
        hint, held = did_you_mean(wanted, there) or ".", ", ".join(there) or "none"
        return self.error(f"there is no {what} {wanted!r}{hint} It has {held}.")

    def read(self, count: int = -1) -> bytes:
        """The first bytes of the file, all of them by default; an error where there are none."""
        try:
            with self.path.open("rb") as stream:
                return stream.read(count)
        except OSError as error:
            raise self.unreadable(error) from error

    def unreadable(self, error: OSError) -> CampaignError:
        """The error of a file that the system does not give."""
        shown = replace(self, withheld=False)
        return self.error(shown.problem(f"cannot be read: {error.strerror}."))


def first_line(error: BaseException) -> str:
    """The first line of what a library says of a fault, else the name of its kind."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]


def head_of(path: Path) -> bytes:
    """The first bytes of a file, none of a folder.

    Parameters
    ----------
    path : Path
        File or folder.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    if path.is_dir():
        return b""
    with path.open("rb") as stream:
        return stream.read(HEAD)


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Columns of numbers as they stand in a file.

    Parameters
    ----------
    headers : tuple of str
        All headers of the file, empty strings where it has none.
    positions : tuple of int
        Which columns were read, counted from 0.
    values : tuple of array
        Their finite numbers, one array of equal length for each position.
    dropped : int
        Rows left out because a value was missing and the campaign file says ``missing = "drop"``.
    notes : tuple of str
        Conversions that the file itself reports.
    unsettled : mapping of str to str
        What is doubtful, by the key of ``[cfd]`` that settles it.
    """

    headers: tuple[str, ...]
    positions: tuple[int, ...]
    values: tuple[Array, ...]
    dropped: int = 0
    notes: tuple[str, ...] = ()
    unsettled: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, kw_only=True)
class Cells:
    """A small file as text and numbers, row by row.

    Parameters
    ----------
    headers : tuple of str
        Headers, empty strings where the file has none.
    rows : tuple of tuple
        Cells: text, a number, or None where empty.
    lines : tuple of int
        Row of the file, counted from 1, of each of the rows.
    decimal : str
        Decimal sign of numbers written as text.
    problems : tuple of Problem
        Rows that are not well formed; they are not among `rows`.
    notes : tuple of str
        What was left out or found out.
    above : tuple of str
        What stands above the headers of a sheet: names and what is stated of them, a line each.
    """

    headers: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    lines: tuple[int, ...]
    decimal: str = "."
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()
    above: tuple[str, ...] = ()

    def number_at(self, index: int, place: int) -> tuple[float | None, str | None]:
        """The number of a cell as `to_number` gives it, and what is wrong with it, or None."""
        cell = self.rows[index][place]
        number = to_number(cell, self.decimal)
        return number, fault(number, cell)

    def mostly_numbers(self, place: int, most: int) -> bool:
        """Whether most of the first cells of a column are numbers, and not all are empty."""
        return mostly_numbers([row[place] for row in self.rows[:most]], self.decimal)

    def numbers(
        self, positions: Sequence[int], request: Request
    ) -> tuple[Array, int, list[Problem]]:
        """Rows of finite numbers (n, len(positions)), how many were dropped, and what is wrong."""
        found = list(self.problems)
        drop = request.options.missing == "drop"
        kept: list[list[float]] = []
        dropped = 0
        for line, row in zip(self.lines, self.rows, strict=True):
            numbers = [to_number(row[place], self.decimal) for place in positions]
            found += [
                request.problem(why, row=line, column=self.headers[place] or str(place + 1))
                for place, number in zip(positions, numbers, strict=True)
                if (why := fault(number, row[place]))
                and not (drop and number is not None and math.isnan(number))
            ]
            if any(number is None or math.isnan(number) for number in numbers):
                dropped += 1
            else:
                kept.append([number for number in numbers if number is not None])
        return np.array(kept, dtype=float).reshape(len(kept), len(positions)), dropped, found

    def column_named(self, name: str) -> int | None:
        """Position of a column by its header, with or without its unit; None if not exactly one."""
        for titles in (self.headers, [split_unit(header)[0] for header in self.headers]):
            places = [place for place, title in enumerate(titles) if title == name.strip()]
            if len(places) == 1:
                return places[0]
        return None

    def matching_rows(
        self, where: Mapping[str, Wanted], request: Request
    ) -> tuple[list[int], list[Problem]]:
        """Indices of the rows whose cells are as stated, and what is wrong with the statement.

        Cells are compared as numbers where both are numbers, else as text.
        """
        problems: list[Problem] = []
        chosen = list(range(len(self.rows)))
        for name, wanted in where.items():
            place = self.column_named(name)
            if place is None:
                problems.append(self.no_column(name, request))
                continue
            either = [wanted] if isinstance(wanted, (str, float, int)) else list(wanted)
            chosen = [
                index
                for index in chosen
                if any(is_cell(self.rows[index][place], value, self.decimal) for value in either)
            ]
        return chosen, problems

    def no_column(self, name: str, request: Request) -> Problem:
        """The problem of a column that is not there, or there twice."""
        return request.problem(
            f"there is not exactly one column {name!r}{did_you_mean(name, self.headers) or '.'} "
            f"The file has {', '.join(repr(header) for header in self.headers)}."
        )

    def filled_in(self, template: str, index: int) -> tuple[str, list[str]]:
        """An id with the cells of a row in place of ``{their column}``, and columns not found.

        ``{their column:04}`` writes a whole number with four digits, ``{their column:01}`` without
        the zeros before it. ``{row}`` is the row of the file where no column is named so.

        Examples
        --------
        >>> table = Cells(headers=("Run No.", "beta"), rows=((376.0, "4"),), lines=(2,))
        >>> table.filled_in("SD_{Run No.}_b{beta}", 0)
        ('SD_376_b4', [])
        >>> table.filled_in("Run{Run No.:04}", 0)
        ('Run0376', [])
        """
        missing = [
            name
            for name in _BRACES.findall(template)
            if name != ROW and self._column_of(name) is None
        ]

        def cell(found: re.Match[str]) -> str:
            place = self._column_of(found[1])
            if place is None:
                return str(self.lines[index]) if found[1] == ROW else found[0]
            text, digits = as_text(self.rows[index][place[0]]), place[1]
            return f"{int(text):0{digits}d}" if digits and text.isdecimal() else text

        return _BRACES.sub(cell, template), missing

    def _column_of(self, name: str) -> tuple[int, int] | None:
        """Position of the column of braces, and to how many digits its whole numbers are filled."""
        place = self.column_named(name)
        if place is not None:
            return place, 0
        found = _FILLED.fullmatch(name)
        place = None if found is None else self.column_named(found[1])
        return None if found is None or place is None else (place, int(found[2]))


def to_number(cell: Cell, decimal: str = ".") -> float | None:
    """A cell's number; NaN where it says that there is none, None where it is not a number.

    Parameters
    ----------
    cell : str, float or None
        As it stands in the file.
    decimal : str
        Decimal sign of numbers written as text.

    Examples
    --------
    >>> to_number(" 1,5 ", ","), to_number("1.5.2"), to_number("n/a")
    (1.5, None, nan)
    """
    if isinstance(cell, float):
        return cell
    text = (cell or "").strip()
    if text.lower() in _NO_VALUE:
        return math.nan
    if decimal != ".":
        if "." in text:
            return None
        text = text.replace(decimal, ".")
    if "_" in text or not text.isascii():
        return None
    try:
        return float(text)
    except ValueError:
        return None


_NO_VALUE: Final = frozenset(
    {
        "",
        "nan",
        "+nan",
        "-nan",
        "na",
        "n/a",
        "#n/a",
        "#na",
        "null",
        "none",
        "<na>",
        "-1.#ind",
        "1.#ind",
        "-1.#qnan",
        "1.#qnan",
        "#n/a n/a",
    }
)


_GROUPED: Final = re.compile(
    r"[+-]?\d{1,3}(?:([,.'’ \u00a0\u2009\u202f_])\d{3})(?:\1\d{3})*(?:[.,]\d*)?"
)
"""A number whose thousands are grouped."""


def columns_of(cells: Cells, positions: Sequence[int], request: Request) -> Columns:
    """Numbers of some columns of a small file, every cell checked."""
    table, dropped, found = cells.numbers(positions, request)
    if found:
        raise request.error(*abridged(found, request))
    if not len(table):
        raise request.error("there are no rows of numbers.")
    return Columns(
        headers=cells.headers,
        positions=tuple(positions),
        values=tuple(np.ascontiguousarray(table[:, place]) for place in range(len(positions))),
        dropped=dropped,
        notes=cells.notes,
    )


def fault(number: float | None, cell: Cell) -> str | None:
    """What is wrong with a cell, or None."""
    if number is None and _GROUPED.fullmatch(str(cell).strip()):
        return f"{_clip(cell)} seems to have thousands separators: export it without them."
    if number is None:
        return f"{_clip(cell)} is not a number."
    if math.isnan(number):
        return "there is no value." if not _clip(cell).strip("' ") else f"{_clip(cell)}: no value."
    if math.isinf(number):
        return f"{_clip(cell)} is infinite."
    if abs(number) > ABSURD:
        return f"{_clip(cell)} is absurdly large."
    return None


def abridged(problems: Sequence[Problem], request: Request) -> list[Problem]:
    """The first problems of a file, and how many more there are."""
    if len(problems) <= LISTED + 1:
        return list(problems)
    more = len(problems) - LISTED
    return [*problems[:LISTED], request.problem(f"and {more} more like these.")]


def _clip(cell: Cell) -> str:
    text = "" if cell is None else str(cell)
    return repr(text if len(text) <= 40 else text[:37] + "...")


def as_text(cell: Cell) -> str:
    """A cell as text; whole numbers without decimals.

    Parameters
    ----------
    cell : str, float or None
        As it stands in the file.
    """
    if isinstance(cell, float):
        return f"{cell:.15g}"
    return (cell or "").strip()


def mostly_numbers(cells: Sequence[Cell], decimal: str) -> bool:
    """Whether most cells of a column are numbers, and not all are empty."""
    found = [to_number(cell, decimal) for cell in cells]
    numbers = [number for number in found if number is not None]
    return len(numbers) > len(found) / 2 and any(number == number for number in numbers)


def is_cell(cell: Cell, wanted: Plain, decimal: str) -> bool:
    """Whether a cell is as stated: as numbers where both are numbers, else as text."""
    number = to_number(cell, decimal)
    if isinstance(wanted, bool):
        return as_text(cell).lower() == str(wanted).lower()
    target = to_number(wanted if isinstance(wanted, str) else float(wanted))
    if number is not None and target is not None:
        return number == target
    return as_text(cell) == str(wanted).strip()


# What every format says of itself and is asked for.


class Reader(ABC):
    """A format of measured files.

    A subclass says below what the format is and reads it with `columns`; the other methods have
    defaults that do for a format of histories in single files. It is made without arguments, holds
    nothing between two calls, and imports what is heavy inside its methods.
    `pmmkit.testing.readers.check_reader` tries whether it keeps its word.

    Attributes
    ----------
    name : str
        What ``format`` in ``[source]`` calls it.
    words : str
        What a file of it is called in a report, e.g. ``workbook``.
    reads : str
        What it reads, in a sentence.
    suffixes : tuple of str
        Ends of the names of such files, in lower case, with the dot.
    container : bool
        Whether those ends only say how a file is packed, so that its content counts before them.
    general : bool
        Whether other formats are special cases of it: it is asked after them.
    fallback : {"file", "folder"} or None
        What it reads if nothing tells the format.
    binary : bool
        Whether its files are not text.
    computed : bool
        Whether its files come from a computation and not from a tank.
    campaign : bool
        Whether a file of it is a campaign of its own, with ship and runs.
    keys : tuple of str
        Keys of ``[source]`` that change what it reads; the others leave it as it is.

    Examples
    --------
    >>> class Counter(Reader):
    ...     name, words, reads = "counter", "counter", "Numbers in a row."
    ...
    ...     def columns(self, request, choose):
    ...         return Columns(headers=("n",), positions=tuple(choose(("n",), 1)), values=())
    >>> Counter().names(Request(path=Path("run.cnt"), shown="run.cnt"))
    ('n',)
    """

    name: ClassVar[str]
    words: ClassVar[str]
    reads: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]] = ()
    container: ClassVar[bool] = False
    general: ClassVar[bool] = False
    fallback: ClassVar[Literal["file", "folder"] | None] = None
    binary: ClassVar[bool] = False
    computed: ClassVar[bool] = False
    campaign: ClassVar[bool] = False
    keys: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns of a history as numbers.

        Parameters
        ----------
        request : Request
            The file.
        choose : callable
            Given the headers and the number of columns: the positions that are wanted.

        Raises
        ------
        CampaignError
            With everything that keeps the file from being read; never a part of it in silence.
        """

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the file, empty strings where it has none."""
        return self.columns(request, lambda *_: ()).headers

    def cells(self, request: Request) -> Cells:
        """A small file whole, as text and numbers: tables whose rows are runs."""
        raise request.error(
            f"a file of the format {self.name!r} is a history, not a table of rows.",
            remedy='Take row and [[tables]] away; for a table of results write format = "csv".',
        )

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file is of the format, or a folder, whose `head` is empty.

        Parameters
        ----------
        path : Path
            Where it lies.
        head : bytes
            The first bytes of a file.

        Returns
        -------
        bool
            Told by the content, soon, without raising anything.
        """
        return False

    def usual(self, headers: Sequence[str]) -> Mapping[str, str]:  # noqa: ARG002
        """Our channels and the headers, without unit, that they usually stand under."""
        return MappingProxyType({})

    def files(self, request: Request) -> Sequence[Path]:
        """The files that are read: those of a folder, those that fit a pattern."""
        return (request.path,)

    def sheets(self, request: Request) -> tuple[str, ...]:  # noqa: ARG002
        """Names of the sheets among which the key ``sheet`` chooses."""
        return ()

    def groups(self, request: Request) -> tuple[str, ...]:  # noqa: ARG002
        """Groups with the same columns, a run each, among which the key ``group`` chooses."""
        return ()

    def remarks(self, request: Request) -> tuple[str, ...]:  # noqa: ARG002
        """Single numbers and texts beside the columns, such as ``beta_deg: 4``, a line each."""
        return ()

    def computation(self, request: Request) -> Mapping[str, Any]:  # noqa: ARG002
        """What lies beside the files of a computation and says what ``[cfd]`` asks, by its keys."""
        return MappingProxyType({})

    def prescribed(
        self,
        request: Request,  # noqa: ARG002
    ) -> tuple[Mapping[str, Array], tuple[str, ...]]:
        """The path that the hull was told to follow, where it lies beside the files.

        Returns
        -------
        path : mapping of str to array (n,)
            ``t`` [s], ``x``, ``y`` [m] and ``psi`` [rad] along the axes of the source, or nothing.
        notes : tuple of str
            What of it was not followed.
        """
        return MappingProxyType({}), ()

    @property
    def of_moving_mesh(self) -> Mapping[str, Any]:
        """What the format says of forces on a hull that moves, by the keys of ``[cfd]``."""
        return MappingProxyType({})

    def is_one_run(self, folder: Path) -> bool:  # noqa: ARG002
        """Whether a folder of the format is one measurement, and not one measurement a file."""
        return True
