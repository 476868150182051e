"""A programme for STAR-CCM+: of each run the table of its motion, and the reports that come back.

A file table has its names in the first row with units in parentheses; an expression asks for a
column by its name without the unit (user guide: File Format Reference, Interpolating and
Differentiating Table Values).
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.campaigns import Campaign
from pmmkit.diagnosis import Programme
from pmmkit.exports.programme.solver import NO_DAY, TowingSolver, held_in_words, origin_in_words
from pmmkit.exports.programme.towed_path import TowedPath

MOTION: Final = "motion.csv"
HEADS: Final = (
    "t (s)",
    "x (m)",
    "y (m)",
    "z (m)",
    "psi (rad)",
    "vx (m/s)",
    "vy (m/s)",
    "r (rad/s)",
)
"""Columns of the table of a motion."""


def write_run(folder: Path, path: TowedPath, campaign: Campaign) -> None:
    """The table of a run."""
    del campaign
    folder.mkdir(parents=True)
    (folder / MOTION).write_bytes(motion_text(path).encode())


def motion_text(path: TowedPath) -> str:
    """The table of a motion: x forward, y to port, z up, turned about z."""
    columns = [path.t, path.x, 0.0 - path.y, 0.0 * path.t, 0.0 - path.psi]
    columns += [path.xdot, 0.0 - path.ydot, 0.0 - path.r]
    rows = io.StringIO()
    np.savetxt(rows, np.column_stack(columns), fmt="%.10g", delimiter=",")
    return ",".join(HEADS) + "\n" + rows.getvalue()


def how_to(programme: Programme, campaign: Campaign) -> list[str]:
    """What to do with the tables."""
    first = programme.runs[0].id
    return [
        "STAR-CCM+: a folder a run in runs/, with the table of its motion.",
        "",
        "1. The mesh has x forward, y to port, z up. Its origin is",
        f"   {origin_in_words(campaign)}.",
        "   The whole region is towed through water at rest: no current, no inflow.",
        "2. Tools > Tables > New > File Table: motion.csv, called motion. All is SI.",
        "3. Tools > Motions > New > Trajectory, for the region, by the columns t, x, y, z. Over it",
        "   a superposing Rotation about [0, 0, 1] through the origin, by the angle",
        '   interpolateTable(@Table("motion"), "t", SPLINE, "psi", ${Time})',
        "   Or Translation with the velocities vx and vy, over it a Rotation with the rate r.",
        "   The motion starts from rest; after the run-up (run-up [s] in programme.csv) it is that",
        "   of the test.",
        "4. Reports of the hull, pressure and shear, in the laboratory coordinate system:",
        "   Fx  Force, direction [1, 0, 0]      Fy  Force, direction [0, 1, 0]",
        "   Mz  Moment, axis [0, 0, 1], origin [0, 0, 0]: it stays there",
        "   A monitor of each, triggered by time step; the three in one plot over Physical Time.",
        "5. Compute to the end time (end time [s] in programme.csv). Export the plot of each run:",
        f"   runs/{first}/forces.csv; after a restart a second one, forces_2.csv.",
        "6. pmmkit reduce . in this folder. Runs that are not computed yet are left out.",
        NO_DAY,
        *held_in_words(programme),
    ]


STARCCM: Final = TowingSolver(
    format="star-ccm+", forces="forces*.csv", motion=MOTION, write_run=write_run, how_to=how_to
)
