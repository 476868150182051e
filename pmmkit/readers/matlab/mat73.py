"""MATLAB files of version 7.3: HDF5 as MATLAB lays it out.

Arrays stand transposed, their class in the attribute ``MATLAB_class``; structs are groups, texts
are numbers of their letters, cells are references to objects in the group ``#refs#``. An array of
structs is a group whose datasets are references.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.readers.base import Request
from pmmkit.readers.hdf5.datasets import members, new_to, numbers, text_of
from pmmkit.readers.matlab.variable import MatlabVariable

_PLAIN: Final = {
    "double",
    "single",
    "logical",
    *(f"{sign}int{size}" for sign in ("", "u") for size in (8, 16, 32, 64)),
}
_MOST_CELLS: Final = 4096


def read_v73(file: Any, request: Request) -> list[MatlabVariable]:
    """Variables of an open file, structs taken apart."""
    found: list[MatlabVariable] = []
    seen: set[int] = set()
    for name, item in members(file):
        if not name.startswith("#"):
            found += _variables(item, name, request, seen)
    return found


def _variables(item: Any, name: str, request: Request, seen: set[int]) -> Iterator[MatlabVariable]:
    import h5py

    kind = text_of(item.attrs, "MATLAB_class")
    if "MATLAB_object_decode" in item.attrs:
        yield MatlabVariable(name=name, shape=(1, 1), other=kind or "an object", opaque=True)
    elif isinstance(item, h5py.Group):
        if "MATLAB_sparse" in item.attrs:
            yield MatlabVariable(name=name, shape=(1, 1), other="a sparse matrix")
        elif new_to(seen, item):
            for field, inner in members(item):
                yield from _variables(inner, f"{name}.{field}", request, seen)
    elif isinstance(item, h5py.Dataset):
        yield from _dataset(item, name, kind, request, seen)


def _dataset(
    item: Any, name: str, kind: str | None, request: Request, seen: set[int]
) -> Iterator[MatlabVariable]:
    import h5py

    shape = item.shape or ()
    size = math.prod(shape)
    if "MATLAB_empty" in item.attrs:
        yield MatlabVariable(name=name, shape=(0, 0), other="empty")
    elif h5py.check_ref_dtype(item.dtype) is h5py.Reference:
        yield from _references(item, name, kind, request, seen)
    elif kind == "char":
        yield MatlabVariable(name=name, shape=(1, 1), other="a text")
    elif len(shape) not in (1, 2) or item.dtype.kind not in "fiub" or kind not in (*_PLAIN, None):
        other = f"{len(shape)} dimensions" if len(shape) > 2 else kind or "not numbers"
        other = "complex numbers" if item.dtype.names == ("real", "imag") else other
        yield MatlabVariable(name=name, shape=(1, size), other=other)
    else:
        rows, columns = reversed(shape) if len(shape) == 2 else (size, 1)
        yield MatlabVariable(name=name, shape=(rows, columns), read=_reader(item, request))


def _reader(item: Any, request: Request) -> Callable[[], Array]:
    def read() -> Array:
        values = np.asarray(numbers(item, request), dtype=np.float64)
        return values.T if values.ndim == 2 else values.reshape(-1, 1)

    return read


def _references(
    item: Any, name: str, kind: str | None, request: Request, seen: set[int]
) -> Iterator[MatlabVariable]:
    """A cell array, or one field of an array of structs."""
    count = math.prod(item.shape or ())
    if not 0 < count <= _MOST_CELLS or not new_to(seen, item):
        yield MatlabVariable(name=name, shape=(1, count), other="a cell array")
        return
    targets = [item.file[reference] for reference in numbers(item, request).reshape(-1)]
    if kind == "cell":
        texts = [_text(target, request) for target in targets]
        plain = tuple(text for text in texts if text is not None)
        if len(plain) == count:
            yield MatlabVariable(name=name, shape=(count, 1), texts=plain)
        else:
            yield MatlabVariable(name=name, shape=(1, count), other="a cell array")
        return
    owner, _, field = name.rpartition(".")
    for place, target in enumerate(targets, start=1):
        yield from _variables(target, f"{owner}({place}).{field}", request, seen)


def _text(item: Any, request: Request) -> str | None:
    if text_of(item.attrs, "MATLAB_class") != "char" or item.dtype.kind != "u":
        return None
    letters = numbers(item, request).reshape(-1)
    return letters.astype("<u2").tobytes().decode("utf-16-le", "replace").rstrip("\0 ")
