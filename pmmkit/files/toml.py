"""TOML read with every fault named, and written always the same way."""

from __future__ import annotations

import math
import re
import textwrap
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError, ModelError, Problem, Remedy, Way
from pmmkit.numerics import ABSURD

_BARE: Final = re.compile(r"[A-Za-z0-9_-]+")
_TOML: Final = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
WIDTH: Final = 96
DEEPEST: Final = 60
"""Tables inside each other."""


def toml_text(data: Mapping[str, Any]) -> str:
    """Write nested mappings as TOML that `tomllib` reads back equal.

    Parameters
    ----------
    data : mapping
        Texts, booleans, integers, floats, flat lists of them, lists of such lists, mappings, and
        lists of mappings, which become arrays of tables. Floats are written with the fewest
        digits that give the same float again.

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
    >>> print(toml_text({"runs": [{"id": "a", "row": {"n": 1}}, {"id": "b"}]}), end="")
    [[runs]]
    id = "a"
    <BLANKLINE>
    [runs.row]
    n = 1
    <BLANKLINE>
    [[runs]]
    id = "b"
    """
    return "\n".join(_table(data, ())).lstrip("\n") + "\n"


def _table(data: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    """The lines of a table without its own heading; tables inside follow behind its values."""
    plain = {key: value for key, value in data.items() if not _is_table(value)}
    lines = [
        line
        for key, value in plain.items()
        for line in f"{_key(key)} = {_value(value)}".split("\n")
    ]
    for key in (key for key in data if key not in plain):
        value, inner = data[key], (*path, key)
        name = ".".join(map(_key, inner))
        if isinstance(value, Mapping):
            inside = _table(value, inner)
            lines += inside if inside[:1] == [""] else ["", f"[{name}]", *inside]
        else:
            for item in value:
                lines += ["", f"[[{name}]]", *_table(item, inner)]
    return lines


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and all(isinstance(x, Mapping) for x in value)
    )


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else toml_string(name)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, str):
        return toml_string(value)
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


def toml_string(text: str) -> str:
    """A text in quotes for TOML; what is no text in UTF-8 becomes the sign for that.

    Parameters
    ----------
    text : str
        Any text.

    Examples
    --------
    >>> print(toml_string('Tank "A"'))
    "Tank \\"A\\""
    """
    body = "".join(
        _TOML.get(char) or (f"\\u{ord(char):04x}" if ord(char) < 32 or ord(char) == 127 else char)
        for char in text
    )
    return '"{}"'.format(body.encode("utf-8", "replace").decode("utf-8"))


def absurd_numbers(content: object, place: str = "") -> Iterator[tuple[str, float]]:
    """Numbers of a file that no ship and no test can have, with the places where they stand.

    Examples
    --------
    >>> list(absurd_numbers({"ship": {"xG": 1e308, "L": 4.0}, "runs": [{"speed": -1e99}]}))
    [('ship.xG', 1e+308), ('runs #1.speed', -1e+99)]
    """
    if isinstance(content, Mapping):
        for key, item in content.items():
            yield from absurd_numbers(item, f"{place}.{key}" if place else key)
    elif isinstance(content, list):
        for number, item in enumerate(content, start=1):
            yield from absurd_numbers(item, f"{place} #{number}")
    elif isinstance(content, int | float) and ABSURD < abs(content) < math.inf:
        yield place, content


def _depth(content: object) -> int:
    """How many tables and lists stand inside each other, counted without recursion."""
    depth, level = 0, [content]
    while level := [
        inner
        for item in level
        if isinstance(item, Mapping | list)
        for inner in (item.values() if isinstance(item, Mapping) else item)
    ]:
        depth += 1
    return depth


def check_numbers(content: Mapping[str, Any], file: str, kind: type[DataError]) -> None:
    """Refuse a file that holds absurd numbers, or tables in tables without end.

    Parameters
    ----------
    content : mapping
        What `tomllib` reads.
    file : str
        Name for messages.
    kind : type
        Of the error.

    Raises
    ------
    DataError
        Of that kind, with the place of each such number.
    """
    if _depth(content) > DEEPEST:
        raise kind(
            Problem(message=f"more than {DEEPEST} tables stand inside each other.", file=file)
        )
    found = [
        Problem(
            message=f"{value!r:.40} is absurdly large.",
            file=file,
            entry=place,
            remedy="Correct it; all is in SI units.",
        )
        for place, value in absurd_numbers(content)
    ]
    if found:
        raise kind(found)


@dataclass(frozen=True)
class TomlKind:
    """A kind of TOML file of pmmkit, its usual name, and who reads it."""

    words: str
    file: str
    keys: frozenset[str]
    remedy: Remedy


CAMPAIGN: Final = TomlKind(
    "a campaign file",
    "campaign.toml",
    frozenset({"campaign", "runs", "tables"}),
    Remedy(
        "{}",
        (
            Way(
                "pmmkit.open_campaign reads it.",
                "Give it where a command asks for a campaign; pmmkit reduce makes a model of it.",
            ),
        ),
    ),
)
MODEL: Final = TomlKind(
    "a model file",
    "model.toml",
    frozenset({"effects", "convention"}),
    Remedy(
        "{}", (Way("pmmkit.load_model reads it.", "Give it where a command asks for a model."),)
    ),
)


def kind_of(content: Mapping[str, Any]) -> TomlKind | None:
    """What kind of file this is the content of, by its tables; None if it may be several.

    Examples
    --------
    >>> kind_of({"campaign": {}, "ship": {}}).words
    'a campaign file'
    """
    found = [kind for kind in (CAMPAIGN, MODEL) if kind.keys & content.keys()]
    return found[0] if len(found) == 1 else None


def refuse_other(
    content: Mapping[str, Any], wanted: TomlKind | None, file: str, error: type[DataError]
) -> None:
    """Refuse the content of another kind of file than is wanted, and say who reads it.

    Parameters
    ----------
    content : mapping
        What `tomllib` reads.
    wanted : TomlKind or None
        The kind that is read here.
    file : str
        Name for messages.
    error : type
        Of the error.

    Raises
    ------
    DataError
        Of that kind.
    """
    kind = kind_of(content)
    if kind is not None and kind is not wanted:
        raise error(Problem(message=f"this is {kind.words}.", file=file, remedy=kind.remedy))


def read_toml(path: str | Path) -> dict[str, Any]:
    """The content of a TOML file at a `path`.

    Raises
    ------
    ModelError
        If the file is missing, not text or not TOML, with the line where known.
    """
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
        content = tomllib.loads(text)
    except FileNotFoundError as error:
        raise ModelError(
            "The file does not exist.", file=str(path), remedy="Check the path."
        ) from error
    except OSError as error:
        raise ModelError(f"The file cannot be read: {error.strerror}.", file=str(path)) from error
    except UnicodeDecodeError as error:
        raise ModelError(
            f"The file is not UTF-8 text (byte {error.start}).",
            file=str(path),
            remedy="Save it as UTF-8.",
        ) from error
    except (ValueError, RecursionError) as error:
        raise ModelError(
            f"The file is not valid TOML: {error}.",
            file=str(path),
            remedy="Correct that line, or take the file from its source again.",
        ) from error
    check_numbers(content, str(path), ModelError)
    return content
