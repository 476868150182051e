"""Mean drift at rest by the momentum of the waves that a ship sends out.

Far away the waves of a ship that moves and scatters in a unit wave have the amplitude f(θ)/√R in
the direction θ. Sections tell it by Kochin's function, the waves of whatever flows through them.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.seakeeping.lengthwise import Complex, weights
from pmmkit.seakeeping.motions import critical_of, mass_matrix, restoring
from pmmkit.seakeeping.sectional import answers, normals
from pmmkit.seakeeping.strips import coefficients, wave_velocity
from pmmkit.seakeeping.transfer import Rao

_FEWEST: Final = 48
"""Directions beside kL of them: products of f hold harmonics to kL and a few more, which 24 are
enough for."""


def momentum_drift(rao: Rao) -> Array:
    """Mean X, Y and N about midship of a ship at rest, (3, headings, frequencies) [N/m², N m/m²].

    In X and Y what a fixed point sees of the interference of f with the wave is had from the
    energy, as in Maruo (1960): ¼ρg ∫|f|² (α - θ) dθ and k/ω of the power that roll damping beside
    the waves takes, along the wave, α and θ being unit vectors. N is ρg/4k (∫ Im f̄f' dθ +
    2 Im D̄f'(α)) with D = √(2π/k) e^(iπ/4) (Newman 1967).
    """
    towards = -rao.heading
    found = np.empty((3, rao.heading.size, rao.omega.size))
    for place in range(rao.omega.size):
        k = float(rao.wavenumber[place])
        angles = np.linspace(
            0.0, 2 * math.pi, _FEWEST + 2 * math.ceil(0.7 * k * rao.L), endpoint=False
        )
        sent = waves_sent(rao, place, angles)
        found[:, :, place] = 0.25 * rao.rho * rao.g * _fluxes(sent, angles, towards, k)
    found[:2] += _absorbed(rao) * rao.wavenumber / rao.omega * _along(towards)[..., None]
    found[2] += rao.x * found[1]
    return found


def _along(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)])


def _fluxes(sent: Complex, angles: Array, towards: Array, k: float) -> Array:
    """Momentum along x and y and moment about the origin over ¼ρg: (3, headings)."""
    step = 2 * math.pi / angles.size
    energy = np.abs(sent) ** 2 * step
    pushed = energy.sum(-1) * _along(towards) - _along(angles) @ energy.T
    order = np.fft.fftfreq(angles.size, 1 / angles.size)
    harmonics = np.fft.fft(sent) / angles.size * 1j * order
    turning = np.fft.ifft(harmonics) * angles.size
    ahead = np.sum(harmonics * np.exp(1j * np.outer(towards, order)), axis=-1)
    plane = math.sqrt(2 * math.pi / k) * np.exp(-0.25j * math.pi)
    around = np.sum((sent.conj() * turning).imag, axis=-1) * step
    return np.concatenate([pushed, [(around + 2 * (plane * ahead).imag) / k]])


def waves_sent(rao: Rao, place: int, angles: Array) -> Complex:
    """f [√m] of a ship at rest in waves of one frequency, (headings, angles).

    Kochin's function ∫ (∂φ/∂n - φ ∂/∂n) e^(kz + ik(x cos θ + y sin θ)) dS of what flows through the
    sides of sections, which answer each by itself, and through the ends, which do not.

    angles (angles,) [rad], from x to y.
    """
    strips, k = rao.strip_sections, rao.wavenumber[place : place + 1]
    x, size = strips.x, float(k[0])
    cos_from, sin_from = np.cos(rao.heading), np.sin(rao.heading)
    cos_to, sin_to = np.cos(angles), np.sin(angles)
    rest = int(np.flatnonzero(rao.speed == 0.0)[0])
    motion = np.nan_to_num(rao.motion[:, rest, :, place])[..., None]
    lead = np.exp(1j * size * np.outer(cos_from, x))
    heave, sway, roll = (
        (each * lead)[..., None]
        for each in (motion[2] - x * motion[4], motion[1] + x * motion[5], motion[3])
    )

    def through(points: Complex, steps: Complex) -> tuple[Complex, Complex]:
        """Flow through half of the sections, over k times the potential of the wave."""
        up, out, turn = normals(points, steps)
        even, odd = (part[:, 0] / 2 for part in wave_velocity(points, steps, k, sin_from))
        return heave * up - even, sway * out + roll * turn - odd

    points, steps, *answer = answers(strips.fit.maps, k)
    local: Complex = np.zeros((rao.heading.size, angles.size, x.size), dtype=complex)
    for flow, potential, wave in zip(
        through(points, steps), answer, wave_velocity(points, steps, k, sin_to), strict=True
    ):
        moved = np.einsum("jsn,bsj->bsn", potential[:, 0], flow, optimize=True)
        local -= size**2 * np.einsum("bsn,tsn->bts", moved, wave[:, 0], optimize=True)
    points, steps = strips.panels
    decay = np.exp(-size * points.real)
    phase = size * np.multiply.outer(sin_to, points.imag)
    for flow, wave in zip(
        through(points, steps), (2 * decay * np.cos(phase), 2j * decay * np.sin(phase)), strict=True
    ):
        local += size * np.einsum("bsn,tsn->bts", flow, wave, optimize=True)

    def area(decayed: Array, across: Array) -> Array:
        """∫ of what decays with depth and runs across, over the areas of sections."""
        shape = np.sinc(size / math.pi * np.multiply.outer(across, points.imag))
        return np.asarray(np.sum(2 * points.imag * -steps.real * decayed * shape, axis=-1))

    surge, pitch = (motion[mode][:, None] * lead[:, None] for mode in (0, 4))
    moved = surge * area(decay, sin_to) - pitch * area(points.real * decay, sin_to)
    crossing = area(decay**2, np.add.outer(sin_from, sin_to))
    against = (cos_from[:, None] * np.subtract.outer(-cos_from, -cos_to))[..., None]
    local += size**2 * (1j * cos_to[:, None] * moved - against * crossing)
    level, _ = weights(x, size * np.subtract.outer(cos_from, cos_to))
    kochin = np.sum(level * local, axis=-1)
    return np.asarray(1j * math.sqrt(size / (2 * math.pi)) * np.exp(0.25j * math.pi) * kochin)


def _absorbed(rao: Rao) -> Array:
    """Power that the roll damping beside the waves takes, its linear part [W/m²]."""
    if rao.loading is None:
        return np.zeros((rao.heading.size, rao.omega.size))
    strips = rao.strip_sections
    added = rao.rho * coefficients(strips, np.zeros(1), rao.omega)
    stiffness = rao.rho * restoring(strips, rao.loading)
    critical = critical_of(stiffness, mass_matrix(strips, rao.loading, rao.rho), added)
    rest = int(np.flatnonzero(rao.speed == 0.0)[0])
    rate = rao.omega * np.abs(np.nan_to_num(rao.motion[3, rest]))
    return np.asarray(0.5 * rao.loading.roll_damping * critical * rate**2)
