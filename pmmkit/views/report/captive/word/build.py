"""A report as a Word document: what stands where."""

from __future__ import annotations

import io
import zipfile
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError
from pmmkit.presentation import Grid, Picture, Section, printable
from pmmkit.views.report.captive.columns import columns_for
from pmmkit.views.report.captive.document import Chapter, Document, Item
from pmmkit.views.report.captive.word.own_style import (
    add_bookmark,
    add_field,
    chapter_mark,
    contents,
    is_spacer,
    own_style,
    spacer,
    style_of,
    thin,
)
from pmmkit.views.report.captive.word.tables import GRID, grid_table, items_table

if TYPE_CHECKING:
    from docx.document import Document as WordFile
    from docx.text.paragraph import Paragraph


# Pages of a Word document, upright and across.

DOTS: Final = 170
"""Dots per inch of a figure."""


def inside(file: WordFile) -> tuple[float, float]:
    """Width and height of the last pages between their margins [cm]."""
    from docx.shared import Length

    page = file.sections[-1]
    width = page.page_width - page.left_margin - page.right_margin
    height = page.page_height - page.top_margin - page.bottom_margin
    return Length(width).cm, Length(height).cm


def lay(file: WordFile, *, across: bool) -> None:
    """Go on across or upright, on a new page where the last is not so already.

    Margins and running heads stay as they were.
    """
    from docx.enum.section import WD_ORIENTATION, WD_SECTION
    from docx.text.paragraph import Paragraph

    last = file.sections[-1]
    width, height = last.page_width, last.page_height
    if (last.orientation == WD_ORIENTATION.LANDSCAPE) == across:
        return
    page = file.add_section(WD_SECTION.NEW_PAGE)
    *_, before, bearer = file.element.body[:-1]
    if is_spacer(before):  # behind a table that fills the page it would stand on the next
        before.getparent().remove(before)
    thin(Paragraph(bearer, file), 1.0)
    page.page_width, page.page_height = height, width
    page.orientation = WD_ORIENTATION.LANDSCAPE if across else WD_ORIENTATION.PORTRAIT
    page.different_first_page_header_footer = False


DATE: Final = datetime(1980, 1, 1)
"""Of every part of the file, so that the same report gives the same bytes."""
HIGHEST: Final = 0.78
"""Part of the height of a page that a figure may have."""
NARROW: Final = 0.6
"""Part of the width that a narrow figure has."""
BODY: Final = "PMMKIT-REPORT-BODY"
"""Stands where a template has ``{{ body }}`` until the chapters are put there."""


@dataclass(frozen=True, kw_only=True)
class _Sheet:
    """A document that is being written.

    `file`: of python-docx, which grows. `width`: of an upright page between its margins [cm].
    `grid`: style of its tables, for lines of the laboratory's own. `captions`: how many tables
    and figures have been numbered.
    """

    file: WordFile
    width: float
    grid: str | None = None
    captions: Counter[str] = field(default_factory=Counter)


def word_bytes(document: Document, template: str | Path | None = None) -> bytes:
    """A report as a Word document."""
    import docx

    if template is None:
        file = docx.Document()
        own_style(file, document)
        sheet = _Sheet(file=file, width=inside(file)[0])
        _cover(sheet, document)
        _chapters(sheet, document, anew=True)
    else:
        file = _filled(document, Path(template))
    file.core_properties.title = printable(document.title)[:255]
    file.core_properties.author = "pmmkit"
    file.core_properties.created = file.core_properties.modified = DATE
    return _undated(file)


def fields_of(document: Document) -> dict[str, Any]:
    """What a template can name."""

    def plain(items: Iterable[Item]) -> list[dict[str, str]]:
        return [{"what": x.what, "value": x.text, "supply": x.supply} for x in items]

    every = [*document.items, *(item for x in document.chapters for item in x.items)]
    return {
        "title": document.title,
        "subtitle": document.subtitle,
        "body": BODY,
        "report": {item.key: item.text for item in every if item.table == "report"},
        "items": plain(document.items),
        "chapters": [
            {"number": mark, "title": chapter.title, "items": plain(chapter.items)}
            for mark, chapter in document.numbered
        ],
        "missing": plain(item for _, item in document.missing),
    }


