"""How far a packed file may expand."""

from __future__ import annotations

import io
import stat
import zipfile
import zlib
from collections.abc import Callable
from contextlib import contextmanager
from mmap import mmap
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import CampaignError, PmmkitError
from pmmkit.readers.base import Request

if TYPE_CHECKING:
    from collections.abc import Iterator


SMALL: Final = 200_000_000
"""Bytes that any file may expand to."""
RATIO: Final = 200
"""A file may expand to this many times its size."""
_PIECE: Final = 1 << 16


class Damaged(ValueError):
    """A file is not as its own sizes say; never leaves the reader."""


def limit_of(size: int) -> int:
    """Bytes that a file of that size may expand to.

    Examples
    --------
    >>> limit_of(1000), limit_of(10_000_000)
    (200000000, 2000000000)
    """
    return max(SMALL, RATIO * size)


def too_large(request: Request, declared: int, size: int, what: str) -> CampaignError:
    """The error of a file that would expand too far."""
    return request.error(
        f"{what} would take {declared:,} bytes, the file has {size:,}: damaged, or made to "
        f"exhaust the memory. At most {limit_of(size):,} are read.",
        remedy="If it is right, save it unpacked or as text.",
    )


def inflated_size(packed: bytes | memoryview, most: int, *, raw: bool = False) -> int:
    """Bytes that a deflated stream expands to, counted without keeping them.

    Examples
    --------
    >>> inflated_size(zlib.compress(bytes(1000)), 10_000)
    1000
    """
    stream = zlib.decompressobj(-15 if raw else 15)
    view = memoryview(packed)
    count = 0
    for place in range(0, len(view), _PIECE):
        rest: bytes | memoryview = view[place : place + _PIECE]
        while rest and not stream.eof and count <= most:
            count += len(stream.decompress(rest, _PIECE))
            rest = stream.unconsumed_tail
    while not stream.eof and count <= most and (more := stream.decompress(b"", _PIECE)):
        count += len(more)
    return count


# Zip archives of unknown origin: what they hold, never unpacked beyond what they say.
#
# Nothing is written under a name out of an archive, so that no name leads out of a folder.


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
