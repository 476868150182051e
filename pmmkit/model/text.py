"""A small writer of TOML: sections, texts, numbers and lists of them, always the same way."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, Final

_BARE: Final = re.compile(r"[A-Za-z0-9_-]+")
_ESCAPES: Final = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
WIDTH: Final = 96


def toml_text(data: Mapping[str, Any]) -> str:
    """Write nested mappings as TOML that `tomllib` reads back equal.

    Parameters
    ----------
    data : mapping
        Texts, booleans, integers, floats, flat lists of them, lists of such lists, mappings.
        Floats are written with the fewest digits that give the same float again.

    Returns
    -------
    str

    Examples
    --------
    >>> print(toml_text({"name": "a", "values": {"Yv|v|": -0.1, "Yv": [1.0, 2.0]}}), end="")
    name = "a"
    <BLANKLINE>
    [values]
    "Yv|v|" = -0.1
    Yv = [1.0, 2.0]
    """
    return "\n".join(_table(data, ())).lstrip("\n") + "\n"


def _table(data: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    plain = {key: value for key, value in data.items() if not isinstance(value, Mapping)}
    nested = {key: value for key, value in data.items() if isinstance(value, Mapping)}
    lines = []
    if path and (plain or not nested):
        lines += ["", f"[{'.'.join(map(_key, path))}]"]
    for key, value in plain.items():
        lines += f"{_key(key)} = {_value(value)}".split("\n")
    for key, value in nested.items():
        lines += _table(value, (*path, key))
    return lines


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _string(name)


def _string(text: str) -> str:
    body = "".join(
        _ESCAPES.get(char)
        or (f"\\u{ord(char):04x}" if ord(char) < 32 or ord(char) == 127 else char)
        for char in text
    )
    return f'"{body}"'


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, Sequence):
        return _list([_value(item) for item in value], any(isinstance(v, str) for v in value))
    raise TypeError(f"{type(value).__name__} has no place in a TOML file")


def _list(items: list[str], texts: bool) -> str:
    line = f"[{', '.join(items)}]"
    if len(line) <= WIDTH and "\n" not in line:
        return line
    if texts or any("\n" in item or item.startswith("[") for item in items):
        inner = "".join(f"{_indented(item)},\n" for item in items)
        return f"[\n{inner}]"
    wrapped = textwrap.wrap(
        ", ".join(items), WIDTH - 4, break_long_words=False, break_on_hyphens=False
    )
    return "[\n" + _indented("\n".join(wrapped)) + ",\n]"


def _indented(text: str) -> str:
    """Lines moved in; only line feeds part them, not the further breaks that Unicode knows."""
    return "    " + text.replace("\n", "\n    ")
