"""Files that are never half written, and where data came from."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import time
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError, FileExists
from pmmkit.files.json_text import readable
from pmmkit.presentation import safe_cell

if TYPE_CHECKING:
    from pandas import DataFrame


@contextmanager
def atomic_path(path: str | Path, *, sealed: bool = False) -> Iterator[Path]:
    """A temporary path beside `path` that takes its name when the block ends without error.

    The file is flushed to disk before it is renamed, so at every moment either the old or the
    new content is there. On an error the temporary file is removed and `path` is untouched.

    Parameters
    ----------
    path : path
        The file to be written. Its folder is made when missing; a link is followed.
    sealed : bool
        Whether the SHA-256 of its content is put behind it (see `is_intact`).

    Examples
    --------
    >>> import uuid
    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "note.txt"
    >>> with atomic_path(target) as part:
    ...     _ = part.write_text("all of it")
    >>> target.read_text()
    'all of it'
    """
    target = Path(path).resolve()
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{uuid.uuid4().hex[:12]}.part{target.suffix}")
    try:
        with _named(part, target):
            yield part
        if sealed:
            digest = sha256(part).encode()
            with part.open("ab") as stream:
                stream.write(SEAL + digest)
        with part.open("rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(part, target)
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def atomic_folder(path: str | Path) -> Iterator[Path]:
    """A temporary folder beside `path` whose files all move there when the block ends well.

    A folder that is not there yet appears with everything in it at once; in one that is, files of
    the same name are replaced, each by the whole new one, and others are left alone. On an error
    nothing is changed. Temporary files that a stopped program left here a week ago go.

    Parameters
    ----------
    path : path
        The folder to be filled.

    Examples
    --------
    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "results"
    >>> with atomic_folder(target) as part:
    ...     _ = (part / "note.txt").write_text("all of it")
    >>> [file.name for file in target.iterdir()]
    ['note.txt']
    """
    target = Path(path).resolve()
    if target.exists() and not target.is_dir():
        raise FileExists(f"{target} is a file; the results need a folder.")
    target.parent.mkdir(parents=True, exist_ok=True)
    _clear(target.parent, target)
    part = target.with_name(f".{target.name}-{uuid.uuid4().hex[:12]}.part")
    part.mkdir()
    try:
        with _named(part, target):
            yield part
        if target.is_dir():
            for file in sorted(part.iterdir()):
                os.replace(file, target / file.name)
        else:
            os.replace(part, target)
    finally:
        shutil.rmtree(part, ignore_errors=True)


@contextmanager
def _named(part: Path, target: Path) -> Iterator[None]:
    """Errors name what is being written by the name that it was to have."""
    try:
        yield
    except OSError as error:
        if isinstance(error.filename, str | os.PathLike):
            error.filename = os.fspath(error.filename).replace(str(part), str(target))
        raise
    except DataError as error:
        error.problems = tuple(
            replace(item, file=item.file and item.file.replace(str(part), str(target)))
            for item in error.problems
        )
        error.args = (error.said("python"),)
        raise


_PART: Final = re.compile(r"\.(?:.+-)?[0-9a-f]{12}\.part(?:\.\w+)?")
"""Names of what is being written."""
_ABANDONED: Final = 7 * 86400.0
"""Seconds after which no program writes it any more: none of ours runs for a week."""


def _clear(*folders: Path) -> None:
    """Remove what stopped programs have left half written."""
    for entry in chain.from_iterable(map(Path.iterdir, filter(Path.is_dir, folders))):
        if not _PART.fullmatch(entry.name):
            continue
        with suppress(OSError):  # another program clears it too
            if entry.lstat().st_mtime < time.time() - _ABANDONED:
                shutil.rmtree(entry) if entry.is_dir() else entry.unlink()


def write_results(path: str | Path, results: Iterable[tuple[str, Any]]) -> list[str]:
    """Results as the files of a folder: nothing is there before all of it is made.

    They take their names together in a folder that is new, one after the other in one that is there
    (see `atomic_folder`).

    Parameters
    ----------
    path : path
        The folder, as for `atomic_folder`.
    results : iterable of (str, object)
        Names of files with what they hold: a text; a table (DataFrame), written without its index;
        a function that writes it to the path it is given; anything else becomes JSON. What an
        iterator makes is written before the next is made.

    Returns
    -------
    list of str
        The names in order.

    Examples
    --------
    >>> import tempfile
    >>> target = Path(tempfile.mkdtemp()) / "results"
    >>> write_results(target, [("note.txt", "all of it"), ("numbers.json", {"L": 7.0})])
    ['note.txt', 'numbers.json']
    """
    with atomic_folder(path) as folder:
        for name, content in results:
            _write_result(folder / name, content)
        return sorted(file.name for file in folder.iterdir())


def _write_result(path: Path, content: Any) -> None:
    if callable(content):
        content(path)
    elif hasattr(content, "to_csv"):
        _harmless(content).to_csv(path, index=False)
    else:
        text = content if isinstance(content, str) else readable(content) + "\n"
        path.write_bytes(text.encode("utf-8"))


def _harmless(table: DataFrame) -> DataFrame:
    """A table whose texts no spreadsheet takes for formulas."""
    texts = table.select_dtypes(exclude="number")
    changed = texts.map(lambda item: safe_cell(item) if isinstance(item, str) else item)
    return table.assign(**changed).rename(columns=lambda name: safe_cell(str(name)))


def is_empty_place(path: Path) -> bool:
    """Whether nothing stands at a path, or an empty folder.

    Parameters
    ----------
    path : Path
        A file or folder.
    """
    return not path.exists() or (path.is_dir() and next(path.iterdir(), None) is None)


def free_folder(path: Path) -> Path:
    """A folder, or the same name with a number where it holds something.

    A file of that name is left in the way.

    Parameters
    ----------
    path : Path
        The folder that is wanted.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> (folder / "run-1.5").mkdir(), (folder / "run-1.5" / "track.csv").touch()
    (None, None)
    >>> free_folder(folder / "run-1.5").name, free_folder(folder / "run-2").name
    ('run-1.5-2', 'run-2')
    """
    if path.is_file():
        return path
    numbered = (path.with_name(f"{path.name}-{n}") for n in count(2))
    return next(filter(is_empty_place, chain([path], numbered)))


def write_text(path: str | Path, text: str) -> None:
    """Write text as UTF-8 with unix line ends, all or nothing.

    Parameters
    ----------
    path : path
        The file.
    text : str
        All of it.
    """
    with atomic_path(path) as part:
        part.write_bytes(text.encode("utf-8"))


def sha256(path: str | Path) -> str:
    """Hexadecimal SHA-256 of a file's bytes.

    Parameters
    ----------
    path : path
        The file.
    """
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


SEAL: Final = b"\npmmkit sha256 "
"""What stands before the checksum behind the content of a sealed file."""


def is_intact(path: str | Path) -> bool | None:
    """Whether a file is what was sealed; None where it has no seal.

    Behind the end that HDF5 knows of its library does not look; it can run forever on a file with
    damaged texts, so a damaged one must be known before it is opened.

    Parameters
    ----------
    path : path
        The file.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "a"
    >>> with atomic_path(place, sealed=True) as part:
    ...     _ = part.write_bytes(b"12")
    >>> found = [is_intact(place)]
    >>> _ = place.write_bytes(b"3" + place.read_bytes()[1:])
    >>> _ = (place.parent / "b").write_bytes(b"12")
    >>> [*found, is_intact(place), is_intact(place.parent / "b")]
    [True, False, None]
    """
    whole = Path(path).read_bytes()
    length = len(SEAL) + 2 * hashlib.sha256().digest_size
    body, end = whole[:-length], whole[-length:]
    if not end.startswith(SEAL):
        return None
    return end == SEAL + hashlib.sha256(body).hexdigest().encode()


def matching(pattern: str | Path) -> tuple[Path, ...]:
    """The files whose names fit a pattern with ``*`` in its last part, sorted by name.

    Parameters
    ----------
    pattern : path
        Such as ``runs/*.csv``.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> for name in ("b.csv", "a.csv", "c.txt"):
    ...     _ = (folder / name).write_text("1")
    >>> [file.name for file in matching(folder / "*.csv")], matching(folder / "c.txt")
    (['a.csv', 'b.csv'], ())
    """
    place = Path(pattern)
    if "*" not in place.name:
        return ()
    found = place.parent.glob(place.name.replace("[", "[[]"))
    return tuple(sorted(file for file in found if file.is_file()))


def datasets_folder() -> Path:
    """The folder of the data that come with pmmkit (in the wheel, or beside the package)."""
    inside = Path(__file__).parents[1] / "datasets"
    return inside if inside.is_dir() else Path(__file__).parents[2] / "datasets"


def cache_folder() -> Path:
    """Where compiled equations and copies of remote files are kept.

    ``PMMKIT_CACHE``, or the user's folder for such things.
    """
    if given := os.environ.get("PMMKIT_CACHE"):
        return Path(given)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "pmmkit"
