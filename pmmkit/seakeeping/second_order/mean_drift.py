"""Mean drift of waves: by momentum, by what sections do alone, and by reflection.

Forces are means of second order over the square of the amplitude of the wave [N/m²].
"""

from __future__ import annotations

import math
from typing import Final, Literal

import numpy as np

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.seakeeping.hull_forms.hull import Hull
from pmmkit.seakeeping.lengthwise import Complex
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.second_order.far_field import momentum_drift
from pmmkit.seakeeping.sectional import HEAVE, ROLL, SWAY
from pmmkit.seakeeping.strips import at_frequency
from pmmkit.seakeeping.transfer import Rao, nearest

_TURNED: Final = np.array([-1j, -1.0, -1.0])
"""Elevation beside the section over what `Sections.far` holds: a source lags by a quarter."""


def mean_force(values: Array, omega: Array, sea: Sea) -> float:
    """2∫S F/ζ² dω [N]; NaN where a method does not hold in the sea.

    Beyond the last frequency F/ζ² stays what it is there: waves that are short beside the ship are
    reflected whatever their length. values [N/m²], omega [rad/s].
    """
    energy = sea.spectrum(omega)
    silent = energy < 1e-4 * energy.max()
    within = float(np.trapezoid(np.where(silent, 0.0, energy * values), omega))
    beyond = 0.0 if silent[-1] else sea.energy_above(float(omega[-1])) * float(values[-1])
    return 2 * (within + beyond)


def radiated_force(rao: Rao) -> Array:
    """Force along the waves by the energy that heave and pitch send out [N/m²].

    k/(2ωₑ) ∫ (b₃₃ - U da₃₃/dx) |V|² dx, with V the vertical velocity of a section against the
    wave, whose velocity decays with depth (Gerritsma and Beukelman 1972).
    """
    strips, k = rao.strip_sections, rao.wavenumber
    x = strips.x
    points, steps = strips.panels
    half = strips.hull.breadths / 2
    inside = np.sum(np.exp(-np.multiply.outer(k, points.real)) * points.imag * -steps.real, -1)
    share = 1 - k[:, None] * inside / half
    along = np.multiply.outer(np.cos(rao.heading), k)[..., None]
    wave = 1j * rao.omega[:, None] * share * np.exp(-1j * along * x)
    heave, pitch = (rao.mode(name)[..., None] for name in ("heave", "pitch"))
    encounter, speed = rao.encounter[..., None], rao.speed[:, None, None, None]
    velocity = 1j * encounter * (heave - x * pitch) + speed * pitch - wave
    local = np.abs(velocity) ** 2
    added = rao.rho * np.stack(
        [
            at_frequency(strips, strips.sections.added[HEAVE, HEAVE, :, s], np.abs(rao.encounter))
            for s in range(x.size)
        ],
        axis=-1,
    )
    damped = -added.imag * np.abs(encounter) * local
    between = 0.5 * (local[..., 1:] + local[..., :-1])
    growth = np.sum(np.diff(added.real, axis=-1) * between, axis=-1)
    energy = np.trapezoid(damped, x, axis=-1) - rao.speed[:, None, None] * growth
    slow = np.maximum(np.abs(rao.encounter), 1e-6)
    return np.asarray(np.where(rao.quasi_static, 0.0, k / (2 * slow) * energy))


def reflected_force(rao: Rao) -> Array:
    """Mean X, Y and N about midship of waves that sides of any depth reflect [N/m², N m/m²].

    Faltinsen's (1980) asymptote for waves that are short beside the ship, over the part of the
    waterline that the waves strike: ½ρg (c² + 2ωU/g c n_x) on the normal, with c the cosine of
    incidence.
    """
    normal, length, lever = _waterline(rao.strip_sections.hull)
    direction = np.stack([np.cos(rao.heading), -np.sin(rao.heading)], axis=-1)
    strike = np.maximum(-direction @ normal.T, 0.0)
    pushed = -length * np.column_stack([normal, lever]).T
    still, moving = (strike**2) @ pushed.T, strike @ (pushed * normal[:, 0]).T
    fast = 2 * np.multiply.outer(rao.speed, rao.omega)[:, None] / rao.g
    found = still.T[:, None, :, None] + moving.T[:, None, :, None] * fast
    return np.asarray(0.5 * rao.rho * rao.g * found)


