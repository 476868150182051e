"""Datasets of an HDF5 file read with care: nothing outside the file, nothing that expands far."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.errors import PmmkitError
from pmmkit.readers.base import Request
from pmmkit.readers.bounds import limit_of, too_large
from pmmkit.readers.hdf5.chunks import Incomplete, chunks_of, deflated, read_chunks
from pmmkit.readers.hdf5.guard import LIBRARY_FAULTS, open_hdf5

_STEEPEST: Final = 1032
"""Bytes that deflate can make of one."""
_LONGEST_TEXT: Final = 1 << 16


@contextmanager
def opened(request: Request) -> Iterator[Any]:
    """The file for reading; every fault of the library becomes an error of ours.

    Raises
    ------
    CampaignError
        If the file cannot be read.
    """
    try:
        with open_hdf5(request.path) as file:
            yield file
    except PmmkitError:
        raise
    except LIBRARY_FAULTS as error:
        detail = (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
        raise request.error(
            request.problem(
                f"cannot be read as HDF5: damaged, cut short or of another format ({detail}).",
                remedy="Copy it again, or export it again from its source.",
            )
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
    """All values of a dataset.

    Raises
    ------
    CampaignError
        If they would take far more memory than the file, lie in another file or are not all there.
    """
    size = request.path.stat().st_size
    shown = f"dataset {dataset.name}"
    if lies_elsewhere(dataset):
        raise request.error(
            request.problem(
                f"{shown} lies in another file.", remedy="Save it with its data inside."
            )
        )
    item = dataset.id.get_type().get_size()
    declared = math.prod(dataset.shape or (0,)) * item
    chunk = math.prod(dataset.chunks or (0,)) * item
    if max(declared, chunk) > limit_of(size):
        raise too_large(request, max(declared, chunk), size, shown)
    try:
        return _values(dataset, declared, request)
    except Incomplete as error:
        raise request.error(
            request.problem(
                f"{shown}: {error}.", remedy="The file is damaged or was not completely written."
            )
        ) from error


def _values(dataset: Any, declared: int, request: Request) -> NDArray[Any]:
    if not _usual(dataset):
        raise Incomplete("its numbers are of no usual format")
    if dataset.chunks and declared:
        chunks = chunks_of(dataset)
        with request.path.open("rb") as stream:
            values = read_chunks(dataset, chunks, stream)
        if values is not None:
            return values
        limit = limit_of(request.path.stat().st_size)
        if deflated(dataset) and max(chunk.size for chunk in chunks) * _STEEPEST > limit:
            raise Incomplete("its large chunks are packed in an unusual way")
    elif declared and not dataset.dtype.hasobject:
        stored = dataset.id.get_storage_size()
        if stored != declared:
            raise Incomplete(f"it should have {declared} bytes, {stored} are there")
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
