"""Sections and tables, as plain text and as HTML, and text that is safe in either."""

from __future__ import annotations

import base64
import html
import re
import unicodedata
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import starmap
from pathlib import PurePath
from types import MappingProxyType
from typing import Any, Final

from pmmkit.presentation.numbers import ABSENT

# Text of unknown origin on a terminal, in the cells of tables and in figures.


_SIGNS: Final = "=+\\-@＝＋－＠"
_FORMULA: Final = re.compile(rf"(?<![^;\t\r\n])(?='* *[{_SIGNS}])|\A(?='*[\t\r])")
"""Places where a formula could begin: at the start, and where some separate cells elsewhere."""
_MARKED: Final = re.compile(rf"(?<![^;\t\r\n])'(?='* *[{_SIGNS}])|\A'(?='*[\t\r])")
_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def safe_cell(text: str) -> str:
    """A text as a cell of a table that no spreadsheet computes; numbers stay as they are.

    Parameters
    ----------
    text : str
        Any text. A stroke goes before what could begin a formula (`text_of_cell` takes it away).

    Examples
    --------
    >>> safe_cell("=1+1"), safe_cell("-4"), safe_cell("SD_+4"), safe_cell("'=1")
    ("'=1+1", '-4', 'SD_+4', "''=1")
    """
    return text if _NUMBER.fullmatch(text) else _FORMULA.sub("'", text)


def text_of_cell(cell: str) -> str:
    """The text that `safe_cell` made a `cell` of.

    Examples
    --------
    >>> text_of_cell("'=1+1"), text_of_cell("-4"), text_of_cell("'quoted'")
    ('=1+1', '-4', "'quoted'")
    """
    return _MARKED.sub("", cell)


def printable(text: str, *, lines: bool = False) -> str:
    """A text without control characters, for one line of a terminal or for several.

    Parameters
    ----------
    text : str
        Any text.
    lines : bool
        Whether its line breaks stay.

    Examples
    --------
    >>> text = "two" + chr(10) + "lines" + chr(27) + "[2J"
    >>> printable(text), printable(text, lines=True)
    ('two lines [2J', 'two\\nlines [2J')
    """
    if lines:
        return "\n".join(map(printable, text.split("\n")))
    return text if text.isprintable() else "".join(x if x.isprintable() else " " for x in text)


def figure_text(text: str) -> str:
    r"""A `text` in a figure, where $ would begin mathematics.

    Examples
    --------
    >>> print(figure_text("5 $"))
    5 \$
    """
    return printable(text).encode("utf-8", "replace").decode("utf-8").replace("$", r"\$")


def quoted(path: PurePath) -> str:
    """A `path` as it is typed.

    Examples
    --------
    >>> quoted(PurePath("my tests/run 1")), quoted(PurePath("tests"))
    ('"my tests/run 1"', 'tests')
    """
    text = str(path)
    return f'"{text}"' if " " in text else text


Cell = str | None
"""A text, a `Symbol` among them; None where there is no value."""


class Symbol(str):
    """A derivative as it is typeset: a letter, and what stands below it.

    Parameters
    ----------
    letter, below : str
        Its parts; as plain text they stand side by side.

    Examples
    --------
    >>> print(Symbol("N′", "vvr"))
    N′vvr
    """

    __slots__ = ("below", "letter")
    letter: str
    below: str

    def __new__(cls, letter: str, below: str) -> Symbol:
        """The plain text with its parts."""
        made = super().__new__(cls, f"{letter}{below}")
        made.letter, made.below = letter, below
        return made


@dataclass(frozen=True, kw_only=True)
class Group:
    """Rows of a table under a title of their own.

    Parameters
    ----------
    rows : sequence of sequence of str or None
        The cells.
    title : str
        None where empty.
    """

    rows: Sequence[Sequence[Cell]]
    title: str = ""


