"""Which files of a case are meant: a file, a start-time folder, a function object, a case.

A solver writes ``postProcessing/<function object>/<start time>/<name>.dat``; each start of the
computation makes a folder of its own, and a file ``<name>_<time>.dat`` where there is one already.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pmmkit.base import Problem
from pmmkit.readers.base import Request
from pmmkit.readers.openfoam.header import LONGEST, Kind, RowLayout, layout_of

RESULTS: Final = "postProcessing"
_PREFERRED: Final[tuple[tuple[Kind, ...], ...]] = (
    ("forces",),
    ("force", "moment"),
    ("coefficients",),
    ("motion",),
)
_COMPETING: Final[tuple[frozenset[Kind], ...]] = (
    frozenset({"forces", "force", "moment"}),
    frozenset({"coefficients"}),
    frozenset({"motion"}),
)
_TIME: Final = re.compile(r"-?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?")
_AGAIN: Final = re.compile(rf"(?P<name>.+)_(?P<time>{_TIME.pattern})")
_OTHER_HALF: Final = {"force": "moment", "moment": "force"}


@dataclass(frozen=True, kw_only=True)
class RestartPart:
    """What one start of the computation wrote into one file.

    `start`: time from which it was written, -inf where neither folder nor file say [s].
    """

    request: Request
    layout: RowLayout
    start: float


@dataclass(frozen=True, kw_only=True)
class FileSeries:
    """The files that hold one history.

    `families`: one family, or two where forces and moments have files of their own; of each the
    parts in the order in which they were computed. `notes`: files that hold nothing.
    """

    families: tuple[tuple[RestartPart, ...], ...]
    notes: tuple[str, ...] = ()

    @property
    def parts(self) -> list[RestartPart]:
        """All files."""
        return [part for family in self.families for part in family]


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is one of OpenFOAM's, or a folder holds its results."""
    if head:
        return layout_of(head) is not None
    try:
        if not path.is_dir():
            return False
        if (path / RESULTS).is_dir() or path.name == RESULTS:
            return True
        for pattern in ("*.dat", "[0-9]*/*.dat"):
            for file in path.glob(pattern):
                with file.open("rb") as stream:
                    if layout_of(stream.read(LONGEST)) is not None:
                        return True
    except OSError:
        return False
    return False


def series_of(request: Request) -> FileSeries:
    """The files that a request means."""
    path = request.path
    try:
        if not path.is_dir():
            return _of_file(request)
        results = path if path.name == RESULTS else path / RESULTS
        if results.is_dir():
            return series_of(_only_object(request, results))
        starts = [folder for folder in _folders(path) if _time(folder.name) is not None]
        return _of_folders(request, starts or [path])
    except OSError as error:
        raise request.unreadable(error) from error


def _of_file(request: Request) -> FileSeries:
    """A file, and the moments beside the forces."""
    layout = read_layout(request)
    if layout is None:
        raise request.error(_not_known(request, request.path))
    families = [[_part(request, layout)]]
    other = _OTHER_HALF.get(layout.kind)
    if other is not None:
        name = request.path.name.replace(layout.kind, other, 1)
        beside = request.inside(request.path.with_name(name))
        half = read_layout(beside) if name != request.path.name and beside.path.is_file() else None
        if half is not None and half.kind == other:
            families.append([_part(beside, half)])
    return FileSeries(families=tuple(map(tuple, families)))


