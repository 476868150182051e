"""Tecplot's text files: named variables, and a zone for each run.

Words stand before numbers: TITLE, VARIABLES, and of each ZONE its title T, its size I, J, K, and
whether the numbers stand point by point or variable by variable (BLOCK).
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.readers.base import Request
from pmmkit.readers.vectors import Vector, VectorReader

_BINARY: Final = (b"#!TDV", b"#!SZPLT")
_COMMENT: Final = re.compile(rb"^[ \t]*#.*$", re.MULTILINE)
_WORDS: Final = re.compile(rb"^[ \t]*(?!nan\b|inf)[a-z]", re.MULTILINE | re.IGNORECASE)
_NUMBERS: Final = re.compile(rb"^[ \t]*(?:[-+.]*\d|[-+]?nan\b|[-+]?inf)", re.M | re.IGNORECASE)
_STATEMENT: Final = re.compile(
    r"^[ \t]*(TITLE|VARIABLES|ZONE|DATASETAUXDATA|VARAUXDATA|TEXT|GEOMETRY|FILETYPE)\b",
    re.MULTILINE | re.IGNORECASE,
)
_PAIR: Final = re.compile(r"([A-Za-z]\w*)\s*=\s*(\"[^\"]*\"|\([^)]*\)|[^\s,]+)")
_BESIDE: Final = re.compile(r"AUXDATA\s+(\w+)\s*=\s*\"([^\"]*)\"", re.IGNORECASE)
_NAME: Final = re.compile(r"\"([^\"]*)\"|'([^']*)'|([^\s,\"']+)")
_REPEATED: Final = re.compile(rb"\d+\*")


@dataclass(frozen=True, kw_only=True)
class Zone:
    """A table of a file.

    `points`: how many it states, where it does. `block`: whether it stands variable by variable.
    `beside`: what is said of it. `numbers`: as they stand in the file.
    """

    title: str = ""
    variables: tuple[str, ...] = ()
    points: int | None = None
    block: bool = False
    beside: tuple[str, ...] = ()
    numbers: bytes = b""


class Tecplot(VectorReader):
    """Text files of Tecplot."""

    name = "tecplot"
    words = "Tecplot file"
    reads = "Text files of Tecplot (.dat, .plt, .tec), of one zone or several."
    suffixes = (".plt", ".tec")
    container = True
    keys = ("group", "missing")

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether VARIABLES and a ZONE stand before numbers, or the file is Tecplot's binary."""
        if head.startswith(_BINARY):
            return True
        said = {word.upper() for word in _STATEMENT.findall(_text(_before_numbers(head)))}
        return {"VARIABLES", "ZONE"} <= said

    def contents(self, request: Request) -> AbstractContextManager[tuple[list[Vector], list[str]]]:
        """The variables of a zone; where there are several those of each, behind its title."""
        return _contents(request)

    def groups(self, request: Request) -> tuple[str, ...]:
        """Titles of the zones, where there are several of the same variables."""
        zones = zones_of(request)
        one = len(zones) > 1 and len({zone.variables for zone in zones}) == 1
        return tuple(zone.title for zone in zones) if one else ()

    def remarks(self, request: Request) -> tuple[str, ...]:
        """Titles of file and zone, and auxiliary data."""
        zones = _chosen(zones_of(request), request)
        return tuple(dict.fromkeys(line for zone in zones for line in zone.beside))


@contextmanager
def _contents(request: Request) -> Iterator[tuple[list[Vector], list[str]]]:
    zones = _chosen(zones_of(request), request)
    offered: list[Vector] = []
    for zone in zones:
        table = table_of(zone, request)
        before = "" if len(zones) == 1 else f"{zone.title}: "
        offered += [
            Vector(
                name=f"{before}{name}",
                length=len(table),
                read=functools.partial(np.take, table, place, axis=1),
            )
            for place, name in enumerate(zone.variables)
        ]
    yield offered, []


