"""Strip theory beside capytaine 3 on the same hull, at rest, with the processor time of both.

    python -m scripts.studies.beside_capytaine HULL.mgf DRAUGHT

capytaine is no dependency of pmmkit: install it where this runs. Set OMP_NUM_THREADS=1 for times
of one core. The sections and the panels are those of one file; added mass and damping are about
the water above the centre of buoyancy.
"""

from __future__ import annotations

import sys
from time import process_time
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.seakeeping import Hull, read_hull
from pmmkit.seakeeping.strips import coefficients, strips_of

OMEGA: Final = np.array([0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.3])
ALONG, AROUND = 60, 10
RHO: Final = 1025.0
MODES: Final = {"Sway": 1, "Heave": 2, "Roll": 3, "Pitch": 4, "Yaw": 5}


def panels(hull: Hull) -> tuple[Array, Array]:
    """Vertices and faces of the whole hull below the water, x from its centre of buoyancy."""
    rings = []
    for contour in hull.contours:
        along = np.r_[0.0, np.cumsum(np.abs(np.diff(contour)))]
        places = np.linspace(0.0, along[-1], AROUND + 1)
        depth, half = (np.interp(places, along, part) for part in (contour.real, contour.imag))
        rings.append(np.column_stack([half, -depth]))
    places = np.linspace(hull.x[0], hull.x[-1], ALONG + 1)
    stack = np.stack(rings)
    lofted = np.empty((ALONG + 1, AROUND + 1, 2))
    for point in range(AROUND + 1):
        for axis in range(2):
            lofted[:, point, axis] = np.interp(places, hull.x, stack[:, point, axis])
    x = places - hull.hydrostatics.xB
    vertices, faces = [], []
    for side in (1.0, -1.0):
        start = len(vertices)
        for i in range(ALONG + 1):
            vertices += [(x[i], side * y, z) for y, z in lofted[i]]
        for i in range(ALONG):
            for j in range(AROUND):
                a, width = start + i * (AROUND + 1) + j, AROUND + 1
                square = [a, a + 1, a + width + 1, a + width]
                faces.append(square if side > 0.0 else square[::-1])
    return np.array(vertices), np.array(faces)


def by_panels(hull: Hull) -> tuple[dict[str, Array], float, int]:
    """Added mass and damping by capytaine, (frequencies, 2), its processor time and panels."""
    import capytaine

    mesh = capytaine.Mesh(*panels(hull)).immersed_part()
    body = capytaine.FloatingBody(
        mesh=mesh,
        lid_mesh=mesh.generate_lid(),  # against irregular frequencies, the first at 1.2 rad/s
        dofs=capytaine.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)),
        name="hull",
    )
    begun = process_time()
    solver = capytaine.BEMSolver()
    problems = [
        capytaine.RadiationProblem(body=body, radiating_dof=dof, omega=omega, rho=RHO)
        for omega in OMEGA
        for dof in MODES
    ]
    results = solver.solve_all(problems, n_jobs=1, progress_bar=False)
    spent = process_time() - begun
    found = {
        dof: np.array(
            [
                (item.added_masses[dof], item.radiation_dampings[dof])
                for item in results
                if item.radiating_dof == dof
            ]
        )
        for dof in MODES
    }
    return found, spent, mesh.nb_faces


def by_strips(hull: Hull) -> tuple[dict[str, Array], float]:
    """The same by strip theory."""
    begun = process_time()
    found = RHO * coefficients(strips_of(hull, float(OMEGA[-1])), np.zeros(1), OMEGA)
    spent = process_time() - begun
    return {
        dof: np.column_stack([found[i, i].real, -OMEGA * found[i, i].imag])
        for dof, i in MODES.items()
    }, spent


def main(file: str, draught: float) -> None:
    """Print ratios of strips over panels."""
    hull = read_hull(file, draught=draught)
    theirs, long, count = by_panels(hull)
    ours, short = by_strips(hull)
    print(f"{hull.name}, {count} panels: {long:.1f} s; strips: {short:.2f} s (processor)")
    print("strips over panels, added mass and damping")
    print("omega " + " ".join(f"{dof:>13}" for dof in MODES))
    for i, omega in enumerate(OMEGA):
        cells = " ".join(
            f"{ours[dof][i, 0] / theirs[dof][i, 0]:6.3f} {ours[dof][i, 1] / theirs[dof][i, 1]:6.3f}"
            for dof in MODES
        )
        print(f"{omega:5.2f} {cells}")
    roll = {"strips": ours["Roll"][0, 0], "panels": theirs["Roll"][0, 0]}
    told = ", ".join(f"{name} {x:.2e} kg m²" for name, x in roll.items())
    print(f"added inertia in roll at {OMEGA[0]} rad/s: {told}")


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
