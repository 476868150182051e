"""Hulls from files: offsets or curves of sections as CSV, and the layout of ShipX and VERES."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.seakeeping.hull_forms.hull import Hull, Station
from pmmkit.seakeeping.hull_forms.meshes import above_base, is_mesh, mesh_stations
from pmmkit.seakeeping.hull_forms.particulars import lewis_station

_POINTS: Final = ("x", "y", "z")
_CURVES: Final = ("x", "breadth", "draught", "area")
_SAID: Final = (
    "the first line must name x,y,z (forward of midship, half breadth, height above the base line) "
    "or x,breadth,draught,area, all in metres"
)


def read_hull(path: str | Path, *, draught: float, L: float | None = None) -> Hull:
    """A hull from a file.

    Parameters
    ----------
    path : path
        ``.csv`` with columns x, y, z (x forward of midship, half breadth, height above the base
        line or the water, from the keel upward) or x, breadth, draught, area (then Lewis forms);
        ``.mgf`` as ShipX and VERES write it (x aft of midship, from the deck downward); a mesh,
        ``.gdf`` of WAMIT (panels of low order) or ``.stl``, x forward of midship, heights above
        the water or the base line.
    draught : float
        [m].
    L : float, optional
        Length between perpendiculars [m]; needed for CSV; that of the mesh where absent.

    Returns
    -------
    Hull

    Raises
    ------
    DataError
        With the place of everything that is wrong.
    """
    path = Path(path)
    if is_mesh(path):
        cut, length = mesh_stations(path, draught)
        found = _hull(path.stem, L or length, draught, cut)
        own = f"L, {length:.4g} m, is the length of the mesh between its ends."
        return replace(found, notes=(*found.notes, *([] if L else [own])))
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(Problem(message=f"cannot be read: {error}", file=str(path))) from error
    if path.suffix.lower() == ".mgf":
        return _from_mgf(text, path, draught)
    if L is None:
        raise DataError(
            Problem(
                message="holds no length between perpendiculars",
                file=str(path),
                remedy="Give L [m].",
            )
        )
    return _from_csv(text, path, draught, L)


def _from_csv(text: str, path: Path, draught: float, L: float) -> Hull:
    rows = [row for row in csv.reader(text.splitlines()) if row and not row[0].startswith("#")]
    head = tuple(cell.strip().lower() for cell in rows[0]) if rows else ()
    if head not in (_POINTS, _CURVES):
        raise DataError(Problem(message=_SAID, file=str(path), row=1))
    problems: list[Problem] = []
    numbers = [
        _numbers(row, len(head), path, line, problems) for line, row in enumerate(rows[1:], start=2)
    ]
    if problems:
        raise DataError(problems, title="Not read")
    if head == _CURVES:
        stations = [lewis_station(x, b, T, area, draught) for x, b, T, area in sorted(numbers)]
    else:
        up = above_base(min((row[2] for row in numbers), default=0.0), draught, path)
        numbers = [[x, y, z + up] for x, y, z in numbers]
        stations = [
            Station(x=x, y=np.array([r[1] for r in part]), z=np.array([r[2] for r in part]))
            for x, part in ((x, list(rows)) for x, rows in groupby(numbers, key=lambda r: r[0]))
        ]
    return _hull(path.stem, L, draught, stations)


def _numbers(
    row: list[str], count: int, path: Path, line: int, problems: list[Problem]
) -> list[float]:
    try:
        found = [float(cell) for cell in row]
    except ValueError:
        found = []
    if len(found) != count or not all(map(math.isfinite, found)):
        problems.append(
            Problem(message=f"needs {count} finite numbers: {row!r:.60}", file=str(path), row=line)
        )
    return found


STEP: Final = 5e-4
"""Part of the draught by which heights may step down: the keel of ShipX's own supply ship does by
2e-4."""


LEADING: Final = 0.005
"""Part of the length by which the centre of the waterplane may lie before that of buoyancy; in the
S175 and a tanker of 320 m it lies 2.4 and 3.3 % aft of it."""


NECK: Final = 0.02
"""Part of its breadth by which a section that is closed below the water reaches it: its volume
stays, and hardly any waterplane is added."""


def _necked(station: Station, draught: float) -> Station:
    """A section that is closed below the water, under a neck; others as they are."""
    y, z = station.y, station.z
    wide = np.flatnonzero(y > 0.0)
    top = int(wide[-1]) + 1 if wide.size else y.size
    if top >= y.size or z[top] >= draught:
        return station
    neck = NECK * float(y.max())
    return replace(station, y=np.r_[y[:top], neck, neck], z=np.r_[z[: top + 1], draught])


def _hull(name: str, L: float, draught: float, given: Iterable[Station]) -> Hull:
    """A hull of stations as a file has them: from aft, without those above the water, and without
    steps that are the rounding of a drawing."""
    stations: list[Station] = []
    dry: list[Station] = []
    for station in sorted(given, key=lambda one: one.x):
        level = np.maximum.accumulate(station.z)
        if station.z.size and (level - station.z).max() <= STEP * draught:
            station = replace(station, z=level)
        (dry if station.z.size and station.z.min() >= draught else stations).append(station)
    above = ", ".join(f"{station.x:.4g}" for station in dry)
    notes = [f"Stations above the water are left out: x = {above} m."] if dry else []
    necked = [_necked(station, draught) for station in stations]
    bulbs = [new.x for new, old in zip(necked, stations, strict=True) if new is not old]
    if 0 < len(bulbs) < len(stations) / 2:
        stations = necked
        notes.append(
            "Sections that are closed below the water keep their volume under a narrow neck: "
            f"x = {', '.join(f'{x:.4g}' for x in bulbs)} m."
        )
    hull = Hull(name=name, L=L, draught=draught, stations=tuple(stations))
    if (ahead := hull.hydrostatics.xF - hull.hydrostatics.xB) > LEADING * L:
        notes.append(
            f"The centre of the waterplane lies {ahead:.3g} m forward of that of buoyancy; ships "
            "have it aft. If x counts positive aft here, following seas are told as head seas."
        )
    return replace(hull, notes=tuple(notes)) if notes else hull


def _from_mgf(text: str, path: Path, draught: float) -> Hull:
    """Four lines of words, the length, then each section: number, place, count, points."""
    lines = text.splitlines()
    place = 4

    def take(count: int) -> list[float]:
        nonlocal place
        while place < len(lines) and not lines[place].strip():
            place += 1
        cells = lines[place].split() if place < len(lines) else []
        try:
            found = [float(cell) for cell in cells]
        except ValueError:
            found = []
        if len(found) != count or not all(map(math.isfinite, found)):
            raise DataError(
                Problem(
                    message=f"needs {count} finite numbers here: {' '.join(cells)!r:.60}",
                    file=str(path),
                    row=place + 1,
                )
            )
        place += 1
        return found

    (L,) = take(1)
    stations = []
    while any(line.strip() for line in lines[place:]):
        take(1)
        (aft,), (count,) = take(1), take(1)
        points = np.array([take(2) for _ in range(int(count))]).reshape(-1, 2)[::-1]
        stations.append(Station(x=-aft, y=points[:, 0], z=points[:, 1]))
    name = lines[0].strip() or path.stem
    return _hull(name, L, draught, stations)
