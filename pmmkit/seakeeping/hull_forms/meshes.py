"""Hulls from meshes: panels of WAMIT (.gdf) and triangles (.stl), cut into stations."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.numerics import Array
from pmmkit.seakeeping.hull_forms.hull import FACET, Station

STATIONS: Final = 41
"""Cuts of a mesh: of an S175 in 24 stations hydrostatics differ by less than .5 % from there on."""
ENDS: Final = 0.01
"""Part of the length by which the outermost cuts stand inside of a mesh."""
SAME: Final = 1e-6
"""Part of the length by which heights may differ that are one."""
CLOSED: Final = 0.02
"""Part of the draught by which a section may end below the water that reaches it: meshes of panels
leave so much to a sheer of the waterline."""


def is_mesh(path: Path) -> bool:
    """Whether a file is a mesh, by its name."""
    return path.suffix.lower() in (".gdf", ".stl")


def above_base(lowest: float, draught: float, path: Path) -> float:
    """What heights of a file need to count from the base line [m]: they may count from the water.

    A DataError is raised where the keel is at neither.
    """
    if abs(lowest + draught) < 0.1 * draught:
        return draught
    if abs(lowest) > 0.1 * draught:
        raise DataError(
            Problem(
                message=f"reaches down to z = {lowest:g} m, at a draught of {draught:g} m",
                file=str(path),
                remedy="Let z count from the water (the keel at minus the draught) or from the "
                "base line (the keel at zero), upward, in metres.",
            )
        )
    return 0.0


def mesh_stations(path: Path, draught: float) -> tuple[list[Station], float]:
    """Stations of a mesh, from aft to forward, and its length [m].

    Heights count from the water (keel at -draught) or from the base line (keel at zero).
    """
    triangles = _gdf(path) if path.suffix.lower() == ".gdf" else _stl(path)
    if not len(triangles) or not np.isfinite(triangles).all():
        raise DataError(Problem(message="holds no panels of finite numbers", file=str(path)))
    x, z = triangles[..., 0], triangles[..., 2]
    length, lowest = float(np.ptp(x)), float(z.min())
    triangles = triangles + np.array([0.0, 0.0, above_base(lowest, draught, path)])
    # one side: a half mesh may be that of port or of starboard
    side = triangles[..., 1].mean(axis=1)
    half = triangles[side >= 0.0] if (side > 0.0).sum() >= (side < 0.0).sum() else None
    if half is None:
        half = triangles[side <= 0.0] * np.array([1.0, -1.0, 1.0])
    share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, STATIONS))
    places = float(x.min()) + length * (ENDS + (1.0 - 2.0 * ENDS) * share)
    stations = []
    for place in places.tolist():
        y, z = _cut(half, place, SAME * length).T
        if z.size > 1 and z[-1] < draught - CLOSED * draught:
            y, z = np.r_[y, 0.0], np.r_[z, z[-1]]
        elif z.size > 1:
            z[-1] = max(z[-1], draught)
        if z.size > 1:
            stations.append(Station(x=place, y=np.maximum(y, 0.0), z=z))
    return stations, length


def _cut(triangles: Array, x: float, same: float) -> Array:
    """Half section (n, 2) of y and z at a place, from the keel on: the outermost y at each height.

    No corner needs to be one of two panels, and panels may leave gaps or lie twice.
    """
    above = triangles[..., 0] > x
    left = triangles[above.any(axis=1) & ~above.all(axis=1)]
    right = np.roll(left, -1, axis=1)
    cuts = (left[..., 0] > x) != (right[..., 0] > x)  # two edges of each triangle
    left, right = left[cuts], right[cuts]
    share = (x - left[:, :1]) / (right[:, :1] - left[:, :1])
    ends = (left + share * (right - left))[:, 1:].reshape(-1, 2, 2)
    heights = np.unique(np.round(ends[..., 1] / same)) * same
    low, high = ends[..., 1].min(axis=1), ends[..., 1].max(axis=1)
    rise = ends[:, 1, 1] - ends[:, 0, 1]
    level = heights[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.clip((level - ends[:, 0, 1]) / rise, 0.0, 1.0)
    y = ends[:, 0, 0] + place * (ends[:, 1, 0] - ends[:, 0, 0])
    y = np.where(np.abs(rise) > same, y, ends[..., 0].max(axis=1))
    there = (low <= level + same) & (level - same <= high)
    half = np.where(there, y, -np.inf).max(axis=1, initial=-np.inf)
    known = np.isfinite(half)
    return np.column_stack([half[known], heights[known]])


def _gdf(path: Path) -> Array:
    """Triangles (n, 3, 3) of quadrilateral panels, mirrored where half of the length is given."""
    text = _text(path).splitlines()
    try:
        scale = float(text[1].split()[0])
        forward, _ = (int(word) for word in text[2].split()[:2])
        count = int(text[3].split()[0])
        numbers = np.array(" ".join(text[4:]).split()[: 12 * count], float)
        corners = numbers.reshape(count, 4, 3) * scale
    except (IndexError, ValueError) as error:
        raise DataError(
            Problem(
                message="is no low-order geometry of WAMIT: a title, ULEN GRAV, ISX ISY, the "
                "number of panels, and four corners of each",
                file=str(path),
            )
        ) from error
    if forward:
        corners = np.concatenate([corners, corners * np.array([-1.0, 1.0, 1.0])])
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


def _stl(path: Path) -> Array:
    """Triangles (n, 3, 3) of a binary or a plain STL."""
    content = path.read_bytes()
    count = int.from_bytes(content[80:84], "little") if len(content) >= 84 else -1
    if len(content) == 84 + 50 * count:
        return np.frombuffer(content, FACET, offset=84)["corners"].astype(float)
    words = [line.split() for line in _text(path).splitlines()]
    try:
        corners = np.array([row[1:4] for row in words if row[:1] == ["vertex"]], float)
        return corners.reshape(-1, 3, 3)
    except ValueError as error:
        raise DataError(Problem(message="is no STL of whole triangles", file=str(path))) from error


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="latin-1")
    except OSError as error:
        raise DataError(Problem(message=f"cannot be read: {error}", file=str(path))) from error
