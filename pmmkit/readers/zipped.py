"""Zip archives of unknown origin: what they hold, never unpacked beyond what they say.

Nothing is written under a name out of an archive, so that no name leads out of a folder.
"""

from __future__ import annotations

import io
import stat
import zipfile
import zlib
from collections.abc import Callable
from contextlib import contextmanager
from mmap import mmap
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import PmmkitError
from pmmkit.readers.bounds import Damaged, inflated_size

if TYPE_CHECKING:
    from collections.abc import Iterator

ZIP: Final = b"PK\x03\x04"
"""How an archive begins."""
MOST_MEMBERS: Final = 10_000
Packed = bytes | mmap
"""An archive in memory, or on the disk as if it were."""
_LOCAL_HEADER: Final = 30
_FAULTS: Final = (zipfile.BadZipFile, zlib.error, ValueError, NotImplementedError, EOFError)


@contextmanager
def damage_told(error: Callable[[str], Exception]) -> Iterator[None]:
    """What is wrong with an archive becomes an error of the caller's."""
    try:
        yield
    except PmmkitError:
        raise
    except _FAULTS as fault:
        raise error(str(fault)) from fault


def members_of(data: Packed) -> list[zipfile.ZipInfo]:
    """The entries of an archive, none of which is a link or encrypted."""
    stream: Any = io.BytesIO(data) if isinstance(data, bytes) else data
    with zipfile.ZipFile(stream) as archive:
        members = archive.infolist()
    if len(members) > MOST_MEMBERS or len({item.filename for item in members}) != len(members):
        raise Damaged("it has too many parts, or two of one name")
    for item in members:
        if stat.S_ISLNK(item.external_attr >> 16) or item.flag_bits & 1:
            raise Damaged(f"{item.filename} is a link or encrypted")
    return members


def check_length(data: Packed, item: zipfile.ZipInfo) -> None:
    """Refuse an entry that is not as long as it says, counted without keeping it."""
    packed = _packed(data, item)
    if item.compress_type == zipfile.ZIP_STORED:
        count = len(packed)
    elif item.compress_type == zipfile.ZIP_DEFLATED:
        count = inflated_size(packed, item.file_size, raw=True)
    else:
        raise Damaged(f"{item.filename} is packed in an unusual way")
    if count != item.file_size:
        raise Damaged(f"{item.filename} is not as long as it says")


def content_of(data: Packed, item: zipfile.ZipInfo) -> bytes:
    """The bytes of an entry whose length was checked."""
    packed = _packed(data, item)
    stored = item.compress_type == zipfile.ZIP_STORED
    return bytes(packed) if stored else zlib.decompress(packed, -15)


def _packed(data: Packed, item: zipfile.ZipInfo) -> memoryview:
    """The bytes of an entry as they stand in the archive."""
    start = item.header_offset
    header = data[start : start + _LOCAL_HEADER]
    if len(header) < _LOCAL_HEADER or not header.startswith(ZIP):
        raise zipfile.BadZipFile(f"{item.filename} has no header")
    start += _LOCAL_HEADER + int.from_bytes(header[26:28], "little")
    start += int.from_bytes(header[28:30], "little")
    if start + item.compress_size > len(data):
        raise zipfile.BadZipFile(f"{item.filename} is cut off")
    return memoryview(data)[start : start + item.compress_size]
