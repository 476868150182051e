"""Opening HDF5 files so that damage ends in an error and not in a hang of the library."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

LIBRARY_FAULTS: Final = (
    OSError,
    RuntimeError,
    LookupError,
    ValueError,
    TypeError,
    AttributeError,
    ArithmeticError,
    MemoryError,
    AssertionError,
)
"""What h5py raises on files that are damaged."""

SIGNATURE: Final = b"\x89HDF\r\n\x1a\n"
_HEAP: Final = b"GCOL\x01\0\0\0"
_SAVED: Final = ("pmmkit", "index_crc32")
"""Attributes that only campaigns have that pmmkit saved."""
_OBJECT: Final = struct.Struct("<HHIQ")


def is_hdf5(head: bytes) -> bool:
    """Whether bytes begin an HDF5 file: its signature at 0, 512, 1024, 2048 …

    Examples
    --------
    >>> is_hdf5(bytes(512) + SIGNATURE), is_hdf5(b"t,X,Y,N")
    (True, False)
    """
    places = [0, *(512 << power for power in range(8))]
    return any(head.startswith(SIGNATURE, place) for place in places)


@contextmanager
def open_hdf5(path: Path) -> Iterator[Any]:
    """The file for reading; its heaps are looked at first.

    libhdf5 (seen in 2.0.0) runs for ever on a global heap, where texts of variable length lie, of
    which an object has neither an index nor a size.

    Raises
    ------
    OSError
        If a heap is damaged; and whatever h5py raises (``LIBRARY_FAULTS``).
    """
    import h5py

    with path.open("rb") as stream:
        stream.seek(0, 2)
        if stream.tell():
            with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
                check_heaps(data)
    with h5py.File(path, "r", locking="best-effort") as file:
        yield file


def check_heaps(data: bytes | mmap.mmap) -> None:
    """Walk through every global heap of a file.

    Raises
    ------
    OSError
        If the objects of one do not fill it.
    """
    place = data.find(_HEAP)
    while place >= 0:
        (size,) = struct.unpack("<Q", data[place + 8 : place + 16].ljust(8, b"\0"))
        end, at = place + size, place + 16
        while at + _OBJECT.size <= min(end, len(data)):
            index, _, _, held = _OBJECT.unpack(data[at : at + _OBJECT.size])
            step = _OBJECT.size + held + -held % 8 if index else held
            if step < _OBJECT.size or at + step > end:
                raise OSError(f"the heap at byte {place} is damaged")
            at += step
        if end > len(data) or size < _OBJECT.size:
            raise OSError(f"the heap at byte {place} ends behind the file")
        place = data.find(_HEAP, place + 8)


def is_saved_campaign(path: Path) -> bool:
    """Whether a file is a campaign that pmmkit saved; damaged files are none."""
    import h5py

    try:
        with h5py.File(path, "r", locking="best-effort") as file:
            return any(name in file.attrs for name in _SAVED)
    except LIBRARY_FAULTS:
        return False
