"""Readers of measured files, one module for each format.

A reader is a module with three functions:

``names(request)``
    The headers of the file, nothing else read.
``columns(request, choose)``
    Some columns of a history as numbers; ``choose(headers, count)`` says which.
``cells(request)``
    A small file whole, as text and numbers: tables whose rows are runs.

It may have a fourth, ``recognises(path, head)``: whether a file (or folder, whose `head` is empty)
is of its format, told by content and never raising.

To add a format, write the module and put its name below.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from pathlib import Path, PurePath
from typing import Final, Protocol, cast

from pmmkit.errors import UnknownNameError
from pmmkit.runs.readers.base import HEAD, Cells, Choose, Columns, Options, Request

__all__ = [
    "FORMATS",
    "Cells",
    "Columns",
    "Options",
    "Reader",
    "Request",
    "format_of",
    "head_of",
    "reader_for",
    "recognise",
]

FORMATS: Final[dict[str, str]] = {
    "csv": "pmmkit.runs.readers.csv",
    "excel": "pmmkit.runs.readers.excel",
    "pmmkit": "pmmkit.runs.readers.saved",
}
"""Formats by name, and the module that reads each."""

_SUFFIXES: Final[dict[str, str]] = {
    ".xls": "excel", ".xlsx": "excel", ".xlsm": "excel", ".xlsb": "excel", ".ods": "excel",
    ".h5": "pmmkit", ".hdf5": "pmmkit", ".nc": "pmmkit",
}  # fmt: skip
_CONTAINERS: Final = (".h5", ".hdf5", ".nc")
"""Suffixes that say how a file is packed, not what its layout is."""


class Reader(Protocol):
    """What a module of a format offers."""

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the file."""

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns as numbers."""

    def cells(self, request: Request) -> Cells:
        """The whole of a small file."""


def format_of(file: str, options: Options, path: Path | None = None) -> str:
    """Format of a file: as stated, else by its suffix, else by its content, else ``csv``.

    Parameters
    ----------
    file : str
        Its name.
    options : Options
        What the campaign file states.
    path : Path, optional
        Where it lies; without it the content is not looked at. Where the suffix is that of a
        container of several formats (HDF5), the content counts before it.

    Examples
    --------
    >>> format_of("tests.xls", Options()), format_of("run.dat", Options())
    ('excel', 'csv')
    """
    if options.format:
        return options.format
    suffix = PurePath(file).suffix.lower()
    named = _SUFFIXES.get(suffix)
    if path is None or (named is not None and suffix not in _CONTAINERS):
        return named or "csv"
    found = recognise(path, (name for name in FORMATS if name != "csv"))
    return found or named or "csv"


def recognise(path: Path, formats: Iterable[str] | None = None) -> str | None:
    """The format of a file or folder by its content; None if no reader knows it.

    Parameters
    ----------
    path : Path
        File or folder.
    formats : iterable of str, optional
        Formats that are tried, in this order; by default all, plain text last.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "run.out"
    >>> _ = file.write_text("t X\\n0.0 1.5\\n0.1 1.6\\n")
    >>> recognise(file)
    'csv'
    """
    try:
        head = head_of(path)
    except OSError:
        return None
    names = formats or (*(name for name in FORMATS if name != "csv"), "csv")
    for name in names:
        recognises = getattr(importlib.import_module(FORMATS[name]), "recognises", None)
        if recognises is not None and recognises(path, head):
            return name
    return None


def head_of(path: Path) -> bytes:
    """The first bytes of a file, none of a folder.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    if path.is_dir():
        return b""
    with path.open("rb") as stream:
        return stream.read(HEAD)


def reader_for(request: Request) -> Reader:
    """The reader of a file.

    Raises
    ------
    UnknownNameError
        If the format is not known.
    """
    name = format_of(request.shown, request.options, request.path)
    if name not in FORMATS:
        raise UnknownNameError(f"Format {name!r} is not known: {', '.join(FORMATS)}.")
    return cast(Reader, importlib.import_module(FORMATS[name]))
