"""What ``constant/dynamicMeshDict`` says of the motion of the mesh: read as text, nothing executed.

Solid body motions of both branches of OpenFOAM (v2306, v10): ``oscillatingLinearMotion`` is
amplitude sin(omega t) in metres, ``oscillatingRotatingMotion`` the same in degrees about the axes,
``linearMotion`` a velocity, ``tabulated6DoFMotion`` a table of times, places and degrees,
``multiMotion`` several of them together. Sources: the classes of these names in
``meshTools``/``dynamicFvMesh`` of either branch.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.readers.openfoam.places import RESULTS, FileSeries

# What ``system/controlDict`` says of a function object: read as text, nothing is executed.


LARGEST: Final = 1 << 20
"""Bytes beyond which a dictionary is not looked at."""

_LISTED: Final = ("CofR", "magUInf", "lRef", "Aref", "dragDir", "sideDir", "liftDir", "pitchAxis")

Dictionary = Mapping[str, object]

_LEFT_OUT: Final = re.compile(
    r'("(?:[^"\\]|\\.)*(?:"|\Z))|//[^\n]*|/\*.*?(?:\*/|\Z)|#\{.*?(?:#\}|\Z)|^[ \t]*#\w[^\n]*',
    re.DOTALL | re.MULTILINE,
)
"""Comments, code and directives; text in quotes stays."""
_TOKEN: Final = re.compile(r'"(?:[^"\\]|\\.)*"|[{};()\[\]]|[^\s{};()\[\]"]+')
_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def entries_of(file: Path) -> Mapping[str, str]:
    """Plain entries of the function object that wrote a file; empty if it is not to be found."""
    case = case_of(file)
    if case is None:
        return {}
    folder = file.absolute().parent.parent
    system = case / "system"
    for name in ("controlDict", "functions", folder.name):
        whole = parsed(text_of(system / name))
        found = _named(whole, folder.name)
        if found is None and name == folder.name and "type" in whole:
            found = whole
        if found is not None:
            return {key: value for key, value in found.items() if isinstance(value, str)}
    return {}


def density_doubt(entries: Mapping[str, str]) -> str | None:
    """Why the forces may be per density, or None.

    Of an incompressible flow (``rho rhoInf``) the pressure is per density and ``rhoInf`` multiplies
    it; where that is 1 or missing, so are the forces.
    """
    if entries.get("rho", entries.get("rhoName")) != "rhoInf":
        return None
    stated = entries.get("rhoInf")
    if stated is not None and number_in(stated) != 1.0:
        return None
    how = "is missing" if stated is None else "is 1"
    return (
        f"the flow is incompressible (rho rhoInf) and rhoInf {how} in controlDict: the forces are "
        "per density unless something else multiplies them"
    )


def density_in(entries: Mapping[str, str]) -> float | None:
    """The density of an incompressible flow that multiplies the forces; None where not stated.

    Examples
    --------
    >>> density_in({"rho": "rhoInf", "rhoInf": "998.8"}), density_in({"rho": "rho"})
    (998.8, None)
    """
    if entries.get("rho", entries.get("rhoName")) != "rhoInf" or "rhoInf" not in entries:
        return None
    density = number_in(entries["rhoInf"])
    return density if density is not None and density > 0 else None


def told(series: FileSeries, entries: Mapping[str, str]) -> list[str]:
    """What headers and controlDict say that a reader of the report should know."""
    stated = {name: entries[name] for name in _LISTED if name in entries}
    stated |= series.parts[0].layout.values
    notes = []
    if "CofR" in stated:
        notes.append(f"moments about CofR {stated['CofR']} of the mesh")
    rest = [f"{name} {stated[name]}" for name in _LISTED[1:] if name in stated]
    if rest:
        notes.append(f"coefficients with {', '.join(rest)}")
    notes += [
        f"controlDict: {name} {entries[name]}" for name in ("rho", "rhoInf") if name in entries
    ]
    starts = len(series.families[0])
    if starts > 1:
        notes.append(f"{starts} starts of the computation joined")
    return notes


def number_in(text: str) -> float | None:
    """The last number of an entry; None where there is none or where it is computed.

    Examples
    --------
    >>> number_in("rhoInf [1 -3 0 0 0 0 0] 998.8"), number_in("$rhoWater")
    (998.8, None)
    """
    words = text.split()
    computed = "$" in text or "#" in text
    return float(words[-1]) if words and not computed and _NUMBER.fullmatch(words[-1]) else None


def parsed(text: str) -> Dictionary:
    """The entries of a dictionary of OpenFOAM, as text, dictionaries in it as mappings.

    Whatever does not fit is passed over: the result is only used for what it happens to say.

    Examples
    --------
    >>> parsed("forces { type forces; CofR (0 0 1); // about\\n rhoInf 998.8; }")
    {'forces': {'type': 'forces', 'CofR': '(0 0 1)', 'rhoInf': '998.8'}}
    """
    top: dict[str, object] = {}
    open_ones = [top]
    words: list[str] = []
    depth = 0
    for token in _TOKEN.findall(_LEFT_OUT.sub(lambda found: found[1] or " ", text)):
        if token in "([":
            depth += 1
        elif token in ")]":
            depth = max(depth - 1, 0)
        if depth == 0 and token == "{":
            inner: dict[str, object] = {}
            if words:
                open_ones[-1][words[0].strip('"')] = inner
            open_ones.append(inner)
            words = []
        elif depth == 0 and token == "}":
            if len(open_ones) > 1:
                open_ones.pop()
            words = []
        elif depth == 0 and token == ";":
            if len(words) > 1:
                text = re.sub(r"(?<=[(\[]) | (?=[)\]])", "", " ".join(words[1:]))
                open_ones[-1][words[0].strip('"')] = text
            words = []
        else:
            words.append(token)
    return top


def _named(whole: Dictionary, name: str) -> Dictionary | None:
    """The dictionary of a name, at the top or under ``functions``."""
    functions = whole.get("functions")
    for place in (functions, whole):
        if isinstance(place, Mapping) and isinstance(found := place.get(name), Mapping):
            return found
    return None


def case_of(file: Path) -> Path | None:
    """The case in which a function object wrote a file, or None."""
    folder = file.absolute().parent.parent
    return folder.parent.parent if folder.parent.name == RESULTS else None


def text_of(path: Path, *, most: int = LARGEST) -> str:
    """The text of a small file, empty if there is none."""
    try:
        if path.is_file() and path.stat().st_size <= most:
            return path.read_bytes().decode("utf-8", "replace")
    except OSError:
        return ""
    return ""


PLACE: Final = "constant/dynamicMeshDict"
_STILL: Final = frozenset({"staticFvMesh", "none"})
_FUNCTION: Final = "solidBodyMotionFunction"
_INCLUDE: Final = re.compile(
    r'^[ \t]*#include(?:IfPresent|Etc|Func)?[ \t]+["<]?([^">\s]+)[">]?[^\n]*', re.MULTILINE
)
_VARIABLE: Final = re.compile(r"\$\{?([A-Za-z_]\w*)\}?")
_TABLE_BYTES: Final = 1 << 24
_CYCLES: Final = 4
_PER_CYCLE: Final = 100
_DEEPEST: Final = 8
"""Files that include each other, beyond which none is followed."""


@dataclass(frozen=True, kw_only=True)
class MeshMotion:
    """How a mesh was told to move.

    `moves`: false where the dictionary says that it stands still. `path`: of the hull along the
    axes of the mesh: ``t`` [s], ``x``, ``y`` [m], ``psi`` [rad]; empty where the dictionary
    does not state it in plain numbers. Of an oscillation four cycles. `notes`: what was not
    followed: computed values, files outside of the case, other kinds of motion.
    """

    moves: bool = True
    path: Mapping[str, Array] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Piece:
    """One solid body motion: a constant velocity or an oscillation, translation and rotation."""

    velocity: float = 0.0
    omega: float = 0.0
    x: float = 0.0
    y: float = 0.0
    psi: float = 0.0


def mesh_motion(case: Path) -> MeshMotion | None:
    """The motion of a case's mesh; None where there is no dictionary of it."""
    text = text_of(case / PLACE)
    if not text:
        return None
    notes: list[str] = []
    whole = parsed(_with_includes(text, case / PLACE, case, notes))
    kind = whole.get("dynamicFvMesh")
    if kind in _STILL:
        return MeshMotion(moves=False)
    found = _with_function(whole)
    if found is None:
        return MeshMotion(notes=(*notes, f"{PLACE}: no solid body motion that is known"))
    table = _table(found, case, notes)
    if table is not None:
        return MeshMotion(path=table, notes=tuple(notes))
    pieces = list(_pieces(found, whole, notes))
    return MeshMotion(path={} if notes else _sampled(pieces, notes), notes=tuple(notes))


