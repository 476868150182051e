"""Classic NetCDF files taken apart, each size checked against what is there.

Layout after Unidata, "The NetCDF Classic Format Specification" (2023): versions 1, 2 and 5.
"""

from __future__ import annotations

import itertools
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.readers.bounds import Damaged

_TYPES: Final = {
    1: "i1",
    2: "S1",
    3: ">i2",
    4: ">i4",
    5: ">f4",
    6: ">f8",
    7: "u1",
    8: ">u2",
    9: ">u4",
    10: ">i8",
    11: ">u8",
}
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_LARGE: Final = 1 << 31
"""From this size on the header need not state the true one."""
_STREAMING: Final = (0xFFFFFFFF, 0xFFFFFFFFFFFFFFFF)


Variable = tuple[str, NDArray[Any], Mapping[str, str | NDArray[Any]]]
"""Name, values (a view of the bytes of the file), and attributes: texts, and arrays of numbers."""


def is_netcdf3(head: bytes) -> bool:
    """Whether a file begins as classic NetCDF."""
    return head[:3] == b"CDF" and head[3:4] in (b"\x01", b"\x02", b"\x05")


def netcdf3_variables(data: bytes) -> list[Variable]:
    """The variables of a file."""
    if not is_netcdf3(data):
        raise Damaged("the mark of NetCDF is missing")
    return _Header(data, wide=data[3] == 5, far=data[3] != 1).variables()


@dataclass(frozen=True, kw_only=True)
class _Entry:
    """A variable as the header states it."""

    name: str
    shape: tuple[int, ...]
    record: bool
    dtype: np.dtype[Any]
    begin: int
    attributes: Mapping[str, str | NDArray[Any]]

    @property
    def size(self) -> int:
        """Bytes, of one record for a variable that has records."""
        return math.prod(self.shape[self.record :]) * self.dtype.itemsize

    @property
    def padded(self) -> int:
        """The same, up to the next multiple of four."""
        return self.size + -self.size % 4


@dataclass
class _Header:
    """Goes through the header from front to back."""

    data: bytes
    wide: bool
    far: bool
    place: int = field(default=4, init=False)

    def variables(self) -> list[Variable]:
        """All variables."""
        records = self._count()
        sides = [(self._name(), self._count()) for _ in range(self._list(_DIMENSIONS))]
        self._attributes()
        entries = [
            self._entry([side for _, side in sides], records) for _ in range(self._list(_VARIABLES))
        ]
        repeated = [entry for entry in entries if entry.record]
        step = sum(entry.padded for entry in repeated)
        if len(repeated) == 1:
            step = repeated[0].size
        if repeated and step:
            room = len(self.data) - min(entry.begin for entry in repeated)
            if records in _STREAMING:
                records = room // step
                repeated = [
                    _Entry(**{**vars(entry), "shape": (records, *entry.shape[1:])})
                    for entry in repeated
                ]
            elif room >= (records + 1) * step:
                raise Damaged(f"{records} records are declared, {room // step} are there")
        self._check_order(entries)
        fixed = [entry for entry in entries if not entry.record]
        return [self._values(entry, step, records) for entry in (*fixed, *repeated)]

    @staticmethod
    def _check_order(entries: list[_Entry]) -> None:
        """Refuse variables that lie over one another."""
        ordered = sorted(entries, key=lambda entry: entry.begin)
        for entry, following in itertools.pairwise(ordered):
            if entry.begin + entry.size > following.begin:
                raise Damaged(f"{entry.name!r} and {following.name!r} lie over one another")

    def _entry(self, sides: list[int], records: int) -> _Entry:
        name = self._name()
        places = [self._count() for _ in range(self._bounded(self._count()))]
        if any(place >= len(sides) for place in places):
            raise Damaged(f"{name!r} has an unknown dimension")
        attributes = self._attributes()
        dtype = self._type()
        stated = self._count()
        begin = self._number(8 if self.far else 4)
        record = bool(places) and sides[places[0]] == 0
        shape = tuple(sides[place] for place in places)
        if record:
            shape = (0 if records in _STREAMING else records, *shape[1:])
        entry = _Entry(
            name=name, shape=shape, record=record, dtype=dtype, begin=begin, attributes=attributes
        )
        if begin % 4 or (stated not in (entry.size, entry.padded) and entry.size < _LARGE):
            raise Damaged(f"{name!r} should take {entry.size} bytes, {stated} are stated")
        return entry

    def _values(self, entry: _Entry, step: int, records: int) -> Variable:
        last = step * max(0, records - 1) if entry.record else 0
        if entry.begin < self.place or entry.begin + last + entry.size > len(self.data):
            raise Damaged(f"{entry.name!r} ends behind the end of the file")
        if not entry.record or not records:
            count = math.prod(entry.shape)
            values = np.frombuffer(self.data, entry.dtype, count, entry.begin)
            values = values.reshape(entry.shape)
        else:
            inner = entry.shape[1:]
            strides = [
                entry.dtype.itemsize * math.prod(inner[at + 1 :]) for at in range(len(inner))
            ]
            values = np.ndarray(entry.shape, entry.dtype, self.data, entry.begin, (step, *strides))
        return entry.name, values, entry.attributes

    def _attributes(self) -> dict[str, str | NDArray[Any]]:
        found: dict[str, str | NDArray[Any]] = {}
        for _ in range(self._list(_ATTRIBUTES)):
            name, dtype, count = self._name(), self._type(), self._count()
            raw = self._bytes(count * dtype.itemsize)
            text = dtype.kind == "S"
            found[name] = raw.decode("utf-8", "replace") if text else np.frombuffer(raw, dtype)
        return found

    def _list(self, expected: int) -> int:
        mark, count = self._number(4), self._count()
        if mark != expected and (mark or count):
            raise Damaged(f"a list of kind {mark} stands where one of kind {expected} should")
        return self._bounded(count)

    def _bounded(self, count: int) -> int:
        if count > len(self.data):
            raise Damaged(f"{count} entries are declared")
        return count

    def _name(self) -> str:
        return self._bytes(self._count()).decode("utf-8", "replace")

    def _type(self) -> np.dtype[Any]:
        code = self._number(4)
        if code not in _TYPES:
            raise Damaged(f"there is no type {code}")
        return np.dtype(_TYPES[code])

    def _count(self) -> int:
        return self._number(8 if self.wide else 4)

    def _number(self, size: int) -> int:
        raw = self._bytes(size)
        return int(struct.unpack(">Q" if size == 8 else ">I", raw)[0])

    def _bytes(self, count: int) -> bytes:
        end = self.place + count
        if end > len(self.data):
            raise Damaged("the header ends behind the end of the file")
        found = self.data[self.place : end]
        self.place = end + -count % 4
        return found
