"""What ``system/controlDict`` says of a function object: read as text, nothing is executed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from pmmkit.readers.openfoam.places import RESULTS, FileSeries

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
