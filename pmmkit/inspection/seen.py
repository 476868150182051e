"""What was seen of a file: its columns, its clock, how it is read."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from pmmkit.errors import Problem
from pmmkit.inspection.doubts import without_doubt
from pmmkit.inspection.guessing import Suggestion
from pmmkit.readers import Options, Request, reader_of
from pmmkit.readers.text.layout import Layout

What = Literal["steady", "cycle", "sweep", "statistics", "other names", "incomplete"]


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

    @property
    def clipped(self) -> str:
        """The label, cut to 36 letters, that can be shown."""
        label = without_doubt(self.label)
        plain = "".join(char if char.isprintable() else "?" for char in label)
        return plain if len(plain) <= 36 else plain[:34] + " …"


@dataclass(frozen=True, kw_only=True)
class Block:
    """Rows of a sheet that belong together.

    Parameters
    ----------
    what : str
        ``steady``: each row is a test; ``cycle``: the rows of a name are one cycle; ``sweep``: the
        rudder goes through a cycle, the rest is steady; ``statistics``: of the rows above;
        ``other names``: a row that names columns otherwise, and all below; ``incomplete``.
    test : str or None
        Kind of test of steady rows, cycles and sweeps.
    lines : tuple of int
        Rows of the file, counted from 1.
    names : tuple of str
        Tests, each once; of other names those names; of statistics what they are.
    words : tuple of str
        What their column of kinds says.
    headed : bool
        Whether steady rows have a heading where their columns of drift and sway say none.
    """

    what: What
    test: str | None
    lines: tuple[int, ...]
    names: tuple[str, ...]
    words: tuple[str, ...] = ()
    headed: bool = False

    @property
    def places(self) -> str:
        """Its rows in words."""
        ends = [
            place
            for place in range(1, len(self.lines))
            if self.lines[place] != self.lines[place - 1] + 1
        ]
        first, last = self.lines[0], self.lines[-1]
        if not ends:
            return f"row {first}" if first == last else f"rows {first} to {last}"
        return f"{len(self.lines)} of the rows {first} to {last}"


@dataclass(frozen=True, kw_only=True)
class Blocks:
    """The blocks of a sheet, and the columns by which they are told.

    Parameters
    ----------
    blocks : tuple of Block
        In the order of their first rows.
    name, word : str
        Headers of the columns of names and of kinds of test; empty where there is none.
    """

    blocks: tuple[Block, ...] = ()
    name: str = ""
    word: str = ""

    def of(self, *what: What) -> tuple[Block, ...]:
        """The blocks of some kinds."""
        return tuple(block for block in self.blocks if block.what in what)

    @property
    def runs(self) -> tuple[Block, ...]:
        """Those whose rows are runs or samples of runs."""
        return self.of("steady", "cycle", "sweep")

    @property
    def mixed(self) -> bool:
        """Whether there is more than rows that are runs."""
        return any(block.what != "steady" for block in self.blocks)

    @property
    def last_row(self) -> int | None:
        """The last row above other names."""
        below = self.of("other names")
        return below[0].lines[0] - 1 if below else None


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
    blocks : Blocks
        What the rows of a sheet are.
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
    blocks: Blocks = field(default_factory=Blocks)
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def is_campaign(self) -> bool:
        """Whether it is a campaign of its own, with ship and runs."""
        return bool(self.format) and reader_of(self.format).campaign

    @property
    def has_sheets(self) -> bool:
        """Whether it is a workbook, or a sheet of one."""
        return bool(self.format) and "sheet" in reader_of(self.format).keys

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
