"""The hull in sections, and its hydrostatics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.files import atomic_path, write_text
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section
from pmmkit.seakeeping.lengthwise import Complex

FACET: Final = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""A triangle of a binary STL."""
FEWEST: Final = 11
"""Stations that a hull needs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Station:
    """One section of a hull that is the same on both sides.

    `x`: forward of midship [m]. `y, z`: half breadths and heights above the base line [m], from
    the keel upward.
    """

    x: float
    y: Array
    z: Array

    def contour(self, draught: float) -> Complex:
        """w = (depth) + i (half breadth) [m] from the middle of the keel to the water."""
        under = int(np.searchsorted(np.maximum.accumulate(self.z), draught))
        y, z = self.y[:under], self.z[:under]
        if under < self.z.size:
            share = (draught - z[-1]) / (self.z[under] - z[-1])
            y = np.r_[y, y[-1] + share * (self.y[under] - y[-1])]
            z = np.r_[z, draught]
        if y[0] > 0.0:
            y, z = np.r_[0.0, y], np.r_[z[0], z]
        return np.asarray(draught - z + 1j * y)

    def problems(self, draught: float) -> list[str]:
        """What is wrong with the offsets, said of one station or of several."""
        if self.y.shape != self.z.shape or self.y.ndim != 1 or self.y.size < 2:
            return ["as many half breadths as heights are needed, two or more."]
        if not (np.isfinite(self.y).all() and np.isfinite(self.z).all() and math.isfinite(self.x)):
            return ["numbers are not finite."]
        found = []
        if (self.y < 0.0).any():
            found.append("half breadths lie below zero.")
        if (np.diff(self.z) < 0.0).any():
            found.append(
                "the section goes down again: give heights from the keel upward (a tunnel or a "
                "section of two parts is beyond this description)."
            )
        if self.z[-1] < draught - 1e-9:
            found.append(f"the section ends {draught - self.z[-1]:.3g} m below the water.")
        elif self.z[0] >= draught:
            found.append("the section lies above the water: leave it out.")
        elif not found and self.contour(draught)[-1].imag <= 0.0:
            found.append(
                "the section is closed below the water: only sections that reach it count."
            )
        return found


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Hull(Described):
    """A hull in sections, on even keel.

    Parameters
    ----------
    name : str
        For reports.
    L : float
        Length between perpendiculars [m].
    draught : float
        Of the base line [m].
    stations : tuple of Station
        From aft to forward, 11 or more; below the water they are the hull.
    notes : tuple of str
        Warnings: what the sections cost that are not the ship's own.

    Raises
    ------
    DataError
        With everything that is wrong.
    """

    name: str
    L: float
    draught: float
    stations: tuple[Station, ...]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        wrong: dict[str, list[float]] = {}
        for station in self.stations:
            for text in station.problems(self.draught):
                wrong.setdefault(text, []).append(station.x)
        found = [f"{_places(x)}: {text}" for text, x in wrong.items()]
        if len(self.stations) < FEWEST:
            found.append(f"{len(self.stations)} stations are given; {FEWEST} or more are needed.")
        if (np.diff(self.x) <= 0.0).any():
            found.append("Stations must stand from aft to forward, each at a place of its own.")
        if not (self.L > 0.0 and self.draught > 0.0):
            found.append(f"L = {self.L:g} m and draught = {self.draught:g} m must be positive.")
        found = found or self._out_of_shape()
        if found:
            raise DataError([Problem(message=text) for text in found], title=f"Hull {self.name}")

    def _out_of_shape(self) -> list[str]:
        """What no floating body is: frames, units and whole breadths in place of half ones."""
        L, d, aft, fore = self.L, self.draught, float(self.x[0]), float(self.x[-1])
        breadth, where = float(self.breadths.max()), f"from x = {aft:g} to {fore:g} m"
        found = []
        if not 0.5 < (fore - aft) / L < 1.5:
            found.append(
                f"Stations stand {where}, of a ship of L = {L:g} m: are both in metres, from aft "
                "to forward?"
            )
        elif abs(fore + aft) > 0.4 * L:
            end = "aft" if fore + aft > 0.0 else "forward"
            found.append(
                f"Stations stand {where}, of a ship of L = {L:g} m: x counts from midship, and "
                f"here as if from the {end} perpendicular. "
                f"{'Subtract' if end == 'aft' else 'Add'} {L / 2:g} m."
            )
        if not 0.7 < L / breadth < 30:
            found.append(
                f"The breadth at the water is {breadth:g} m, of a ship of L = {L:g} m: are half "
                "breadths in metres?"
            )
        if not 0.5 < breadth / d < 100:
            found.append(
                f"The breadth at the water is {breadth:g} m at a draught of {d:g} m: are heights "
                "above the base line, and the draught, in metres?"
            )
        return found

    @property
    def in_words(self) -> str:
        """Its particulars in a line, by which a wrong frame, unit or order is seen.

        Examples
        --------
        >>> from pmmkit.seakeeping.hull_forms.particulars import load_hull
        >>> print(load_hull("s175-design").in_words)
        L 175 m, B 25.4 m, T 9.5 m (L/B 6.89, B/T 2.67), stations from x = -86.6 to 86.6 m; \
