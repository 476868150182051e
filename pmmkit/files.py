"""Files that are never half written, and where data came from."""

from __future__ import annotations

import hashlib
import os
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pmmkit.errors import FileExists


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its name when the block ends without error.

    The file is flushed to disk before it is renamed, so at every moment either the old or the
    new content is there. On an error the temporary file is removed and `path` is untouched.

    Parameters
    ----------
    path : path
        The file to be written. Its folder is made when missing; a link is followed.

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
        yield part
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
    nothing is changed.

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
    part = target.with_name(f".{target.name}-{uuid.uuid4().hex[:12]}.part")
    part.mkdir()
    try:
        yield part
        if target.is_dir():
            for file in sorted(part.iterdir()):
                os.replace(file, target / file.name)
        else:
            os.replace(part, target)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def write_text(path: str | Path, text: str) -> None:
    """Write text as UTF-8 with unix line ends, all or nothing."""
    with atomic_path(path) as part:
        part.write_bytes(text.encode("utf-8"))


def sha256(path: str | Path) -> str:
    """Hexadecimal SHA-256 of a file's bytes."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def matching(pattern: str | Path) -> tuple[Path, ...]:
    """The files whose names fit a pattern with ``*`` in its last part, sorted by name.

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
    inside = Path(__file__).parent / "datasets"
    return inside if inside.is_dir() else Path(__file__).parents[1] / "datasets"
