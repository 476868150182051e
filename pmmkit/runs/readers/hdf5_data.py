"""Datasets of an HDF5 file read with care: nothing outside the file, nothing that expands far."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.errors import PmmkitError
from pmmkit.runs.hdf5_guard import LIBRARY_FAULTS, open_hdf5
from pmmkit.runs.readers.base import Request
from pmmkit.runs.readers.bounds import inflated_size, limit_of, too_large

_DEFLATE: Final = 1
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
    except (*LIBRARY_FAULTS, zlib.error) as error:
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


def numbers(dataset: Any, request: Request) -> NDArray[Any]:
    """All values of a dataset.

    Raises
    ------
    CampaignError
        If they would take far more memory than the file, or lie in another file.
    """
    check_size(dataset, request)
    return np.asarray(dataset[()])


def check_size(dataset: Any, request: Request) -> None:
    """Refuse a dataset that would expand far, lies in another file or is not all there."""
    size = request.path.stat().st_size
    shown = f"dataset {dataset.name}"
    if dataset.is_virtual or dataset.external:
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
    wrong = None if not declared else _chunk_fault(dataset) if chunk else _fault(dataset, declared)
    if wrong is None and not _usual(dataset):
        wrong = "its numbers are of no usual format"
    if wrong is not None:
        raise request.error(
            request.problem(
                f"{shown}: {wrong}.", remedy="The file is damaged or was not completely written."
            )
        )
    if chunk and _deflated(dataset):
        _check_deflated(dataset, chunk, size, request)


def _fault(dataset: Any, declared: int) -> str | None:
    if dataset.dtype.kind == "O":
        return None
    stored = dataset.id.get_storage_size()
    return None if stored == declared else f"it should have {declared} bytes, {stored} are there"


def _chunk_fault(dataset: Any) -> str | None:
    """What is wrong with how a dataset is cut into chunks, or None."""
    sides = list(zip(dataset.shape, dataset.chunks, dataset.maxshape, strict=True))
    if any(most is not None and chunk > max(side, most) for side, chunk, most in sides):
        return "its chunks are larger than it is"
    expected = math.prod(-(-side // chunk) for side, chunk, _ in sides)
    places = {place for place, _ in _chunks(dataset)}
    if len(places) != expected:
        return f"it should have {expected} chunks, {len(places)} are there"
    return None


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


def _check_deflated(dataset: Any, chunk: int, size: int, request: Request) -> None:
    """Refuse chunks that expand to more than a chunk holds, before the library expands them."""
    shown = f"a chunk of dataset {dataset.name}"
    for place, packed in _chunks(dataset):
        if packed > chunk + chunk // 100 + 1024:
            raise too_large(request, packed, size, shown)
        if packed * _STEEPEST > limit_of(size):
            unfiltered, data = dataset.id.read_direct_chunk(place)
            count = 0 if unfiltered else inflated_size(data, limit_of(size))
            if count > limit_of(size):
                raise too_large(request, count, size, shown)


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


def _deflated(dataset: Any) -> bool:
    plist = dataset.id.get_create_plist()
    return any(plist.get_filter(place)[0] == _DEFLATE for place in range(plist.get_nfilters()))


def _chunks(dataset: Any) -> Sequence[tuple[tuple[int, ...], int]]:
    """Where each chunk begins, and the bytes that it takes."""
    found: list[tuple[tuple[int, ...], int]] = []
    dataset.id.chunk_iter(lambda info: found.append((info.chunk_offset, info.size)))
    return found
