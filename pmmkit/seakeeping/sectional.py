"""Added mass, damping and potentials of sections that oscillate at the free surface.

Ursell's method (1949) on conformal maps, for heave as in Tasai (1959), for sway and roll as in
Tasai (1961): a source (heave) or a dipole (sway, roll) at the origin and multipoles that satisfy
the condition of the free surface each by itself, whose strengths follow from the stream function
on the section. It has no irregular frequencies. The section lies in w = y + ix, y down, x outward;
time is e^(iωt); deep water.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.seakeeping.lengthwise import Complex
from pmmkit.seakeeping.mapping import at, slope

MULTIPOLES: Final = 20  # what is lost of the energy falls with the square of their number
NODES: Final = 36
HEAVE, SWAY, ROLL = 0, 1, 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Sections:
    """What sections do in water when they oscillate.

    `wavenumber (frequencies,)`: k = ω²/g [1/m]. `points, weights (sections, nodes)`: points w =
    y + ix [m] of half of each section, and dw [m] by which sums integrate along it. `potentials
    (3, frequencies, sections, nodes)`: of unit velocity in heave, sway and roll, of the signs
    of `normals`, at the points [m²/s per m/s; per rad/s for roll]. `added (3, 3, frequencies,
    sections)`: a - ib/ω over ρ [m²; m³ and m⁴ where roll takes part], symmetric (Timman and
    Newman 1962). `far (3, frequencies, sections)`: amplitude of the waves sent out over that of
    the motion [-; m for roll].
    """

    wavenumber: Array
    points: Complex
    weights: Complex
    potentials: Complex
    added: Complex
    far: Complex


def normals(points: Complex, weights: Complex) -> Array:
    """The normals times arc length, out of the body: up, outward, out·n_up + depth·n_out.

    Up is against the depth; roll is positive where the outward side rises.
    """
    up, out = -weights.imag, -weights.real
    return np.stack([up, out, points.imag * up + points.real * out])


SHORTEST: Final = 500.0
"""Wavenumber times the size of the section beyond which nothing changes any more: e^-500 is what
the waves are at the keel, and e^-745 is no number."""


def solve(maps: Array, wavenumber: Array) -> Sections:
    """The radiation problems of sections for all frequencies at once.

    maps (sections, coefficients); wavenumber (frequencies,); wavenumber [1/m].

    Examples
    --------
    A half circle of radius 1 m at Ka = 1 (Ursell 1949):

    >>> found = solve(np.array([[1.0, 0.0, 0.0]]), np.array([1.0]))
    >>> heave = found.added[0, 0, 0, 0] / (np.pi / 2)
    >>> f"{heave.real:.3f} {-heave.imag:.3f}"
    '0.605 0.396'
    """
    theta, points, weights = _nodes(maps)
    given, wavenumber = wavenumber, _bounded(wavenumber, points)
    even = multipoles(maps, theta, wavenumber, odd=False)
    odd = multipoles(maps, theta, wavenumber, odd=True)
    stream = (-points.imag, -points.real, -0.5 * np.abs(points) ** 2)
    heave, source = strengths(even, stream[:1])
    across, dipole = strengths(odd, stream[1:], free=True)
    potentials = np.concatenate([heave, across])
    # the source sends out waves of π K, the dipole of π K², per unit of their strength
    far = math.pi * np.concatenate(
        [wavenumber[:, None] * source, wavenumber[:, None] ** 2 * dipole]
    )
    added = -2 * np.einsum("jfsn,isn->ijfs", potentials, normals(points, weights))
    even_odd = np.equal.outer(np.arange(3) == HEAVE, np.arange(3) == HEAVE)
    return Sections(
        wavenumber=given,
        points=points,
        weights=weights,
        potentials=potentials,
        added=added * even_odd[:, :, None, None],
        far=far.astype(np.complex128),
    )


def _nodes(maps: Array) -> tuple[Array, Complex, Complex]:
    """Angles of the nodes, their points w and the weights dw."""
    nodes, gauss = np.polynomial.legendre.leggauss(NODES)
    theta = 0.25 * math.pi * (nodes + 1)
    return theta, at(maps, theta), slope(maps, theta) * (0.25 * math.pi * gauss)


def _bounded(wavenumber: Array, points: Complex) -> Array:
    return np.minimum(wavenumber, SHORTEST / float(np.abs(points).max()))


def answers(maps: Array, wavenumber: Array) -> tuple[Complex, Complex, Complex, Complex]:
    """Points, weights and the potentials of any motion of the section's surface, even and odd.

    The potentials (nodes of the flow, frequencies, sections, nodes) are those of a unit flow
    through each node [m²/s] of the sign of `normals`: the stream function grows along the section
    by what flows through it.

    maps (sections, coefficients); wavenumber [1/m].
    """
    theta, points, weights = _nodes(maps)
    bounded = _bounded(wavenumber, points)
    streams = tuple(np.broadcast_to(column, points.shape) for column in _running_sums().T)
    even = strengths(multipoles(maps, theta, bounded, odd=False), streams)[0]
    odd = strengths(multipoles(maps, theta, bounded, odd=True), streams, free=True)[0]
    return points, weights, even, odd


@cache
def _running_sums() -> Array:
    """Integrals from the keel to each node by what stands at all nodes, weights taken."""
    legendre = np.polynomial.legendre
    nodes, _ = legendre.leggauss(NODES)
    degrees = np.arange(NODES)
    grown = np.stack(
        [legendre.legval(nodes, legendre.legint(np.eye(NODES)[m], lbnd=-1)) for m in degrees], -1
    )
    return np.asarray((grown * (degrees + 0.5)) @ legendre.legvander(nodes, NODES - 1).T)


def multipoles(maps: Array, theta: Array, wavenumber: Array, *, odd: bool) -> Complex:
    """Complex potentials on the sections, shape (2, functions, frequencies, sections, nodes).

    The first of two is what is in phase, the second what sends out waves (of the first function
    only): each is φ + iψ, the i of the plane.

    maps (sections, coefficients); wavenumber [1/m].
    """
    points = at(maps, theta)
    K = wavenumber[:, None, None]
    decay = np.exp(-K * points)
    source = decay * _exponential_integral(-K * points) - 1j * math.pi * decay
    if odd:
        first = np.stack([1j * (-1 / points - K * source), 1j * K * math.pi * decay])
    else:
        first = np.stack([source, -math.pi * decay])
    order = np.arange(1, MULTIPOLES + 1)
    power = 2 * order + (1 if odd else 0)
    n = np.arange(maps.shape[1])
    below = power[:, None] + 2 * n - 1
    circle = np.exp(-1j * np.multiply.outer(below, theta))
    ratio = (2 * n - 1) / below
    tail = np.einsum("sn,mn,mnt->mst", maps, ratio, circle)
    lead = np.exp(-1j * np.multiply.outer(power, theta))
    found = lead[:, None, None, :] - K * tail[:, None]
    found = np.broadcast_to(found, (MULTIPOLES, *source.shape))
    found = (1j if odd else 1.0) * found
    return np.stack(
        [
            np.concatenate([first[0][None], found]),
            np.concatenate([first[1][None], np.zeros_like(found)]),
        ]
    )


def _exponential_integral(z: Complex) -> Complex:
    from scipy.special import exp1

    return np.asarray(exp1(z))


def strengths(
    functions: Complex, stream: tuple[Array, ...], *, free: bool = False
) -> tuple[Complex, Complex]:
    """Potentials at the nodes and the strength of the first function, by least squares."""
    in_phase, outgoing = functions
    columns = np.moveaxis(in_phase.imag + 1j * outgoing.imag, 0, -1)
    if free:
        columns = np.concatenate([columns, np.ones((*columns.shape[:-1], 1))], axis=-1)
    size = np.linalg.norm(columns, axis=-2, keepdims=True)
    q, r = np.linalg.qr(columns / size)
    wanted = np.stack(stream, axis=-1)[None]
    found = np.linalg.solve(r, np.swapaxes(q.conj(), -1, -2) @ wanted) / np.swapaxes(size, -1, -2)
    kept = found[..., : in_phase.shape[0], :]
    values = np.moveaxis(in_phase.real + 1j * outgoing.real, 0, -1)
    potentials = np.moveaxis(values @ kept, -1, 0)
    return potentials, np.moveaxis(kept[..., 0, :], -1, 0)
