"""The look of a report without a laboratory's template: A4, plain letters, running heads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from pmmkit.escaping import printable
from pmmkit.report.captive.document import Document
from pmmkit.report.captive.word.parts import (
    add_field,
    begin_field,
    chapter_mark,
    end_field,
    link_from,
)

if TYPE_CHECKING:
    from docx.document import Document as WordFile

WHOLE: Final = 16.5
"""Width of text on A4 [cm]."""
INK, SOFT = "1B1B1B", "5A5A5A"
HEADINGS: Final = {"Heading 1": (15, 20, 6), "Heading 2": (11.5, 12, 4)}
"""Letters, room before and room behind [pt]."""
NOT_OLD: Final = "15"
"""Word's mode of layout from 2013 on; without it a file opens in compatibility mode."""


def own_style(file: WordFile, document: Document) -> None:
    """A4, a plain letter, title and number of the report above each page, its number below.

    Parameters
    ----------
    file : Document
        Of python-docx, new.
    document : Document
        Whose title stands there.
    """
    from docx.enum.text import WD_ALIGN_PARAGRAPH
    from docx.oxml.ns import qn
    from docx.shared import Cm, Pt

    _letters(file)
    page = file.sections[0]
    page.page_width, page.page_height = Cm(21.0), Cm(29.7)
    page.left_margin = page.right_margin = Cm((21.0 - WHOLE) / 2)
    page.top_margin, page.bottom_margin = Cm(2.3), Cm(2.0)
    page.different_first_page_header_footer = True
    number = next((item.value for item in document.items if item.key == "number"), None)
    head, foot = page.header.paragraphs[0], page.footer.paragraphs[0]
    head.text = printable(" · ".join(filter(None, (document.title, number))))
    foot.alignment = WD_ALIGN_PARAGRAPH.RIGHT
    add_field(foot, "PAGE", "1")
    foot.add_run(" / ")
    add_field(foot, "NUMPAGES", "1")
    for run in (*head.runs, *foot.runs):
        run.font.size = Pt(8)
    for setting in file.settings.element.find(qn("w:compat")):
        if setting.get(qn("w:name")) == "compatibilityMode":
            setting.set(qn("w:val"), NOT_OLD)


def _letters(file: WordFile) -> None:
    """Sizes, colours and distances of the styles that a report has."""
    from docx.enum.style import WD_STYLE_TYPE
    from docx.enum.text import WD_TAB_ALIGNMENT
    from docx.shared import Cm, Pt, RGBColor

    for name in ("Normal", "Heading 1", "Heading 2", "Title", "Subtitle", "Caption", "TOC Heading"):
        style = file.styles[name]
        style.font.name = "Calibri"
        style.font.color.rgb = RGBColor.from_string(INK)
        fonts = style.element.rPr.rFonts  # else the theme's letters come first
        for place in ("asciiTheme", "hAnsiTheme", "eastAsiaTheme", "cstheme"):
            fonts.attrib.pop(f"{{{fonts.nsmap['w']}}}{place}", None)
    normal = file.styles["Normal"]
    normal.font.size = Pt(10)
    normal.paragraph_format.space_after, normal.paragraph_format.line_spacing = Pt(6), 1.1
    for name, (size, before, after) in HEADINGS.items():
        style = file.styles[name]
        style.font.size = Pt(size)
        layout = style.paragraph_format
        layout.space_before, layout.space_after = Pt(before), Pt(after)
    caption = file.styles["Caption"]
    caption.font.bold, caption.font.size = False, Pt(8.5)
    caption.font.color.rgb = RGBColor.from_string(SOFT)
    caption.paragraph_format.space_before = Pt(4)
    caption.paragraph_format.space_after = Pt(4)
    file.styles["List Bullet"].paragraph_format.space_after = Pt(3)
    line = file.styles.add_style("toc 1", WD_STYLE_TYPE.PARAGRAPH)
    line.base_style = normal
    line.paragraph_format.space_after = Pt(1)
    stops = line.paragraph_format.tab_stops
    stops.add_tab_stop(Cm(0.8))
    stops.add_tab_stop(Cm(WHOLE), WD_TAB_ALIGNMENT.RIGHT)


def contents(file: WordFile, document: Document) -> None:
    """A table of contents, of which Word fills in the pages when its fields are updated.

    Parameters
    ----------
    file : Document
        Of python-docx.
    document : Document
        Whose chapters are listed; each entry leads to its chapter.
    """
    file.add_paragraph("Contents", style="TOC Heading")
    entries = document.numbered
    for place, (mark, chapter) in enumerate(entries):
        line = file.add_paragraph(style="toc 1")
        if place == 0:
            begin_field(line, r'TOC \o "1-1" \h \z')
        first = len(line._p)
        line.add_run(f"{mark}\t{chapter.title}\t")
        add_field(line, rf"PAGEREF {chapter_mark(mark)} \h", "")
        link_from(line, first, chapter_mark(mark))
        if place == len(entries) - 1:
            end_field(line)
