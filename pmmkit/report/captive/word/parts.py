"""Small parts of a Word document that python-docx has no words for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from docx.document import Document as WordFile
    from docx.text.paragraph import Paragraph

SPACE: Final = 8.0
"""Room behind a table [pt]."""


def element(name: str, /, *children: Any, **attributes: object) -> Any:
    """An XML element of WordprocessingML.

    Parameters
    ----------
    name : str
        With its prefix, such as ``w:tblBorders``.
    *children : element
        Inside, in the order that the schema asks for.
    **attributes : object
        Of the namespace ``w``.
    """
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
