"""MATLAB files (.mat): versions 4, 5, 7 and 7.3.

Vectors are columns, matrices several columns, fields of structs stand behind dots. A cell array of
texts beside a matrix with as many columns names them. Nothing in the file is ever executed.
"""

from __future__ import annotations

import functools
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Final

from pmmkit.base import CampaignError
from pmmkit.readers.base import HEAD, Request
from pmmkit.readers.bounds import Damaged
from pmmkit.readers.hdf5.datasets import is_hdf5, opened
from pmmkit.readers.matlab.mat5 import MatlabVariable, is_v4, is_v5, read_v4, read_v5, read_v73
from pmmkit.readers.vectors import WIDEST, Vector, main_length, matrix_columns

_SAVE_PLAINLY: Final = (
    "Save plain numbers in MATLAB: for a timetable s = table2struct(timetable2table(tt), "
    '"ToScalar", true), for a table s = table2struct(tb, "ToScalar", true), for a timeseries '
    "s.t = ts.Time; s.Y = ts.Data, for times seconds(d - d(1)); then save run.mat -struct s."
)


@contextmanager
def contents(request: Request) -> Iterator[tuple[list[Vector], list[str]]]:
    """What the file offers as columns, and what else it holds; open as long as it is used."""
    with _variables(request) as found:
        chosen = _group(found, request)
        offered = _vectors(chosen)
        opaque = [variable for variable in chosen if variable.opaque]
        if opaque and not any(vector.texts is None for vector in offered):
            listed = ", ".join(f"{variable.name} ({variable.other})" for variable in opaque)
            raise request.error(
                f"{listed}: MATLAB keeps these in a form of its own that is not published.",
                remedy=_SAVE_PLAINLY,
            )
        yield offered, [_described(variable) for variable in chosen if not _is_column(variable)]


def remarks(request: Request) -> tuple[str, ...]:
    """The variables of one number, and of a struct its fields."""
    with _variables(request) as found:
        return tuple(
            f"{item.name}: {float(item.read().item()):g}"
            for item in _group(found, request)
            if item.shape == (1, 1) and item.texts is None and item.other is None
        )


@contextmanager
def _variables(request: Request) -> Iterator[list[MatlabVariable]]:
    head = request.read(HEAD)
    if is_hdf5(head):
        with opened(request) as file:
            yield read_v73(file, request)
        return
    yield _in_memory(head, request)


def _in_memory(head: bytes, request: Request) -> list[MatlabVariable]:
    try:
        if is_v5(head):
            return read_v5(request.path.read_bytes(), request)
        if is_v4(head):
            return read_v4(request.path.read_bytes())
    except (Damaged, zlib.error, OSError) as error:
        raise request.error(
            f"the MATLAB file is damaged or cut short ({error}).", remedy="Copy it again."
        ) from error
    raise _not_matlab(head, request)


def _not_matlab(head: bytes, request: Request) -> CampaignError:
    if not head:
        return request.error("the file is empty (0 bytes).")
    octave = head.startswith((b"# Created by Octave", b"Octave-1"))
    return request.error(
        "Octave's own format is not read." if octave else "this is not a MATLAB file.",
        remedy="Save it with save -v7 run.mat.",
    )


def _group(found: list[MatlabVariable], request: Request) -> list[MatlabVariable]:
    """The variables, or the fields of the struct that is asked for."""
    wanted = request.options.group
    if wanted is None:
        return found
    inside = [
        replace(variable, name=variable.name.removeprefix(f"{wanted}."))
        for variable in found
        if variable.name.startswith(f"{wanted}.")
    ]
    if not inside:
        structs = sorted({variable.name.rpartition(".")[0] for variable in found} - {""})
        raise request.absent("struct", wanted, structs)
    return inside


def _is_column(variable: MatlabVariable) -> bool:
    rows, columns = variable.shape
    if variable.texts is not None:
        return min(rows, columns) == 1
    return variable.other is None and rows * columns > 1 and min(rows, columns) <= WIDEST


def _vectors(found: Sequence[MatlabVariable]) -> list[Vector]:
    usable = [variable for variable in found if _is_column(variable)]
    lengths = frozenset(
        max(item.shape) for item in usable if min(item.shape) == 1 and item.texts is None
    )
    offered: list[Vector] = []
    for item in usable:
        if min(item.shape) == 1:
            offered.append(
                Vector(
                    name=item.name,
                    length=max(item.shape),
                    read=functools.partial(lambda read: read().reshape(-1), item.read),
                    texts=_texts(item),
                )
            )
        else:
            offered += _matrix(item, lengths, usable)
    main = main_length([vector.length for vector in offered if vector.texts is None])
    return [vector for vector in offered if vector.texts is None or vector.length == main]


def _matrix(
    item: MatlabVariable, lengths: frozenset[int], found: Sequence[MatlabVariable]
) -> list[Vector]:
    """Columns of a matrix, named by the one list of texts beside it that fits."""
    owner, dot, _ = item.name.rpartition(".")
    plain = matrix_columns(item.name, item.shape, item.read, lengths=lengths)
    lists = [
        other.texts
        for other in found
        if other.texts is not None
        and len(other.texts) == len(plain)
        and other.name.rpartition(".")[0] == owner
    ]
    if len(lists) != 1:
        return plain
    named = [f"{owner}{dot}{text}" for text in lists[0]]
    return matrix_columns(item.name, item.shape, item.read, lengths=lengths, names=named)


def _texts(item: MatlabVariable) -> Callable[[], tuple[str, ...]] | None:
    texts = item.texts
    return None if texts is None else lambda: texts


def _described(variable: MatlabVariable) -> str:
    rows, columns = variable.shape
    if variable.opaque:
        return f"{variable.name} ({variable.other}: {_SAVE_PLAINLY})"
    if variable.other is None and rows * columns > 1:
        return f"{variable.name} (a matrix of {rows} by {columns})"
    return f"{variable.name} ({variable.other or 'a single number' if rows * columns else 'empty'})"
