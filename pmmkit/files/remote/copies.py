"""Copies of objects in a folder of this machine, each for one state of its object.

``remote/KEY-STATE/`` below pmmkit's cache holds one copy and ``pmmkit-origin.json``, which names
its URL, size and SHA-256. Such a folder appears at once, whole, and is never changed; it goes when
another state of its object was copied. All may be deleted at will.
"""

from __future__ import annotations

import errno
import json
import os
import shutil
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from hashlib import sha256 as hashed
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.files.json_text import readable
from pmmkit.files.places import cache_folder, sha256
from pmmkit.files.remote.objects import Origin, is_absent, system_of, told

SHEET: Final = "pmmkit-origin.json"
"""Beside each copy: where it is from and what it was when it came."""
WAITS: Final = (0.5, 2.0)
"""Seconds before a copy that broke off is begun again."""
_DISK: Final = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
"""What a disk says that takes no more."""
MOST_UNSTATED: Final = 1_000_000_000
"""Bytes of an object whose store does not say its size."""


class _TooLong(Exception):
    """More has come than the store said."""


def local_copy(origin: Origin, *, proven: bool = True) -> Path:
    """The copy of an object on this machine, fetched where it is not there.

    Parameters
    ----------
    origin : Origin
        As `Origin.of` gave it, here or in another process.
    proven : bool
        Whether the content of a copy that is there is held against its checksum; else only its
        size is.

    Returns
    -------
    Path
        The file; its content is that of the state that was seen.

    Raises
    ------
    DataError
        If the object has changed since or is gone, its store breaks off three times, or the copy
        cannot be written.
    """
    place = _place(origin)
    known = _known(place, origin, proven)
    if known is not None:
        return known
    try:
        place.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with _part(place) as part:
            _fetch(origin, part / origin.name)
            _write_sheet(origin, part)
            return _moved(part, place, origin)
    except OSError as error:
        raise DataError(
            f"its copy cannot be written below {place.parent}: {error.strerror}.",
            file=origin.shown,
            remedy="Make room there, or name another folder with PMMKIT_CACHE.",
        ) from error


def _place(origin: Origin) -> Path:
    key, state = (hashed(text.encode()).hexdigest()[:24] for text in (origin.url, origin.state))
    return cache_folder().resolve() / "remote" / f"{key}-{state}"


def _known(place: Path, origin: Origin, proven: bool) -> Path | None:
    """A copy that is there and is what it was when it came."""
    copy = place / origin.name
    try:
        sheet = json.loads((place / SHEET).read_text(encoding="utf-8"))
        found = copy.stat()
        whole = sheet["size"] == found.st_size and sheet["url"] == origin.shown
        whole = whole and (not proven or sheet["sha256"] == _digest(copy, found.st_mtime_ns))
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return copy if whole else None


@lru_cache(maxsize=4096)
def _digest(copy: Path, _: int) -> str:
    """SHA-256 of a copy, found once for each time of change: many runs may lie in one file."""
    return sha256(copy)


@contextmanager
def _part(place: Path) -> Iterator[Path]:
    """A new folder beside a place, gone afterwards unless it was moved there."""
    part = place.with_name(f".{uuid.uuid4().hex[:12]}.part")
    part.mkdir()
    try:
        yield part
    finally:
        shutil.rmtree(part, ignore_errors=True)


def _fetch(origin: Origin, target: Path) -> None:
    """Copy an object, from the beginning again where its store breaks off."""
    system = system_of(origin.url)
    for wait in (*WAITS, None):
        try:
            system.get_file(origin.url, str(target), callback=_counting(origin))
            _check_size(origin, target)
            break
        except _TooLong as error:
            raise _changed(origin, str(error)) from error
        except Exception as error:  # stores raise whatever their libraries raise
            if is_absent(error):
                raise _changed(origin, "it is gone") from error
            if isinstance(error, OSError) and error.errno in _DISK:
                raise
            if wait is None:
                raise told(origin.url, error) from error
            time.sleep(wait)
    now = Origin.of(origin.url) if origin.stated else origin
    if now != origin:
        raise _changed(origin, "it is gone" if now is None else "it is another one now")


def _counting(origin: Origin) -> Any:
    """What fsspec calls with the bytes that have come: it stops at more than were stated."""
    from fsspec.callbacks import Callback

    most = MOST_UNSTATED if origin.size is None else origin.size

    class Counting(Callback):  # type: ignore[misc]  # fsspec has no types
        def relative_update(self, inc: int = 1) -> None:
            super().relative_update(inc)
            if self.value > most:
                raise _TooLong(f"more than {most} bytes come")

    return Counting()


def _check_size(origin: Origin, target: Path) -> None:
    size = target.stat().st_size
    if origin.size is not None and size < origin.size:
        raise ConnectionError(f"{size} of {origin.size} bytes came")


def _changed(origin: Origin, what: str) -> DataError:
    return DataError(
        f"it has changed since the campaign was opened: {what}.",
        file=origin.shown,
        remedy="Start again when nothing is written there any more.",
    )


def _write_sheet(origin: Origin, part: Path) -> None:
    copy = part / origin.name
    size = copy.stat().st_size
    sheet = {"url": origin.shown, "size": size, "sha256": sha256(copy)}
    (part / SHEET).write_text(readable(sheet) + "\n", encoding="utf-8")


def _moved(part: Path, place: Path, origin: Origin) -> Path:
    """Give a finished copy its name, unless another process was sooner; older states go."""
    try:
        os.rename(part, place)
    except OSError:
        sooner = _known(place, origin, proven=True)
        if sooner is not None:
            return sooner
        shutil.rmtree(place, ignore_errors=True)
        os.rename(part, place)
    key = place.name.partition("-")[0]
    for other in place.parent.glob(f"{key}-*"):
        if other != place:
            shutil.rmtree(other, ignore_errors=True)
    return place / origin.name
