"""What every reader is asked and what it gives back."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal

import numpy as np

from pmmkit.base import CampaignError, Problem, Remedy, setting
from pmmkit.files import Origin
from pmmkit.numerics import ABSURD, Array

Cell = str | float | None
Choose = Callable[[tuple[str, ...], int], Sequence[int]]
"""Given the headers (empty where the file has none) and the number of columns: positions wanted."""

HEAD: Final = 65536
"""Bytes at the beginning of a file by which its format is recognised."""
WITHHELD: Final = (
    "this holds no measurements that are known. Nothing of it is shown, for it lies outside the "
    "folder of the campaign."
)
_BESIDE: Final = Remedy(
    "Correct the path; or put the file beside the campaign file, or name its folder with {}, to be "
    "told what is wrong with it.",
    (setting("data"),),
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
    """

    headers: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    lines: tuple[int, ...]
    decimal: str = "."
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()


def to_number(cell: Cell, decimal: str = ".") -> float | None:
    """A cell's number; NaN where it says that there is none, None where it is not a number.

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
    table, dropped, found = numbers_of(cells, positions, request)
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


def numbers_of(
    cells: Cells, positions: Sequence[int], request: Request
) -> tuple[Array, int, list[Problem]]:
    """Rows of finite numbers (n, len(positions)), how many were dropped, and what is wrong."""
    found = list(cells.problems)
    drop = request.options.missing == "drop"
    kept: list[list[float]] = []
    dropped = 0
    for line, row in zip(cells.lines, cells.rows, strict=True):
        numbers = [to_number(row[place], cells.decimal) for place in positions]
        found += [
            request.problem(why, row=line, column=cells.headers[place] or str(place + 1))
            for place, number in zip(positions, numbers, strict=True)
            if (why := fault(number, row[place]))
            and not (drop and number is not None and math.isnan(number))
        ]
        if any(number is None or math.isnan(number) for number in numbers):
            dropped += 1
        else:
            kept.append([number for number in numbers if number is not None])
    return np.array(kept, dtype=float).reshape(len(kept), len(positions)), dropped, found


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
