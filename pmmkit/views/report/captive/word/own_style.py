"""The look of a report without a laboratory's template: A4, plain letters, running heads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from pmmkit.presentation import printable
from pmmkit.views.report.captive.document import Document

if TYPE_CHECKING:
    from docx.document import Document as WordFile
    from docx.text.paragraph import Paragraph


# Small parts of a Word document that python-docx has no words for.


SPACE: Final = 8.0
"""Room behind a table [pt]."""


def element(name: str, /, *children: Any, **attributes: object) -> Any:
    """An XML element of WordprocessingML."""
    from docx.oxml import OxmlElement
    from docx.oxml.ns import qn

    made = OxmlElement(name)
    for key, value in attributes.items():
        made.set(qn(f"w:{key}"), str(value))
    for child in children:
        made.append(child)
    return made


def style_of(file: WordFile, name: str | None) -> str | None:
    """A style, where the document has it; templates need not."""
    return name if name in {style.name for style in file.styles} else None


def add_field(paragraph: Paragraph, code: str, shown: str) -> None:
    """A field of Word, with what it shows until Word counts anew."""
    begin_field(paragraph, code)
    paragraph.add_run(shown)
    end_field(paragraph)


def begin_field(paragraph: Paragraph, code: str) -> None:
    """The start of a field, whose text follows."""
    text = element("w:instrText")
    text.text = f" {code} "
    for part in (element("w:fldChar", fldCharType="begin"), text):
        paragraph.add_run()._r.append(part)
    paragraph.add_run()._r.append(element("w:fldChar", fldCharType="separate"))


def end_field(paragraph: Paragraph) -> None:
    """The end of a field."""
    paragraph.add_run()._r.append(element("w:fldChar", fldCharType="end"))


def link_from(paragraph: Paragraph, first: int, name: str) -> None:
    """Make what a paragraph holds from its element `first` on lead to a bookmark."""
    inside = list(paragraph._p)[first:]
    paragraph._p.append(element("w:hyperlink", *inside, anchor=name, history=1))


def chapter_mark(mark: str) -> str:
    """Name of the place where a chapter begins."""
    return f"chapter_{mark}"


def add_bookmark(paragraph: Paragraph, name: str, number: int) -> None:
    """Make a place that links lead to; its number is its own in the document."""
    paragraph._p.append(element("w:bookmarkStart", id=number, name=name))
    paragraph._p.append(element("w:bookmarkEnd", id=number))


def spacer(file: WordFile) -> None:
    """A thin line behind a table, without which Word would join it to the next."""
    thin(file.add_paragraph(), SPACE)


def is_spacer(part: Any) -> bool:
    """Whether a part of the body is an empty paragraph."""
    return bool(part.tag.endswith("}p")) and not part.text and not part.r_lst


def thin(paragraph: Paragraph, height: float) -> None:
    """Give an empty paragraph a height [pt]."""
    from docx.enum.text import WD_LINE_SPACING
    from docx.shared import Pt

    layout = paragraph.paragraph_format
    layout.space_before = layout.space_after = Pt(0)
    layout.line_spacing_rule, layout.line_spacing = WD_LINE_SPACING.EXACTLY, Pt(height)


WHOLE: Final = 16.5
"""Width of text on A4 [cm]."""
INK, SOFT = "1B1B1B", "5A5A5A"
HEADINGS: Final = {"Heading 1": (15, 20, 6), "Heading 2": (11.5, 12, 4)}
"""Letters, room before and room behind [pt]."""
NOT_OLD: Final = "15"
"""Word's mode of layout from 2013 on; without it a file opens in compatibility mode."""


def own_style(file: WordFile, document: Document) -> None:
    """A4, a plain letter, title and number of the report above each page, its number below."""
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
    """A table of contents, of which Word fills in the pages when its fields are updated."""
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