def zones_of(request: Request) -> list[Zone]:
    """All zones of a file."""
    data = request.read()
    if data.startswith(_BINARY):
        raise request.error(
            "this is Tecplot's binary form.",
            remedy="Write it as text: in Tecplot, File > Write Data, ASCII.",
        )
    data = _COMMENT.sub(b"", data.replace(b"\r\n", b"\n"))
    found: list[Zone] = []
    said, place = Zone(), 0
    while first := _NUMBERS.search(data, place):
        said = _said(_text(data[place : first.start()]), said, request)
        after = _WORDS.search(data, first.start())
        place = after.start() if after else len(data)
        taken = {zone.title for zone in found}
        title = said.title if said.title and said.title not in taken else f"zone {len(found) + 1}"
        found.append(replace(said, title=title, numbers=data[first.start() : place]))
    if not found:
        raise request.error("there are no zones of numbers.")
    return found


def _before_numbers(head: bytes) -> bytes:
    head = _COMMENT.sub(b"", head)
    first = _NUMBERS.search(head)
    return head[: first.start()] if first else head


def _text(words: bytes) -> str:
    try:
        return words.decode("utf-8-sig")
    except UnicodeDecodeError:
        return words.decode("latin-1")


def _said(head: str, before: Zone, request: Request) -> Zone:
    """What words say of the zone whose numbers follow them."""
    parts = _STATEMENT.split(head)
    variables, told = before.variables, before.beside[:1]
    title, points, block, beside = "", None, False, []
    for word, text in zip(parts[1::2], parts[2::2], strict=True):
        kind = word.upper()
        if kind == "TITLE":
            told = (text.partition("=")[2].strip().strip("\"'").strip(),)
        elif kind == "VARIABLES":
            names = _NAME.findall(text.partition("=")[2])
            variables = tuple(next(filter(None, each), "").strip() for each in names)
        elif kind == "ZONE":
            stated = {key.upper(): value.strip("\"'") for key, value in _PAIR.findall(text)}
            title = stated.get("T", "").strip()
            packing = f"{stated.get('F', '')}{stated.get('DATAPACKING', '')}".upper()
            block = packing.endswith("BLOCK")
            points = _points(stated, request)
            beside = [f"{name}: {value}" for name, value in _BESIDE.findall(text)]
        elif kind == "DATASETAUXDATA":
            told = (*told, *(f"{name}: {value}" for name, value in _BESIDE.findall(word + text)))
    lines = (*told, title, *beside) if title else (*told, *beside)
    return Zone(title=title, variables=variables, points=points, block=block, beside=lines)


def _points(stated: dict[str, str], request: Request) -> int | None:
    """How many points a zone states; a mesh of elements is no table."""
    kind = f"{stated.get('ZONETYPE', '')}{stated.get('F', '')}".upper()
    if kind.startswith("FE"):
        raise request.error("a zone of finite elements is no table of a run.")
    sides = [stated[key] for key in ("I", "J", "K") if key in stated]
    if not sides or not all(side.isdecimal() for side in sides):
        return None
    return int(np.prod([int(side) for side in sides]))


def _chosen(zones: list[Zone], request: Request) -> list[Zone]:
    """The zone that is asked for, or all."""
    wanted = request.options.group
    if wanted is None:
        return zones
    found = [zone for zone in zones if zone.title == wanted]
    if not found:
        raise request.absent("zone", wanted, [zone.title for zone in zones])
    return found


def table_of(zone: Zone, request: Request) -> Array:
    """The numbers of a zone, (points, variables)."""
    numbers, width = zone.numbers, len(zone.variables)
    if _REPEATED.search(numbers):
        raise request.error(
            f"zone {zone.title!r} writes equal numbers once, as 3*0.5.",
            remedy="Write every number out.",
        )
    words = numbers.replace(b"D", b"E").replace(b"d", b"E").replace(b",", b" ").split()
    try:
        values = np.array(words).astype(np.float64)
    except (ValueError, UnicodeDecodeError):
        wrong = next(word for word in words if not _is_number(word))
        raise request.error(
            f"zone {zone.title!r}: {wrong.decode('latin-1')!r:.40} is not a number."
        ) from None
    whole = values.size if zone.points is None else width * zone.points
    if not width or values.size != whole or values.size % width:
        stated = "" if zone.points is None else f" of {zone.points} points each"
        raise request.error(
            f"zone {zone.title!r} holds {values.size} numbers of {width} variables{stated}: it is "
            "damaged, or cut short."
        )
    return values.reshape(width, -1).T if zone.block else values.reshape(-1, width)


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
