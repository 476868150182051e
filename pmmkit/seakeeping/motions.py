"""Motions of a ship in regular waves, over speed, heading and frequency."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.seakeeping.hull_forms.hull import Hull
from pmmkit.seakeeping.lengthwise import Complex, Flags
from pmmkit.seakeeping.loading import Loading
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.strips import (
    Strips,
    coefficients,
    critical_of,
    excitation,
    mass_matrix,
    restoring,
    strips_of,
)
from pmmkit.seakeeping.transfer import ENGINE, Rao

_ROUNDS: Final = 60
_SETTLED: Final = 1e-6  # of critical damping
SLOW: Final = 0.4
"""ωₑ√(L/g) below which the terms U/ωₑ² of the theory have no meaning: motions are quasi-static.
At rest there are none of them."""


def rao(
    hull: Hull,
    *,
    speeds: ArrayLike,
    headings_deg: ArrayLike = (180.0,),
    omega: ArrayLike | None = None,
    loading: Loading | None = None,
    sea: Sea | None = None,
    waves: float | None = None,
    rho: float = 1025.0,
    g: float = 9.81,
    strips: Strips | None = None,
) -> Rao:
    """Motions of a ship in regular deep-water waves by strip theory.

    Salvesen, Tuck and Faltinsen (1970), with sections by Ursell's multipoles on conformal maps.
    Surge is that of the mass alone under the pressure of the wave, whose moment about the water
    turns the ship with it, so that at rest a long wave carries the ship as it moves the water.

    Parameters
    ----------
    hull : Hull
        The hull in sections.
    speeds : array-like
        [m/s].
    headings_deg : array-like
        180 is head sea, 90 waves that run to starboard, 0 following sea [deg].
    omega : array-like, optional
        Of the waves [rad/s], rising; those of `frequencies` where absent, with `sea`.
    loading : Loading, optional
        The mass; where absent, assumed by `Loading.of`.
    sea : Sea, optional
        The sea that the motions are for: its energy lies within the frequencies where `omega` is
        absent, and a roll damping of `loading` that grows with the rate is made linear in it, as
        if it were long-crested.
    waves : float, optional
        Amplitude of regular waves [m] in which that damping is made linear instead.
    rho, g : float
        Density [kg/m³], gravity [m/s²].
    strips : Strips, optional
        Of the same hull, solved before up to the frequencies of encounter that are asked here.

    Returns
    -------
    Rao

    Raises
    ------
    DataError
        If a speed, heading or frequency is out of range, the ship is unstable in roll, or its
        damping needs `sea` or `waves`.
    """
    U, beta, w = _axes(hull, speeds, headings_deg, omega, g, sea)
    mass = Loading.of(hull) if loading is None else loading
    encounter = w - np.multiply.outer(np.multiply.outer(U, np.cos(beta)), w**2) / g
    highest = float(np.abs(encounter).max())
    if strips is None or strips.hull is not hull or strips.omega[-1] < highest or strips.g != g:
        strips = strips_of(hull, highest, g=g)
    moving = (U > 0.0)[:, None, None]
    slow = moving & (np.abs(encounter) < SLOW * math.sqrt(g / hull.L))
    safe = np.where(slow, SLOW * math.sqrt(g / hull.L), encounter)
    froude_krylov, total = excitation(strips, U, beta, w, safe)
    force = (rho * np.where(slow, froude_krylov, total)).astype(np.complex128)
    added = rho * coefficients(strips, U[:, None, None], safe)
    inertia, stiffness = mass_matrix(strips, mass, rho), rho * restoring(strips, mass)
    critical = critical_of(stiffness, inertia, added)
    still = stiffness[:, :, None, None, None].astype(complex)
    matrix = (still - safe**2 * (inertia[:, :, None, None, None] + added)).astype(np.complex128)

    def solved(damping: Array | float) -> Complex:
        damped = matrix.copy()
        damped[3, 3] += 1j * safe * damping * critical
        return _solved(damped, force, slow, stiffness, mass.KG - hull.draught)

    motion, damping = _damped(solved, mass, sea if waves is None else waves, encounter, w)
    return Rao(
        name=hull.name,
        engine=ENGINE,
        L=hull.L,
        B=float(hull.breadths.max()),
        x=hull.hydrostatics.xB,
        speed=U,
        heading=beta,
        omega=w,
        encounter=encounter,
        motion=motion,
        force=force,
        quasi_static=slow,
        roll_damping=np.where(slow, 0.0, damping * critical),
        strips=strips,
        loading=mass,
        rho=rho,
        g=g,
        notes=(*hull.notes, *strips.fit.notes, *mass.notes, *_warnings(hull, U, beta, w, slow, g)),
    )


def frequencies(L: float, sea: Sea | None = None, *, g: float = 9.81, count: int = 40) -> Array:
    """Frequencies of waves [rad/s] from five times the length of a ship to a fifth of it.

    Parameters
    ----------
    L : float
        Length of the ship [m].
    sea : Sea, optional
        A sea whose energy they hold, to 0.7 of its peak and to three times the peak.
    g : float
        Gravity [m/s²].
    count : int
        How many.

    Examples
    --------
    >>> frequencies(100.0, count=3).round(3)
    array([0.351, 0.785, 1.756])
    """
    low, high = (math.sqrt(2 * math.pi * g / (L * share)) for share in (5.0, 0.2))
    if sea is not None:
        low, high = min(low, 0.7 * sea.peak), max(high, 3.0 * sea.peak)
    return np.geomspace(low, high, count)


def _damped(
    solved: Callable[[Array | float], Complex],
    loading: Loading,
    waves: float | Sea | None,
    encounter: Array,
    omega: Array,
) -> tuple[Complex, Array | float]:
    """Motions with a roll damping that is linear about their own size, and that damping.

    B₁ + 8/(3π) ωφ B₂ takes as much energy from a harmonic roll as the quadratic damping does,
    B₁ + √(8/π) σ B₂ from a Gaussian one. It is found by iteration, half of each step taken.
    """
    motion = solved(loading.roll_damping)
    if loading.roll_quadratic == 0.0:
        return motion, loading.roll_damping
    if waves is None:
        raise DataError(
            "roll_quadratic makes the damping depend on the height of the waves: give sea=, or "
            "waves=, the amplitude of regular waves [m]."
        )
    damping: Array = np.full(encounter.shape, loading.roll_damping)
    for _ in range(_ROUNDS):
        rate = np.nan_to_num(np.abs(encounter * motion[3]))
        if isinstance(waves, Sea):
            energy = np.trapezoid(rate**2 * waves.spectrum(omega), omega, axis=-1)
            felt = math.sqrt(8 / math.pi) * np.sqrt(energy)[..., None]
        else:
            felt = 8 / (3 * math.pi) * waves * rate
        wanted = loading.roll_damping + loading.roll_quadratic * felt
        if np.abs(wanted - damping).max() < _SETTLED:
            break
        damping = 0.5 * (damping + wanted)
        motion = solved(damping)
    return motion, damping


def _axes(
    hull: Hull,
    speeds: ArrayLike,
    headings_deg: ArrayLike,
    omega: ArrayLike | None,
    g: float,
    sea: Sea | None,
) -> tuple[Array, Array, Array]:
    U = np.atleast_1d(np.asarray(speeds, dtype=float))
    beta = np.radians(np.atleast_1d(np.asarray(headings_deg, dtype=float)))
    if omega is None:
        omega = frequencies(hull.L, sea, g=g)
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    wrong = []
    if not np.isfinite(U).all() or (U < 0.0).any():
        wrong.append("Speeds must be finite and not below zero [m/s].")
    if not (np.abs(beta) <= 2 * np.pi + 1e-9).all():
        wrong.append("Headings must lie between -360 and 360 deg.")
    if not np.isfinite(w).all() or (w <= 0.0).any() or (np.diff(w) <= 0.0).any():
        wrong.append("Frequencies must be positive and rising [rad/s].")
    if wrong:
        raise DataError(wrong, title="Motions in waves")
    return U, beta, w


def _solved(
    matrix: Complex, force: Complex, slow: Flags, stiffness: Array, height: float
) -> Complex:
    """Motions: surge with heave and pitch, sway with roll and yaw; quasi-static where slow.

    However slow a wave passes, its side force accelerates the mass, whose centre is at `height`.
    """
    motion = np.full(force.shape, np.nan, dtype=complex)
    for modes in ([0, 2, 4], [1, 3, 5]):
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
            f"{100 * np.mean(slow):.0f} % of the waves meet the ship slower than ωₑ√(L/g) = "
            f"{SLOW}: heave, roll and pitch are quasi-static there, surge, sway and yaw are not "
            "computed."
        )
    along = np.multiply.outer(U, np.cos(beta))[..., None] * w / g
    if ((along > 0.7) & (along < 1.4)).any():
        found.append(
            "Some following waves run about as fast as the ship: surf-riding and broaching are "
            "beyond a linear theory."
        )
    return tuple(found)
