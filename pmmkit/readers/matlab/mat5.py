"""MATLAB files of versions 4, 5 and 7 taken apart, each size checked against what is there.

Layout after The MathWorks, "MAT-File Format" (2023). The bytes are only ever looked at as numbers
and texts: functions, objects and other things that MATLAB could run are passed over.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array
from pmmkit.readers.base import Request
from pmmkit.readers.bounds import Damaged, limit_of, too_large
from pmmkit.readers.hdf5.datasets import members, new_to, numbers, text_of

# MATLAB files of version 7.3: HDF5 as MATLAB lays it out.
#
# Arrays stand transposed, their class in the attribute ``MATLAB_class``; structs are groups, texts
# are numbers of their letters, cells are references to objects in the group ``#refs#``. An array
# of structs is a group whose datasets are references.


# A variable of a MATLAB file, of whatever version.


@dataclass(frozen=True, kw_only=True)
class MatlabVariable:
    """A variable, or a field of a struct.

    `name`: its name, fields behind dots. `read`: gives real numbers in rows and columns.
    `texts`: the texts of a cell array of texts. `other`: what it is, if neither numbers nor
    texts. `opaque`: whether it is of a class that MATLAB keeps in a form of its own (tables,
    times).
    """

    name: str
    shape: tuple[int, int]
    read: Callable[[], Array] = lambda: np.empty((0, 0))
    texts: tuple[str, ...] | None = None
    other: str | None = None
    opaque: bool = False

    @classmethod
    def of(cls, name: str, values: NDArray[Any]) -> MatlabVariable:
        """A matrix of numbers in the bytes of the file."""
        rows, columns = values.shape
        return cls(
            name=name, shape=(rows, columns), read=lambda: np.asarray(values, dtype=np.float64)
        )


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
        texts = [_referenced_text(target, request) for target in targets]
        plain = tuple(text for text in texts if text is not None)
        if len(plain) == count:
            yield MatlabVariable(name=name, shape=(count, 1), texts=plain)
        else:
            yield MatlabVariable(name=name, shape=(1, count), other="a cell array")
        return
    owner, _, field = name.rpartition(".")
    for place, target in enumerate(targets, start=1):
        yield from _variables(target, f"{owner}({place}).{field}", request, seen)


def _referenced_text(item: Any, request: Request) -> str | None:
    if text_of(item.attrs, "MATLAB_class") != "char" or item.dtype.kind != "u":
        return None
    letters = numbers(item, request).reshape(-1)
    return letters.astype("<u2").tobytes().decode("utf-16-le", "replace").rstrip("\0 ")


Raw = NDArray[Any]

_NUMBERS: Final = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
_ENCODINGS: Final = {
    1: "latin-1",
    2: "latin-1",
    4: "utf-16",
    16: "utf-8",
    17: "utf-16",
    18: "utf-32",
}
_MATRIX: Final = 14
_COMPRESSED: Final = 15
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE, _FUNCTION, _OPAQUE = 1, 2, 3, 4, 5, 16, 17
_NUMERIC_CLASSES: Final = range(6, 16)
_BYTES: Final = 9
"""Class of the nameless variable in which MATLAB keeps what its objects share."""
_OF_ONE_CLASS: Final = {7: (7,), 9: (6,), 12: (14, 15), 13: (14, 15)}
"""Types of numbers that stand in variables of some classes only; small integers in all."""
_DEEPEST: Final = 32
_V4_NUMBERS: Final = ("f8", "f4", "i4", "i2", "u2", "u1")
_V4_HEADER: Final = 20
_V5_HEADER: Final = 128


@dataclass(frozen=True)
class _Element:
    """A piece of a file: its type, and its bytes."""

    type: int
    data: memoryview


def read_v5(data: bytes, request: Request) -> list[MatlabVariable]:
    """Variables of a file of version 5 or 7, structs taken apart."""
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None:
        raise Damaged("the mark of the byte order is missing")
    elements = list(_elements(memoryview(data)[128:], order, packed=True))
    packed = [element for element in elements if element.type == _COMPRESSED]
    expanded = sum(_declared(element.data, order) for element in packed)
    if expanded > limit_of(len(data)):
        raise too_large(request, expanded, len(data), "what is packed inside")
    found: list[MatlabVariable] = []
    for element in elements:
        plain = _unpacked(element.data, order) if element.type == _COMPRESSED else element
        if plain.type != _MATRIX:
            raise Damaged(f"an element of type {plain.type} stands where a variable should")
        found += _Matrix(order).variables(plain.data)
    return found


def is_v5(head: bytes) -> bool:
    """Whether a file begins with the header of version 5 or 7."""
    return len(head) >= _V5_HEADER and head[124:128] in (b"\x00\x01IM", b"\x01\x00MI")


def is_v4(head: bytes) -> bool:
    """Whether a file begins with the header of a variable of version 4."""
    try:
        order, _, text, _, _, _, size = _v4_header(head, 0)
    except Damaged:
        return False
    name = head[_V4_HEADER : _V4_HEADER + size]
    return (
        bool(order)
        and text < 3
        and name[-1:] == b"\0"
        and name[:-1].isascii()
        and (name[:-1].decode("ascii").isidentifier())
    )


def read_v4(data: bytes) -> list[MatlabVariable]:
    """Variables of a file of version 4."""
    found: list[MatlabVariable] = []
    place = 0
    while place < len(data):
        order, kind, text, rows, columns, complex_, size = _v4_header(data, place)
        start = place + _V4_HEADER + size
        name = data[place + _V4_HEADER : start].rstrip(b"\0").decode("latin-1")
        step = np.dtype(order + _V4_NUMBERS[kind]).itemsize
        place = start + rows * columns * step * (2 if complex_ else 1)
        if place > len(data):
            raise Damaged(f"{name!r} ends {place - len(data)} bytes behind the end of the file")
        if text or complex_:
            other = ("complex numbers", "a text", "a sparse matrix")[text]
            found.append(MatlabVariable(name=name, shape=(rows, columns), other=other))
            continue
        flat = np.frombuffer(data, order + _V4_NUMBERS[kind], rows * columns, start)
        found.append(MatlabVariable.of(name, flat.reshape((rows, columns), order="F")))
    return found


def _v4_header(data: bytes, place: int) -> tuple[str, int, int, int, int, int, int]:
    if len(data) - place < _V4_HEADER:
        raise Damaged(f"{len(data) - place} bytes are left over at the end")
    for order in "<>":
        mopt, rows, columns, complex_, size = struct.unpack_from(f"{order}5i", data, place)
        machine, kind, text = mopt // 1000, mopt // 10 % 100, mopt % 10
        if (
            machine == (order == ">")
            and kind < len(_V4_NUMBERS)
            and text < 3
            and rows >= 0
            and columns >= 0
            and complex_ in (0, 1)
            and 1 < size <= 256
        ):
            return order, kind, text, rows, columns, complex_, size
    raise Damaged(f"there is no header of a variable at byte {place}")


def _elements(data: memoryview, order: str, *, packed: bool = False) -> Iterator[_Element]:
    """The elements that stand one after the other in some bytes."""
    place = 0
    while place < len(data):
        if len(data) - place < 8:
            raise Damaged(f"{len(data) - place} bytes are left over at the end")
        kind, size = struct.unpack_from(f"{order}2I", data, place)
        start = place + 8
        if kind >> 16:
            kind, size, start = kind & 0xFFFF, kind >> 16, place + 4
            if size > 4:
                raise Damaged("a short element is too long")
            place += 8
        elif packed and kind == _COMPRESSED:
            place = start + size
        else:
            place = start + size + -size % 8
        if start + size > len(data):
            raise Damaged(f"an element ends {start + size - len(data)} bytes behind the end")
        yield _Element(kind, data[start : start + size])


def _declared(packed: memoryview, order: str) -> int:
    """Bytes that a packed element says it expands to."""
    tag = zlib.decompressobj().decompress(packed, 8)
    if len(tag) < 8:
        raise Damaged("a packed element has no header")
    return int(struct.unpack(f"{order}2I", tag)[1]) + 8


def _unpacked(packed: memoryview, order: str) -> _Element:
    stream = zlib.decompressobj()
    size = _declared(packed, order)
    plain = stream.decompress(packed, size)
    if len(plain) < size or stream.decompress(stream.unconsumed_tail, 1) or not stream.eof:
        raise Damaged("a packed element is not as long as it says")
    return _Element(struct.unpack_from(f"{order}I", plain)[0], memoryview(plain)[8:])


@dataclass(frozen=True)
class _Matrix:
    """Takes variables apart that are written in one byte order."""

    order: str

    def variables(
        self, data: memoryview, name: str | None = None, depth: int = 0
    ) -> list[MatlabVariable]:
        """A variable, or those inside a struct, with dots between their names."""
        parts = list(_elements(data, self.order))
        if len(parts) < 3 or depth > _DEEPEST:
            raise Damaged("a variable lacks its header" if parts else "a variable is empty")
        flags = self._numbers(parts[0])
        if len(flags) < 1 or parts[0].type != 6:
            raise Damaged("a variable lacks its flags")
        kind, complex_ = int(flags[0]) & 0xFF, bool(int(flags[0]) & 0x800)
        if kind == _OPAQUE:
            return [self._opaque(parts, name)]
        shape = self._shape(parts[1])
        own = _text(parts[2]) if name is None else name
        if not own and kind == _BYTES:
            return []
        if not own:
            raise Damaged("a variable has no name")
        rest = parts[3:]
        if kind == _STRUCT:
            return self._struct(rest, shape, own, depth)
        if kind == _CELL:
            return [self._cell(rest, shape, own)]
        if kind == _CHAR:
            return [MatlabVariable(name=own, shape=_flat(shape), other="a text")]
        if kind not in _NUMERIC_CLASSES or complex_:
            return [MatlabVariable(name=own, shape=_flat(shape), other=_other(kind))]
        if rest and kind not in _OF_ONE_CLASS.get(rest[0].type, (kind,)):
            raise Damaged(f"the numbers of {own!r} are not of its class")
        return [self._array(rest, shape, own)]

    def _array(self, rest: list[_Element], shape: tuple[int, ...], name: str) -> MatlabVariable:
        if len(rest) != 1:
            raise Damaged(f"{name!r} has no numbers")
        values = self._numbers(rest[0])
        if values.size != np.prod(shape, dtype=object):
            raise Damaged(f"{name!r} should have {shape} values, {values.size} are there")
        if len(shape) != 2:
            return MatlabVariable(name=name, shape=_flat(shape), other=f"{len(shape)} dimensions")
        return MatlabVariable.of(name, values.reshape(shape, order="F"))

    def _struct(
        self, rest: list[_Element], shape: tuple[int, ...], name: str, depth: int
    ) -> list[MatlabVariable]:
        if len(rest) < 2 or not len(widths := self._numbers(rest[0])) or int(widths[0]) < 1:
            raise Damaged(f"the struct {name!r} has no list of fields")
        width = int(widths[0])
        text = bytes(rest[1].data)
        fields = [
            text[place : place + width].split(b"\0")[0].decode("utf-8", "replace")
            for place in range(0, len(text) - width + 1, width)
        ]
        count = int(np.prod(shape, dtype=object))
        if len(rest) - 2 != count * len(fields):
            raise Damaged(f"the struct {name!r} should have {count * len(fields)} fields")
        found: list[MatlabVariable] = []
        for place, element in enumerate(rest[2:]):
            owner = name if count == 1 else f"{name}({place // len(fields) + 1})"
            inner = f"{owner}.{fields[place % len(fields)]}"
            if element.type != _MATRIX:
                raise Damaged(f"{inner!r} is not a variable")
            if len(element.data):
                found += self.variables(element.data, inner, depth + 1)
        return found

    def _cell(self, rest: list[_Element], shape: tuple[int, ...], name: str) -> MatlabVariable:
        """A cell array, of which only texts are of use."""
        if len(rest) != np.prod(shape, dtype=object):
            raise Damaged(f"the cell array {name!r} should have {shape} cells")
        texts = [self._cell_text(element) for element in rest]
        plain = [text for text in texts if text is not None]
        if len(plain) == len(texts) and texts:
            return MatlabVariable(name=name, shape=_flat(shape), texts=tuple(plain))
        return MatlabVariable(name=name, shape=_flat(shape), other="a cell array")

    def _cell_text(self, element: _Element) -> str | None:
        if element.type != _MATRIX:
            raise Damaged("a cell is not a variable")
        if not len(element.data):
            return None
        parts = list(_elements(element.data, self.order))
        if len(parts) < 3 or not len(flags := self._numbers(parts[0])):
            raise Damaged("a cell lacks its header")
        if int(flags[0]) & 0xFF != _CHAR or len(parts) < 4:
            return None
        return _text(parts[3], self.order)

    def _opaque(self, parts: list[_Element], name: str | None) -> MatlabVariable:
        """A table, timetable, datetime …: MATLAB keeps these in a form of its own."""
        words = [_text(part) for part in parts[1:4]]
        own = words[0] if name is None else name
        return MatlabVariable(name=own or "?", shape=(1, 1), other=words[-1], opaque=True)

    def _shape(self, element: _Element) -> tuple[int, ...]:
        shape = tuple(int(side) for side in self._numbers(element))
        if element.type != 5 or not 2 <= len(shape) <= 32 or min(shape) < 0:
            raise Damaged("the dimensions of a variable are damaged")
        return shape

    def _numbers(self, element: _Element) -> Raw:
        if element.type not in _NUMBERS:
            raise Damaged(f"there are no numbers of type {element.type}")
        dtype = np.dtype(self.order + _NUMBERS[element.type])
        if len(element.data) % dtype.itemsize:
            raise Damaged("numbers are cut off")
        return np.frombuffer(element.data, dtype)


def _text(element: _Element, order: str = "<") -> str:
    encoding = _ENCODINGS.get(element.type)
    if encoding is None:
        raise Damaged(f"there is no text of type {element.type}")
    if encoding in ("utf-16", "utf-32"):
        encoding += "-le" if order == "<" else "-be"
    return bytes(element.data).decode(encoding, "replace").rstrip("\0 ")


def _other(kind: int) -> str:
    names = {_OBJECT: "an object", _SPARSE: "a sparse matrix", _FUNCTION: "a function"}
    if kind in _NUMERIC_CLASSES:
        return "complex numbers"
    if kind not in names:
        raise Damaged(f"a variable is of the unknown class {kind}")
    return names[kind]


def _flat(shape: tuple[int, ...]) -> tuple[int, int]:
    return shape[0], int(np.prod(shape[1:], dtype=object))