@dataclass(frozen=True, kw_only=True)
class Grid:
    """A table; a cell None says that there is no value.

    Parameters
    ----------
    head : sequence of str
        Names of the columns.
    groups : sequence of Group
        The rows.
    caption : str
        A line above the table.
    texts : tuple of int
        Columns that hold sentences.
    """

    head: Sequence[str]
    groups: Sequence[Group]
    caption: str = ""
    texts: tuple[int, ...] = ()

    def lines(self) -> list[str]:
        """The lines of a table in plain text."""
        found = [printable(self.caption)] if self.caption else []
        named = any(self.head)
        rows = [
            *([self.head] if named else []),
            *(row for group in self.groups for row in group.rows),
        ]
        if not rows:
            return found
        body = iter(_columns(rows, {0, *self.texts}))
        if named:
            found.append(next(body))
        for group in self.groups:
            found += [printable(group.title)] if group.title else []
            found += [next(body) for _ in group.rows]
        return found

    def html(
        self,
        look: str = "",
        shades: Mapping[str, str] = MappingProxyType({}),
        frame: Mapping[str, str] = MappingProxyType({}),
    ) -> str:
        """The same as HTML, escaped, without scripts and styles.

        Parameters
        ----------
        look : str
            Class of the table.
        shades : mapping of str to str
            Classes of cells by what they say. Cells to the left have the class ``text``.
        frame : mapping of str to str
            Attributes of what stands around the table; nothing stands there without any.
        """
        left = {0, *self.texts}

        def row(kind: str, cells: Sequence[Cell], scope: str = "") -> str:
            inside = ""
            for at, cell in enumerate(cells):
                own = ("text" * (at in left), shades.get(cell or ABSENT, ""))
                inside += _cell_html(kind, cell, " ".join(filter(None, own)), scope)
            return _element("tr", inside)

        caption = _element("caption", _safe(self.caption)) if self.caption else ""
        head = _element("thead", row("th", self.head, "col")) if any(self.head) else ""
        body = "".join(
            (_title_html(group) if group.title else "") + "".join(row("td", x) for x in group.rows)
            for group in self.groups
        )
        table = _element("table", caption + head + _element("tbody", body), {"class": look})
        return _element("div", table, frame) if frame else table


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure with its caption, and with what it shows in words.

    Parameters
    ----------
    figure : Figure
        Of `pmmkit.plotting`.
    caption : str
        The line below it.
    narrow : bool
        Whether it needs but half of the width.
    alt : str
        What is seen, in words, for those who do not see it.
    file : str
        Name without ending of the file in which it stands beside the page too; empty for none.
    """

    figure: Any = field(repr=False, compare=False)
    caption: str
    narrow: bool = False
    alt: str = ""
    file: str = ""

    @property
    def svg(self) -> str:
        """The figure as an ``<svg>`` element."""
        return str(self.figure.svg(self.alt))


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of a report: sentences, points, findings, tables and figures in this order.

    Parameters
    ----------
    title : str
        None where empty.
    paragraphs, points : sequence of str
        Sentences, and the lines of a list.
    findings : sequence of mapping
        Of the checks, each with its ``severity``, ``check``, ``message``, ``runs``, ``remedy``.
    tables : sequence of Grid
        The tables.
    figures : sequence of Picture
        The figures.
    """

    title: str = ""
    paragraphs: Sequence[str] = ()
    points: Sequence[str] = ()
    findings: Sequence[Mapping[str, str]] = ()
    tables: Sequence[Grid] = ()
    figures: Sequence[Picture] = ()

    def lines(self) -> list[str]:
        """The lines of plain text; figures are told by their captions."""
        inside = [printable(text) for text in self.paragraphs]
        inside += [f"- {printable(text)}" for text in self.points]
        for item in self.findings:
            runs = f" ({item['runs']})" if item["runs"] else ""
            told = f"{item['severity']}: {item['check']}{runs}: {item['message']} {item['remedy']}"
            inside.append(printable(told.rstrip()))
        for table in self.tables:
            inside += table.lines()
        inside += [f"[Figure: {printable(figure.caption)}]" for figure in self.figures]
        if not self.title:
            return inside
        return [printable(self.title), *(f"  {line}" for line in inside)]

    def html(self, table: Callable[[Grid], str] = Grid.html) -> str:
        """The same as HTML, escaped, without scripts and styles.

        Parameters
        ----------
        table : callable, optional
            What writes a table.
        """
        parts = [_element("h3", _safe(self.title))] if self.title else []
        parts += [_element("p", _safe(text)) for text in self.paragraphs]
        if self.points:
            parts.append(_element("ul", "".join(_element("li", _safe(x)) for x in self.points)))
        parts += [*map(_finding_html, self.findings), *map(table, self.tables)]
        return "".join([*parts, *map(_picture_html, self.figures)])


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in plain text, the first column to the left, the others to the right.

    Parameters
    ----------
    head : sequence of str
        Names of the columns.
    rows : sequence of sequence of str
        The cells.

    Examples
    --------
    >>> print(aligned(["", "Yv"], [["Fn 0.145", "-11.6"]]))
                 Yv
    Fn 0.145  -11.6
    """
    return "\n".join(_columns([head, *rows], left={0}))


def _columns(rows: Sequence[Sequence[Cell]], left: Collection[int]) -> list[str]:
    cells = [[printable(ABSENT if cell is None else cell) for cell in row] for row in rows]
    widths = [max(map(_width, column)) for column in zip(*cells, strict=True)]

    def filled(place: int, cell: str) -> str:
        blanks = " " * (widths[place] - _width(cell))
        return cell + blanks if place in left else blanks + cell

    return ["  ".join(starmap(filled, enumerate(row))).rstrip() for row in cells]


def _width(text: str) -> int:
    """Places that a text takes on a terminal: a dot above a letter none, a wide letter two."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(x) else 1 + (unicodedata.east_asian_width(x) in "WF")
        for x in text
    )


