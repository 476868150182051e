"""The S175 beside VERES and the time of a whole set, as the pages quote them.

    python -m scripts.studies.s175_in_waves FOLDER

FOLDER holds ``shipx_geometry.mgf`` and ``input.re1`` of the MSS toolbox's S175. Set
OMP_NUM_THREADS=1 for the time of one core.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import process_time

import numpy as np

from pmmkit.numerics import Array, rms
from pmmkit.seakeeping import Loading, added_resistance, rao, read_hull, read_rao
from pmmkit.seakeeping.mapping import fit_sections
from pmmkit.seakeeping.sectional import HEAVE, solve

HEADINGS = (180, 150, 120, 90, 60, 30, 0)
GIVEN = Loading(KG=9.55, kxx=8.331, kyy=42.0, kzz=42.0)


def main(folder: Path) -> None:
    """Print the table, the largest differences of the other motions, the time and the peaks."""
    theirs = read_rao(folder / "input.re1")
    headings = np.degrees(theirs.heading)
    hull = read_hull(folder / "shipx_geometry.mgf", draught=9.5)
    axes = {"speeds": theirs.speed, "headings_deg": headings, "omega": theirs.omega}
    times = []
    for _ in range(3):
        begun = process_time()
        found = rao(hull, **axes, loading=GIVEN)
        times.append(process_time() - begun)
    sizes = " x ".join(str(len(x)) for x in axes.values())
    print(f"{sizes}: {', '.join(f'{x:.2f}' for x in times)} s (processor)")

    def apart(mode: int, a: int, b: int, scale: Array) -> float:
        off = np.abs(found.motion[mode, a, b]) - np.abs(theirs.motion[mode, a, b])
        return rms((off / scale)[~found.quasi_static[a, b]])

    level, slope = np.ones(theirs.omega.size), found.wavenumber
    for heading in HEADINGS:
        b = int(np.argmin(np.abs(headings - heading)))
        cells = (
            f"{apart(2, a, b, level):.3f} / {apart(4, a, b, slope):.3f}"
            for a in range(theirs.speed.size)
        )
        print(f"{heading:3}° | {' | '.join(cells)}")
    for name, mode, scale in (
        ("heave", 2, level),
        ("pitch", 4, slope),
        ("sway", 1, level),
        ("yaw", 5, slope),
    ):
        rows = [
            (apart(mode, a, b, scale), theirs.speed[a], headings[b])
            for a in range(theirs.speed.size)
            for b in range(headings.size)
        ]
        told = ", ".join(
            f"{x:.3f} at {U:.1f} m/s {angle:.0f}°" for x, U, angle in sorted(rows)[:-4:-1]
        )
        print(f"{name}: largest rms {told}; median {np.median([row[0] for row in rows]):.3f}")
    far = (np.abs(found.encounter) > 0.5) & ~found.quasi_static
    k = found.wavenumber
    ours, other = (np.abs(x[3]) / k for x in (found.motion, theirs.motion))
    square = np.where(far, (ours - other) ** 2, 0.0).sum(axis=-1)
    off = np.sqrt(square / np.maximum(far.sum(axis=-1), 1))
    beam = int(np.argmin(np.abs(headings - 90)))
    size = np.where(far, other, 0.0).max(axis=-1)
    told = ", ".join(
        f"{x:.3f} of {y:.2f}" for x, y in zip(off[:, beam], size[:, beam], strict=True)
    )
    print(f"roll/kζ where ωe > .5 rad/s, beam seas: {told}")
    print(f"roll/kζ there, all headings: median rms {np.median(off):.3f}, largest {off.max():.3f}")
    added = added_resistance(found)
    head = int(np.argmin(np.abs(headings - 180)))
    for name, values in added.methods.items():
        known = (row[np.isfinite(row)] for row in values[:, head])
        peaks = (row.max() / added.unit if row.size else np.nan for row in known)
        print(f"{name}: {', '.join(f'{x:.2f}' for x in peaks)}")
    half_circle()


def half_circle() -> None:
    """Heave of a half circle: known values, the limit of long waves, and the energy it sends."""
    a = 1.0
    contour = a * np.exp(1j * np.linspace(0.0, np.pi / 2, 61))
    fit = fit_sections([contour], ["half circle"])
    numbers = np.array([0.5, 1.0, 2.0, 1e-2, 1e-3, 1e-4])
    solved = solve(fit.maps, numbers / a)
    disc = 0.5 * np.pi * a**2
    for i, Ka in enumerate(numbers):
        value = solved.added[HEAVE, HEAVE, i, 0]
        print(f"Ka {Ka:g}: a33 {value.real / disc:.4f}, b33 {-value.imag / disc:.4f}")
    print(f"8/π = {8 / np.pi:.4f}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
