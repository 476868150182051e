"""Readers of measured files, one module for each format.

A reader is a module with three functions:

``names(request)``
    The headers of the file, nothing else read.
``columns(request, choose)``
    Some columns of a history as numbers; ``choose(headers, count)`` says which.
``cells(request)``
    A small file whole, as text and numbers: tables whose rows are runs.

To add a format, write the module and put its name below.
"""

from __future__ import annotations

import importlib
from pathlib import PurePath
from typing import Final, Protocol, cast

from pmmkit.errors import UnknownNameError
from pmmkit.runs.hdf5_guard import is_saved_campaign
from pmmkit.runs.readers.base import Cells, Choose, Columns, Options, Request

__all__ = ["FORMATS", "Cells", "Columns", "Options", "Reader", "Request", "format_of", "reader_for"]

FORMATS: Final[dict[str, str]] = {
    "csv": "pmmkit.runs.readers.csv",
    "excel": "pmmkit.runs.readers.excel",
    "pmmkit": "pmmkit.runs.readers.saved",
    "matlab": "pmmkit.runs.readers.matlab",
    "tdms": "pmmkit.runs.readers.tdms",
    "hdf5": "pmmkit.runs.readers.hdf5",
}
"""Formats by name, and the module that reads each."""

_SUFFIXES: Final[dict[str, str]] = {
    ".xls": "excel", ".xlsx": "excel", ".xlsm": "excel", ".xlsb": "excel", ".ods": "excel",
    ".h5": "hdf5", ".hdf5": "hdf5", ".nc": "hdf5", ".nc4": "hdf5",
    ".mat": "matlab", ".tdms": "tdms",
}  # fmt: skip


class Reader(Protocol):
    """What a module of a format offers."""

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the file."""

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns as numbers."""

    def cells(self, request: Request) -> Cells:
        """The whole of a small file."""


def format_of(file: str, options: Options) -> str:
    """Format of a file: as stated, else by its suffix, else ``csv``.

    Examples
    --------
    >>> format_of("tests.xls", Options()), format_of("run.dat", Options())
    ('excel', 'csv')
    """
    return options.format or _SUFFIXES.get(PurePath(file).suffix.lower(), "csv")


def reader_for(request: Request) -> Reader:
    """The reader of a file.

    Raises
    ------
    UnknownNameError
        If the format is not known.
    """
    name = format_of(request.shown, request.options)
    if name == "hdf5" and request.options.format is None and is_saved_campaign(request.path):
        name = "pmmkit"
    if name not in FORMATS:
        raise UnknownNameError(f"Format {name!r} is not known: {', '.join(FORMATS)}.")
    return cast(Reader, importlib.import_module(FORMATS[name]))