def plate_reflection(depth: Array) -> Array:
    """Energy of waves that a plate from the surface down reflects [-]: π²I₁²/(π²I₁² + K₁²).

    Examples
    --------
    >>> plate_reflection(np.array([0.0, 0.5, 2.0])).round(3)
    array([0.   , 0.193, 0.999])
    """
    from scipy.special import i1e, k1e

    bounded = np.maximum(depth, 1e-9)
    grown = (math.pi * i1e(bounded)) ** 2
    shrunk = (k1e(bounded) * np.exp(-2 * bounded)) ** 2
    return np.asarray(grown / (grown + shrunk))


def scattering(far: Complex) -> tuple[Complex, Complex]:
    """Waves that a fixed section sends back and lets through, over those that meet it.

    The waves of heave and of sway say both: each part of the incident wave, even or odd, comes
    back whole and out of phase (Newman 1975), so that energy is kept.

    far (2 or more, …).
    """
    even, odd = (-far[row] / far[row].conj() for row in (HEAVE, SWAY))
    return 0.5 * (even + odd), 0.5 * (even - odd)


def scattered_force(rao: Rao) -> Array:
    """Mean side force and moment about midship of a ship whose sections scatter waves.

    Each section meets the wave squarely and moves as the ship does: ¼ρg(1 + |R|² - |T|²) for a
    wave of unit amplitude (Maruo 1960), times sin²β. At speed it sends out waves of the frequency
    of encounter, in waves from abaft the beam of that of the wave, which is higher.
    """
    strips = rao.strip_sections
    x = strips.x
    felt = np.maximum(np.abs(rao.encounter), rao.omega)
    sent = np.stack(
        [
            [at_frequency(strips, strips.sections.far[mode, :, s], felt) for s in range(x.size)]
            for mode in (HEAVE, SWAY, ROLL)
        ]
    )
    sent = np.moveaxis(sent, 1, -1) * _TURNED[:, None, None, None, None]
    back, through = scattering(sent)
    along = np.multiply.outer(np.cos(rao.heading), rao.wavenumber)[..., None]
    lead = np.exp(1j * along * x)
    motion = np.nan_to_num(rao.motion)[..., None]
    even = (motion[2] - x * motion[4]) * sent[HEAVE] * lead
    side = np.where(np.sin(rao.heading) < 0.0, -1.0, 1.0)[:, None, None]  # 1: they meet port
    odd = ((motion[1] + x * motion[5]) * sent[SWAY] + motion[3] * sent[ROLL]) * lead * side
    energy = 1 + np.abs(back + even + odd) ** 2 - np.abs(through + even - odd) ** 2
    across = np.sin(rao.heading)[:, None, None]
    local = -0.25 * rao.rho * rao.g * across * np.abs(across) * energy
    return np.stack([np.trapezoid(local, x), np.trapezoid(local * strips.hull.x, x)])


_HALF: Final = 0.5
"""Share of the draught whose reflection blends momentum into reflection. Beside panels (S175 and a
tanker of L/B 5.6, waves of 3 to .18 L) the whole draught blends too early: Y of the S175 by .48 of
its rms for .13, N of waves below .35 L by .69 for .34."""


def sectional_drift(rao: Rao) -> Array:
    """Mean X, Y and N about midship by what each section does by itself [N/m², N m/m²].

    X: the energy that heave and pitch send out pushes along the waves, in long waves; what the
    sides reflect pushes along their normals, in short ones; the two are blended by the energy that
    a plate of the draught reflects (Ursell 1947). In waves from abaft the beam, where energy over
    the frequency of encounter grows beyond reason, it is taken over that of the wave. Y and N: what
    the sections scatter (`scattered_force`) and what the sides reflect, blended alike.
    """
    share = plate_reflection(rao.wavenumber * rao.strip_sections.hull.draught)
    met = np.minimum(np.abs(rao.encounter) / rao.omega, 1.0)
    pushed = met * np.cos(rao.heading)[:, None] * radiated_force(rao)
    long = np.concatenate([pushed[None], scattered_force(rao)])
    return np.asarray((1 - share) * long + share * reflected_force(rao))