def _filled(document: Document, template: Path) -> WordFile:
    """The template with its fields filled, and the chapters in their place."""
    import docxtpl
    from jinja2 import TemplateError
    from jinja2.sandbox import SandboxedEnvironment

    try:
        made = docxtpl.DocxTemplate(template)
        made.render(_printable(fields_of(document)), SandboxedEnvironment(autoescape=True))
    except (TemplateError, OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise DataError(f"{template.name} cannot be filled: {error}.") from error
    file: WordFile = made.docx
    place = next((x for x in file.paragraphs if x.text.strip() == BODY), None)
    if place is None:
        return file
    begin = len(file.element.body)
    _chapters(_Sheet(file=file, width=inside(file)[0], grid=GRID), document)
    added = list(file.element.body)[begin - 1 : -1]  # before the properties of the last section
    for element in added:
        place._p.addprevious(element)
    place._p.getparent().remove(place._p)
    return file


def _printable(value: Any) -> Any:
    """Texts without what Word's XML cannot hold."""
    if isinstance(value, dict):
        return {key: _printable(item) for key, item in value.items()}
    return [_printable(item) for item in value] if isinstance(value, list) else printable(value)


def _cover(sheet: _Sheet, document: Document) -> None:
    file = sheet.file
    file.add_paragraph(printable(document.title), style="Title")
    file.add_paragraph(printable(document.subtitle), style="Subtitle")
    items_table(file, document.items, sheet.width, sheet.grid)
    for text in document.basis:
        file.add_paragraph(printable(text))
    contents(file, document)


def _chapters(sheet: _Sheet, document: Document, *, anew: bool = False) -> None:
    """All chapters, the appendices on pages of their own, and the first one if it begins anew."""
    file = sheet.file
    for number, (mark, chapter) in enumerate(document.numbered):
        heading = file.add_paragraph(f"{mark} {chapter.title}", style=style_of(file, "Heading 1"))
        heading.paragraph_format.page_break_before = chapter.appendix or (anew and number == 0)
        add_bookmark(heading, chapter_mark(mark), number)
        _chapter(sheet, chapter)
        lay(file, across=False)


def _chapter(sheet: _Sheet, chapter: Chapter) -> None:
    if chapter.items:
        items_table(sheet.file, chapter.items, sheet.width, sheet.grid)
    for section in chapter.sections:
        _section(sheet, section)


def _section(sheet: _Sheet, section: Section) -> None:
    file = sheet.file
    lay(file, across=False)
    if section.title:
        file.add_paragraph(printable(section.title), style=style_of(file, "Heading 2"))
    for text in section.paragraphs:
        file.add_paragraph(printable(text))
    for text in section.points:
        file.add_paragraph(printable(text), style=style_of(file, "List Bullet"))
    for found in section.findings:
        told = file.add_paragraph()
        told.paragraph_format.keep_together = True
        runs = f" ({found['runs']})" if found["runs"] else ""
        told.add_run(printable(f"{found['severity']}: {found['check']}")).bold = True
        told.add_run(printable(runs)).add_break()
        told.add_run(printable(f"{found['message']} {found['remedy']}".rstrip()))
    for table in section.tables:
        _table(sheet, table)
    for figure in section.figures:
        _figure(sheet, figure)


def _table(sheet: _Sheet, table: Grid) -> None:
    """A table with its caption above; on a page across where its numbers need it."""
    file = sheet.file
    across = not columns_for(table, sheet.width).fits
    lay(file, across=across)
    if table.caption:
        _caption(sheet, "Table", table.caption).paragraph_format.keep_with_next = True
    grid_table(file, table, columns_for(table, inside(file)[0]), sheet.grid)
    spacer(file)


def _figure(sheet: _Sheet, figure: Picture) -> None:
    from docx.shared import Cm

    lay(sheet.file, across=False)
    across, along = inside(sheet.file)
    shape = figure.figure.width / figure.figure.height
    width = min(across * (NARROW if figure.narrow else 1.0), HIGHEST * along * shape)
    place = sheet.file.add_paragraph()
    place.paragraph_format.keep_with_next = True
    png = io.BytesIO(figure.figure.png(DOTS))
    placed = place.add_run().add_picture(png, width=Cm(width))
    placed._inline.docPr.set("descr", printable(figure.alt))
    _caption(sheet, "Figure", figure.caption)


def _caption(sheet: _Sheet, kind: str, text: str) -> Paragraph:
    """A caption with its number, which Word counts anew where a laboratory adds its own."""
    sheet.captions[kind] += 1
    style = style_of(sheet.file, "Caption")
    caption = sheet.file.add_paragraph(f"{kind} ", style=style)
    add_field(caption, f"SEQ {kind} \\* ARABIC", str(sheet.captions[kind]))
    caption.add_run(printable(f". {text}"))
    if style is None:
        for run in caption.runs:
            run.italic = True
    return caption


def _undated(file: WordFile) -> bytes:
    """The document as bytes whose parts bear one date."""
    raw, made = io.BytesIO(), io.BytesIO()
    file.save(raw)
    with zipfile.ZipFile(raw) as parts, zipfile.ZipFile(made, "w") as result:
        for item in parts.infolist():
            entry = zipfile.ZipInfo(item.filename, DATE.timetuple()[:6])
            result.writestr(entry, parts.read(item), zipfile.ZIP_DEFLATED)
    return made.getvalue()
