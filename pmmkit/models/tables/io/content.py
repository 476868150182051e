"""A derivative table out of what a file holds, checked against its fingerprint."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, fields
from types import MappingProxyType
from typing import Any, Final, Literal, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from pmmkit.base import Problem, TableError
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.models.tables.table import KIND, SCHEMA, DerivativeTable
from pmmkit.numerics import Array

NOT_READ: Final = "The derivative table is not read"
NO_FINGERPRINT: Final = "The file was edited: its fingerprint is null, so damage is not noticed."

Part = TypeVar("Part", Convention, Ship, Water)


def assemble(
    *,
    names: tuple[str, ...],
    Fn: Array,
    value: Array,
    covariance: Array,
    dof: Array,
    method: Any,
    runs: Any,
    header: Mapping[str, Any],
    file: str,
    remedy: str,
) -> DerivativeTable:
    """A table from what a file holds, checked against the fingerprint in its header."""
    problems: list[Problem] = []
    if header.get("kind") != KIND:
        problems.append(Problem(message=f"kind is not {KIND!r}.", file=file))
    schema = header.get("schema")
    if schema != SCHEMA:
        problems.append(
            Problem(
                message=f"schema is {schema!r}; this pmmkit reads {SCHEMA}.",
                file=file,
                remedy="Write the file again, or take a newer pmmkit.",
            )
        )
    if not isinstance(header.get("fingerprint", 0), str | None):
        problems.append(Problem(message="fingerprint is missing.", file=file, remedy=remedy))
    convention = _part(Convention, header, "convention", file, problems)
    ship = _part(Ship, header, "ship", file, problems)
    water = _part(Water, header, "water", file, problems)
    notes, provenance = header.get("notes"), header.get("provenance")
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
        problems.append(Problem(message="notes is not a list of texts.", file=file))
    if not isinstance(provenance, dict):
        problems.append(Problem(message="provenance is not a mapping.", file=file))
    if problems or convention is None or ship is None or water is None:
        raise TableError(problems, title=NOT_READ)
    assert isinstance(notes, list)
    assert isinstance(provenance, dict)
    table = DerivativeTable(
        names=names,
        Fn=Fn,
        value=value,
        covariance=covariance,
        dof=dof,
        method=np.asarray(method, dtype=np.str_).reshape(value.shape),
        runs=np.asarray(runs, dtype=np.int64).reshape(value.shape),
        convention=convention,
        ship=ship,
        water=water,
        notes=tuple(notes),
        provenance=MappingProxyType(provenance),
    )
    stated = header["fingerprint"]
    if stated is None:
        return table.with_(notes=(*table.notes, NO_FINGERPRINT))
    if stated != table.fingerprint:
        raise TableError(
            Problem(
                message="the content is not what pmmkit wrote: it was changed or damaged since.",
                file=file,
                remedy=remedy,
            ),
            title=NOT_READ,
        )
    return table


def _part(
    kind: type[Part], header: Mapping[str, Any], key: str, file: str, problems: list[Problem]
) -> Part | None:
    """One dataclass of the header; what is wrong with it is added to the problems."""
    given = header.get(key)
    if not isinstance(given, Mapping):
        problems.append(Problem(message=f"{key} is missing.", file=file))
        return None
    hints = get_type_hints(kind)
    known = {item.name: item for item in fields(kind)}
    values: dict[str, Any] = {
        name: math.nan if value == "nan" and hints.get(name) is float else value
        for name, value in given.items()
    }
    wrong = [f"{key}.{name} is not known." for name in given if name not in known]
    for name, item in known.items():
        if name not in given:
            if item.default is MISSING:
                wrong.append(f"{key}.{name} is missing.")
        elif not _fits(values[name], hints[name]):
            wrong.append(f"{key}.{name} = {given[name]!r} is not allowed.")
    problems.extend(Problem(message=text, file=file) for text in wrong)
    return None if wrong else kind(**values)


def _fits(value: Any, hint: Any) -> bool:
    if get_origin(hint) is Literal:
        return value in get_args(hint)
    if hint is str:
        return isinstance(value, str)
    if value is None:
        return type(None) in get_args(hint)
    return isinstance(value, int | float) and not isinstance(value, bool) and not math.isinf(value)
