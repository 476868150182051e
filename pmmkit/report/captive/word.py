"""A test report for Word: a document of its own, or the laboratory's template filled."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.errors import DataError
from pmmkit.escaping import printable
from pmmkit.presentation import ABSENT, Cell, Grid, Picture, Section
from pmmkit.report.captive.document import Chapter, Document, Item
from pmmkit.report.drawn import Drawn
from pmmkit.workbench.pages.sections import Symbol

if TYPE_CHECKING:
    from docx.document import Document as WordFile
    from docx.table import Table
    from docx.text.paragraph import Paragraph

DATE: Final = datetime(1980, 1, 1)
"""Of every part of the file, so that the same report gives the same bytes."""
WHOLE: Final = 16.5
"""Width of text on A4 [cm]."""
HIGHEST: Final = 0.85
"""Part of the height of a page that a figure may have."""
BODY: Final = "PMMKIT-REPORT-BODY"
"""Stands where a template has ``{{ body }}`` until the chapters are put there."""


def word_bytes(document: Document, template: str | Path | None = None) -> bytes:
    """A report as a Word document.

    Parameters
    ----------
    document : Document
        What is written.
    template : path, optional
        The laboratory's document. Its fields ``{{ title }}``, ``{{ report.customer }}`` … are
        filled with text, and the chapters stand where a paragraph holds ``{{ body }}``, in its
        styles. Texts of the campaign are put in as they stand: nothing in them is a field.

    Raises
    ------
    DataError
        If the template is no Word document or cannot be filled.
    """
    import docx

    if template is None:
        file = docx.Document()
        _own_style(file, document)
        _cover(file, document)
        _chapters(file, document)
    else:
        file = _filled(document, Path(template))
    file.core_properties.title = printable(document.title)[:255]
    file.core_properties.author = "pmmkit"
    file.core_properties.created = file.core_properties.modified = DATE
    return _undated(file)


def fields_of(document: Document) -> dict[str, Any]:
    """What a template can name.

    Parameters
    ----------
    document : Document
        The report.

    Returns
    -------
    dict
        ``title``, ``subtitle``, ``body``; ``report``, the texts of ``[report]`` by key; ``items``
        and ``chapters``, lists with what is printed; ``missing``, what was not supplied.
    """

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
    _chapters(file, document)
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


def _own_style(file: WordFile, document: Document) -> None:
    """A4, a plain letter, the title above each page and its number below."""
    from docx.enum.text import WD_ALIGN_PARAGRAPH
    from docx.shared import Cm, Pt

    file.styles["Normal"].font.name = "Calibri"
    file.styles["Normal"].font.size = Pt(10)
    page = file.sections[0]
    page.page_width, page.page_height = Cm(21.0), Cm(29.7)
    page.left_margin = page.right_margin = Cm((21.0 - WHOLE) / 2)
    page.top_margin, page.bottom_margin = Cm(2.3), Cm(2.0)
    page.different_first_page_header_footer = True
    page.header.paragraphs[0].text = printable(document.title)
    foot = page.footer.paragraphs[0]
    foot.alignment = WD_ALIGN_PARAGRAPH.RIGHT
    _field(foot, "PAGE")
    foot.add_run(" / ")
    _field(foot, "NUMPAGES")


def _field(paragraph: Paragraph, code: str) -> None:
    from docx.oxml import OxmlElement
    from docx.oxml.ns import qn

    field = OxmlElement("w:fldSimple")
    field.set(qn("w:instr"), code)
    paragraph._p.append(field)


def _cover(file: WordFile, document: Document) -> None:
    file.add_paragraph(printable(document.title), style="Title")
    file.add_paragraph(printable(document.subtitle), style="Subtitle")
    _items(file, document.items)
    for text in document.basis:
        file.add_paragraph(printable(text))
    file.add_page_break()


def _chapters(file: WordFile, document: Document) -> None:
    for mark, chapter in document.numbered:
        _chapter(file, mark, chapter)


def _chapter(file: WordFile, mark: str, chapter: Chapter) -> None:
    heading = file.add_paragraph(f"{mark} {chapter.title}", style=_style(file, "Heading 1"))
    heading.paragraph_format.page_break_before = chapter.appendix
    if chapter.items:
        _items(file, chapter.items)
    for section in chapter.sections:
        _section(file, section)


def _style(file: WordFile, name: str) -> str | None:
    """A style, where the document has it; templates need not."""
    return name if name in [style.name for style in file.styles] else None


def _section(file: WordFile, section: Section) -> None:
    if section.title:
        file.add_paragraph(printable(section.title), style=_style(file, "Heading 2"))
    for text in section.paragraphs:
        file.add_paragraph(printable(text))
    for text in section.points:
        file.add_paragraph(printable(text), style=_style(file, "List Bullet"))
    for found in section.findings:
        told = file.add_paragraph()
        runs = f" ({found['runs']})" if found["runs"] else ""
        told.add_run(printable(f"{found['severity']}: {found['check']}")).bold = True
        told.add_run(printable(f"{runs} {found['message']} {found['remedy']}".rstrip()))
    for table in section.tables:
        _table(file, table)
    for figure in section.figures:
        _figure(file, figure)


def _items(file: WordFile, items: Sequence[Item]) -> None:
    table = _new_table(file, len(items), (42, 58))
    for row, item in zip(table.rows, items, strict=True):
        _write(row.cells[0].paragraphs[0], item.what)
        _write(row.cells[1].paragraphs[0], item.text, italic=item.value is None)
        _whole(row)
    file.add_paragraph()


def _table(file: WordFile, table: Grid) -> None:
    from docx.enum.text import WD_ALIGN_PARAGRAPH

    if table.caption:
        caption = file.add_paragraph()
        caption.add_run(printable(table.caption)).italic = True
        caption.paragraph_format.keep_with_next = True
    rows: list[tuple[str, Sequence[Cell]]] = [("head", table.head)] if any(table.head) else []
    for group in table.groups:
        rows += [("group", [group.title])] if group.title else []
        rows += [("row", cells) for cells in group.rows]
    made = _new_table(file, len(rows), _widths([cells for kind, cells in rows if kind != "group"]))
    texts = {0, *table.texts}
    for row, (kind, cells) in zip(made.rows, rows, strict=True):
        places = row.cells
        if kind == "group":
            places[0].merge(places[-1])
        for column, cell in enumerate(cells):
            paragraph = places[column].paragraphs[0]
            _write(paragraph, ABSENT if cell is None else cell, bold=kind != "row")
            if column not in texts:
                paragraph.alignment = WD_ALIGN_PARAGRAPH.RIGHT
        _whole(row, head=kind == "head")
    file.add_paragraph()


def _widths(rows: Sequence[Sequence[Cell]]) -> list[int]:
    """Parts of the width that columns take: as their longest texts, within limits."""
    columns = zip(*rows, strict=True)
    return [min(max(6, *(len(cell or "") for cell in column)), 40) for column in columns]


def _new_table(file: WordFile, rows: int, widths: Sequence[int]) -> Table:
    table = file.add_table(rows, len(widths))
    table.style = _style(file, "Table Grid")
    for column, part in zip(table.columns, widths, strict=True):
        width = int(_inside(file)[0] * part / sum(widths))
        column.width = width
        for cell in column.cells:
            cell.width = width
    return table


def _inside(file: WordFile) -> tuple[int, int]:
    """Width and height of a page between its margins [EMU]."""
    page = file.sections[-1]
    width = page.page_width - page.left_margin - page.right_margin
    return int(width), int(page.page_height - page.top_margin - page.bottom_margin)


def _write(paragraph: Paragraph, text: str, *, bold: bool = False, italic: bool = False) -> None:
    """A text of a cell; a derivative with its letters set low."""
    from docx.shared import Pt

    parts = [(text, False)]
    if isinstance(text, Symbol):
        parts = [(text.letter, False), (text.below, True)]
    paragraph.paragraph_format.space_after = Pt(0)
    for part, low in parts:
        run = paragraph.add_run(printable(part))
        run.font.size = Pt(8.5)
        run.font.subscript = low or None
        run.bold, run.italic = bold, italic


def _whole(row: Any, *, head: bool = False) -> None:
    """A row that no page breaks; a head stands on every page."""
    from docx.oxml import OxmlElement

    row._tr.get_or_add_trPr().append(OxmlElement("w:cantSplit"))
    if head:
        row._tr.get_or_add_trPr().append(OxmlElement("w:tblHeader"))


def _figure(file: WordFile, figure: Picture) -> None:
    if isinstance(figure, Drawn):
        inside = _inside(file)
        wide, high = figure.figure.get_size_inches()
        width = inside[0] * (0.6 if figure.narrow else 1.0)
        width = min(width, HIGHEST * inside[1] * wide / high)
        place = file.add_paragraph()
        place.paragraph_format.keep_with_next = True
        shape = place.add_run().add_picture(io.BytesIO(figure.png()), width=int(width))
        shape._inline.docPr.set("descr", printable(figure.alt))
    file.add_paragraph().add_run(printable(figure.caption)).italic = True


def _undated(file: WordFile) -> bytes:
    """The document as bytes whose parts bear one date."""
    raw, made = io.BytesIO(), io.BytesIO()
    file.save(raw)
    with zipfile.ZipFile(raw) as parts, zipfile.ZipFile(made, "w") as result:
        for item in parts.infolist():
            entry = zipfile.ZipInfo(item.filename, DATE.timetuple()[:6])
            result.writestr(entry, parts.read(item), zipfile.ZIP_DEFLATED)
    return made.getvalue()