def _with_includes(text: str, file: Path, case: Path, notes: list[str], depth: int = 0) -> str:
    """The text with the files of the case that it includes; others are named and not followed."""

    def included(found: re.Match[str]) -> str:
        name = found[1].replace("$FOAM_CASE", str(case)).replace("<case>", str(case))
        other = file.parent / name
        inside = other.resolve().is_relative_to(case.resolve()) and "$" not in name
        if not inside or depth >= _DEEPEST or not (more := text_of(other)):
            notes.append(f"{PLACE}: {found[1]} is not followed")
            return ""
        return _with_includes(more, other, case, notes, depth + 1)

    return _INCLUDE.sub(included, text)


def _with_function(whole: Dictionary) -> Dictionary | None:
    """The dictionary that names a solid body motion: the top, a mover, coefficients of a solver."""
    if isinstance(whole.get(_FUNCTION), str):
        return whole
    for inner in whole.values():
        if isinstance(inner, Mapping) and (found := _with_function(inner)) is not None:
            return found
    return None


def _coefficients(function: Dictionary) -> tuple[str, Dictionary]:
    """Name of a motion and where its numbers stand."""
    name = str(function[_FUNCTION])
    for place in (f"{name}Coeffs", name, "coeffs"):
        if isinstance(inner := function.get(place), Mapping):
            return name, inner
    return name, function


