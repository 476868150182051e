"""A test report as one HTML file that opens and prints by itself, on A4 with running heads."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Final

from pmmkit.base import DataError
from pmmkit.files import atomic_path, write_text
from pmmkit.presentation import ABSENT, Cell, Grid, Group, Picture, Section, html_text, printable
from pmmkit.views.pages.sections import Symbol
from pmmkit.views.report.bare_page import bare_page
from pmmkit.views.report.captive.columns import columns_for
from pmmkit.views.report.captive.document import Chapter, Document, Item

STYLE: Final = Path(__file__).with_name("style.css")
TEXT: Final = ' class="text"'
HEAD: Final = 'th scope="col"'
MANY: Final = 6
"""Columns from which on a table has small letters."""
UPRIGHT: Final = 17.4 * 0.56 / 0.64
"""Width of an upright page [cm], less what these letters are wider than those of `columns_of`."""


def html_of(document: Document) -> str:
    """A report as HTML."""
    style = STYLE.read_text("utf-8") + _pages(document)
    body = [
        *_cover(document),
        "<main>",
        *(line for mark, chapter in document.numbered for line in _chapter(mark, chapter)),
        "</main>",
    ]
    text = "".join(f"{line}\n" for line in body)
    return bare_page(document.title, style, text, pictures=True)


def _pages(document: Document) -> str:
    """Size of the pages and what stands in their margins; the cover has none."""
    number = next((item.value for item in document.items if item.key == "number"), None)
    return (
        "@page { size: A4; margin: 22mm 18mm 20mm; "
        f"@top-left {{ content: {_css(document.title)}; font: 8pt sans-serif; color: #5a5a5a; }} "
        f"@top-right {{ content: {_css(number or '')}; font: 8pt sans-serif; color: #5a5a5a; }} "
        '@bottom-right { content: counter(page) " / " counter(pages); font: 8pt sans-serif; } }\n'
        "@page across { size: A4 landscape; }\n"
        '@page :first { @top-left { content: ""; } @top-right { content: ""; } '
        '@bottom-right { content: ""; } }\n'
    )


def _css(text: str) -> str:
    """A text as a string of CSS that cannot end: all but letters, digits and blanks by number."""
    return '"' + "".join(x if x.isalnum() or x == " " else f"\\{ord(x):x} " for x in text) + '"'


def _cover(document: Document) -> Iterable[str]:
    yield '<header class="cover">'
    yield f"<h1>{html_text(document.title)}</h1>"
    yield f'<p class="subtitle">{html_text(document.subtitle)}</p>'
    yield _items(document.items)
    yield '<div class="basis">' + "".join(f"<p>{html_text(x)}</p>" for x in document.basis)
    yield "</div>"
    yield "<nav><h2>Contents</h2><ol>"
    for mark, chapter in document.numbered:
        title = html_text(chapter.title)
        yield f'<li><a href="#c{mark}"><b>{mark}</b>{title}</a></li>'
    yield "</ol></nav></header>"


def _chapter(mark: str, chapter: Chapter) -> Iterable[str]:
    kind = ' class="appendix"' if chapter.appendix else ""
    yield f'<section><h2 id="c{mark}"{kind}>{mark} {html_text(chapter.title)}</h2>'
    if chapter.items:
        yield _items(chapter.items)
    for section in chapter.sections:
        yield from _section(section)
    yield "</section>"


def _items(items: Sequence[Item]) -> str:
    rows = "".join(
        f'<tr><th class="text" scope="row">{html_text(item.what)}</th>'
        f'<td class="text{" lack" if item.value is None else ""}">{html_text(item.text)}</td></tr>'
        for item in items
    )
    return f'<table class="items"><tbody>{rows}</tbody></table>'


def _section(section: Section) -> Iterable[str]:
    if section.title:
        yield f"<h3>{html_text(section.title)}</h3>"
    yield from (f"<p>{html_text(text)}</p>" for text in section.paragraphs)
    if section.points:
        yield "<ul>" + "".join(f"<li>{html_text(x)}</li>" for x in section.points) + "</ul>"
    for found in section.findings:
        runs = f" ({html_text(found['runs'])})" if found["runs"] else ""
        remedy = f" {html_text(found['remedy'])}" if found["remedy"] else ""
        yield (
            f'<p class="finding {found["severity"]}"><b>{html_text(found["severity"])}: '
            f"{html_text(found['check'])}</b>{runs}<br>{html_text(found['message'])}{remedy}</p>"
        )
    yield from map(_table, section.tables)
    yield from map(_figure, section.figures)


def _table(table: Grid) -> str:
    texts = {0, *table.texts}

    def row(tag: str, cells: Sequence[Cell]) -> str:
        inside = (
            f"<{tag}{TEXT if place in texts else ''}>{_cell(cell)}</{tag[:2]}>"
            for place, cell in enumerate(cells)
        )
        return f"<tr>{''.join(inside)}</tr>"

    caption = f"<caption>{html_text(table.caption)}</caption>" if table.caption else ""
    head = f"<thead>{row(HEAD, table.head)}</thead>" if any(table.head) else ""
    body = "".join(
        _group(group, len(table.head)) + "".join(row("td", cells) for cells in group.rows)
        for group in table.groups
    )
    dense = ' class="dense"' if len(table.head) >= MANY else ""
    inside = f"{caption}{head}<tbody>{body}</tbody>"
    across = "" if columns_for(table, UPRIGHT).fits else " across"
    return f'<div class="wide{across}" tabindex="0"><table{dense}>{inside}</table></div>'


def _group(group: Group, width: int) -> str:
    if not group.title:
        return ""
    return f'<tr><th class="group" colspan="{width}">{html_text(group.title)}</th></tr>'


def _cell(cell: Cell) -> str:
    if isinstance(cell, Symbol):
        return f"{html_text(cell.letter)}\N{WORD JOINER}<sub>{html_text(cell.below)}</sub>"
    return ABSENT if cell is None else html_text(cell)


def _figure(figure: Picture) -> str:
    data = base64.b64encode(figure.svg.encode()).decode()
    alt = html_text(printable(figure.alt or figure.caption))
    narrow = ' class="narrow"' if figure.narrow else ""
    return (
        f"<figure{narrow}>"
        f'<img src="data:image/svg+xml;base64,{data}" alt="{alt}">'
        f"<figcaption>{html_text(figure.caption)}</figcaption></figure>"
    )


# A test report as a file, by its ending.


FORMATS: Final = ("html", "docx")
"""Endings of the files that can be written."""


def check_target(path: str | Path, template: str | Path | None = None) -> str:
    """How a report would be written, before it is made.

    Parameters
    ----------
    path, template : path
        As for `write_document`.

    Returns
    -------
    str
        One of `FORMATS`.

    Raises
    ------
    DataError
        As `write_document`, but for what only filling a template shows.
    """
    name = Path(path).name
    ending = Path(path).suffix.lower().lstrip(".")
    if ending not in FORMATS:
        raise DataError(f"{name}: a report is written as .{' or .'.join(FORMATS)}.")
    if ending == "html" and template is not None:
        raise DataError("A template is a Word document: name an output that ends in .docx.")
    if template is not None and not Path(template).is_file():
        raise DataError(f"There is no template {template}.")
    if ending == "docx":
        try:
            import_module("docxtpl")
        except ImportError as error:
            raise DataError(
                "A document for Word needs docxtpl, which is not installed: pip install "
                "'pmmkit[word]'."
            ) from error
    return ending


def write_document(
    document: Document, path: str | Path, *, template: str | Path | None = None
) -> Path:
    """Write a report, all or nothing; the ending of the name says how.

    Parameters
    ----------
    document : Document
        What is written.
    path : path
        ``.html``, or ``.docx`` for Word.
    template : path, optional
        The laboratory's own document (``.docx``), which is filled.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    DataError
        If the ending is another, a template is given for HTML, is not there or cannot be filled,
        or what writes Word is not installed.
    """
    target = Path(path)
    if check_target(target, template) == "html":
        write_text(target, html_of(document))
        return target
    from pmmkit.views.report.captive.word.build import word_bytes

    content = word_bytes(document, template)
    with atomic_path(target) as part:
        part.write_bytes(content)
    return target
