"""Mean drift by the momentum of the waves that a ship sends out, at rest and at speed.

Waves that a ship of speed U sends out carry as much momentum as their action times their wave
vector (m, ℓ), whose length κ = w²/g goes with w = ωₑ + Um, their frequency in water at rest; action
of w below zero is owed. Kochin's function tells it, and sections tell that, each by what flows
through it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.numerics import Array
from pmmkit.seakeeping.lengthwise import Complex, Flags, level_weights
from pmmkit.seakeeping.sectional import answers, normals
from pmmkit.seakeeping.strips import GRID, Strips, wave_velocity
from pmmkit.seakeeping.transfer import Rao

Places = NDArray[np.intp]

_FEWEST: Final = 40
"""Directions beside 1.4 for each radian over the ship on a loop, and .4 on a branch: the S175's
drift at four speeds is within 1e-4 of its largest of that with many times more."""
_SHORTEST: Final = 12.0
"""Largest wave number sent out, times the draught: where waves of encounter are long, a ship at
speed sends out some of any shortness, which sections know nothing of."""
_AT_ONCE: Final = 64


@dataclass(frozen=True, kw_only=True, eq=False)
class Asked:
    """Waves one by one.

    `k, heading, omega (waves,)`: of the incident waves [1/m, rad, rad/s]. `speed, encounter`: of
    the ship among the waves that she sends out, and their frequency aboard [m/s, rad/s].
    `motion (6, waves)` [m/m, rad/m].
    """

    k: Array
    heading: Array
    omega: Array
    speed: Array
    encounter: Array
    motion: Complex

    def of(self, some: Places) -> Asked:
        """Some of the waves."""
        return Asked(
            k=self.k[some],
            heading=self.heading[some],
            omega=self.omega[some],
            speed=self.speed[some],
            encounter=self.encounter[some],
            motion=self.motion[:, some],
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Path:
    """Wave vectors along which waves leave, of some of the waves that were asked.

    `which (some,)`: their places. `m, l, kappa (some, nodes)` [1/m], ℓ to port; each stands for the
    one to starboard too. `share`: κ/ℓ dm with the sign of w [1/m].
    """

    which: Places
    m: Array
    l: Array
    kappa: Array
    share: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Sent:
    """What sections give to Kochin's function, over e^(imx) and times it.

    Chebyshev's coefficients in ℓ/κ (waves, stations, orders): `level` of what stands alone,
    `ahead` of what goes with m.
    """

    level: Complex
    ahead: Complex


def momentum_drift(rao: Rao, *, among: Flags | None = None) -> Array:
    """Mean X, Y and N about midship, (3, speeds, headings, frequencies) [N/m², N m/m²].

    Action A dm that leaves along (m, ℓ) takes its own momentum and brings that of the incident
    wave, whose action it was (Maruo 1960; Maruo 1963): X + iY = ∫A (k - (m, ℓ)) dm, with
    A = ρg/(8πk) |H|² κ/|ℓ| and the action that roll damping takes beside. Its moment is that of H
    turned at one κ, and N holds the interference with the wave that goes on too (Newman 1967).

    Waves from abaft the beam are sent out as by a ship at rest that moves as she does, for strips
    at their long encounter are beyond reason; from there to 30° before the beam speed comes in.

    among (frequencies,): those that are computed, all where absent; the others are 0.
    """
    found = np.zeros((3, *rao.encounter.shape))
    some = np.ones(rao.omega.size, dtype=bool) if among is None else among
    asked, strips = asked_of(rao, some), rao.strip_sections
    if not asked.k.size:
        return found
    forces = np.zeros((3, asked.k.size))
    table = Answers.of(strips, asked.encounter)
    order = np.argsort(asked.encounter)
    for part in np.split(order, range(_AT_ONCE, order.size, _AT_ONCE)):
        forces[:, part] = _carried(strips, table, asked.of(part))
    forces *= rao.rho * rao.g
    rate = np.abs(rao.encounter * np.nan_to_num(rao.motion[3]))[..., some].ravel()
    taken = 0.5 * rao.roll_damping[..., some].ravel() * rate**2 / np.abs(asked.encounter)
    forces[0] += taken * asked.k * np.cos(asked.heading)
    forces[1] -= taken * asked.k * np.sin(asked.heading)
    found[..., some] = forces.reshape(3, *rao.encounter[..., some].shape)
    found[2] += rao.x * found[1]
    return found


def asked_of(rao: Rao, some: Flags) -> Asked:
    """Waves of some frequencies at all speeds and headings.

    some (frequencies,).
    """
    grown = np.clip(-2 * np.cos(rao.heading), 0.0, 1.0)
    speed = np.multiply.outer(rao.speed, grown)[..., None]
    along = np.multiply.outer(np.cos(rao.heading), rao.wavenumber)
    parts = (rao.wavenumber, rao.heading[:, None], rao.omega, speed, rao.omega - along * speed)
    k, heading, omega, slowed, encounter = (
        np.broadcast_to(part, rao.encounter.shape)[..., some].ravel() for part in parts
    )
    motion = np.nan_to_num(rao.motion)[..., some].reshape(6, -1)
    return Asked(
        k=k, heading=heading, omega=omega, speed=slowed, encounter=encounter, motion=motion
    )


def _carried(strips: Strips, table: Answers, asked: Asked) -> Array:
    """Mean X, Y and N about the origin over ρg: (3, waves)."""
    sent = sent_by_sections(strips, table, asked)
    toward = asked.k * np.stack([np.cos(asked.heading), -np.sin(asked.heading)])
    found = np.zeros((3, asked.k.size))
    for path in paths(asked, strips.g, strips.hull.L, _SHORTEST / strips.hull.draught):
        for side, H, turned in zip((1, -1), *kochin(strips.x, asked, sent, path), strict=True):
            action = path.share * np.abs(H) ** 2
            for row, out in enumerate((path.m, side * path.l)):
                found[row, path.which] += np.sum(action * (toward[row, path.which, None] - out), -1)
            found[2, path.which] += np.sum(path.share * (H.conj() * turned).imag, axis=-1)
    found /= 8 * math.pi * asked.k
    every = np.arange(asked.k.size)
    on = Path(
        which=every,
        m=toward[0, :, None],
        l=np.abs(toward[1, :, None]),
        kappa=asked.k[:, None],
        share=np.ones((asked.k.size, 1)),
    )
    _, slope = kochin(strips.x, asked, sent, on)
    found[2] += slope[(toward[1] < 0.0).astype(int), every, 0].real / (2 * asked.k)
    return found


def paths(asked: Asked, g: float, L: float, shortest: float) -> Iterator[Path]:
    """All wave vectors along which waves leave.

    Of gκ = (ωₑ + Um)² there is a loop about none where 4Uωₑ < g, and beside it two branches to
    either side; the loop opens into the one ahead where there is more. A branch ends at `shortest`
    [1/m].
    """
    U, w = asked.speed, asked.encounter
    fast = np.sqrt(g**2 + 4 * g * U * w)
    near = 2 * w**2 / (g + 2 * U * w + fast)  # k₂ = -near
    inside = g**2 - 4 * g * U * w
    slow = np.sqrt(np.maximum(inside, 0.0))
    far = 2 * w**2 / np.where(inside > 0.0, g - 2 * U * w + slow, np.inf)  # k₃
    safe = np.maximum(U, 1e-9 * math.sqrt(g * L))
    behind = -((g + 2 * U * w + fast) / (2 * safe**2))  # k₁
    ahead = (g - 2 * U * w + slow) / (2 * safe**2)  # k₄
    last, first = ((sign * math.sqrt(g * shortest) - w) / safe for sign in (1, -1))

    def path(which: Places, m: Array, l: Array, step: Array) -> Path:
        w_out = w[which, None] + U[which, None] * m
        kappa = w_out**2 / g
        return Path(which=which, m=m, l=l, kappa=kappa, share=kappa * step * np.sign(w_out))

    def nodes(radians: Array) -> int:
        return math.ceil(0.5 * _FEWEST + float(radians.max()) * L)

    closed = np.flatnonzero(inside > 0.0)
    if closed.size:
        half, middle = 0.5 * (far + near)[closed, None], 0.5 * (far - near)[closed, None]
        count = nodes(0.7 * half)
        angle = math.pi / count * (np.arange(count) + 0.5)
        m = middle + half * np.cos(angle)
        bent = U[closed, None] ** 2 * m / g
        ends = (w[closed] ** 2 / g)[:, None] / np.stack([near, far])[:, closed, None]
        narrow = np.sqrt((ends[0] + bent) * (ends[1] - bent))
        yield path(closed, m, half * np.sin(angle) * narrow, math.pi / count / narrow)
    for start, end, there in (
        (behind, first, behind > first),
        (ahead, last, (inside > 0.0) & (ahead < last)),
        (-near, last, inside <= 0.0),
    ):
        which = np.flatnonzero(there)
        if not which.size:
            continue
        reach = (end - start)[which, None]
        count = nodes(0.2 * np.abs(reach))
        s, gauss = (part[count:] for part in np.polynomial.legendre.leggauss(2 * count))
        m = start[which, None] + reach * s**2
        size = (w[which, None] + U[which, None] * m) ** 2 / g
        l = np.sqrt(np.maximum((size - m) * (size + m), 1e-300))
        yield path(which, m, l, 2 * np.abs(reach) * s * gauss / l)


def kochin(x: Array, asked: Asked, sent: Sent, path: Path) -> tuple[Complex, Complex]:
    """H along a path, and its slope where the wave vector turns at one κ: (2, some, nodes), to port
    and to starboard.

    Polynomials of even order in ℓ/κ are alike to both sides, those of odd order opposite; their
    slopes the other way round.
    """
    across = np.arccos(np.clip(path.l / path.kappa, -1.0, 1.0))[..., None]
    weight = level_weights(x, (asked.k * np.cos(asked.heading))[path.which, None] - path.m)
    m, count = path.m[..., None], x.size
    sums = []
    for first in (0, 1):
        order = np.arange(first, sent.level.shape[-1], 2)
        of_order = [part[path.which][..., first::2] for part in (sent.level, sent.ahead)]
        both = np.ascontiguousarray(np.swapaxes(np.concatenate(of_order, axis=1), 1, 2))
        waves, leaning = np.cos(across * order), np.sign(m) * order * np.sin(across * order)
        # shapes are real: as pairs of real numbers the product takes half of the time
        alone, slope = ((part @ both.view(float)).view(complex) for part in (waves, leaning))
        local = alone[..., :count] + m * alone[..., count:]
        bent = slope[..., :count] + m * slope[..., count:]
        parts = (local, 1j * x * local + alone[..., count:], bent)
        sums.append([np.einsum("cts,cts->ct", weight, part) for part in parts])
    even, odd = sums
    return (
        np.stack([even[0] + odd[0], even[0] - odd[0]]),
        np.stack(
            [
                even[2] + odd[2] - path.l * (even[1] + odd[1]),
                odd[2] - even[2] + path.l * (even[1] - odd[1]),
            ]
        ),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Answers:
    """What a unit flow through each node of the sections sends out across.

    `omega, K`: frequency aboard and ωₑ²/g [rad/s, 1/m]. `points, steps (stations, nodes)`. `across
    (directions,)`: ℓ/κ. `even, odd, cosine, sine (K, stations, nodes, directions)`: with what it
    stirs up, and alone.
    """

    omega: Array
    K: Array
    points: Complex
    steps: Complex
    across: Array
    even: Complex
    odd: Complex
    cosine: Array
    sine: Array

    @classmethod
    def of(cls, strips: Strips, encounter: Array) -> Answers:
        """For frequencies of encounter: of each, or of a grid where they are many."""
        omega = np.unique(encounter)
        if omega.size > GRID:
            omega = np.geomspace(omega[0], omega[-1], GRID)
        K = omega**2 / strips.g
        maps = strips.fit.maps
        widest = 0.5 * float(strips.hull.breadths.max())
        count = 6 + math.ceil(0.5 * float(K[-1]) * widest)
        across = np.cos(0.25 * math.pi / count * (2 * np.arange(count) + 1))
        parts = []
        for k in K[:, None]:
            points, steps, *potentials = answers(maps, k)
            waves = wave_velocity(points, steps, k, across)
            decay = np.exp(-k * points.real)[..., None]
            phase = np.multiply.outer(k * points.imag, across)
            cosine, sine = decay * np.cos(phase), decay * np.sin(phase)
            stirred = [
                np.moveaxis(potential[:, 0], 0, 1) @ np.moveaxis(wave[:, 0], 0, 2)
                for potential, wave in zip(potentials, waves, strict=True)
            ]
            even, odd = 2 * cosine - k * stirred[0], 2j * sine - k * stirred[1]
            parts.append((even, odd, cosine, sine))
        even, odd, cosine, sine = (np.stack(part) for part in zip(*parts, strict=True))
        return cls(
            omega=omega,
            K=K,
            points=points,
            steps=steps,
            across=across,
            even=even,
            odd=odd,
            cosine=cosine,
            sine=sine,
        )


def sent_by_sections(strips: Strips, table: Answers, asked: Asked) -> Sent:
    """What sections send out of the flow through their sides, which they answer, and their ends.

    Over k times the potential of the incident wave, flow is that of the motion less that of the
    wave: a ship that goes with the water sends out nothing.
    """
    x, points, steps = strips.x, table.points, table.steps
    up, out, turn = normals(points, steps)
    surge, sway, heave, roll, pitch, yaw = asked.motion[..., None] * np.exp(
        1j * np.multiply.outer(asked.k * np.cos(asked.heading), x)
    )
    met = (asked.encounter / asked.omega)[:, None]
    swept = (asked.speed / (1j * asked.omega))[:, None]
    lift = met * (heave - x * pitch) + swept * pitch
    side = met * (sway + x * yaw) - swept * yaw
    k, p = asked.k[:, None, None], (asked.k * np.sin(asked.heading))[:, None, None]
    decay = np.exp(-k * points.real)
    cosine, sine = decay * np.cos(p * points.imag), decay * np.sin(p * points.imag)
    lean = np.sin(asked.heading)[:, None, None]
    even = lift[..., None] * up - (cosine * up - lean * sine * out)
    odd = side[..., None] * out + (met * roll)[..., None] * turn
    odd = odd - 1j * (sine * up + lean * cosine * out)
    area = -2 * steps.real
    moved = (met * surge)[..., None] * area - (met * pitch)[..., None] * area * points.real

    directions = table.across.size
    shape = (asked.k.size, x.size, directions)
    sides, ends, going = np.zeros((3, 2, *shape), dtype=np.complex128)
    for place, cases, share in _neighbours(table.omega, asked.encounter):
        q = table.K[place] * table.across
        flows = [
            np.swapaxes(np.swapaxes(flow[cases], 0, 1) @ answer[place], 0, 1)
            for flow, answer in (
                (even, table.even),
                (odd, table.odd),
                (moved, table.sine),
                (area * sine, table.cosine),
                (area * cosine, table.sine),
            )
        ]
        share = share[:, None, None]
        sides[0, cases] += share * flows[0]
        sides[1, cases] += share * flows[1]
        going[0, cases] += share * flows[2] / q
        apart = share / (p[cases] ** 2 - q**2)
        ends[0, cases] += apart * (flows[3] * p[cases] - flows[4] * q)
        ends[1, cases] += apart * (flows[4] * p[cases] - flows[3] * q)
    facing = k * np.cos(asked.heading)[:, None, None]
    level: Complex = np.asarray(k * sides + facing**2 * ends)
    ahead = np.asarray(1j * k * going - facing * ends)
    return Sent(level=_chebyshev(level), ahead=_chebyshev(ahead))


def _neighbours(grid: Array, wanted: Array) -> Iterator[tuple[int, Places, Array]]:
    """Places of a grid, what is wanted beside them, and its shares by cubics through four."""
    most = min(4, grid.size)
    first = np.clip(np.searchsorted(grid, wanted) - most // 2, 0, grid.size - most)
    beside = grid[first[:, None] + np.arange(most)]
    for place in range(most):
        others = np.delete(beside, place, axis=1)
        share = np.prod((wanted[:, None] - others) / (beside[:, place, None] - others), axis=1)
        for one in np.unique(first[share != 0.0]):
            cases = np.flatnonzero((first == one) & (share != 0.0))
            yield int(one) + place, cases, np.asarray(share[cases])


def _chebyshev(values: Complex) -> Complex:
    """Coefficients of all orders out of values (2, …, directions) of what is even and odd."""
    count = values.shape[-1]
    angle = 0.25 * math.pi / count * (2 * np.arange(count) + 1)
    found: Complex = np.empty((*values.shape[1:-1], 2 * count), dtype=complex)
    for first in (0, 1):
        order = 2 * np.arange(count) + first
        found[..., first::2] = values[first] @ np.linalg.inv(np.cos(np.outer(order, angle)))
    return found
