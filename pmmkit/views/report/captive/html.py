"""A test report as one HTML file that opens and prints by itself, on A4 with running heads."""

from __future__ import annotations

import base64
from importlib import import_module
from pathlib import Path
from typing import Final

from pmmkit.base import DataError
from pmmkit.files import atomic_path, write_text
from pmmkit.presentation import ABSENT
from pmmkit.views.report.bare_page import bare_page
from pmmkit.views.report.captive.columns import columns_for
from pmmkit.views.report.captive.document import Document

STYLE: Final = Path(__file__).with_name("style.css")
MANY: Final = 6
"""Columns from which on a table has small letters."""
UPRIGHT: Final = 17.4 * 0.56 / 0.64
"""Width of an upright page [cm], less what these letters are wider than those of `columns_of`."""


def html_of(document: Document) -> str:
    """A report as HTML."""
    return bare_page(
        "captive/report.html",
        title=document.title,
        style=STYLE.read_text("utf-8") + _pages(document),
        pictures=True,
        document=document,
        absent=ABSENT,
        many=MANY,
        across=lambda grid: not columns_for(grid, UPRIGHT).fits,
        base64=lambda figure: base64.b64encode(figure.svg.encode()).decode(),
    )


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


# A test report as a file, by its ending.


FORMATS: Final = ("html", "docx")
"""Endings of the files that can be written."""


def check_target(path: str | Path, template: str | Path | None = None) -> str:
    """How a report would be written, before it is made.

    Parameters
    ----------
    path, template : path
        As for `write_report`.

    Returns
    -------
    str
        One of `FORMATS`.

    Raises
    ------
    DataError
        As `write_report`, but for what only filling a template shows.
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


def write_document(document: Document, target: Path, *, template: str | Path | None = None) -> None:
    """Write a report, all or nothing; the ending of the name says how.

    template: the laboratory's own document (``.docx``), which is filled.
    """
    if check_target(target, template) == "html":
        write_text(target, html_of(document))
        return
    from pmmkit.views.report.captive.word.build import word_bytes

    content = word_bytes(document, template)
    with atomic_path(target) as part:
        part.write_bytes(content)
