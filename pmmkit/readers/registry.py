"""Readers of measured files: a class for each format, in a file or folder of its own.

To add a format, write a file with a class derived from `Reader` into this folder, or into a package
of your own that names the class in the entry point group ``pmmkit.readers``.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import Final, Literal

from pmmkit.base import UnknownNameError, offered
from pmmkit.conventions import did_you_mean
from pmmkit.readers.base import Cells, Choose, Columns, Options, Request, columns_of, head_of
from pmmkit.readers.reader import Reader

__all__ = [
    "GROUP",
    "Cells",
    "Choose",
    "Columns",
    "Options",
    "Reader",
    "Request",
    "columns_of",
    "files_of",
    "format_of",
    "reader_for",
    "reader_of",
    "readers",
    "recognise",
]

GROUP: Final = "pmmkit.readers"
"""Entry point group by which other packages bring readers."""


@cache
def readers() -> Mapping[str, Reader]:
    """All readers by name: those of this folder, then those of other installed packages.

    A reader of another package that cannot be imported, or whose name is taken, is left out with a
    warning.

    Examples
    --------
    >>> readers()["tdms"].words, ".nc" in readers()["hdf5"].suffixes
    ('TDMS (LabVIEW)', True)
    """
    found = {reader.name: reader for reader in sorted(_ours(), key=lambda item: item.name)}
    brought = offered(GROUP, Reader, found)  # type: ignore[type-abstract]
    return MappingProxyType(found | brought)


def _ours() -> Iterator[Reader]:
    """A reader of each class that the modules and packages of this folder define."""
    for item in pkgutil.iter_modules(importlib.import_module("pmmkit.readers").__path__):
        module = importlib.import_module(f"pmmkit.readers.{item.name}")
        for thing in vars(module).values():
            if (
                isinstance(thing, type)
                and issubclass(thing, Reader)
                and thing.__module__ == module.__name__
                and not inspect.isabstract(thing)
            ):
                yield thing()


def reader_of(name: str) -> Reader:
    """The reader of a format.

    Parameters
    ----------
    name : str
        Of the format.

    Raises
    ------
    UnknownNameError
        If the format is not known.

    Examples
    --------
    >>> reader_of("openfoam").computed
    True
    """
    if name not in readers():
        guess = did_you_mean(name, readers()) or "."
        raise UnknownNameError(
            f"Format {name!r} is not known{guess} Known: {', '.join(readers())}."
        )
    return readers()[name]


def format_of(file: str, options: Options, path: Path | None = None) -> str:
    """Format of a file: as stated, else by its suffix, else by its content, else text of columns.

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
    named = next((reader for reader in readers().values() if suffix in reader.suffixes), None)
    otherwise = named.name if named is not None else _fallback("file")
    if path is None:
        return otherwise
    if path.is_dir():
        return recognise(path) or _fallback("folder")
    if named is not None and not named.container:
        return named.name
    told = [name for name in _ordered() if readers()[name].fallback != "file"]
    return recognise(path, told) or otherwise


def _fallback(kind: Literal["file", "folder"]) -> str:
    """The format of a file or folder of which nothing tells it."""
    return next(reader.name for reader in readers().values() if reader.fallback == kind)


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
    tried = _ordered() if formats is None else formats
    return next((name for name in tried if readers()[name].recognises(path, head)), None)


def _ordered() -> list[str]:
    """All formats, special ones first, text last."""
    return sorted(readers(), key=lambda name: (readers()[name].general, not readers()[name].binary))


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
    return reader_of(format_of(request.shown, request.options, request.path))


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
    return {request.inside(path).shown: path for path in reader_for(request).files(request)}