def _pieces(function: Dictionary, whole: Dictionary, notes: list[str]) -> Iterator[_Piece]:
    name, numbers = _coefficients(function)
    if name == "multiMotion":
        for inner in numbers.values():
            if isinstance(inner, Mapping) and _FUNCTION in inner:
                yield from _pieces(inner, whole, notes)
        return
    wanted = {
        "oscillatingLinearMotion": ("amplitude", "omega"),
        "oscillatingRotatingMotion": ("amplitude", "omega"),
        "linearMotion": ("velocity",),
    }.get(name)
    if wanted is None:
        notes.append(f"{PLACE}: {name} is not followed")
        return
    shifted = [key for key in ("phaseShift", "verticalShift") if numbers.get(key)]
    read = {key: _numbers(numbers.get(key), whole) for key in wanted}
    unread = [key for key, values in read.items() if values is None]
    if unread or shifted:
        listed = ", ".join([*unread, *shifted])
        notes.append(f"{PLACE}: {listed} of {name} is no plain number, or is not followed")
        return
    stated = {key: values for key, values in read.items() if values is not None}
    if name == "linearMotion":
        yield _Piece(velocity=stated["velocity"][0])
        return
    size, omega = stated["amplitude"], stated["omega"][0]
    if name == "oscillatingLinearMotion":
        yield _Piece(omega=omega, x=size[0], y=size[1])
    else:
        yield _Piece(omega=omega, psi=math.radians(size[2]))