def _of_folders(request: Request, starts: Sequence[Path]) -> FileSeries:
    """Every start of a function object."""
    parts: list[RestartPart] = []
    unknown: list[Path] = []
    for folder in starts:
        for path in sorted(folder.glob("*.dat")):
            one = request.inside(path)
            layout = read_layout(one)
            if layout is None:
                unknown.append(path)
            else:
                parts.append(_part(one, layout))
    kinds = {part.layout.kind for part in parts}
    chosen = next((group for group in _PREFERRED if kinds & set(group)), ())
    if not chosen:
        listed = ", ".join(sorted({path.name for path in unknown})[:8])
        raise request.error(
            "there are no forces, coefficients or motions of OpenFOAM in this folder"
            + (f"; its files {listed} hold something else." if listed else "."),
            remedy="Name a .dat file, a start-time folder, postProcessing/<function object> or "
            "the case.",
        )
    if {"forces"} < kinds & {"forces", "force", "moment"}:
        raise request.error(
            "forces.dat and force.dat are both there: releases of OpenFOAM were mixed.",
            remedy="Name the start-time folder or the file.",
        )
    families = [[part for part in parts if part.layout.kind == kind] for kind in chosen]
    names = {_name(part.request.path) for family in families for part in family}
    notes, problems = [], []
    for path in unknown:
        if _name(path) not in names:
            continue
        one = request.inside(path)
        if path.stat().st_size == 0:
            notes.append(f"{one.shown}: the file is empty (0 bytes)")
        else:
            problems.append(_not_known(one, path))
    problems += _several(request, families)
    if problems:
        raise request.error(*problems)
    return FileSeries(
        families=tuple(tuple(sorted(family, key=_order)) for family in families if family),
        notes=tuple(notes),
    )


def _several(request: Request, families: Iterable[Sequence[RestartPart]]) -> list[Problem]:
    """A problem for each kind of which there are files of several names."""
    problems = []
    for family in families:
        names = sorted({_name(part.request.path) for part in family})
        if len(names) > 1:
            problems.append(
                request.problem(
                    f"there are several files of {family[0].layout.kind}: "
                    f"{', '.join(name + '.dat' for name in names)}.",
                    remedy="Name one of them.",
                )
            )
    return problems


def _only_object(request: Request, results: Path) -> Request:
    """The only function object of a case that writes forces (else coefficients, else motions)."""
    found: dict[str, set[Kind]] = {}
    for folder in _folders(results):
        starts = [start for start in _folders(folder) if _time(start.name) is not None]
        kinds = {
            layout.kind
            for start in starts
            for path in start.glob("*.dat")
            if (layout := read_layout(request.inside(path))) is not None
        }
        if kinds:
            found[folder.name] = kinds
    for group in _COMPETING:
        names = [name for name, kinds in found.items() if kinds & group]
        if len(names) == 1:
            return request.inside(results / names[0])
        if names:
            raise request.error(
                f"the case has several function objects: {', '.join(names)}.",
                remedy=f'Name one: file = "{request.inside(results / names[0]).shown}".',
            )
    others = ", ".join(folder.name for folder in _folders(results)) or "nothing"
    raise request.error(
        f"{RESULTS} holds no forces, coefficients or motions of OpenFOAM; it has {others}."
    )


def read_layout(request: Request) -> RowLayout | None:
    """The layout of a file, None if it is not one of OpenFOAM."""
    return layout_of(request.read(LONGEST))


def _part(request: Request, layout: RowLayout) -> RestartPart:
    again = _opened_again(request.path)
    start = _time(request.path.parent.name) if again is None else again[1]
    return RestartPart(request=request, layout=layout, start=-math.inf if start is None else start)


def _order(part: RestartPart) -> tuple[float, float]:
    """Starts by time; a file that was opened again after the one that was there."""
    folder = _time(part.request.path.parent.name)
    again = _opened_again(part.request.path)
    return -math.inf if folder is None else folder, -math.inf if again is None else again[1]


def _name(path: Path) -> str:
    again = _opened_again(path)
    return path.stem if again is None else again[0]


def _opened_again(path: Path) -> tuple[str, float] | None:
    """Name and time of ``forces_5.dat`` beside ``forces.dat``; None for a file of its own."""
    found = _AGAIN.fullmatch(path.stem)
    if found is None or not path.with_name(found["name"] + path.suffix).is_file():
        return None
    return found["name"], float(found["time"])


def _time(name: str) -> float | None:
    """The start time that a folder is named by, None if it is another folder."""
    return float(name) if _TIME.fullmatch(name) else None


def _folders(path: Path) -> list[Path]:
    return sorted(folder for folder in path.iterdir() if folder.is_dir())


def _not_known(request: Request, path: Path) -> Problem:
    size = path.stat().st_size
    if size == 0:
        return request.problem("the file is empty (0 bytes).")
    return request.problem(
        "the header is not one of OpenFOAM's forces, coefficients or rigid body motions: there is "
        "no line '# Time' with names that are known.",
        remedy="Copy the file again, its header lines (#) included.",
    )
