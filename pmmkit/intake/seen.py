"""What was seen of a file: its columns, its clock, how it is read."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.conventions import unit_factor
from pmmkit.intake.guessing import Suggestion
from pmmkit.presentation import meanings
from pmmkit.readers import READERS, Options, Request, TextLayout

# Columns of which their header says that they are not to be believed.


_REMARK: Final = re.compile(r"\(([^()]*)\)|\[([^\[\]]*)\]")
_FORCES: Final = re.compile(
    r"force|kraft|kr[aä]fte|kracht|load|moment|fuerza|força|力|힘", re.IGNORECASE
)
"""A doubt about forces leaves the angle beside them alone."""


def doubt_in(title: str) -> str:
    """What a header says against its column, as it stands there; empty where it says nothing.

    Examples
    --------
    >>> doubt_in("RUDDER (force measurements not useful) X (N)"), doubt_in("Fx [N]")
    ('force measurements not useful', '')
    >>> doubt_in("Dehnung, defekt [V]")
    'Dehnung, defekt [V]'
    """
    for found in _REMARK.finditer(title):
        said = found[1] or found[2] or ""
        if meanings("doubt", said):
            return said.strip()
    return title.strip() if meanings("doubt", title) else ""


def concerns(doubt: str, unit: str | None) -> bool:
    """Whether a doubt is about a column of that unit: one about forces only about those.

    Examples
    --------
    >>> concerns("force measurements not useful", "N"), concerns("force measurements n/a", "°")
    (True, False)
    """
    if not doubt or unit is None or not _FORCES.search(doubt):
        return bool(doubt)
    try:
        return unit_factor(unit)[0] in ("N", "N m")
    except DataError:
        return True


def without_doubt(header: str) -> str:
    """A header without the remark in brackets that doubts it.

    Examples
    --------
    >>> without_doubt("RUDDER (force measurements not useful) given")
    'RUDDER given'
    """
    kept = _REMARK.sub(lambda x: "" if meanings("doubt", x[1] or x[2] or "") else x[0], header)
    return " ".join(kept.split())


What = Literal["steady", "cycle", "sweep", "statistics", "other names", "incomplete"]


_DELIMITERS: Final = {",": "commas", ";": "semicolons", "\t": "tabs", " ": "blanks", "|": "bars"}
_KINDS: Final = {
    "history": "samples in time",
    "table": "a table whose rows are runs",
    "open water": "propeller coefficients",
    "unknown": "numbers",
}


@dataclass(frozen=True, kw_only=True)
class Clock:
    """The time of a history.

    `interval, duration`: median step and whole length [in the unit of the column]. `even`:
    whether all steps differ by less than 2 % from the median, gaps apart. `gaps, repeated,
    backward`: steps longer than 1.5 intervals, of zero, and back in time. `longest`: the
    longest step [in the unit of the column].
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
class SheetBlock:
    """Rows of a sheet that belong together.

    `what`: ``steady``: each row is a test; ``cycle``: the rows of a name are one cycle;
    ``sweep``: the rudder goes through a cycle, the rest is steady; ``statistics``: of the rows
    above; ``other names``: a row that names columns otherwise, and all below; ``incomplete``.
    `test`: kind of test of steady rows, cycles and sweeps. `lines`: rows of the file, counted
    from 1. `names`: tests, each once; of other names those names; of statistics what they are.
    `words`: what their column of kinds says. `headed`: whether steady rows have a heading where
    their columns of drift and sway say none.
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

    `blocks`: in the order of their first rows. `name, word`: headers of the columns of names
    and of kinds of test; empty where there is none.
    """

    blocks: tuple[SheetBlock, ...] = ()
    name: str = ""
    word: str = ""

    def of(self, *what: What) -> tuple[SheetBlock, ...]:
        """The blocks of some kinds."""
        return tuple(block for block in self.blocks if block.what in what)

    @property
    def runs(self) -> tuple[SheetBlock, ...]:
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
    layout : TextLayout or None
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
    above : tuple of str
        What stands above the table of a sheet.
    """

    path: Path
    shown: str
    format: str = ""
    size: int = 0
    kind: str = "unknown"
    rows: int = 0
    sampled: bool = False
    options: Options = field(default_factory=Options)
    layout: TextLayout | None = None
    columns: tuple[ColumnLook, ...] = ()
    clock: Clock | None = None
    blocks: Blocks = field(default_factory=Blocks)
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()
    above: tuple[str, ...] = ()

    @property
    def lines_above(self) -> tuple[str, ...]:
        """The lines of a text file above the names of its columns, or what else a container
        says beside them."""
        if self.layout is None:
            return self.above or READERS[self.format].remarks(self.request)
        if not self.options.skip_rows:
            return ()
        with self.path.open(encoding=self.layout.encoding, errors="replace") as stream:
            lines = [line.rstrip() for line in itertools.islice(stream, self.options.skip_rows)]
        return tuple(line for line in lines if line)

    @property
    def file(self) -> str:
        """Its name without the sheet, the group or the run."""
        bare = self.shown.partition(", sheet ")[0].removesuffix(f", group {self.options.group}")
        for name, value in self.options.where:
            bare = bare.removesuffix(f", {name} {value}")
        return bare

    @property
    def is_campaign(self) -> bool:
        """Whether it is a campaign of its own, with ship and runs."""
        return bool(self.format) and READERS[self.format].campaign

    @property
    def has_sheets(self) -> bool:
        """Whether it is a workbook, or a sheet of one."""
        return bool(self.format) and "sheet" in READERS[self.format].keys

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

    @property
    def words(self) -> str:
        """Format, layout and size of a file in words."""
        words = [READERS[self.format].words, _KINDS[self.kind]]
        layout = self.layout
        if layout is not None:
            sign = "comma" if layout.decimal == "," else "point"
            words.append(
                f"{_DELIMITERS[layout.delimiter]} between, decimal {sign}, {layout.encoding}"
            )
            header = layout.header_line
            words.append("no header" if header is None else f"names in line {header}")
            if layout.units:
                words.append("units below them")
            words.append(f"numbers from line {layout.first_row}")
        elif self.options.skip_rows:
            words.append(f"{self.options.skip_rows} rows above the table")
        if self.rows:
            about = "about " if self.sampled else ""
            words.append(f"{about}{self.rows} rows")
        if self.sampled:
            words.append("only beginning, middle and end were read")
        return ", ".join(words)

    @property
    def clock_words(self) -> str:
        """The clock of a history in words; empty where there is none."""
        if self.clock is None:
            return ""
        clock, column = self.clock, self.known["t"]
        unit = (column.suggestion.unit if column.suggestion else None) or column.unit or "s"
        even = "even" if clock.even else "uneven"
        words = [
            f"Sampled every {clock.interval:.6g} {unit} ({even}), {clock.duration:.6g} {unit} long"
        ]
        if clock.gaps:
            words.append(f"{clock.gaps} gaps, the longest {clock.longest:.6g} {unit}")
        if clock.repeated:
            words.append(f"{clock.repeated} times stand twice")
        if clock.backward:
            words.append(f"time runs backward at {clock.backward} places")
        return ", ".join(words) + "."
