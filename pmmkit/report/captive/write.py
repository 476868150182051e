"""A test report as a file, by its ending."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Final

from pmmkit.errors import DataError
from pmmkit.files import atomic_path, write_text
from pmmkit.report.captive.document import Document
from pmmkit.report.captive.html import html_of

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
    from pmmkit.report.captive.word import word_bytes

    content = word_bytes(document, template)
    with atomic_path(target) as part:
        part.write_bytes(content)
    return target
