"""What the header of an OpenFOAM file says of its columns.

The layouts differ between releases and forks; the words of the header tell them apart, never the
name of the file: ``forces(pressure viscous porous) moment(…)`` are brackets in brackets,
``total_x total_y total_z pressure_x …`` are forces or moments after the title, with or without
brackets, ``Cd Cs Cl …`` are coefficients, ``centreOfRotation …`` is the motion of a body.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, Literal

import numpy as np

from pmmkit.base import Problem
from pmmkit.numerics import ABSURD, Array
from pmmkit.readers.base import LISTED, Cells, Request, abridged

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


# The rows of one OpenFOAM file as numbers.
#
# A file is read in blocks. Brackets are taken away and pandas parses what is left, once brackets
# and fields have been counted; a block in which anything is not as it should be is taken apart
# line by line, which names each fault.


BLOCK: Final = 1 << 21
"""Bytes that are parsed at a time."""

_BLANKS: Final = bytes.maketrans(b"\t\r", b"  ")
_BRACKETS: Final = bytes.maketrans(b"()\t\r", b"    ")
_ENDS: Final = b" \t\r\n\0"


def read_rows(
    request: Request, layout: RowLayout, wanted: Sequence[int]
) -> tuple[Array, int, tuple[str, ...]]:
    """Some columns of a file (k, n), every row checked; how many rows lack a value, and notes."""
    columns = sorted({0, *(place % layout.width for place in wanted)})
    found: list[Array] = []
    problems: list[Problem] = []
    notes: list[str] = []
    dropped, line = 0, layout.first_line
    for block in _blocks(request, layout, notes):
        values = _fast(block, layout, columns)
        if values is None:
            values, lost, faults = _careful(block, line, layout, columns, request)
            dropped += lost
            problems += faults
            if len(problems) > LISTED:
                break
        found.append(values)
        line += _count(block, b"\n")
    if problems:
        raise request.error(*abridged(problems, request))
    table = np.concatenate(found, axis=1) if found else np.empty((len(columns), 0))
    if layout.local:
        table = _paired(table, notes, request)
        columns = [*columns, *(place + layout.width for place in columns)]
    step = 2 if layout.local else 1
    first = None if dropped else layout.first_line
    _check_times(table[0], first, step, request)
    return table[[columns.index(place) for place in wanted]], dropped, tuple(notes)


def _blocks(request: Request, layout: RowLayout, notes: list[str]) -> Iterator[bytes]:
    """The rows in blocks of whole lines; a last row that is cut off is left out and noted."""
    rest = b""
    try:
        with request.path.open("rb") as stream:
            stream.seek(layout.start)
            while data := stream.read(BLOCK):
                data = rest + data
                cut = data.rstrip(_ENDS).rfind(b"\n") + 1
                if cut:
                    yield data[:cut]
                rest = data[cut:]
                if len(rest) > BLOCK:
                    raise request.error("a line has no end: the file is damaged.")
    except OSError as error:
        raise request.unreadable(error) from error
    last = rest.rstrip(_ENDS)
    if not last:
        return
    ended = b"\n" in rest[len(last) :]
    whole = (len(_fields(last)), last.count(b"("), last.count(b")")) == (
        layout.width,
        layout.brackets,
        layout.brackets,
    )
    short = len(_fields(last)) < layout.width
    if short or not (ended or (whole and layout.brackets)):
        notes.append(f"{request.shown}: the last row is cut off and was left out")
    else:
        yield last + b"\n"


def _count(data: bytes, sign: bytes) -> int:
    """How often a byte occurs; four times as fast as ``bytes.count``."""
    return int(np.count_nonzero(np.frombuffer(data, dtype=np.uint8) == ord(sign)))


def _fields(line: bytes) -> list[bytes]:
    return line.translate(_BRACKETS).split()


def _fast(block: bytes, layout: RowLayout, columns: Sequence[int]) -> Array | None:
    """The columns of a block, or None where anything is not as it should be."""
    import pandas as pd

    count = _count(block, b"\n")
    brackets = count * layout.brackets
    if _count(block, b"(") != brackets or _count(block, b")") != brackets:
        return None
    text = block.translate(_BRACKETS) if brackets else block.translate(_BLANKS)
    code = np.frombuffer(text, dtype=np.uint8)
    gap = code <= 32
    if np.count_nonzero(gap[1:] > gap[:-1]) != count * layout.width:
        return None
    last = layout.width - 1
    used = sorted({*columns, last})
    try:
        table = pd.read_csv(
            io.BytesIO(text),
            header=None,
            usecols=used,
            dtype=np.float64,
            quoting=csv.QUOTE_NONE,
            sep=" ",
            skipinitialspace=True,
            low_memory=False,
        )
    except (ValueError, OverflowError):
        return None
    if len(table) != count:
        return None
    values = np.stack([table[place].to_numpy() for place in used])
    if not float(np.abs(values).max()) <= ABSURD:
        return None
    return values if last in columns else values[:-1]


def _careful(
    block: bytes, first: int, layout: RowLayout, columns: Sequence[int], request: Request
) -> tuple[Array, int, list[Problem]]:
    """Every line taken apart on its own."""
    rows: list[tuple[str, ...]] = []
    lines: list[int] = []
    problems: list[Problem] = []
    for line, raw in enumerate(block[:-1].split(b"\n"), start=first):
        fields = tuple(field.decode("utf-8", "replace") for field in _fields(raw))
        why = _misshapen(raw, len(fields), layout)
        if why is not None:
            problems.append(request.problem(why, row=line))
        else:
            rows.append(fields)
            lines.append(line)
    cells = Cells(
        headers=tuple(map(layout.title, range(layout.width))),
        rows=tuple(rows),
        lines=tuple(lines),
        problems=tuple(problems),
    )
    table, dropped, found = cells.numbers(columns, request)
    return table.T, dropped, found


def _misshapen(raw: bytes, count: int, layout: RowLayout) -> str | None:
    if not raw.strip():
        return "the line is empty."
    if b"\0" in raw:
        return "there are zero bytes: the file is damaged."
    if count != layout.width:
        few = "few" if count < layout.width else "many"
        return f"{count} numbers, too {few}: by the header there are {layout.width}."
    if (raw.count(b"("), raw.count(b")")) != (layout.brackets, layout.brackets):
        return f"the brackets do not match: there should be {layout.brackets} pairs."
    return None


def _paired(table: Array, notes: list[str], request: Request) -> Array:
    """Each time's two rows side by side; a last time without its second row is left out."""
    if table.shape[1] % 2:
        notes.append(f"{request.shown}: the last time lacks its local row and was left out")
        table = table[:, :-1]
    ours, theirs = table[:, ::2], table[:, 1::2]
    apart = np.flatnonzero(ours[0] != theirs[0])
    if len(apart):
        raise request.error(
            f"by the header each time has two rows, the second in local axes; the "
            f"{int(apart[0]) + 1}. pair has the times {ours[0][apart[0]]:.10g} and "
            f"{theirs[0][apart[0]]:.10g}."
        )
    return np.concatenate([ours, theirs])


def _check_times(times: Array, first: int | None, step: int, request: Request) -> None:
    """Refuse times that do not rise; rows begin in line `first`, `step` lines for each time."""
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        raise request.error(
            *abridged(
                [
                    request.problem(
                        f"the time does not rise: {times[place + 1]:.10g} follows "
                        f"{times[place]:.10g}.",
                        row=None if first is None else first + step * (place + 1),
                        remedy="A computation that was started again has a folder of its own for "
                        "each start; files that were joined by hand must be taken apart.",
                    )
                    for place in back[: 10 * LISTED].tolist()
                ],
                request,
            )
        )
