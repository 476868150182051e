"""Conformal maps of the outside of a circle to the outside of a section: Lewis forms, close fit.

The half section lies in w = y + ix, y [m] down and x [m] outward, the circle in ζ = e^(α+iθ) with θ
from 0 at the keel to π/2 at the water: w = Σ dₙ ζ^(1-2n), n = 0, 1, …. With the textbooks' numbers
dₙ = M (-1)ⁿ a₂ₙ₋₁. A Lewis form has three coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.seakeeping.lengthwise import Complex

_POINTS: Final = 120
_COUNTS: Final = (3, 5, 7, 9, 12)
_AREA_KEPT: Final = 0.003  # enough: more coefficients follow corners of offsets and flare
_AREA_LOST: Final = 0.05
_SMOOTH: Final = 0.02
_NECK: Final = 0.7
_FULL: Final = 0.9
_STEPS: Final = 60
_STILL: Final = 1e-6
_WATERLINE: Final = 30.0  # weight of keel and waterline, whose places are the draught and breadth


def at(map_: Array, theta: Array) -> Complex:
    """Points of the section: w = y + ix [m] at the angles θ [rad] of the circle.

    map_ [m].
    """
    powers = 1 - 2 * np.arange(map_.shape[-1])
    return np.asarray(map_ @ np.exp(1j * np.outer(powers, theta)))


def slope(map_: Array, theta: Array) -> Complex:
    """dw/dθ [m] of `at`."""
    powers = 1 - 2 * np.arange(map_.shape[-1])
    return np.asarray((1j * powers * map_) @ np.exp(1j * np.outer(powers, theta)))


def area(map_: Array) -> Array:
    """Area [m²] of the whole section below the water, π/2 Σ (1-2n) dₙ²."""
    powers = 1 - 2 * np.arange(map_.shape[-1])
    return np.asarray(0.5 * math.pi * np.sum(powers * map_**2, axis=-1))


def is_conformal(map_: Array) -> bool:
    """Whether dw/dζ has no zero outside the circle, nor on it."""
    powers = 1 - 2 * np.arange(map_.shape[-1])
    zeros = np.roots(powers * map_)  # a polynomial in ζ²
    return bool((np.abs(zeros) < 1.0).all())


def lewis_area_range(breadth: float, draught: float) -> tuple[float, float]:
    """Areas over breadth times draught between which a Lewis form is a section that exists.

    Below the first it is re-entrant at the keel or the water, beyond the second it has loops
    (von Kerczek and Tuck 1969).

    Examples
    --------
    >>> [round(x, 3) for x in lewis_area_range(2.0, 1.0)]
    [0.295, 1.178]
    """
    ratio = 0.5 * breadth / draught
    flat = min(ratio, 1 / ratio)
    low = 3 * math.pi / 32 * (2 - flat)
    return low, math.pi / 32 * (ratio + 1 / ratio + 10)


def lewis(breadth: float, draught: float, section_area: float) -> Array:
    """The Lewis form of a breadth [m], a draught [m] and an area [m²].

    Examples
    --------
    >>> lewis(2.0, 1.0, 1.570796).round(4) + 0.0
    array([1., 0., 0.])
    """
    low, high = lewis_area_range(breadth, draught)
    fullness = section_area / (breadth * draught)
    if not low <= fullness <= high:
        raise DataError(
            f"No Lewis form has a breadth of {breadth:.4g} m, a draught of {draught:.4g} m and an "
            f"area coefficient of {fullness:.3f}: it lies between {low:.3f} and {high:.3f}. Give "
            "the offsets of the section, to which more coefficients are fitted."
        )
    half = 0.5 * breadth
    total, lift = half + draught, half - draught
    # b + T = 2M(1 + a₃), b - T = 2M a₁, area = π/2 M² (1 - a₁² - 3a₃²)
    rest = section_area * 2 / math.pi + 0.25 * lift**2
    scale = 0.75 * total - 0.25 * math.sqrt(3 * total**2 - 8 * rest)
    return np.array([scale, -0.5 * lift, 0.5 * total - scale])


def _resampled(points: Complex, count: int) -> Complex:
    """Points at equal steps of arc along a polyline of complex points."""
    along = np.r_[0.0, np.cumsum(np.abs(np.diff(points)))]
    places = np.linspace(0.0, along[-1], count)
    return np.asarray(
        np.interp(places, along, points.real) + 1j * np.interp(places, along, points.imag)
    )


def fitted(contour: Complex, count: int, smooth: float = 0.0) -> Array:
    """The map with so many coefficients that lies closest to a contour, by least squares.

    Distances are taken along the normal of the map (Gauss and Newton); keel and waterline weigh
    more, so that draught and breadth are kept.

    contour [m].

    Examples
    --------
    >>> quarter = np.exp(1j * np.linspace(0, np.pi / 2, 40))
    >>> fitted(quarter, 4).round(3) + 0.0
    array([1., 0., 0., 0.])
    """
    points = _resampled(contour, _POINTS)
    powers = 1 - 2 * np.arange(count)
    half, draught = contour[-1].imag, contour[0].real
    scale = max(half, 0.02 * draught)
    map_ = np.zeros(count)
    map_[:2] = 0.5 * (scale + draught), -0.5 * (scale - draught)
    theta = np.linspace(0.0, 0.5 * math.pi, points.size)
    weight = np.ones(points.size)
    weight[[0, -1]] = _WATERLINE
    held = smooth * math.sqrt(points.size) * np.diag(np.where(powers < -1, powers, 0.0))
    change = math.inf
    for _ in range(_STEPS):
        for _ in range(3):
            tangent = slope(map_, theta)
            ahead = ((points - at(map_, theta)) * tangent.conj()).real
            theta = theta + np.clip(ahead / np.abs(tangent) ** 2, -0.1, 0.1)
            theta = np.clip(theta, 0.0, 0.5 * math.pi)
        tangent = slope(map_, theta)
        normal = -1j * tangent / np.abs(tangent)
        basis = (np.exp(1j * np.outer(theta, powers)) * normal.conj()[:, None]).real
        miss = ((points - at(map_, theta)) * normal.conj()).real
        rows, wanted = (
            np.vstack([basis * weight[:, None], held]),
            np.r_[miss * weight, -held @ map_],
        )
        step = np.linalg.lstsq(rows, wanted, rcond=1e-10)[0]
        largest = float(np.abs(step).max())
        map_ = map_ + step * min(1.0, 0.2 * draught / max(largest, 1e-12))
        if largest < _STILL * draught or largest > 10 * change:
            break
        change = largest
    return map_


def misfit(map_: Array, contour: Complex) -> float:
    """Largest distance [m] of points of a contour to the section of a map."""
    curve = at(map_, np.linspace(0.0, 0.5 * math.pi, 721))
    points = _resampled(contour, _POINTS)
    return float(np.abs(points[:, None] - curve[None, :]).min(axis=1).max())


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionFit:
    """Maps of some sections.

    `maps (sections, coefficients)`: dₙ [m], zero where a section has fewer. `misfit`: largest
    distance of a section to its map [m]. `notes`: sections that could not be followed, and what
    stands for them.
    """

    maps: Array
    misfit: float
    notes: tuple[str, ...] = ()


def fit_sections(contours: Sequence[Complex], labels: Sequence[str]) -> SectionFit:
    """Maps that follow sections closely, with as few coefficients as do.

    A map is sound where it is conformal and has the section's area to 5 %; the first that has it
    to 0.3 % is taken, else the best. Where none is sound, and where a section is much narrower at
    the water than below (functions with their poles at the water cannot follow a bulb under a
    neck), a Lewis form of its area and depth stands for it, and a note says so.

    contours [m].
    """
    rows, worst, notes = [], 0.0, []
    for contour, label in zip(contours, labels, strict=True):
        wanted = float(-2 * np.trapezoid(contour.imag, contour.real))
        breadth, depth = float(2 * contour[-1].imag), float(contour.real.max())
        necked = breadth < _NECK * 2 * float(contour.imag.max())
        map_ = None if necked else _closest(contour, wanted)
        if map_ is not None:
            worst = max(worst, misfit(map_, contour))
        else:
            wide = max(breadth, wanted / (_FULL * depth))
            full = max(wanted / (wide * depth), lewis_area_range(wide, depth)[0])
            map_ = lewis(wide, depth, full * wide * depth)
            why = "is necked above a bulb" if necked else "has no conformal map"
            notes.append(
                f"{label} {why}: to the flow it is a Lewis form {wide:.3g} m wide at the water, "
                f"not {breadth:.3g} m, with {full * wide * depth / wanted:.2f} of its area."
            )
        rows.append(np.pad(map_, (0, _COUNTS[-1] - map_.size)))
    return SectionFit(maps=np.array(rows), misfit=worst, notes=tuple(notes))


def _closest(contour: Complex, wanted: float) -> Array | None:
    """The sound map with the fewest coefficients that keeps an area [m²], None if there is none."""
    for smooth in (0.0, _SMOOTH):
        best, found = _AREA_LOST, None
        for count in _COUNTS:
            tried = fitted(contour, count, smooth)
            lost = abs(float(area(tried)) / wanted - 1)
            if lost < best and is_conformal(tried):
                best, found = lost, tried
            if best < _AREA_KEPT:
                break
        if found is not None:
            return found
    return None
