"""What is wrong with a key of a campaign file, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pmmkit.base import Problem, Remedy, did_you_mean


@dataclass
class Faults:
    """What is wrong with a file, as it is found.

    `file`: its name, for messages.
    """

    file: str
    problems: list[Problem] = field(default_factory=list)

    def report(
        self, message: str, entry: str | None = None, remedy: str | Remedy | None = None
    ) -> None:
        """Note a problem of an entry, such as ``[ship], key 'L'``."""
        self.problems.append(Problem(message=message, file=self.file, entry=entry, remedy=remedy))


def fault_words(found: Mapping[str, Any], key: str, known: Sequence[str]) -> str:
    """What is wrong with a key, from an error of pydantic."""
    kind, given, extra = found["type"], found.get("input"), found.get("ctx", {})
    if kind == "extra_forbidden":
        return f"not known{did_you_mean(key, known) or '.'}"
    if kind == "missing":
        return "is missing."
    if kind == "literal_error":
        listed = extra["expected"].replace(" or ", ", ").split(", ")
        options = [option.strip("'") for option in listed]
        guess = did_you_mean(given, options) if isinstance(given, str) else ""
        return f"{shown(given)} is not one of {', '.join(options)}{guess or '.'}"
    if kind in ("value_error", "assertion_error"):
        return str(extra.get("error", found["msg"])).rstrip(".") + "."
    bounds = {
        "greater_than": "greater than",
        "greater_than_equal": "at least",
        "less_than": "less than",
        "less_than_equal": "at most",
    }
    if kind in bounds:
        limit = next(iter(extra.values()))
        return f"must be {bounds[kind]} {limit:g}, it is {shown(given)}."
    plain = {
        "float_type": "a number",
        "int_type": "a whole number",
        "string_type": "text in quotes",
        "bool_type": "true or false",
        "list_type": "a list",
        "dict_type": "a table",
        "model_type": "a table",
        "model_attributes_type": "a table",
        "finite_number": "a finite number",
        "int_from_float": "a whole number",
        "string_too_short": "not empty",
    }
    if kind in plain:
        return f"must be {plain[kind]}, it is {shown(given)}."
    return f"{found['msg'].rstrip('.')}: {shown(given)}."


def shown(value: Any) -> str:
    """A value of a file in a sentence, as TOML writes it, cut where it is long."""
    text = {True: "true", False: "false"}.get(value, "") if isinstance(value, bool) else ""
    text = text or repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
