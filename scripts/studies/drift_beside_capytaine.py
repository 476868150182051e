"""Mean drift at rest beside the far field of capytaine 3: hemisphere, box, Wigley hull, S175.

    python -m scripts.studies.drift_beside_capytaine

capytaine is no dependency of pmmkit: install it where this runs. Its Kochin functions are made
forces by the action that they carry, whose size damping in heave tells, and whose interference with
the incident wave the balance of a fixed hull does: no constant of them is ours.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.seakeeping import Hull, Loading, Rao, load_hull, rao
from pmmkit.seakeeping.hull_forms.hull import Station
from pmmkit.seakeeping.second_order.mean_drift import drift
from pmmkit.seakeeping.strips import mass_matrix, restoring
from scripts.studies.beside_capytaine import body_of
from scripts.validation.wigley import loaded, wigley

RATIOS: Final = (3.0, 2.0, 1.4, 1.0, 0.7, 0.5, 0.4)
"""Lengths of waves over that of the hull."""
HEADINGS: Final = (180.0, 150.0, 120.0, 90.0, 60.0, 30.0, 0.0)
ANGLES: Final = np.linspace(0.0, 2 * math.pi, 180, endpoint=False)


def _hull(name: str, L: float, d: float, rows: list[tuple[float, Array, Array]]) -> Hull:
    stations = tuple(Station(x=x, y=y, z=z) for x, y, z in rows)
    return Hull(name=name, L=L, draught=d, stations=stations)


def hemisphere(radius: float = 10.0) -> Hull:
    """Half a ball that floats to its middle."""
    angle = np.linspace(0.0, 0.5 * math.pi, 25)
    places = 0.995 * radius * np.sin(np.linspace(-0.5 * math.pi, 0.5 * math.pi, 31))
    size = np.sqrt(radius**2 - places**2)
    rows = [
        (x, r * np.sin(angle), radius - r * np.cos(angle))
        for x, r in zip(places.tolist(), size, strict=True)
    ]
    return _hull("hemisphere", 2 * radius, radius, rows)


def box(L: float = 100.0, B: float = 20.0, d: float = 8.0) -> Hull:
    """A barge with upright sides and ends."""
    bottom, side = np.linspace(0.0, 0.5 * B, 13), np.linspace(0.0, d, 11)[1:]
    y, z = np.r_[bottom, np.full(10, 0.5 * B)], np.r_[0.0 * bottom, side]
    return _hull("box", L, d, [(x, y, z) for x in np.linspace(-L / 2, L / 2, 31).tolist()])


def by_panels(found: Rao) -> Array:
    """X, Y and N about midship by capytaine: (3, headings, frequencies)."""
    import capytaine
    from capytaine.post_pro.kochin import compute_kochin

    assert found.strips is not None
    assert found.loading is not None
    body, hull = body_of(found.strips.hull), found.strips.hull
    solver = capytaine.BEMSolver()
    dofs = list(body.dofs)
    mass = mass_matrix(found.strips, found.loading, found.rho)
    still = found.rho * restoring(found.strips, found.loading)
    result = np.empty((3, found.heading.size, found.omega.size))
    for place, omega in enumerate(found.omega):
        given = {"body": body, "omega": omega, "rho": found.rho, "g": found.g}
        moved = [
            solver.solve(capytaine.RadiationProblem(radiating_dof=dof, **given)) for dof in dofs
        ]
        added = np.array([[one.added_masses[dof] for one in moved] for dof in dofs])
        damping = np.array([[one.radiation_dampings[dof] for one in moved] for dof in dofs])
        heave = dofs.index("Heave")
        sent = np.array([compute_kochin(one, ANGLES).conj() for one in moved])
        unit = omega * damping[heave, heave] / (2 * _mean(np.abs(sent[heave]) ** 2))
        damping[3, 3] += found.roll_damping[0, 0, place]
        system = still - omega**2 * (mass + added) - 1j * omega * damping
        fixed: list[Any] = []
        for heading in found.heading:
            one = solver.solve(capytaine.DiffractionProblem(wave_direction=-heading, **given))
            force = np.array([one.forces[dof] + _pushed(one, dof) for dof in dofs])
            motion = np.linalg.solve(system, force).conj()
            fixed.append((compute_kochin(one, ANGLES).conj(), motion))
        toward = -found.heading
        held = np.array(
            [_at(scattered, a) for (scattered, _), a in zip(fixed, toward, strict=True)]
        )
        balance = unit * np.array([_mean(np.abs(scattered) ** 2) for scattered, _ in fixed])
        (real, imaginary), *_ = np.linalg.lstsq(
            np.column_stack([held.real, -held.imag]), balance, rcond=None
        )
        met = real + 1j * imaginary
        k = omega**2 / found.g
        for row, ((scattered, motion), a) in enumerate(zip(fixed, toward, strict=True)):
            H = scattered + motion @ sent
            action = unit * np.abs(H) ** 2
            taken = 0.5 * found.roll_damping[0, 0, place] * omega * abs(motion[3]) ** 2
            X, Y = (
                k * (_mean(action * (ahead(a) - ahead(ANGLES))) + taken * ahead(a))
                for ahead in (np.cos, np.sin)
            )
            slope = _turned(H)
            N = unit * _mean((H.conj() * slope).imag) + (1j * met * _at(slope, a)).real
            result[:, row, place] = X, Y, N + hull.hydrostatics.xB * Y
    return result


def _pushed(one: Any, dof: str) -> complex:
    """Force of the incident wave by its pressure."""
    from capytaine.bem.airy_waves import froude_krylov_force

    return complex(froude_krylov_force(one.problem)[dof])


def _mean(values: Array) -> float:
    return float(values.mean() * 2 * math.pi)


def _turned(values: Array) -> Array:
    order = np.fft.fftfreq(values.size, 1 / values.size)
    return np.asarray(np.fft.ifft(np.fft.fft(values) * 1j * order))


def _at(values: Array, angle: float) -> complex:
    order = np.fft.fftfreq(values.size, 1 / values.size)
    return complex(np.sum(np.fft.fft(values) / values.size * np.exp(1j * order * angle)))


def main() -> None:
    """Print differences over the rms, and the worst over the largest."""
    import capytaine

    capytaine.set_logging("ERROR")
    hulls = [hemisphere(), box(), wigley("III"), load_hull("s175-design")]
    for hull in hulls:
        loading = loaded(hull) if hull.name.startswith("Wigley") else Loading.of(hull)
        omega = np.sqrt(2 * math.pi * 9.81 / (np.array(RATIOS) * hull.L))
        found = rao(hull, speeds=0.0, headings_deg=HEADINGS, omega=omega, loading=loading)
        theirs = by_panels(found)
        print(f"{hull.name}: rms / worst of X, Y, N")
        for method in ("momentum", "sections"):
            ours = drift(found, method=method)[:, 0]
            cells = [
                f"{math.sqrt(np.mean((a - b) ** 2) / np.mean(b**2)):.2f} / "
                f"{np.abs(a - b).max() / np.abs(b).max():.2f}"
                for a, b, lever in zip(ours, theirs, (1.0, 1.0, hull.L), strict=True)
                if np.abs(b).max() > 1e-3 * lever * np.abs(theirs[1]).max()
            ]
            print(f"  {method:<10} {', '.join(cells)}")


if __name__ == "__main__":
    main()
