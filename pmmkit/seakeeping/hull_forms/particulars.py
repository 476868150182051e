"""Hulls from particulars alone: Lewis forms under assumed curves of area and breadth."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError, Problem, UnknownNameError, did_you_mean
from pmmkit.conventions import Ship
from pmmkit.files import datasets_folder, read_toml
from pmmkit.models import load_ship, number, ships
from pmmkit.numerics import Array
from pmmkit.seakeeping.hull_forms.hull import Hull, Station
from pmmkit.seakeeping.lengthwise import Complex
from pmmkit.seakeeping.mapping import at, lewis, lewis_area_range

STATIONS: Final = 41
_ENDS: Final = 0.99  # the last stations over half the length: at 1 nothing is left of the curves
_POINTS: Final = 61


def lewis_station(x: float, breadth: float, depth: float, area: float, draught: float) -> Station:
    """The station with the Lewis form or round bilge of a breadth, a depth [m] and an area [m²]."""
    shape = at(lewis(breadth, depth, area), np.linspace(0.0, 0.5 * math.pi, _POINTS))
    bulges = (np.diff(shape.imag) < -1e-9).any() or (np.diff(shape.real) > 1e-9).any()
    radius = math.sqrt(max(breadth * depth - area, 0.0) / (2 - 0.5 * math.pi))
    if bulges and radius < min(0.5 * breadth, depth):
        shape = _with_bilge(0.5 * breadth, depth, radius)
    y = np.maximum(shape.imag, 0.0)
    z = np.maximum.accumulate(draught - shape.real)
    y[0], z[-1] = 0.0, draught
    return Station(x=x, y=y, z=z)


def _with_bilge(half: float, depth: float, radius: float) -> Complex:
    """A flat bottom and a straight side joined by a quarter of a circle, as `at` gives points.

    It stands for full sections, whose Lewis forms bulge beyond breadth and draught.
    """
    turn = np.linspace(0.0, 0.5 * math.pi, _POINTS)
    bilge = depth - radius + radius * np.cos(turn) + 1j * (half - radius + radius * np.sin(turn))
    return np.concatenate([[depth + 0j], bilge, [1j * half]])


def hull_from_particulars(
    *,
    name: str,
    L: float,
    B: float,
    d: float,
    block: float,
    waterplane: float | None = None,
    midship: float | None = None,
    xB: float = 0.0,
    xF: float | None = None,
) -> Hull:
    """A hull of Lewis forms with the particulars of a ship whose lines are not known.

    Area and breadth fall from midship to both ends as ``1 - |2x/L|ⁿ``, with an exponent forward
    and one aft from the coefficient and the centre of each curve. The keel is level.

    Parameters
    ----------
    name : str
        For reports.
    L, B, d : float
        Length between perpendiculars, breadth, draught [m].
    block : float
        Block coefficient [-].
    waterplane, midship : float, optional
        Coefficients of the waterplane and of the midship section [-]; where absent,
        0.18 + 0.86 CB/CM and 1.006 - 0.0056 CB⁻³·⁵⁶.
    xB, xF : float, optional
        Centres of buoyancy and of the waterplane forward of midship [m]; the second couples heave
        and pitch, and a wrong one spoils both (a note says where it is assumed to be at midship).

    Returns
    -------
    Hull
        With notes that say what is assumed.

    Examples
    --------
    >>> hull = hull_from_particulars(name="box", L=100.0, B=20.0, d=8.0, block=0.75)
    >>> hull
    <Hull box: L 100 m, draught 8 m, 41 stations, volume 11999 m³>
    """
    shown = 1.006 - 0.0056 * block**-3.56 if midship is None else midship
    prismatic = block / shown
    plane = 0.18 + 0.86 * prismatic if waterplane is None else waterplane
    if not (0.3 < block < 0.95 and block < shown <= 1.0 and block < plane < 1.0):
        raise DataError(
            f"Block coefficient {block:g}, midship {shown:.3f} and waterplane {plane:.3f}: both "
            "others must lie between the first, from 0.3 to 0.95, and 1."
        )
    place = _ENDS * np.sin(np.linspace(-0.5 * math.pi, 0.5 * math.pi, STATIONS))
    areas = B * d * shown * _curve(place, prismatic, 2 * xB / L)
    breadths = B * _curve(place, plane, 2 * (xF or 0.0) / L)
    x = 0.5 * L * place
    areas *= block * L * B * d / np.trapezoid(areas, x)  # what is lost at the ends
    fullness, moved, stations = areas / (breadths * d), 0.0, []
    for one, breadth, full in zip(x, breadths, fullness, strict=True):
        low, high = lewis_area_range(breadth, d)
        kept = min(max(full, low + 1e-6), high - 1e-6)
        moved = max(moved, abs(kept - full))
        stations.append(lewis_station(float(one), breadth, d, kept * breadth * d, d))
    notes = [
        "Sections are Lewis forms from the particulars, not the ship's: heave and pitch in waves "
        "longer than the ship are little touched; short waves, roll and added resistance are."
    ]
    if xF is None:
        notes.append(
            "The centre of the waterplane is assumed at midship; most ships have it up to 4 % of "
            "the length aft. It couples heave and pitch: give xF where it is known."
        )
    if moved > 0.01:
        notes.append(
            f"The area coefficient of some sections was moved by up to {moved:.2f} into the range "
            "in which Lewis forms exist."
        )
    return Hull(name=name, L=L, draught=d, stations=tuple(stations), notes=tuple(notes))


def _curve(place: Array, coefficient: float, centre: float) -> Array:
    """1 - |x|ⁿ, with exponents aft and forward that give a mean over -1 to 1 and a centre."""
    from scipy.optimize import brentq

    def halves(shift: float) -> tuple[float, float]:
        fore, aft = coefficient + shift, coefficient - shift
        return fore / (1 - fore), aft / (1 - aft)

    def off(shift: float) -> float:
        fore, aft = halves(shift)
        return 0.25 * (fore / (fore + 2) - aft / (aft + 2)) / coefficient - centre

    room = 0.98 * min(coefficient, 1 - coefficient)
    if off(-room) > 0 or off(room) < 0:
        raise DataError(
            f"A curve of coefficient {coefficient:.3f} has no centre at {centre:+.3f} of half the "
            "length from midship: check xB and xF."
        )
    fore, aft = halves(float(brentq(off, -room, room)))
    return np.asarray(1 - np.abs(place) ** np.where(place > 0, fore, aft))


# Hulls by name: those whose particulars come along, and the ships of the library.


_NEEDED: Final = ("L", "B", "d", "block")
_ALLOWED: Final = ("waterplane", "midship", "xB", "xF")


def hulls() -> list[str]:
    """Names of the hulls whose particulars come along.

    Examples
    --------
    >>> "tanker-320" in hulls()
    True
    """
    return sorted(path.stem for path in (datasets_folder() / "hulls").glob("*.toml"))


def load_hull(name: str | Path) -> Hull:
    """A hull of Lewis forms from particulars that have a name or a file.

    Parameters
    ----------
    name : str or path
        One of `hulls`, a ship of the library, or a file ``.toml`` with name, L, B, d, block and
        perhaps waterplane, midship, xB, xF (see `hull_from_particulars`).

    Returns
    -------
    Hull

    Raises
    ------
    UnknownNameError
        With the names there are.
    DataError
        With everything that is wrong with a file.

    Examples
    --------
    >>> load_hull("tanker-320")
    <Hull tanker-320: L 320 m, draught 20.8 m, 41 stations, volume 312262 m³>
    """
    text = str(name)
    if text.endswith(".toml"):
        return _from_file(Path(name))
    if text in hulls():
        return _from_file(datasets_folder() / "hulls" / f"{text}.toml")
    if text in ships():
        return hull_of(load_ship(text))
    known = sorted({*hulls(), *ships()})
    meant = did_you_mean(text, known) or "."
    raise UnknownNameError(
        f"There is no hull {text!r}{meant} There are {', '.join(known)}; for offsets "
        "of your own write a path with the ending .csv or .mgf."
    )


def hull_of(ship: Ship) -> Hull:
    """A hull of Lewis forms with the particulars of a ship, at its scale."""
    return hull_from_particulars(
        name=ship.name, L=ship.L, B=ship.B, d=ship.d, block=ship.block, xB=ship.xG
    )


def _from_file(path: Path) -> Hull:
    data = read_toml(path)
    problems = [
        Problem(message=f"lacks {key}", file=str(path)) for key in _NEEDED if key not in data
    ]
    given: dict[str, Any] = {"name": str(data.get("name", path.stem))}
    for key, value in data.items():
        if key == "name":
            continue
        if key not in (*_NEEDED, *_ALLOWED):
            message = f"{key} is not known; there are name, {', '.join((*_NEEDED, *_ALLOWED))}"
            problems.append(Problem(message=message, file=str(path)))
        elif number(value) is None:
            problems.append(Problem(message=f"{key} must be a finite number", file=str(path)))
        else:
            given[key] = number(value)
    if problems:
        raise DataError(problems, title="Hull")
    return hull_from_particulars(**given)