24052 m³, CB 0.570, LCB -2.63 m, LCF -6.91 m from midship, KM 10.5 m.
        """
        found, breadth = self.hydrostatics, float(self.breadths.max())
        return (
            f"L {self.L:.4g} m, B {breadth:.3g} m, T {self.draught:.3g} m (L/B "
            f"{self.L / breadth:.2f}, B/T {breadth / self.draught:.2f}), stations from x = "
            f"{self.x[0]:.3g} to {self.x[-1]:.3g} m; {_volume(found.volume)} m³, CB "
            f"{found.volume / (self.L * breadth * self.draught):.3f}, LCB {found.xB:z.2f} m, LCF "
            f"{found.xF:z.2f} m from midship, KM {found.KM:.3g} m."
        )

    @cached_property
    def x(self) -> Array:
        """Places of the stations forward of midship [m]."""
        return np.array([station.x for station in self.stations])

    @cached_property
    def contours(self) -> tuple[Complex, ...]:
        """Half sections below the water, w = (depth) + i (half breadth) [m]."""
        return tuple(station.contour(self.draught) for station in self.stations)

    @cached_property
    def breadths(self) -> Array:
        """Breadths at the water [m]."""
        return np.array([2 * contour[-1].imag for contour in self.contours])

    @cached_property
    def draughts(self) -> Array:
        """Depths of the sections below the water [m]."""
        return np.array([contour.real.max() for contour in self.contours])

    @cached_property
    def areas(self) -> Array:
        """Areas of the sections below the water [m²]."""
        return np.array([-2 * np.trapezoid(w.imag, w.real) for w in self.contours])

    @cached_property
    def hydrostatics(self) -> Hydrostatics:
        """Volume, centres and second moments."""
        return _hydrostatics(self)

    def panels(self, across: int = 12) -> Array:
        """Port half below the water in panels between the stations, with flat ends.

        Parameters
        ----------
        across : int
            Panels from the keel to the water.

        Returns
        -------
        array, shape (panels, 4, 3)
            Corners [m], x forward of midship, y to port, z up from the water, in turn as seen from
            the water around. Those of which two corners are one are triangles.

        Examples
        --------
        >>> from pmmkit.seakeeping.hull_forms.particulars import load_hull
        >>> load_hull("s175-design").panels().shape[1:]
        (4, 3)
        """
        sections = []
        for x, contour in zip(self.x, self.contours, strict=True):
            along = np.r_[0.0, np.cumsum(np.abs(np.diff(contour)))]
            places = np.linspace(0.0, along[-1], across + 1)
            depth, half = (np.interp(places, along, part) for part in (contour.real, contour.imag))
            sections.append(np.column_stack([np.full(across + 1, x), half, -depth]))
        aft, fore = sections[0], sections[-1]
        middle = np.array([1.0, 0.0, 1.0])
        # the ends lie between the middle line and the section
        strips = [(middle * aft, aft), *pairwise(sections), (fore, middle * fore)]
        corners = [
            np.stack([first[:-1], first[1:], second[1:], second[:-1]], axis=1)
            for first, second in strips
        ]
        found = np.concatenate(corners)
        diagonals = found[:, 2] - found[:, 0], found[:, 3] - found[:, 1]
        whole = np.linalg.norm(np.cross(*diagonals), axis=1) > 1e-12 * self.L**2
        return np.asarray(found[whole])

    def write(self, path: str | Path) -> None:
        """Write the hull below the water as a mesh that other programs and `read_hull` read.

        Parameters
        ----------
        path : path
            ``.gdf`` of WAMIT (port half, metres, 9.81 m/s²) or ``.stl`` (both halves).

        Raises
        ------
        DataError
            If it is of another kind.
        """
        path, panels = Path(path), self.panels()
        if path.suffix.lower() == ".gdf":
            head = f"{self.name}\n1.0 9.81\n0 1\n{len(panels)}\n"
            rows = (" ".join(f"{number:.6f}" for number in row) for row in panels.reshape(-1, 12))
            write_text(path, head + "\n".join(rows) + "\n")
        elif path.suffix.lower() == ".stl":
            sides = np.concatenate([panels, panels[:, ::-1] * np.array([1.0, -1.0, 1.0])])
            facets = np.concatenate([sides[:, [0, 1, 2]], sides[:, [0, 2, 3]]])
            normal = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
            size = np.linalg.norm(normal, axis=1)
            facets, normal = facets[size > 0.0], (normal / np.maximum(size, 1e-300)[:, None])
            content = np.zeros(len(facets), FACET)
            content["normal"], content["corners"] = normal[size > 0.0], facets
            title = self.name.encode("ascii", "replace")[:79].ljust(80)
            with atomic_path(path) as part:
                part.write_bytes(title + len(facets).to_bytes(4, "little") + content.tobytes())
        else:
            raise DataError(f"{path.name}: hulls are written as .gdf and .stl.")

    def _headline(self) -> str:
        return (
            f"{self.name}: L {self.L:.4g} m, draught {self.draught:.4g} m, "
            f"{len(self.stations)} stations, volume {_volume(self.hydrostatics.volume)} m³"
        )

    def _sections(self) -> Sequence[Section]:
        found = self.hydrostatics
        breadth = float(self.breadths.max())
        rows = [
            ("breadth [m]", f"{breadth:.2f}"),
            ("volume [m³]", f"{found.volume:.0f}"),
            ("block coefficient", f"{found.volume / (self.L * breadth * self.draught):.3f}"),
            ("centre of buoyancy forward of midship [m]", f"{found.xB:.2f}"),
            ("centre of buoyancy above the base line [m]", f"{found.KB:.2f}"),
            ("area of the waterplane [m²]", f"{found.waterplane:.0f}"),
            ("its coefficient", f"{found.waterplane / (self.L * breadth):.3f}"),
            ("its centre forward of midship [m]", f"{found.xF:.2f}"),
            ("metacentre above the base line [m]", f"{found.KM:.2f}"),
        ]
        return [
            Section(tables=[Grid(head=["", "value"], groups=[Group(rows=rows)])]),
            *([Section(title="Notes", points=self.notes)] if self.notes else []),
        ]


def _volume(size: float) -> str:
    """To five digits, or to the cubic metre."""
    return f"{size:.0f}" if size >= 1e5 else f"{size:.5g}"


def _places(x: Sequence[float]) -> str:
    """One station, or several."""
    if len(x) == 1:
        return f"Station x = {x[0]:g} m"
    return f"{len(x)} stations, x = {min(x):g} to {max(x):g} m"


@dataclass(frozen=True, kw_only=True)
class Hydrostatics:
    """What the sections displace.

    `xB, KB`: centre of buoyancy forward of midship and above the base line [m]. `waterplane,
    xF`: area of the waterplane [m²], its centre forward of midship [m]. `across, along`: second
    moments of the waterplane [m⁴] about the middle line, and about midship. `KM`: transverse
    metacentre above the base line [m].
    """

    volume: float
    xB: float
    KB: float
    waterplane: float
    xF: float
    across: float
    along: float
    KM: float


def _hydrostatics(hull: Hull) -> Hydrostatics:
    x, areas, breadths = hull.x, hull.areas, hull.breadths
    depth = np.array([_depth_moment(contour) for contour in hull.contours])
    volume = float(np.trapezoid(areas, x))
    waterplane = float(np.trapezoid(breadths, x))
    across = float(np.trapezoid(breadths**3, x)) / 12
    KB = hull.draught - float(np.trapezoid(depth, x)) / volume
    return Hydrostatics(
        volume=volume,
        xB=float(np.trapezoid(areas * x, x)) / volume,
        KB=KB,
        waterplane=waterplane,
        xF=float(np.trapezoid(breadths * x, x)) / waterplane,
        across=across,
        along=float(np.trapezoid(breadths * x**2, x)),
        KM=KB + across / volume,
    )


def _depth_moment(contour: Complex) -> float:
    """∫ (depth) dA of a whole section of straight pieces [m³]."""
    y, depth = contour.imag, contour.real
    steps = -np.diff(depth)
    mean = (y[:-1] * (2 * depth[:-1] + depth[1:]) + y[1:] * (2 * depth[1:] + depth[:-1])) / 6
    return float(2 * np.sum(mean * steps))