def _numbers(entry: object, whole: Dictionary) -> tuple[float, ...] | None:
    """Plain numbers of an entry, a vector or one; None where they are computed or missing."""
    if not isinstance(entry, str):
        return None

    def value(found: re.Match[str]) -> str:
        other = whole.get(found[1])
        return other if isinstance(other, str) and "$" not in other else found[0]

    text = _VARIABLE.sub(value, entry)
    if "#" in text or "$" in text:
        return None
    if text.endswith(")"):
        try:
            numbers = tuple(map(float, text[text.rindex("(") + 1 : -1].split()))
        except ValueError:
            return None
        return numbers if len(numbers) == 3 else None
    number = number_in(text)
    return None if number is None else (number,)


def _table(function: Dictionary, case: Path, notes: list[str]) -> Mapping[str, Array] | None:
    """The path of a table of the case; None where the motion is no table that can be read."""
    name, entries = _coefficients(function)
    if name != "tabulated6DoFMotion":
        return None
    stated = str(entries.get("timeDataFileName", "")).strip('"')
    place = stated.replace("$FOAM_CASE", str(case)).replace("<case>", str(case))
    place = place.replace("<constant>", str(case / "constant"))
    file = case / place
    if "$" in place or not file.resolve().is_relative_to(case.resolve()):
        notes.append(f"{PLACE}: {stated} is not followed")
        return {}
    table = motion_table(file)
    if table is None:
        notes.append(f"{PLACE}: {stated} holds no table of times, places and angles")
        return {}
    times, x, y, _, _, _, turned = table
    return {"t": times, "x": x - x[0], "y": y, "psi": np.radians(turned)}


_TABLE: Final = re.compile(rb"\s*(?:\d+\s*)?\(\s*\(\s*[-+.\deE]+\s*\(\s*\([-+.\deE\s]+\)\s*\(")
"""How a table of motions begins: ``(t ((x y z) (rx ry rz)))`` in a list, with its length or not."""
_REMARKS: Final = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


def is_motion_table(head: bytes) -> bool:
    """Whether a file begins as a table of six degrees of freedom does.

    Examples
    --------
    >>> is_motion_table(b"3\\n(\\n(0 ((0 0 0) (0 0 0)))"), is_motion_table(b"3 (1 2 3)")
    (True, False)
    """
    plain = _REMARKS.sub(" ", head.decode("utf-8", "replace")).encode()
    return _TABLE.match(plain) is not None


def motion_table(file: Path) -> Array | None:
    """Times [s], places [m] and angles [deg] of a table of ``tabulated6DoFMotion`` (7, n)."""
    plain = _REMARKS.sub(" ", text_of(file, most=_TABLE_BYTES))
    length, _, rest = plain.partition("(")
    try:
        stated = int(length) if length.strip() else None
        numbers = np.array(rest.translate(str.maketrans("();", "   ")).split(), float)
    except ValueError:
        return None
    rows = len(numbers) // 7
    if len(numbers) != 7 * rows or rows < 3 or stated not in (None, rows):
        return None
    found: Array = numbers.reshape(-1, 7).T
    return found if np.isfinite(found).all() else None


def _sampled(pieces: list[_Piece], notes: list[str]) -> Mapping[str, Array]:
    """Four cycles of the motions together."""
    omegas = {piece.omega for piece in pieces if piece.omega}
    if len(omegas) != 1:
        if omegas:
            notes.append(f"{PLACE}: several frequencies")
        return {}
    omega = omegas.pop()
    t = np.arange(_CYCLES * _PER_CYCLE + 1) * (2 * math.pi / abs(omega) / _PER_CYCLE)
    wave = np.sin(omega * t)
    total = {name: sum(getattr(piece, name) for piece in pieces) for name in ("x", "y", "psi")}
    along = sum(piece.velocity for piece in pieces) * t
    return {
        "t": t,
        "x": along + total["x"] * wave,
        "y": total["y"] * wave,
        "psi": total["psi"] * wave,
    }
