"""Sections and tables, as plain text and as HTML, and text that is safe in either."""

from __future__ import annotations

import html
import re
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePath
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


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure as SVG text, with what it shows in words.

    Parameters
    ----------
    svg, caption : str
        The figure, and the line below it.
    narrow : bool
        Whether it needs but half of the width.
    alt : str
        What is seen, in words, for those who do not see it.
    file : str
        Name without ending of the file in which it stands beside the page too; empty for none.
    figure : Figure, optional
        What it was drawn from, for documents that take no SVG.
    """

    svg: str
    caption: str
    narrow: bool = False
    alt: str = ""
    file: str = ""
    figure: Any = field(default=None, repr=False, compare=False)


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
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(
            cell.ljust(width) if place in left else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in cells
    ]


def section_lines(section: Section) -> list[str]:
    """The lines of a section in plain text: sentences and points first, then the tables."""
    inside = [printable(text) for text in section.paragraphs]
    inside += [f"- {printable(text)}" for text in section.points]
    for table in section.tables:
        inside += table.lines()
    if not section.title:
        return inside
    return [printable(section.title), *(f"  {line}" for line in inside)]


def text_of(sections: Iterable[Section]) -> str:
    """Sections in plain text, an empty line between them.

    Parameters
    ----------
    sections : iterable of Section
        Those that say nothing are left out.
    """
    blocks = map(section_lines, sections)
    return "\n\n".join("\n".join(lines) for lines in blocks if lines)


def section_html(section: Section) -> str:
    """The same as HTML, escaped, without scripts."""
    parts = [f"<p><strong>{_safe(section.title)}</strong></p>"] if section.title else []
    parts += [f"<p>{_safe(text)}</p>" for text in section.paragraphs]
    if section.points:
        parts.append("<ul>" + "".join(f"<li>{_safe(x)}</li>" for x in section.points) + "</ul>")
    parts += [_table_html(table) for table in section.tables]
    return "".join(parts)


def _table_html(table: Grid) -> str:
    left = {0, *table.texts}

    def row(kind: str, cells: Sequence[Cell]) -> str:
        sides = ("left" if place in left else "right" for place in range(len(cells)))
        return (
            "<tr>"
            + "".join(
                f'<{kind} style="text-align:{side}">{_safe(cell)}</{kind}>'
                for side, cell in zip(sides, cells, strict=True)
            )
            + "</tr>"
        )

    caption = f"<caption>{_safe(table.caption)}</caption>" if table.caption else ""
    head = f"<thead>{row('th', table.head)}</thead>" if any(table.head) else ""
    body = "".join(
        (_title_html(group) if group.title else "") + "".join(row("td", x) for x in group.rows)
        for group in table.groups
    )
    return f"<table>{caption}{head}<tbody>{body}</tbody></table>"


def _title_html(group: Group) -> str:
    width = max((len(row) for row in group.rows), default=1)
    return f'<tr><th colspan="{width}" style="text-align:left">{_safe(group.title)}</th></tr>'


def _safe(text: Cell) -> str:
    return html.escape(printable(ABSENT if text is None else text))


# Objects that tell their own state: one line, a report, and the same in a notebook.


LONGEST: Final = 110
"""Characters of a `repr`."""


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
    >>> Mass()._repr_html_()
    '<div><p>Mass 12 kg</p><p><strong>Weighed</strong></p><p>on &lt;a&gt; balance</p></div>'
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
        title = section_html(Section(paragraphs=[self._title()]))
        return f"<div>{title}{''.join(map(section_html, self._sections()))}</div>"
