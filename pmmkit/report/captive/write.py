"""A test report as a file, by its ending."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pmmkit.errors import DataError
from pmmkit.files import atomic_path, write_text
from pmmkit.report.captive.document import Document
from pmmkit.report.captive.html import html_of

FORMATS: Final = ("html", "docx")
"""Endings of the files that can be written."""


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
        If the ending is another, a template is given for HTML, or cannot be filled, or what
        writes Word is not installed.
    """
    target = Path(path)
    ending = target.suffix.lower().lstrip(".")
    if ending not in FORMATS:
        raise DataError(f"{target.name}: a report is written as {' or '.join(FORMATS)}.")
    if ending == "html":
        if template is not None:
            raise DataError("A template is a Word document: name an output that ends in .docx.")
        write_text(target, html_of(document))
        return target
    from pmmkit.report.captive.word import word_bytes

    content = word_bytes(document, template)
    with atomic_path(target) as part:
        part.write_bytes(content)
    return target
