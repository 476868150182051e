"""Strip theory of Salvesen, Tuck and Faltinsen (1970): coefficients and excitation of a whole hull.

Axes: x forward, y to port, z up, from the water above the centre of gravity; time e^(iωt); waves
ζ = e^(iωt - ik(x cos β - y sin β)): heading β is 0 following, 180° head, and at 90° waves run to
starboard. Modes are 1 surge … 6 yaw; pitch is positive with the bow down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.seakeeping.hull_forms.hull import Hull
from pmmkit.seakeeping.lengthwise import Complex, second, weights
from pmmkit.seakeeping.loading import Loading
from pmmkit.seakeeping.mapping import SectionFit, fit_sections
from pmmkit.seakeeping.sectional import HEAVE, ROLL, SWAY, Sections, normals, solve

GRID: Final = 64
_ACROSS: Final = {(1, 1): (SWAY, SWAY), (1, 3): (SWAY, ROLL), (3, 3): (ROLL, ROLL)}
_PANELS: Final = 30
_LOWEST: Final = 0.05  # √(L/g) times the lowest frequency of the grid


@dataclass(frozen=True, kw_only=True, eq=False)
class Strips:
    """A hull with the radiation of its sections on a grid of frequencies.

    `fit`: maps of its sections. `omega`: the grid [rad/s], in equal steps of the logarithm.
    `sections`: solutions at the grid.
    """

    hull: Hull
    fit: SectionFit
    omega: Array
    sections: Sections
    g: float

    @cached_property
    def x(self) -> Array:
        """Stations forward of the centre of gravity [m]."""
        return self.hull.x - self.hull.hydrostatics.xB

    @cached_property
    def panels(self) -> tuple[Complex, Complex]:
        """Midpoints w and steps dw [m] of small pieces of half of each section, true to offsets."""
        ends = np.array([_divided(contour) for contour in self.hull.contours])
        return 0.5 * (ends[:, 1:] + ends[:, :-1]), np.diff(ends, axis=1)


def strips_of(hull: Hull, highest: float, *, g: float = 9.81) -> Strips:
    """The sections of a hull solved from long waves up to a frequency of encounter.

    highest [rad/s]; g [m/s²].
    """
    fit = fit_sections(hull.contours, [f"The section at x = {x:g} m" for x in hull.x])
    scale = math.sqrt(g / hull.L)
    omega = np.geomspace(_LOWEST * scale, max(1.01 * highest, scale), GRID)
    return Strips(hull=hull, fit=fit, omega=omega, sections=solve(fit.maps, omega**2 / g), g=g)


def _divided(contour: Complex) -> Complex:
    along = np.r_[0.0, np.cumsum(np.abs(np.diff(contour)))]
    places = np.linspace(0.0, along[-1], _PANELS + 1)
    return np.asarray(
        np.interp(places, along, contour.real) + 1j * np.interp(places, along, contour.imag)
    )


def at_frequency(strips: Strips, values: Complex, omega: Array) -> Complex:
    """What stands on the grid (first axis) at frequencies, by cubics through four neighbours.

    values (grid, …).
    """
    place = np.log(np.maximum(np.abs(omega), strips.omega[0]) / strips.omega[0])
    place = place / math.log(strips.omega[1] / strips.omega[0])
    first = np.clip(np.floor(place).astype(int) - 1, 0, strips.omega.size - 4)
    t = np.clip(place - first, 0.0, 3.0)
    shares = (
        -(t - 1) * (t - 2) * (t - 3) / 6,
        t * (t - 2) * (t - 3) / 2,
        -t * (t - 1) * (t - 3) / 2,
        t * (t - 1) * (t - 2) / 6,
    )
    if values.ndim == 1:
        found = sum(share * values[first + k] for k, share in enumerate(shares))
    else:
        cells = np.indices(omega.shape[-(values.ndim - 1) :])
        found = sum(share * values[(first + k, *cells)] for k, share in enumerate(shares))
    return np.asarray(np.where(omega < 0.0, np.conj(found), found))


def coefficients(strips: Strips, speed: Array, omega: Array) -> Complex:
    """a - ib/ω over ρ of the hull, shape (6, 6, …).

    speed, omega [m/s].
    """
    x, added = strips.x, strips.sections.added
    level, tilted = weights(x, np.zeros(1))[:, 0].real
    squared = second(x)
    U, w = np.broadcast_arrays(speed, omega)
    drift = U / (1j * w)  # STF's U/iω
    found = np.zeros((6, 6, *w.shape), dtype=complex)

    def whole(i: int, j: int, by: Array) -> Complex:
        return at_frequency(strips, added[i, j] @ by, w)

    def end(i: int, j: int) -> Complex:
        return at_frequency(strips, added[i, j, :, 0], w)

    xA = x[0]
    t, tA, tx, txx = (
        whole(HEAVE, HEAVE, level),
        end(HEAVE, HEAVE),
        whole(HEAVE, HEAVE, tilted),
        whole(HEAVE, HEAVE, squared),
    )
    found[2, 2] = t + drift * tA
    found[2, 4] = -tx + drift * t - drift * xA * tA + drift**2 * tA
    found[4, 2] = -tx - drift * t - drift * xA * tA
    found[4, 4] = txx - drift**2 * t + drift * xA**2 * tA - drift**2 * xA * tA
    for (m, n), (i, j) in _ACROSS.items():
        found[m, n] = found[n, m] = whole(i, j, level) + drift * end(i, j)
    for m, j in ((1, SWAY), (3, ROLL)):
        t, tA, tx = whole(SWAY, j, level), end(SWAY, j), whole(SWAY, j, tilted)
        found[m, 5] = tx - drift * t + drift * xA * tA - drift**2 * tA
        found[5, m] = tx + drift * t + drift * xA * tA
    t, tA = whole(SWAY, SWAY, level), end(SWAY, SWAY)
    found[5, 5] = (
        whole(SWAY, SWAY, squared) - drift**2 * t + drift * xA**2 * tA - drift**2 * xA * tA
    )
    return found


def mass_matrix(strips: Strips, loading: Loading, rho: float) -> Array:
    """The mass matrix about the water above the centre of gravity."""
    mass = rho * strips.hull.hydrostatics.volume
    height = loading.KG - strips.hull.draught
    found = np.diag([mass] * 3 + [mass * r**2 for r in (loading.kxx, loading.kyy, loading.kzz)])
    found[3, 3] += mass * height**2
    found[4, 4] += mass * height**2
    found[0, 4] = found[4, 0] = mass * height
    found[1, 3] = found[3, 1] = -mass * height
    return np.asarray(found)


def restoring(strips: Strips, loading: Loading) -> Array:
    """Restoring by buoyancy and weight over ρ, with the sums along the hull that excite it."""
    still, x = strips.hull.hydrostatics, strips.x
    level, tilted = weights(x, np.zeros(1))[:, 0].real
    b = strips.hull.breadths
    found = np.zeros((6, 6))
    found[2, 2] = level @ b
    found[2, 4] = found[4, 2] = -tilted @ b
    found[4, 4] = second(x) @ b + still.volume * (still.KB - loading.KG)
    found[3, 3] = still.volume * (still.KM - loading.KG)
    if found[3, 3] <= 0.0:
        raise DataError(
            f"KG = {loading.KG:.3f} m lies above the metacentre, {still.KM:.3f} m: the ship does "
            "not stand upright."
        )
    return np.asarray(strips.g * found)


def critical_of(stiffness: Array, inertia: Array, added: Complex) -> Array:
    """Critical damping of roll, over which that beside the waves is stated [N m s]."""
    return np.asarray(2 * np.sqrt(stiffness[3, 3] * (inertia[3, 3] + added[3, 3].real)))


def critical_damping(
    strips: Strips, loading: Loading, rho: float, speed: Array, omega: Array
) -> Array:
    """`critical_of` a hull at speeds and frequencies of encounter [m/s, rad/s].

    rho [kg/m³].
    """
    felt = np.where(omega < 0.0, -1.0, 1.0) * np.maximum(np.abs(omega), strips.omega[0])
    added = rho * coefficients(strips, speed, felt)
    return critical_of(rho * restoring(strips, loading), mass_matrix(strips, loading, rho), added)


def excitation(
    strips: Strips, speed: Array, heading: Array, omega: Array, encounter: Array
) -> tuple[Complex, Complex]:
    """Forces over ρ of waves of unit amplitude: by their pressure alone, and with diffraction.

    Diffraction is by Haskind's relation, that of sections at the frequency of encounter, in two
    dimensions. Forces (6, speeds, headings, frequencies) [m³/s²; m⁴/s²].

    encounter (speeds, headings, frequencies); encounter [rad/s].
    """
    k = omega**2 / strips.g
    across = np.sin(heading)
    along = np.multiply.outer(np.cos(heading), k)
    level, tilted = weights(strips.x, along)
    first = np.exp(-1j * along * strips.x[0])
    direct = -strips.g * _projected(*strips.panels, k, across)
    w = np.zeros((6, *along.shape), dtype=complex)
    for mode, row in ((2, HEAVE), (1, SWAY), (3, ROLL)):
        w[mode] = np.sum(level * direct[row], axis=-1)
    w[4] = -np.sum(tilted * direct[HEAVE], axis=-1)
    w[5] = np.sum(tilted * direct[SWAY], axis=-1)
    w[0], turning = _surge(strips, k, along, across, level)
    w[4] += turning
    incident = np.broadcast_to(w[:, None], (6, *encounter.shape))

    points, steps = strips.sections.points, strips.sections.weights
    even, odd = wave_velocity(points, steps, k, across)
    drift = speed[:, None, None] / (1j * encounter)
    scale = encounter * omega
    total = incident.copy()
    for mode, row, shape in ((2, HEAVE, even), (1, SWAY, odd), (3, ROLL, odd)):
        local = _over_sections(strips.sections.potentials[row], shape, encounter)
        force = scale * _summed(strips, local, np.stack([level, tilted]), encounter)
        ends = np.zeros_like(level)[None]
        ends[..., 0] = first
        (aft,) = scale * _summed(strips, local, ends, encounter)
        total[mode] += force[0] + drift * aft
        if mode != 3:
            turning = force[1] + drift * (force[0] + strips.x[0] * aft)
            total[4 if mode == 2 else 5] += -turning if mode == 2 else turning
    return incident, total


def _over_sections(potentials: Complex, shape: Complex, encounter: Array) -> list[Complex]:
    """∫ potential times wave over sections; where waves are overtaken, with its conjugate too."""
    waves = (shape, shape.conj()) if (encounter < 0.0).any() else (shape,)
    return [np.einsum("fsn,hwsn->fhws", potentials, wave, optimize=True) for wave in waves]


def _summed(strips: Strips, local: list[Complex], by: Complex, encounter: Array) -> Complex:
    """What was integrated over sections, with weights `by`, along the hull."""
    found = []
    for part, weight in zip(local, (by, by.conj()), strict=False):
        sums = np.einsum("fhws,bhws->bfhw", part, weight, optimize=True)
        found.append(np.stack([at_frequency(strips, one, np.abs(encounter)) for one in sums]))
    if len(found) == 1:
        return found[0]
    # of waves that are overtaken the potential is the conjugate, the wave is not
    return np.where(encounter < 0.0, found[1].conj(), found[0])


def wave_velocity(
    points: Complex, steps: Complex, k: Array, across: Array
) -> tuple[Complex, Complex]:
    """The wave's velocity through whole sections: even and odd over the breadth, by node.

    Over k times the potential above the middle line: (headings, frequencies, sections, nodes).
    """
    up, out, _ = normals(points, steps)
    decay = np.exp(-np.multiply.outer(k, points.real))
    phase = np.multiply.outer(np.multiply.outer(across, k), points.imag)
    side = across[:, None, None, None]
    even = 2 * decay * (np.cos(phase) * up - side * np.sin(phase) * out)
    odd = 2j * decay * (np.sin(phase) * up + side * np.cos(phase) * out)
    return even, odd


def _projected(points: Complex, steps: Complex, k: Array, across: Array) -> Complex:
    """∫ of the wave's pressure over ρg on the normals: (3, headings, frequencies, stations)."""
    up, out, turn = normals(points, steps)
    decay = np.exp(-np.multiply.outer(k, points.real))
    phase = np.multiply.outer(np.multiply.outer(across, k), points.imag)
    even, odd = 2 * decay * np.cos(phase), 2j * decay * np.sin(phase)
    return np.stack([np.sum(even * up, -1), np.sum(odd * out, -1), np.sum(odd * turn, -1)])


def _surge(
    strips: Strips, k: Array, along: Array, across: Array, level: Complex
) -> tuple[Complex, Complex]:
    """Pressure of the wave on the ends: ik cos β ∫∫ over the areas of sections, and its moment
    about the water, below which it acts."""
    points, steps = strips.panels
    decay = np.exp(-np.multiply.outer(k, points.real))
    half = np.multiply.outer(np.multiply.outer(across, k), points.imag)
    width = 2 * points.imag * np.sinc(half / math.pi)
    inside = decay * width * -steps.real
    force, moment = (
        strips.g * 1j * along * np.sum(level * np.sum(part, axis=-1), axis=-1)
        for part in (inside, inside * -points.real)
    )
    return np.asarray(force), np.asarray(moment)
