"""HDF5 and NetCDF files of any origin (.h5, .hdf5, .nc).

Datasets of one dimension are columns, those of two several columns, named fields of records columns
each. Attributes count as in the CF conventions (Eaton et al., 2024): ``units``, ``_FillValue``,
``missing_value``, ``scale_factor``, ``add_offset``.
"""

from __future__ import annotations

import functools
import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array
from pmmkit.readers.base import HEAD, Request
from pmmkit.readers.bounds import Damaged
from pmmkit.readers.hdf5.datasets import members, new_to, number_of, numbers, opened, text_of
from pmmkit.readers.hdf5.netcdf3 import is_netcdf3, netcdf3_variables
from pmmkit.readers.vectors import WIDEST, Vector, matrix_columns, with_unit

_MOST_TEXTS: Final = 10_000
_NOT_A_VARIABLE: Final = "This is a netCDF dimension but not a netCDF variable"
_SINCE: Final = re.compile(r"\s*(\w+)\s+since\s+\S.*")
_TIME_UNITS: Final = {
    "seconds": "s",
    "second": "s",
    "sec": "s",
    "milliseconds": "ms",
    "minutes": "min",
    "hours": "h",
}


@dataclass(frozen=True, kw_only=True)
class _Found:
    """A dataset, or a field of one: where it stands, its shape, and how its numbers are meant.

    `other` tells what it is where it is not numbers; `texts` are those of a dataset of texts.
    """

    path: str
    shape: tuple[int, ...] = ()
    read: Callable[[], Array] = lambda: np.empty(0)
    unit: str | None = None
    factor: float = 1.0
    offset: float = 0.0
    missing: tuple[float, ...] = ()
    other: str | None = None
    texts: Callable[[], tuple[str, ...]] | None = None

    def values(self) -> Array:
        """The values, NaN where there is none."""
        stored = np.array(self.read(), dtype=np.float64)
        lacking = np.isin(stored, np.array(self.missing))
        values = stored * self.factor + self.offset if self.packed else stored
        values[lacking] = np.nan
        return values

    @property
    def packed(self) -> bool:
        """Whether numbers are not the values themselves."""
        return self.factor != 1.0 or self.offset != 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """What is done to the numbers, in words."""
        told = f"{self.path}: number * {self.factor:g} + {self.offset:g}, as the file states"
        return (told,) if self.packed else ()

    @property
    def is_column(self) -> bool:
        """Whether it can be one or several columns."""
        if self.other is not None or len(self.shape) not in (1, 2) or math.prod(self.shape) < 2:
            return False
        return len(self.shape) == 1 or min(self.shape) <= WIDEST


@contextmanager
def contents(request: Request) -> Iterator[tuple[list[Vector], list[str]]]:
    """What the file offers as columns, and what else it holds; open as long as it is used."""
    head = request.read(HEAD)
    if not head:
        raise request.error("the file is empty (0 bytes).")
    if is_netcdf3(head):
        yield _sorted_out(_classic(request))
        return
    with opened(request) as file:
        yield _sorted_out(list(_datasets(_group(file, request), "", request, set())))


_UNITS: Final = ("units", "unit", "Units", "Unit", "UNIT")
"""Attributes that hold the unit of a dataset."""


def remarks(request: Request) -> tuple[str, ...]:
    """The attributes of the file or of the group: numbers and short texts."""
    if is_netcdf3(request.read(HEAD)):
        return ()
    with opened(request) as file:
        held = _group(file, request).attrs
        said = {name: number_of(held, name) for name in held}
        told = {
            name: text_of(held, name) if number is None else f"{number:g}"
            for name, number in said.items()
        }
    return tuple(f"{name}: {value}" for name, value in told.items() if value)


def _sorted_out(found: Sequence[_Found]) -> tuple[list[Vector], list[str]]:
    usable = [item for item in found if item.is_column]
    bare = Counter(item.path.rpartition("/")[2] for item in usable)
    lengths = frozenset(
        item.shape[0] for item in usable if len(item.shape) == 1 and item.texts is None
    )
    offered: list[Vector] = []
    for item in usable:
        last = item.path.rpartition("/")[2]
        offered += _vectors(item, last if bare[last] == 1 else item.path, lengths)
    return offered, [_described(item) for item in found if not item.is_column]


def _vectors(item: _Found, name: str, lengths: frozenset[int]) -> list[Vector]:
    if len(item.shape) == 2:
        rows, columns = item.shape
        return matrix_columns(name, (rows, columns), item.values, lengths=lengths, unit=item.unit)
    return [
        Vector(
            name=with_unit(name, item.unit),
            length=item.shape[0],
            read=item.values,
            texts=item.texts,
            notes=item.notes,
        )
    ]


