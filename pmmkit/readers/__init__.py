"""Readers of measured files, one module for each format.

A reader is a module with three functions:

``names(request)``
    The headers of the file, nothing else read.
``columns(request, choose)``
    Some columns of a history as numbers; ``choose(headers, count)`` says which.
``cells(request)``
    A small file whole, as text and numbers: tables whose rows are runs.

and, where the format asks for it,

``USUAL``, or ``usual(headers)``
    Our channels and the headers (without unit) that they usually stand under.
``files(request)``
    The files that a folder or a pattern stands for.
``recognises(path, head)``
    Whether a file is of the format, or a folder, whose `head` is empty: told by content, cheap,
    never raising.

To add a format, write the module and put its name below.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Final, Protocol, cast

from pmmkit.errors import UnknownNameError
from pmmkit.readers.base import HEAD, Cells, Choose, Columns, Options, Request

__all__ = [
    "FORMATS",
    "Cells",
    "Columns",
    "Options",
    "Request",
    "files_of",
    "format_of",
    "head_of",
    "reader_for",
    "recognise",
    "usual_of",
]

FORMATS: Final[dict[str, str]] = {
    "csv": "pmmkit.readers.text.csv",
    "excel": "pmmkit.readers.excel.reader",
    "hdf5": "pmmkit.readers.hdf5.reader",
    "matlab": "pmmkit.readers.matlab.reader",
    "openfoam": "pmmkit.readers.openfoam",
    "pmmkit": "pmmkit.readers.saved.reader",
    "star-ccm+": "pmmkit.readers.starccm.reader",
    "tdms": "pmmkit.readers.tdms.reader",
}
"""Formats by name, and the module that reads each."""

_SUFFIXES: Final[dict[str, str]] = {
    ".xls": "excel",
    ".xlsx": "excel",
    ".xlsm": "excel",
    ".xlsb": "excel",
    ".ods": "excel",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".nc": "hdf5",
    ".nc4": "hdf5",
    ".mat": "matlab",
    ".tdms": "tdms",
    ".csv": "csv",
}
_CONTAINERS: Final = (".h5", ".hdf5", ".nc", ".nc4")
"""Suffixes that say how a file is packed and not what its layout is."""
_GENERAL: Final = ("hdf5", "csv")
"""Formats of which others are special cases: they are tried last."""
OF_FOLDERS: Final = "openfoam"
"""Format of a folder that no reader recognises."""


class Reader(Protocol):
    """What a module of a format offers: `names`, `columns` and `cells`."""

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
    if path is None:
        return named or "csv"
    if path.is_dir():
        return recognise(path) or OF_FOLDERS
    if named is not None and suffix not in _CONTAINERS:
        return named
    return recognise(path, [name for name in _ordered() if name != "csv"]) or named or "csv"


def recognise(path: Path, formats: Iterable[str] | None = None) -> str | None:
    r"""The format of a file or folder by its content; None if no reader knows it.

    Parameters
    ----------
    path : Path
        File or folder.
    formats : iterable of str, optional
        Formats that are tried, in this order; by default all, those of which others are special
        cases last.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "run.out"
    >>> _ = file.write_text("t X\n0.0 1.5\n0.1 1.6\n")
    >>> recognise(file)
    'csv'
    """
    try:
        head = head_of(path)
    except OSError:
        return None
    for name in _ordered() if formats is None else formats:
        recognises = getattr(importlib.import_module(FORMATS[name]), "recognises", None)
        if recognises is not None and recognises(path, head):
            return name
    return None


def _ordered() -> list[str]:
    """All formats, special ones first."""
    return [*(name for name in FORMATS if name not in _GENERAL), *_GENERAL]


def head_of(path: Path) -> bytes:
    """The first bytes of a file, none of a folder.

    Parameters
    ----------
    path : Path
        File or folder.

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

    Parameters
    ----------
    request : Request
        The file.

    Raises
    ------
    UnknownNameError
        If the format is not known.
    """
    name = format_of(request.shown, request.options, request.path)
    if name not in FORMATS:
        raise UnknownNameError(f"Format {name!r} is not known: {', '.join(FORMATS)}.")
    return cast(Reader, importlib.import_module(FORMATS[name]))


def usual_of(request: Request, headers: Sequence[str]) -> Mapping[str, str]:
    """Channels and the headers that they usually stand under in the format of a file.

    Parameters
    ----------
    request : Request
        The file.
    headers : sequence of str
        Of the file.
    """
    reader = reader_for(request)
    find: Callable[[Sequence[str]], Mapping[str, str]] | None = getattr(reader, "usual", None)
    usual: Mapping[str, str] = getattr(reader, "USUAL", {})
    return usual if find is None else find(headers)


def files_of(request: Request) -> dict[str, Path]:
    """The files that are read for a request, by the names that messages give them.

    Parameters
    ----------
    request : Request
        The file.

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
