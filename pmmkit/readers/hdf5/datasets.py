"""Datasets of an HDF5 file read with care: nothing outside the file, nothing that expands far."""

from __future__ import annotations

import itertools
import math
import mmap
import struct
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import PmmkitError
from pmmkit.readers.base import Request, first_line
from pmmkit.readers.bounds import Damaged, limit_of, too_large

if TYPE_CHECKING:
    from h5py.h5d import StoreInfo


# Chunks of an HDF5 dataset, read by the addresses that the file lists.
#
# libhdf5 looks each chunk up in a tree that has no checksum in older files; a chunk that it does
# not find it takes for one never written, and gives zeros. Here all chunks that are listed are
# read, each expanded to the size of a chunk and no further; every one must be there.


_DEFLATE, _SHUFFLE = 1, 2
_OURS: Final = ((), (_DEFLATE,), (_SHUFFLE, _DEFLATE))
"""Chains of filters that are undone here; others are left to the library."""


def chunks_of(dataset: Any) -> tuple[StoreInfo, ...]:
    """All chunks of a dataset."""
    found: list[StoreInfo] = []
    dataset.id.chunk_iter(found.append)
    sides = list(zip(dataset.shape, dataset.chunks, dataset.maxshape, strict=True))
    if any(most is not None and chunk > max(side, most) for side, chunk, most in sides):
        raise Damaged("its chunks are larger than it is")
    expected = math.prod(-(-side // chunk) for side, chunk, _ in sides)
    if len(found) != expected or {chunk.chunk_offset for chunk in found} != set(
        itertools.product(*(range(0, side, chunk) for side, chunk, _ in sides))
    ):
        raise Damaged(f"it should have {expected} chunks, {len(found)} are there")
    size = math.prod(dataset.chunks) * dataset.id.get_type().get_size()
    every = (1 << len(_filters(dataset))) - 1
    if any(chunk.filter_mask & every == every and chunk.size != size for chunk in found):
        raise Damaged(f"its chunks should have {size} bytes each")
    return tuple(found)


def read_chunks(dataset: Any, chunks: Sequence[StoreInfo], file: BinaryIO) -> NDArray[Any] | None:
    """The values of a dataset, or None where they must be left to the library."""
    filters = _filters(dataset)
    if filters not in _OURS or dataset.dtype.hasobject or not chunks:
        return None
    if _stored(chunks[0], file) != dataset.id.read_direct_chunk(chunks[0].chunk_offset)[1]:
        return None
    values = np.empty(dataset.shape, dataset.dtype)
    for chunk in chunks:
        plain = _plain(_stored(chunk, file), chunk, filters, dataset)
        block = np.frombuffer(plain, dataset.dtype).reshape(dataset.chunks)
        inside = tuple(
            slice(start, min(start + step, side))
            for start, step, side in zip(
                chunk.chunk_offset, dataset.chunks, dataset.shape, strict=True
            )
        )
        values[inside] = block[tuple(slice(0, part.stop - part.start) for part in inside)]
    return values


def deflated(dataset: Any) -> bool:
    """Whether deflate is among the filters of a dataset."""
    return _DEFLATE in _filters(dataset)


def _filters(dataset: Any) -> tuple[int, ...]:
    plist = dataset.id.get_create_plist()
    return tuple(plist.get_filter(place)[0] for place in range(plist.get_nfilters()))


def _stored(chunk: StoreInfo, file: BinaryIO) -> bytes:
    file.seek(chunk.byte_offset)
    return file.read(chunk.size)


def _plain(stored: bytes, chunk: StoreInfo, filters: tuple[int, ...], dataset: Any) -> bytes:
    """A chunk with its filters undone, the last one first."""
    size = math.prod(dataset.chunks) * dataset.dtype.itemsize
    data = stored
    for order, kind in reversed(list(enumerate(filters))):
        if chunk.filter_mask >> order & 1:
            continue
        if kind == _DEFLATE:
            stream = zlib.decompressobj()
            try:
                data = stream.decompress(data, size)
                ended = not stream.decompress(stream.unconsumed_tail, 1) and stream.eof
            except zlib.error as error:
                raise Damaged(f"a chunk is damaged ({error})") from error
            if not ended:
                raise Damaged("a chunk does not end where it should")
        elif len(data) == size:
            table = np.frombuffer(data, np.uint8).reshape(dataset.dtype.itemsize, -1)
            data = table.T.tobytes()
    if len(data) != size:
        raise Damaged(f"a chunk should have {size} bytes, {len(data)} are there")
    return data


# Opening HDF5 files so that damage ends in an error and not in a hang of the library.


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

    Parameters
    ----------
    path : Path
        The file.

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
    """Walk through every global heap of a file."""
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


_STEEPEST: Final = 1032
"""Bytes that deflate can make of one."""
_LONGEST_TEXT: Final = 1 << 16


@contextmanager
def opened(request: Request) -> Iterator[Any]:
    """The file for reading; every fault of the library becomes an error of ours."""
    try:
        with open_hdf5(request.path) as file:
            yield file
    except PmmkitError:
        raise
    except LIBRARY_FAULTS as error:
        raise request.error(
            "cannot be read as HDF5: damaged, cut short or of another format "
            f"({first_line(error)}).",
            remedy="Copy it again, or export it again from its source.",
        ) from error


def members(group: Any) -> Iterator[tuple[str, Any]]:
    """Names and objects of a group; links to elsewhere are not followed."""
    import h5py

    for name in group:
        if isinstance(group.get(name, getlink=True), h5py.HardLink):
            yield name, group[name]


def new_to(seen: set[int], item: Any) -> bool:
    """Whether an object is met for the first time; it is noted among those `seen`."""
    import h5py

    address = int(h5py.h5o.get_info(item.id).addr)
    known = address in seen
    seen.add(address)
    return not known


def lies_elsewhere(item: Any) -> bool:
    """Whether an object is a dataset whose numbers are in other files."""
    import h5py

    return isinstance(item, h5py.Dataset) and bool(item.is_virtual or item.external)


def declared_bytes(file: Any) -> int:
    """Bytes of all that a file declares.

    Parameters
    ----------
    file : h5py.File
        Opened.

    Raises
    ------
    OSError
        If a part of it lies elsewhere, or has two names, by which some programs read it twice.
    """
    import h5py

    seen: set[int] = set()

    def total(group: Any) -> int:
        own = dict(members(group))
        lost = [name for name in group if name not in own or lies_elsewhere(own[name])]
        if lost:
            raise OSError(f"{group.name.rstrip('/')}/{lost[0]} lies elsewhere")
        again = [name for name, item in own.items() if not new_to(seen, item)]
        if again:
            raise OSError(f"{group.name.rstrip('/')}/{again[0]} has another name too")
        inside = own.values()
        return sum(x.nbytes if isinstance(x, h5py.Dataset) else total(x) for x in inside)

    return total(file)


def numbers(dataset: Any, request: Request) -> NDArray[Any]:
    """All values of a dataset."""
    size = request.path.stat().st_size
    shown = f"dataset {dataset.name}"
    if lies_elsewhere(dataset):
        raise request.error(
            f"{shown} lies in another file.", remedy="Save it with its data inside."
        )
    item = dataset.id.get_type().get_size()
    declared = math.prod(dataset.shape or (0,)) * item
    chunk = math.prod(dataset.chunks or (0,)) * item
    if max(declared, chunk) > limit_of(size):
        raise too_large(request, max(declared, chunk), size, shown)
    try:
        return _values(dataset, declared, request)
    except Damaged as error:
        raise request.error(
            f"{shown}: {error}.", remedy="The file is damaged or was not completely written."
        ) from error


def _values(dataset: Any, declared: int, request: Request) -> NDArray[Any]:
    if not _usual(dataset):
        raise Damaged("its numbers are of no usual format")
    if dataset.chunks and declared:
        chunks = chunks_of(dataset)
        with request.path.open("rb") as stream:
            values = read_chunks(dataset, chunks, stream)
        if values is not None:
            return values
        limit = limit_of(request.path.stat().st_size)
        if deflated(dataset) and max(chunk.size for chunk in chunks) * _STEEPEST > limit:
            raise Damaged("its large chunks are packed in an unusual way")
    elif declared and not dataset.dtype.hasobject:
        stored = dataset.id.get_storage_size()
        if stored != declared:
            raise Damaged(f"it should have {declared} bytes, {stored} are there")
    return np.asarray(dataset[()])


def _usual(dataset: Any) -> bool:
    """Whether numbers are stored as the machine has them, and not in a format of their own."""
    import h5py

    dtype, stored = dataset.dtype, dataset.id.get_type()
    if dtype.names:
        return all(
            dtype[name].kind not in "fiu"
            or dtype[name].shape
            or h5py.h5t.py_create(dtype[name]) == stored.get_member_type(place)
            for place, name in enumerate(dtype.names)
        )
    return dtype.kind not in "fiu" or dtype.shape or h5py.h5t.py_create(dtype) == stored


def text_of(attributes: Any, name: str) -> str | None:
    """A short attribute of text, None if there is none."""
    if name not in attributes:
        return None
    held = attributes.get_id(name)
    if math.prod(held.shape) != 1 or held.dtype.itemsize > _LONGEST_TEXT:
        return None
    value = np.asarray(attributes[name]).reshape(-1)[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace").strip("\0 ")
    return value.strip() if isinstance(value, str) else None


def number_of(attributes: Any, name: str) -> float | None:
    """An attribute of one number, None if there is none."""
    if name not in attributes:
        return None
    held = attributes.get_id(name)
    if math.prod(held.shape) != 1 or held.dtype.kind not in "fiu":
        return None
    return float(np.asarray(attributes[name]).reshape(-1)[0])