def _described(item: _Found) -> str:
    size = " by ".join(map(str, item.shape))
    return f"{item.path} ({item.other or size or 'a single number'})"


def _group(file: Any, request: Request) -> Any:
    """The group that is asked for, or the root."""
    import h5py

    wanted = request.options.group
    if wanted is None:
        return file
    group = file
    for part in wanted.strip("/").split("/"):
        inside = {name: item for name, item in members(group) if isinstance(item, h5py.Group)}
        if part not in inside:
            raise request.absent("group", part, [*inside])
        group = inside[part]
    return group


def _datasets(group: Any, path: str, request: Request, seen: set[int]) -> Iterator[_Found]:
    """The datasets of a group and of the groups inside it."""
    import h5py

    for name, item in members(group):
        inner = f"{path}{name}"
        if isinstance(item, h5py.Group):
            if new_to(seen, item):
                yield from _datasets(item, f"{inner}/", request, seen)
        elif isinstance(item, h5py.Dataset):
            yield from _dataset(item, inner, request)


def _dataset(item: Any, path: str, request: Request) -> Iterator[_Found]:
    import h5py

    shape = tuple(item.shape or ())
    dtype = item.dtype
    if (text_of(item.attrs, "NAME") or "").startswith(_NOT_A_VARIABLE):
        return
    if dtype.names and len(shape) == 1:
        whole = functools.cache(functools.partial(numbers, item, request))
        for name in dtype.names:
            if dtype[name].kind in "fiub":
                yield _Found(
                    path=f"{path}/{name}",
                    shape=(*shape, *dtype[name].shape),
                    read=_field(whole, name),
                )
            else:
                yield _Found(path=f"{path}/{name}", shape=shape, other="not numbers")
    elif dtype.kind in "fiub":
        missing = [number_of(item.attrs, name) for name in ("_FillValue", "missing_value")]
        factor, offset = (number_of(item.attrs, name) for name in ("scale_factor", "add_offset"))
        yield _Found(
            path=path,
            shape=shape,
            read=functools.partial(numbers, item, request),
            unit=_unit(next(filter(None, (text_of(item.attrs, x) for x in _UNITS)), None)),
            factor=1.0 if factor is None else factor,
            offset=offset or 0.0,
            missing=tuple(number for number in missing if number is not None),
        )
    elif h5py.check_string_dtype(dtype) and len(shape) == 1 and 1 < shape[0] <= _MOST_TEXTS:
        texts = functools.partial(_letters, item, request)
        yield _Found(path=path, shape=shape, texts=texts)
    else:
        yield _Found(path=path, shape=shape, other="not numbers")


def _letters(item: Any, request: Request) -> tuple[str, ...]:
    return tuple(
        text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
        for text in numbers(item, request)
    )


def _field(whole: Callable[[], Any], name: str) -> Callable[[], Array]:
    return lambda: np.asarray(whole()[name])


def _classic(request: Request) -> list[_Found]:
    """The variables of a classic NetCDF file."""
    try:
        variables = netcdf3_variables(request.path.read_bytes())
    except (Damaged, OSError, MemoryError) as error:
        raise request.error(
            f"the NetCDF file is damaged or cut short ({error}).", remedy="Copy it again."
        ) from error
    if request.options.group is not None:
        raise request.error("a NetCDF file of this version has no groups.", remedy="Drop group.")
    return [_classic_variable(*item) for item in variables]


def _classic_variable(
    name: str, values: NDArray[Any], attributes: Mapping[str, str | NDArray[Any]]
) -> _Found:
    if values.dtype.kind == "S":
        return _Found(path=name, shape=values.shape, other="a text")
    stated = {
        key: float(value.reshape(-1)[0])
        for key, value in attributes.items()
        if not isinstance(value, str) and value.size == 1
    }
    unit = attributes.get("units")
    return _Found(
        path=name,
        shape=values.shape,
        read=lambda: np.asarray(values, dtype=np.float64),
        unit=_unit(unit if isinstance(unit, str) else None),
        factor=stated.get("scale_factor", 1.0),
        offset=stated.get("add_offset", 0.0),
        missing=tuple(stated[key] for key in ("_FillValue", "missing_value") if key in stated),
    )


def _unit(stated: str | None) -> str | None:
    """A unit as it stands, that of a time since some date without the date."""
    found = _SINCE.fullmatch(stated or "")
    return stated if found is None else _TIME_UNITS.get(found[1].lower(), found[1])
