"""Motions of a ship in regular waves: transfer functions over speed, heading and frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.errors import DataError
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, counted
from pmmkit.seakeeping.arrays import Complex, Flags
from pmmkit.seakeeping.hull import Hull
from pmmkit.seakeeping.lengthwise import second, weights
from pmmkit.seakeeping.loading import Loading, loading_of
from pmmkit.seakeeping.strips import Strips, coefficients, excitation, strips_of

MODES: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")
SLOW: Final = 0.4
"""ωₑ√(L/g) below which the terms U/ωₑ² of the theory have no meaning: motions are quasi-static."""


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Rao(Described):
    """Transfer functions of a ship in waves, per metre of wave amplitude (not of height).

    Axes are those of `pmmkit.seakeeping.strips`: x forward, y to port, z up, from the water above
    the centre of gravity; heading 180° is head sea; pitch is positive with the bow down.

    Parameters
    ----------
    name : str
        Of the ship.
    L : float
        Length between perpendiculars [m].
    speed : array, shape (speeds,)
        [m/s].
    heading : array, shape (headings,)
        [rad].
    omega : array, shape (frequencies,)
        Of the waves in a frame at rest [rad/s].
    encounter : array, shape (speeds, headings, frequencies)
        ωₑ = ω - kU cos β [rad/s]; negative where the ship overtakes the waves.
    motion : array of complex, shape (6, speeds, headings, frequencies)
        Surge, sway, heave [m/m], roll, pitch, yaw [rad/m].
    force : array of complex, of the same shape
        Of the waves [N/m], [N m/m].
    quasi_static : array of bool, shape (speeds, headings, frequencies)
        Where ωₑ is so low that heave, roll and pitch follow the wave, and surge, sway and yaw are
        not computed (NaN).
    strips : Strips
        The sections.
    loading : Loading
        The mass.
    rho, g : float
        Density [kg/m³], gravity [m/s²].
    notes : tuple of str
        What is assumed, and where the theory ends.
    """

    name: str
    L: float
    speed: Array
    heading: Array
    omega: Array
    encounter: Array
    motion: Complex
    force: Complex
    quasi_static: Flags
    strips: Strips
    loading: Loading
    rho: float
    g: float
    notes: tuple[str, ...] = ()

    @property
    def wavenumber(self) -> Array:
        """k = ω²/g [1/m]."""
        return self.omega**2 / self.g

    def mode(self, name: str) -> Complex:
        """The transfer function of one of `MODES`.

        Parameters
        ----------
        name : str
            Such as ``heave``.
        """
        if name not in MODES:
            raise DataError(f"There is no motion {name!r}. There are {', '.join(MODES)}.")
        return np.asarray(self.motion[MODES.index(name)])

    def at_point(self, x: float, y: float = 0.0, z: float = 0.0) -> Complex:
        """Motion of a point (x, y, z) of the ship [m/m], shape (3, speeds, headings, frequencies).

        Parameters
        ----------
        x, y, z : float
            Forward of midship, to port of the middle, above the water [m].
        """
        forward = x - self.strips.hull.hydrostatics.xB
        s, r = self.motion[:3], self.motion[3:]
        return np.stack(
            [
                s[0] + z * r[1] - y * r[2],
                s[1] + forward * r[2] - z * r[0],
                s[2] + y * r[0] - forward * r[1],
            ]
        )

    def _headline(self) -> str:
        froude = self.speed / math.sqrt(self.g * self.L)
        return (
            f"{self.name}: Fn {', '.join(f'{x:.3f}' for x in froude[:6])}, "
            f"{counted(self.heading.size, 'heading')}, "
            f"{self.omega.size} frequencies"
        )

    def _sections(self) -> Sequence[Section]:
        rows = []
        for i, speed in enumerate(self.speed):
            for j, heading in enumerate(self.heading):
                size = np.abs(self.motion[:, i, j])
                peaks = [
                    f"{np.nanmax(size[m]):.3f} at {self.omega[np.nanargmax(size[m])]:.2f}"
                    if np.isfinite(size[m]).any()
                    else None
                    for m in (2, 3, 4)
                ]
                rows.append([f"{speed:.2f} m/s, {math.degrees(heading):.0f}°", *peaks])
        shown = rows[:30]
        head = ["speed, heading", "heave [m/m]", "roll [rad/m]", "pitch [rad/m]"]
        more = [f"Shown are {len(shown)} of {len(rows)} speeds and headings."]
        return [
            Section(
                title="Largest motions per metre of wave amplitude, at ω [rad/s]",
                paragraphs=more if len(shown) < len(rows) else [],
                tables=[Grid(head=head, groups=[Group(rows=shown)])],
            ),
            *([Section(title="Notes", points=self.notes)] if self.notes else []),
        ]


def rao(
    hull: Hull,
    *,
    speeds: ArrayLike,
    headings_deg: ArrayLike = (180.0,),
    omega: ArrayLike | None = None,
    loading: Loading | None = None,
    rho: float = 1025.0,
    g: float = 9.81,
) -> Rao:
    """Motions of a ship in regular deep-water waves by strip theory.

    Salvesen, Tuck and Faltinsen (1970), with sections by Ursell's multipoles on conformal maps.
    Surge is that of the mass alone under the pressure of the wave.

    Parameters
    ----------
    hull : Hull
        The hull in sections.
    speeds : array-like
        [m/s].
    headings_deg : array-like
        180 is head sea, 90 waves that run to starboard, 0 following sea [deg].
    omega : array-like, optional
        Of the waves [rad/s], rising; where absent, 40 of wave lengths from 5 L to 0.2 L.
    loading : Loading, optional
        The mass; where absent, assumed by `loading_of`.
    rho, g : float
        Density [kg/m³], gravity [m/s²].

    Returns
    -------
    Rao

    Raises
    ------
    DataError
        If a speed, heading or frequency is out of range, or the ship is unstable in roll.
    """
    U, beta, w = _axes(hull, speeds, headings_deg, omega, g)
    mass = loading_of(hull) if loading is None else loading
    encounter = w - np.multiply.outer(np.multiply.outer(U, np.cos(beta)), w**2) / g
    strips = strips_of(hull, float(np.abs(encounter).max()), g=g)
    slow = np.abs(encounter) < SLOW * math.sqrt(g / hull.L)
    safe = np.where(slow, SLOW * math.sqrt(g / hull.L), encounter)
    waves = excitation(strips, U, beta, w, safe)
    force = (rho * np.where(slow, waves.froude_krylov, waves.total)).astype(np.complex128)
    added = rho * coefficients(strips, U[:, None, None], safe)
    inertia, stiffness = _mass(strips, mass, rho), rho * _stiffness(strips, mass)
    inertia_rolled = inertia[3, 3] + added[3, 3].real
    critical = 2 * np.sqrt(stiffness[3, 3] * inertia_rolled)
    still = stiffness[:, :, None, None, None].astype(complex)
    matrix = (still - safe**2 * (inertia[:, :, None, None, None] + added)).astype(np.complex128)
    matrix[3, 3] += 1j * safe * mass.roll_damping * critical
    motion = _solved(matrix, force, slow, stiffness, mass.KG - hull.draught)
    return Rao(
        name=hull.name,
        L=hull.L,
        speed=U,
        heading=beta,
        omega=w,
        encounter=encounter,
        motion=motion,
        force=force,
        quasi_static=slow,
        strips=strips,
        loading=mass,
        rho=rho,
        g=g,
        notes=(*hull.notes, *strips.fit.notes, *mass.notes, *_warnings(hull, U, beta, w, slow, g)),
    )


def _axes(
    hull: Hull, speeds: ArrayLike, headings_deg: ArrayLike, omega: ArrayLike | None, g: float
) -> tuple[Array, Array, Array]:
    U = np.atleast_1d(np.asarray(speeds, dtype=float))
    beta = np.radians(np.atleast_1d(np.asarray(headings_deg, dtype=float)))
    if omega is None:
        omega = np.sqrt(2 * math.pi * g / hull.L / np.geomspace(5.0, 0.2, 40))
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    wrong = []
    if not np.isfinite(U).all() or (U < 0.0).any():
        wrong.append("Speeds must be finite and not below zero [m/s].")
    if not np.isfinite(beta).all():
        wrong.append("Headings must be finite [deg].")
    if not np.isfinite(w).all() or (w <= 0.0).any() or (np.diff(w) <= 0.0).any():
        wrong.append("Frequencies must be positive and rising [rad/s].")
    if wrong:
        raise DataError(wrong, title="Motions in waves")
    return U, beta, w


def _mass(strips: Strips, loading: Loading, rho: float) -> Array:
    """The mass matrix about the water above the centre of gravity."""
    mass = rho * strips.hull.hydrostatics.volume
    height = loading.KG - strips.hull.draught
    found = np.diag([mass] * 3 + [mass * r**2 for r in (loading.kxx, loading.kyy, loading.kzz)])
    found[3, 3] += mass * height**2
    found[4, 4] += mass * height**2
    found[0, 4] = found[4, 0] = mass * height
    found[1, 3] = found[3, 1] = -mass * height
    return np.asarray(found)


def _stiffness(strips: Strips, loading: Loading) -> Array:
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


def _solved(
    matrix: Complex, force: Complex, slow: Flags, stiffness: Array, height: float
) -> Complex:
    """Motions: heave with pitch, sway with roll and yaw, surge alone; quasi-static where slow.

    However slow a wave passes, its side force accelerates the mass, whose centre is at `height`.
    """
    motion = np.full(force.shape, np.nan, dtype=complex)
    for modes in ([0], [2, 4], [1, 3, 5]):
        system = np.moveaxis(matrix[np.ix_(modes, modes)], (0, 1), (-2, -1))
        right = np.moveaxis(force[modes], 0, -1)[..., None]
        motion[modes] = np.moveaxis(np.linalg.solve(system, right)[..., 0], -1, 0)
    if slow.any():
        still = motion[:, slow]
        still[[0, 1, 5]] = np.nan
        still[[2, 4]] = np.linalg.solve(stiffness[np.ix_([2, 4], [2, 4])], force[[2, 4]][:, slow])
        still[3] = (force[3] + height * force[1])[slow] / stiffness[3, 3]
        motion[:, slow] = still
    return motion


def _warnings(
    hull: Hull, U: Array, beta: Array, w: Array, slow: Flags, g: float
) -> tuple[str, ...]:
    found = []
    froude = float(U.max()) / math.sqrt(g * hull.L)
    if froude > 0.4:
        found.append(f"Fn {froude:.2f} is high for strip theory, which is trusted up to 0.4.")
    if slow.any():
        found.append(
            f"{np.mean(slow):.0%} of the waves meet the ship slower than ωₑ√(L/g) = {SLOW}: heave, "
            "roll and pitch are quasi-static there, surge, sway and yaw are not computed."
        )
    along = np.multiply.outer(U, np.cos(beta))[..., None] * w / g
    if ((along > 0.7) & (along < 1.4)).any():
        found.append(
            "Some following waves run about as fast as the ship: surf-riding and broaching are "
            "beyond a linear theory."
        )
    return tuple(found)
