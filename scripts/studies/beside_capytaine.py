"""Strip theory beside capytaine 3 on the same hull, at rest, with the processor time of both.

    python -m scripts.studies.beside_capytaine HULL.mgf DRAUGHT

capytaine is no dependency of pmmkit: install it where this runs. Set OMP_NUM_THREADS=1 for times
of one core. The sections and the panels are those of one file; added mass and damping are about
the water above the centre of buoyancy.
"""

from __future__ import annotations

import sys
from time import process_time
from typing import Any, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.seakeeping import Hull, read_hull
from pmmkit.seakeeping.strips import coefficients, strips_of

OMEGA: Final = np.array([0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.3])
RHO: Final = 1025.0
MODES: Final = {"Sway": 1, "Heave": 2, "Roll": 3, "Pitch": 4, "Yaw": 5}


def body_of(hull: Hull, across: int = 10) -> Any:
    """The hull below the water as capytaine takes it, with a lid, x from the centre of buoyancy."""
    import capytaine

    port = hull.panels(across) - np.array([hull.hydrostatics.xB, 0.0, 0.0])
    corners = np.concatenate([port, port[:, ::-1] * np.array([1.0, -1.0, 1.0])])
    mesh = capytaine.Mesh(corners.reshape(-1, 3), np.arange(4 * len(corners)).reshape(-1, 4))
    mesh = mesh.immersed_part()
    return capytaine.FloatingBody(
        mesh=mesh,
        lid_mesh=mesh.generate_lid(),  # against irregular frequencies
        dofs=capytaine.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)),
        name=hull.name,
    )


def by_panels(hull: Hull) -> tuple[dict[str, Array], float, int]:
    """Added mass and damping by capytaine, (frequencies, 2), its processor time and panels."""
    import capytaine

    body = body_of(hull)
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
    return found, spent, body.mesh.nb_faces


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
