"""Pages of a Word document, upright and across."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pmmkit.report.captive.word.parts import is_spacer, thin

if TYPE_CHECKING:
    from docx.document import Document as WordFile


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
