"""Readers of measured files: a class for each format, in a file or folder of its own.

To add a format, write a file with a class derived from `Reader` into this folder, or into a package
of your own that names the class in the entry point group ``pmmkit.readers``.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePath
from typing import Final, Literal

from pmmkit.base import Registry
from pmmkit.readers.base import (
    Cells,
    Choose,
    Columns,
    Options,
    Reader,
    Request,
    columns_of,
    head_of,
)

__all__ = [
    "GROUP",
    "READERS",
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
    "recognise",
]

GROUP: Final = "pmmkit.readers"
"""Entry point group by which other packages bring readers."""


def _ours() -> Iterator[Reader]:
    """A reader of each class that the modules and packages of this folder define, by name."""
    made = []
    for item in pkgutil.iter_modules(importlib.import_module("pmmkit.readers").__path__):
        module = importlib.import_module(f"pmmkit.readers.{item.name}")
        for thing in vars(module).values():
            if (
                isinstance(thing, type)
                and issubclass(thing, Reader)
                and thing.__module__ == module.__name__
                and not inspect.isabstract(thing)
            ):
                made.append(thing())
    yield from sorted(made, key=lambda reader: reader.name)


READERS: Final = Registry(
    Reader,  # type: ignore[type-abstract]
    _ours,
    what="format",
    group=GROUP,
    unknown="Format {name!r} is not known{guess} Known: {names}.",
    contract="pmmkit.testing.readers:check_reader",
)
"""All readers by name: those of this folder, then those of other installed packages."""


def format_of(file: str, options: Options, path: Path | None = None) -> str:
    """Format of a file: as stated, else by its suffix, else by its content, else text of columns.

    Examples
    --------
    >>> format_of("tests.xls", Options()), format_of("run.dat", Options())
    ('excel', 'csv')
    """
    if options.format:
        return options.format
    suffix = PurePath(file).suffix.lower()
    named = next((reader for reader in READERS.values() if suffix in reader.suffixes), None)
    otherwise = named.name if named is not None else _fallback("file")
    if path is None:
        return otherwise
    if path.is_dir():
        return recognise(path) or _fallback("folder")
    if named is not None and not named.container:
        return named.name
    told = [name for name in _ordered() if READERS[name].fallback != "file"]
    return recognise(path, told) or otherwise


def _fallback(kind: Literal["file", "folder"]) -> str:
    """The format of a file or folder of which nothing tells it."""
    return next(reader.name for reader in READERS.values() if reader.fallback == kind)


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
    return next((name for name in tried if READERS[name].recognises(path, head)), None)


def _ordered() -> list[str]:
    """All formats, special ones first, text last."""
    return sorted(READERS, key=lambda name: (READERS[name].general, not READERS[name].binary))


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
    return READERS[format_of(request.shown, request.options, request.path)]


def files_of(request: Request) -> dict[str, Path]:
    """The files that are read for a request, by the names that messages give them."""
    return {request.inside(path).shown: path for path in reader_for(request).files(request)}
