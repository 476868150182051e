"""Readers of measured files, one module for each format.

A reader is a module with three functions:

``names(request)``
    The headers of the file, nothing else read.
``columns(request, choose)``
    Some columns of a history as numbers; ``choose(headers, count)`` says which.
``cells(request)``
    A small file whole, as text and numbers: tables whose rows are runs.

and, where the format asks for it,

``USUAL``
    Our channels and the headers (without unit) that they usually stand under.
``files(request)``
    The files that a folder stands for.

To add a format, write the module and put its name below.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Final, Protocol, cast

from pmmkit.errors import UnknownNameError
from pmmkit.runs.readers.base import Cells, Choose, Columns, Options, Request

__all__ = [
    "FORMATS", "Cells", "Columns", "Options", "Reader", "Request", "files_of", "format_of",
    "reader_for", "usual_of",
]  # fmt: skip

FORMATS: Final[dict[str, str]] = {
    "csv": "pmmkit.runs.readers.csv",
    "excel": "pmmkit.runs.readers.excel",
    "openfoam": "pmmkit.runs.readers.openfoam",
    "pmmkit": "pmmkit.runs.readers.saved",
}
"""Formats by name, and the module that reads each."""

_SUFFIXES: Final[dict[str, str]] = {
    ".xls": "excel", ".xlsx": "excel", ".xlsm": "excel", ".xlsb": "excel", ".ods": "excel",
    ".h5": "pmmkit", ".hdf5": "pmmkit", ".nc": "pmmkit",
}  # fmt: skip


OF_FOLDERS: Final = "openfoam"
"""Format of a folder where none is stated."""


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
    if request.options.format is None and request.path.is_dir():
        name = OF_FOLDERS
    if name not in FORMATS:
        raise UnknownNameError(f"Format {name!r} is not known: {', '.join(FORMATS)}.")
    return cast(Reader, importlib.import_module(FORMATS[name]))


def usual_of(request: Request) -> Mapping[str, str]:
    """Channels and the headers that they usually stand under in the format of a file."""
    usual: Mapping[str, str] = getattr(reader_for(request), "USUAL", {})
    return usual


def files_of(request: Request) -> dict[str, Path]:
    """The files that are read for a request, by the names that messages give them.

    Raises
    ------
    CampaignError
        If the request means a folder that holds nothing of its format.
    """
    files: Callable[[Request], Sequence[Path]] | None = getattr(reader_for(request), "files", None)
    if files is None:
        return {request.shown: request.path}
    folder = request.path if request.path.is_dir() else request.path.parent
    shown = request.shown if request.path.is_dir() else request.shown.rpartition("/")[0]
    return {
        f"{shown.rstrip('/')}/{name}" if shown else name: path
        for path in files(request)
        for name in [path.relative_to(folder).as_posix()]
    }
