"""Sections of TOML files, read with every fault named by its place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import MappingProxyType
from typing import (
    TYPE_CHECKING,
    Any,
    Final,
    Literal,
    TypeVar,
    cast,
    get_args,
    get_origin,
    get_type_hints,
)

from pmmkit.base import ModelError, Problem, did_you_mean
from pmmkit.models.library import number
from pmmkit.models.step import Step, Value

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Record = TypeVar("Record", bound="DataclassInstance")


class FileReader:
    """Collects what is wrong with a file while taking out what is right."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.problems: list[Problem] = []

    def fault(self, message: str, remedy: str | None = None) -> None:
        """What is wrong, and what to do."""
        self.problems.append(Problem(message=message, file=self.file, remedy=remedy))

    def known(self, data: Mapping[str, Any], names: Iterable[str], place: str) -> None:
        """Names the entries that have no place in a section."""
        stray = [key for key in data if key not in tuple(names)]
        if stray:
            there = tuple(names)
            guess = did_you_mean(stray[0], there) or "."
            self.fault(
                f"{place} has no {', '.join(map(repr, stray))}{guess} It has {', '.join(there)}."
            )

    def section(self, data: Mapping[str, Any], key: str, place: str) -> Mapping[str, Any]:
        """A section inside another; empty where it is absent."""
        value = data.get(key, {})
        if isinstance(value, dict):
            return value
        self.fault(f"{place} must be a section.")
        return {}

    def text(self, data: Mapping[str, Any], key: str, place: str = "") -> str:
        """A text; empty where it is absent."""
        value = data.get(key, "")
        if isinstance(value, str):
            return value
        self.fault(f"{place}{key} must be a text, not {value!r:.40}.")
        return ""

    def texts(self, data: Mapping[str, Any], key: str, place: str = "") -> tuple[str, ...]:
        """A list of texts; empty where it is absent."""
        value = data.get(key, [])
        if isinstance(value, list) and all(isinstance(item, str) for item in value):
            return tuple(value)
        self.fault(f"{place}{key} must be a list of texts.")
        return ()

    def words(self, data: Mapping[str, Any], key: str, place: str) -> Mapping[str, str]:
        """A section of texts."""
        content = self.section(data, key, place)
        wrong = [name for name, value in content.items() if not isinstance(value, str)]
        if wrong:
            self.fault(f"{place}.{', '.join(wrong)} must be a text.")
        return MappingProxyType({k: v for k, v in content.items() if isinstance(v, str)})

    def number(self, value: object, place: str) -> Value | None:
        """A finite number or a list of them."""
        if isinstance(value, list):
            read = [number(item) for item in value]
            kept = tuple(item for item in read if item is not None)
            if len(kept) == len(value):
                return kept
        else:
            single = number(value)
            if single is not None:
                return single
        self.fault(f"{place} must be a finite number or a list of them, not {value!r:.40}.")
        return None

    def record(self, kind: type[Record], data: Mapping[str, Any], place: str) -> Record | None:
        """A dataclass from a section with an entry per field; None if anything is wrong."""
        before = len(self.problems)
        hints = get_type_hints(kind)
        self.known(data, hints, place)
        lost = [
            item.name
            for item in fields(kind)
            if item.default is MISSING and item.default_factory is MISSING and item.name not in data
        ]
        if lost:
            self.fault(f"{place} lacks {', '.join(lost)}.")
        given = {
            key: self._entry(hint, data, key, f"{place}.{key}")
            for key, hint in hints.items()
            if key in data
        }
        if len(self.problems) > before:
            return None
        try:
            return kind(**given)
        except ModelError as error:
            for problem in error.problems:
                self.fault(f"{place}: {problem.message}")
        return None

    def steps(self, data: Mapping[str, Any]) -> tuple[Step, ...]:
        """The ``[[steps]]`` of a file; what is wrong is added to the faults."""
        items = data.get("steps", [])
        if not isinstance(items, list) or not all(isinstance(item, dict) for item in items):
            self.fault("steps must be sections [[steps]].")
            return ()
        found = [self.record(Step, item, f"steps.{i}") for i, item in enumerate(items, start=1)]
        return tuple(step for step in found if step is not None)

    def _entry(self, hint: Any, data: Mapping[str, Any], key: str, place: str) -> Any:
        """One entry as the annotation of its field wants it."""
        value = data[key]
        inner = [item for item in get_args(hint) if item is not type(None)]
        if type(None) in get_args(hint):
            (hint,) = inner
            inner = list(get_args(hint))
        if get_origin(hint) is Literal:
            if value not in inner:
                self.fault(f"{place} is {value!r:.40}; possible: {', '.join(inner)}.")
        elif is_dataclass(hint):
            return self.record(cast(type, hint), self.section(data, key, place), place)
        elif get_origin(hint) is Mapping:
            return self._mapping(inner[1], self.section(data, key, place), place)
        elif hint == tuple[str, ...]:
            return self.texts({place: value}, place)
        elif hint == tuple[float, ...]:
            found = self.number(value, place)
            return found if isinstance(found, tuple) or found is None else (found,)
        elif hint is float:
            if number(value) is None:
                self.fault(f"{place} is {value!r:.40}; possible: a number.")
            return number(value)
        elif not isinstance(value, hint) or (hint is int and isinstance(value, bool)):
            self.fault(f"{place} must be {_KINDS[hint]}, not {value!r:.40}.")
        return value

    def _mapping(self, hint: Any, content: Mapping[str, Any], place: str) -> Mapping[str, Any]:
        if hint is str:
            return self.words({place: content}, place, place)
        found = {name: self.number(value, f"{place}.{name}") for name, value in content.items()}
        return MappingProxyType(found)


_KINDS: Final = {str: "a text", bool: "true or false", int: "a whole number"}
