"""Chunks of an HDF5 dataset, read by the addresses that the file lists.

libhdf5 looks each chunk up in a tree that has no checksum in older files; a chunk that it does not
find it takes for one never written, and gives zeros. Here all chunks that are listed are read, each
expanded to the size of a chunk and no further; every one must be there.
"""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from h5py.h5d import StoreInfo

_DEFLATE, _SHUFFLE = 1, 2
_OURS: Final = ((), (_DEFLATE,), (_SHUFFLE, _DEFLATE))
"""Chains of filters that are undone here; others are left to the library."""


class Incomplete(ValueError):
    """Chunks are missing or damaged; never leaves the reader."""


def chunks_of(dataset: Any) -> tuple[StoreInfo, ...]:
    """All chunks of a dataset."""
    found: list[StoreInfo] = []
    dataset.id.chunk_iter(found.append)
    sides = list(zip(dataset.shape, dataset.chunks, dataset.maxshape, strict=True))
    if any(most is not None and chunk > max(side, most) for side, chunk, most in sides):
        raise Incomplete("its chunks are larger than it is")
    expected = math.prod(-(-side // chunk) for side, chunk, _ in sides)
    if len(found) != expected or {chunk.chunk_offset for chunk in found} != set(
        itertools.product(*(range(0, side, chunk) for side, chunk, _ in sides))
    ):
        raise Incomplete(f"it should have {expected} chunks, {len(found)} are there")
    size = math.prod(dataset.chunks) * dataset.id.get_type().get_size()
    every = (1 << len(_filters(dataset))) - 1
    if any(chunk.filter_mask & every == every and chunk.size != size for chunk in found):
        raise Incomplete(f"its chunks should have {size} bytes each")
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
                raise Incomplete(f"a chunk is damaged ({error})") from error
            if not ended:
                raise Incomplete("a chunk does not end where it should")
        elif len(data) == size:
            table = np.frombuffer(data, np.uint8).reshape(dataset.dtype.itemsize, -1)
            data = table.T.tobytes()
    if len(data) != size:
        raise Incomplete(f"a chunk should have {size} bytes, {len(data)} are there")
    return data