def text_of(sections: Iterable[Section]) -> str:
    """Sections in plain text, an empty line between them.

    Parameters
    ----------
    sections : iterable of Section
        Those that say nothing are left out.
    """
    blocks = map(Section.lines, sections)
    return "\n\n".join("\n".join(lines) for lines in blocks if lines)


def _element(
    kind: str, inside: str | None, attributes: Mapping[str, str] = MappingProxyType({})
) -> str:
    """An element, with those of its attributes that say something; empty if there is no inside."""
    said = "".join(f' {name}="{_safe(own)}"' for name, own in attributes.items() if own)
    return f"<{kind}{said}/>" if inside is None else f"<{kind}{said}>{inside}</{kind}>"


def _cell_html(kind: str, cell: Cell, look: str, scope: str) -> str:
    inside = _safe(cell)
    if isinstance(cell, Symbol):  # the letter and what is below it stay on one line
        inside = f"{_safe(cell.letter)}\u2060{_element('sub', _safe(cell.below))}"
    return _element(kind, inside, {"scope": scope, "class": look})


def _title_html(group: Group) -> str:
    width = max((len(row) for row in group.rows), default=1)
    look = {"class": "group text", "colspan": str(width)}
    return _element("tr", _element("th", _safe(group.title), look))


def _finding_html(item: Mapping[str, str]) -> str:
    runs = f" ({_safe(item['runs'])})" if item["runs"] else ""
    told = " ".join(filter(None, (item["message"], item["remedy"])))
    head = _element("b", _safe(f"{item['severity']}: {item['check']}"))
    inside = f"{head}{runs}{_element('br', None)}{_safe(told)}"
    return _element("p", inside, {"class": f"finding {item['severity']}"})


def _picture_html(figure: Picture) -> str:
    image = base64.b64encode(figure.svg.encode()).decode()
    shown = {"src": f"data:image/svg+xml;base64,{image}", "alt": figure.alt or figure.caption}
    caption = _element("figcaption", _safe(figure.caption))
    look = {"class": "narrow" * figure.narrow}
    return _element("figure", _element("img", None, shown) + caption, look)


def _safe(text: Cell) -> str:
    return html.escape(printable(ABSENT if text is None else text))


# Objects that tell their own state: one line, a report, and the same in a notebook.


LONGEST: Final = 110
"""Characters of a `repr`."""


NOTEBOOK: Final = "<style>.pmmkit h3 { font-size: 1em } .pmmkit .text { text-align: left }</style>"
"""How a notebook shows them."""


class Described(ABC):
    """An object with a `repr` of one line, a `str` that reports, and HTML for notebooks.

    A class says what it is in `_headline`, and everything else in `_sections`. A dataclass needs
    ``repr=False``, or it writes a `repr` of its own with every sample in it.

    Examples
    --------
    >>> class Mass(Described):
    ...     def _headline(self):
    ...         return "12 kg"
    ...     def _sections(self):
    ...         return [Section(title="Weighed", paragraphs=["on <a> balance"])]
    >>> Mass()
    <Mass 12 kg>
    >>> print(Mass())
    Mass 12 kg
    <BLANKLINE>
    Weighed
      on <a> balance
    >>> Mass()._repr_html_().partition(NOTEBOOK)[2]
    '<p>Mass 12 kg</p><h3>Weighed</h3><p>on &lt;a&gt; balance</p></div>'
    """

    @abstractmethod
    def _headline(self) -> str:
        """What it is and its size, on one line, without the name of the class."""

    @abstractmethod
    def _sections(self) -> Sequence[Section]:
        """What it says of itself, in sections."""

    def sections(self) -> Sequence[Section]:
        """What it says of itself, in sections; its `str` begins with a title and goes on so."""
        return self._sections()

    def _title(self) -> str:
        return " ".join(printable(f"{type(self).__name__} {self._headline()}").split())

    def __repr__(self) -> str:
        line = self._title()
        return f"<{line}>" if len(line) <= LONGEST else f"<{line[: LONGEST - 1]}…>"

    def __str__(self) -> str:
        return text_of([Section(paragraphs=[self._title()]), *self._sections()])

    def _repr_html_(self) -> str:
        told = [Section(paragraphs=[self._title()]), *self._sections()]
        return _element("div", NOTEBOOK + "".join(map(Section.html, told)), {"class": "pmmkit"})