_ALL: Final = 1 - 1e-5
"""Share of reflection beyond which nothing of the waves sent out is left to see."""


def whole_drift(rao: Rao) -> Array:
    """Mean X, Y and N about midship by what the whole ship sends out [N/m², N m/m²].

    The momentum of these waves (`momentum_drift`), blended into what the sides reflect by the
    energy that a plate of half the draught reflects.
    """
    share = plate_reflection(_HALF * rao.wavenumber * rao.strip_sections.hull.draught)
    long = momentum_drift(rao, among=share < _ALL)
    return np.asarray((1 - share) * long + share * reflected_force(rao))


Method = Literal["momentum", "sections"]


def drift(rao: Rao, *, method: Method | None = None) -> Array:
    """Mean drift X (forward), Y (port) and N about midship of waves [N/m², N m/m²].

    By ``momentum`` (`whole_drift`) or by ``sections`` alone (`sectional_drift`); where no method is
    named what the engine itself computed, and momentum where it did not.

    Raises
    ------
    DataError
        If there is no such method.
    """
    if method is None and rao.second_order is not None:
        return rao.second_order
    if method not in (None, "momentum", "sections"):
        raise DataError(f"There is no drift by {method!r}. There is momentum, and sections.")
    found = sectional_drift(rao) if method == "sections" else whole_drift(rao)
    return significant(found)


def significant(values: Array) -> Array:
    """Values with rounding beside the largest of its kind, 1e-12 of it, as 0."""
    largest = np.abs(values).max(axis=tuple(range(1, values.ndim)), keepdims=True)
    return np.where(np.abs(values) < 1e-12 * largest, 0.0, values)


def drift_table(
    rao: Rao, sea: Sea, *, speed: float | None = None, method: Method | None = None
) -> dict[str, tuple[float, ...]]:
    """Mean drift of a sea as the table that a manoeuvring model takes.

    A DataError is raised where the frequencies leave out a tenth of the sea (`Rao.share_of`).
    """
    a = nearest(rao.speed, speed, "speed [m/s]")
    headings = np.degrees(rao.heading)
    if sea.spreading is not None:
        raise DataError("A table of drift is that of a long-crested sea: leave out spreading.")
    if headings.min() > 1e-6 or headings.max() < 180.0 - 1e-6 or (headings > 180.0 + 1e-6).any():
        raise DataError("A table of drift needs headings from 0 to 180°, both ends among them.")
    rao.share_of(sea)
    scale = rao.rho * rao.g * sea.Hs**2 * rao.L
    found = drift(rao.at_speed(a), method=method)[:, 0]
    order = np.argsort(-headings)
    # waves of heading β run to starboard; those from starboard are their mirror, and y turns round
    X, Y, N = (
        tuple(mean_force(values[b], rao.omega, sea) / size for b in order)
        for values, size in zip(found, (scale, scale, scale * rao.L), strict=True)
    )
    return {"angle_deg": tuple((180.0 - headings[order]).tolist()), "DX": X, "DY": Y, "DN": N}


def _waterline(hull: Hull) -> tuple[Array, Array, Array]:
    """Outward normals, lengths and levers of the normals about midship of the pieces of the whole
    waterline: (n, 2), (n,), (n,)."""
    x = np.r_[hull.x[0], hull.x, hull.x[-1]]
    y = np.r_[0.0, hull.breadths / 2, 0.0]
    step = np.column_stack([np.diff(x), np.diff(y)])
    middle = np.column_stack([x[1:] + x[:-1], y[1:] + y[:-1]]) / 2
    length = np.hypot(*step.T)
    whole = length > 1e-12
    step, middle, length = step[whole], middle[whole], length[whole]
    port = np.column_stack([-step[:, 1], step[:, 0]]) / length[:, None]
    lever = middle[:, 0] * port[:, 1] - middle[:, 1] * port[:, 0]
    return (
        np.concatenate([port, port * np.array([1.0, -1.0])]),
        np.concatenate([length, length]),
        np.concatenate([lever, -lever]),
    )
