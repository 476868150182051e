"""What the header of an OpenFOAM file says of its columns.

The layouts differ between releases and forks; the words of the header tell them apart, never the
name of the file: ``forces(pressure viscous porous) moment(…)`` are brackets in brackets,
``total_x total_y total_z pressure_x …`` are forces or moments after the title, with or without
brackets, ``Cd Cs Cl …`` are coefficients, ``centreOfRotation …`` is the motion of a body.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, Literal

Kind = Literal["forces", "force", "moment", "coefficients", "motion"]

MOVED: Final = "displacement"
"""Name under which the way of the centre of rotation from its first place is offered."""
LONGEST: Final = 65536
"""Bytes in which the header must end."""

_AXES: Final = "xyz"
_NESTED: Final = re.compile(r"(local)?(force|moment)s?\s*\(([^()]*)\)", re.IGNORECASE)
_TITLE: Final = re.compile(r"#\s*(force|moment)s?\b(?!.*coefficient)", re.IGNORECASE)
_VALUE: Final = re.compile(r"#\s*([A-Za-z][\w ]*?)\s*:\s*(.*\S)")
_COMPONENT: Final = re.compile(r"([A-Za-z]\w*)_([xyz])")
_COEFFICIENT: Final = re.compile(r"C[A-Za-z]\w*(?:\([fr]\))?")
_VECTORS: Final = {
    "centreOfRotation": "m",
    "centreOfMass": "m",
    "rotation": "angle",
    "velocity": "m/s",
    "omega": "rate",
    "angularVelocity": "rate",
}


@dataclass(frozen=True, kw_only=True)
class RowLayout:
    """How the rows of a file are to be read.

    `kind`: ``forces``: forces and moments in one file; ``force``, ``moment``: one of them;
    ``coefficients``; ``motion`` of a rigid body. `width`: numbers in a row, the time among
    them. `brackets`: opening brackets in a row. `offered`: headers for the user (``Fx [N]``)
    and the columns, counted from 0, whose sum each is. `parts`: of totals that the file states
    itself: the columns that they must be the sum of. `local`: whether a second row of the same
    time follows, with the same in local axes. `values`: the values of the header, e.g.
    ``CofR``. `start`: byte at which the rows begin. `first_line`: line, counted from 1, in
    which they begin.
    """

    kind: Kind
    width: int
    brackets: int
    offered: Mapping[str, tuple[int, ...]]
    parts: Mapping[str, tuple[int, ...]]
    local: bool
    values: Mapping[str, str]
    start: int
    first_line: int

    def title(self, place: int) -> str:
        """Header of a single column, or its number counted from 1."""
        names = [name for name, places in self.offered.items() if places == (place,)]
        return names[0] if names else str(place + 1)


@dataclass(frozen=True, kw_only=True)
class _Columns:
    """What the line of names says."""

    kind: Kind
    width: int
    brackets: int
    offered: Mapping[str, tuple[int, ...]]
    parts: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    local: bool = False


def layout_of(head: bytes) -> RowLayout | None:
    """The layout of a file from its first bytes; None if it is not one that is known.

    Examples
    --------
    >>> text = b"# Force\\n# CofR : (1 0 0)\\n#\\n# Time\\ttotal_x total_y total_z\\n1 2 3 4\\n"
    >>> layout = layout_of(text)
    >>> layout.kind, layout.width, list(layout.offered), layout.values["CofR"]
    ('force', 4, ['Fx [N]', 'Fy [N]', 'Fz [N]'], '(1 0 0)')
    """
    head = head[:LONGEST]
    start = 3 if head.startswith(b"\xef\xbb\xbf") else 0
    lines: list[str] = []
    while (end := head.find(b"\n", start)) >= 0:
        line = head[start:end].decode("utf-8", "replace").strip()
        if line and not line.startswith("#"):
            break
        lines.append(line)
        start = end + 1
    found = _columns([line for line in lines if line])
    if found is None:
        return None
    values = {}
    for line in lines:
        stated = _VALUE.fullmatch(line)
        if stated is not None:
            values[stated[1]] = stated[2]
    return RowLayout(
        kind=found.kind,
        width=found.width,
        brackets=found.brackets,
        offered=_with_angles(found.offered, values.get("Angle Units", "radians")),
        parts=found.parts,
        local=found.local,
        values=MappingProxyType(values),
        start=start,
        first_line=len(lines) + 1,
    )


def _columns(lines: list[str]) -> _Columns | None:
    """The columns from the line of names, which is the last one that begins with Time."""
    named = [line[1:].strip() for line in lines if re.match(r"#\s*Time\s", line)]
    if not named:
        return None
    names = named[-1].removeprefix("Time").strip()
    if _NESTED.match(names):
        return _nested(names)
    words = names.replace("(", " (").split()
    if words and all(word in _VECTORS for word in words):
        return _motion(words)
    if words and all(_COEFFICIENT.fullmatch(word) for word in names.split()):
        return _coefficients(names.split())
    titles = [found[1].lower() for line in lines if (found := _TITLE.match(line))]
    return _flat(names, titles[0]) if titles else None


def _nested(names: str) -> _Columns | None:
    """``forces(pressure viscous) moments(pressure viscous)``, and the same in local axes."""
    sums: dict[str, tuple[int, ...]] = {}
    pieces: dict[str, tuple[int, ...]] = {}
    rows = {"": 0, "local": 0}
    column = {"": 1, "local": 1}
    heads = [(found[1], found[2].lower()) for found in _NESTED.finditer(names)]
    if len(set(heads)) < len(heads):
        return None
    for found in _NESTED.finditer(names):
        where = (found[1] or "").lower()
        letter, unit = ("F", "N") if found[2].lower() == "force" else ("M", "N m")
        prefix = f"{where}_{letter}" if where else letter
        groups = re.split(r"[,\s]+", found[3].strip())
        first = column[where]
        for axis, name in enumerate(_AXES):
            places = tuple(first + 3 * group + axis for group in range(len(groups)))
            sums[f"{prefix}{name} [{unit}]"] = places
            for group, place in zip(groups, places, strict=True):
                pieces[f"{prefix}{name}_{group} [{unit}]"] = (place,)
        column[where] = first + 3 * len(groups)
        rows[where] += len(groups) + 1
    local = column["local"] > 1
    if column[""] == 1 or (local and (column["local"], rows["local"]) != (column[""], rows[""])):
        return None
    width = column[""]
    offered = {
        name: tuple(place + width for place in places) if name.startswith("local") else places
        for name, places in {**sums, **pieces}.items()
    }
    return _Columns(kind="forces", width=width, brackets=rows[""], offered=offered, local=local)


def _flat(names: str, title: str) -> _Columns | None:
    """``total_x total_y total_z pressure_x …``, each three in brackets or not."""
    words = names.replace("(", " ").replace(")", " ").split()
    found = [_COMPONENT.fullmatch(word) for word in words]
    places = {(part[1], part[2]): place for place, part in enumerate(found, start=1) if part}
    groups = list(dict.fromkeys(group for group, _ in places))
    if len(places) != len(words) or len(places) != 3 * len(groups) or not groups:
        return None
    letter, unit = ("F", "N") if title == "force" else ("M", "N m")
    others = [group for group in groups if group != "total"]
    offered: dict[str, tuple[int, ...]] = {}
    parts: dict[str, tuple[int, ...]] = {}
    for axis in _AXES:
        pieces = tuple(places[group, axis] for group in others)
        total = (places["total", axis],) if "total" in groups else pieces
        offered[f"{letter}{axis} [{unit}]"] = total
        if others and "total" in groups:
            parts[f"{letter}{axis} [{unit}]"] = pieces
    for group in others:
        for axis in _AXES:
            offered[f"{letter}{axis}_{group} [{unit}]"] = (places[group, axis],)
    return _Columns(
        kind="force" if title == "force" else "moment",
        width=len(words) + 1,
        brackets=names.count("("),
        offered=offered,
        parts=parts,
    )


def _coefficients(words: list[str]) -> _Columns | None:
    """``Cd Cs Cl …``; front and rear parts ``Cl(f)`` are what follows from the others."""
    offered = {f"{word} [-]": (place,) for place, word in enumerate(words, start=1)}
    if len(offered) != len(words):
        return None
    return _Columns(kind="coefficients", width=len(words) + 1, brackets=0, offered=offered)


def _motion(words: list[str]) -> _Columns:
    """``centreOfRotation centreOfMass rotation velocity omega``, each a vector in brackets."""
    offered = {
        f"{word}_{axis} [{_VECTORS[word]}]": (1 + 3 * place + turn,)
        for place, word in enumerate(words)
        for turn, axis in enumerate(_AXES)
    }
    for axis in _AXES:
        if f"centreOfRotation_{axis} [m]" in offered:
            offered[f"{MOVED}_{axis} [m]"] = offered[f"centreOfRotation_{axis} [m]"]
    return _Columns(kind="motion", width=1 + 3 * len(words), brackets=len(words), offered=offered)


def _with_angles(
    offered: Mapping[str, tuple[int, ...]], stated: str
) -> Mapping[str, tuple[int, ...]]:
    """The headers with the unit of angles that the file states."""
    angle = "deg" if stated.strip().lower().startswith("deg") else "rad"
    units = {"[angle]": f"[{angle}]", "[rate]": f"[{angle}/s]"}
    out = {}
    for name, places in offered.items():
        head, _, unit = name.rpartition(" ")
        out[f"{head} {units.get(unit, unit)}"] = places
    return MappingProxyType(out)
