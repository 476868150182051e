"""A programme for OpenFOAM: of each run the part of a case that moves the mesh and writes forces.

The table is that of ``tabulated6DoFMotion``: a list of ``(t ((x y z) (rx ry rz)))`` with its length
before it, metres and degrees, in between a spline; the solver stops with an error beyond the last
row. Source: ``tabulated6DoFMotion.C`` and the tutorial ``sloshingTank3D6DoF`` of the OpenFOAM
Foundation and of OpenCFD.
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

MOTION: Final = "constant/6DoF.dat"


def write_run(folder: Path, path: TowedPath, campaign: Campaign) -> None:
    """The part of a case that is of a run."""
    for name, text in {
        MOTION: motion_text(path),
        "constant/dynamicMeshDict": _DYNAMIC_MESH,
        "system/forces": _FORCES.format(rho=f"{campaign.water.rho:.10g}"),
        "system/times": _TIMES.format(end=f"{path.end:.10g}", run_up=f"{path.run_up:.10g}"),
    }.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text.encode())


def motion_text(path: TowedPath) -> str:
    """The table of six degrees of freedom: x forward, y to port, z up."""
    table = np.column_stack([path.t, path.x, 0.0 - path.y, 0.0 - np.degrees(path.psi)])
    rows = io.StringIO()
    np.savetxt(rows, table, fmt="(%.10g ((%.10g %.10g 0) (0 0 %.10g)))")
    head = "// t [s], place [m] and angles [deg] of the mesh: x forward, y to port, z up"
    return f"{head}\n{len(table)}\n(\n{rows.getvalue()})\n"


def how_to(programme: Programme, campaign: Campaign) -> list[str]:
    """What to do with the folders."""
    first = programme.runs[0].id
    return [
        "OpenFOAM: a folder a run in runs/. Put mesh, fields and schemes of your case into each.",
        "",
        "1. The mesh has x forward, y to port, z up. Its origin is",
        f"   {origin_in_words(campaign)}.",
        "   The whole mesh is towed through water at rest: U is 0 inside and on the outer",
        "   boundaries, and movingWallVelocity on the hull.",
        "2. constant/dynamicMeshDict and constant/6DoF.dat move it. It starts from rest; after the",
        "   run-up (run-up [s] in programme.csv) the motion is that of the test.",
        '3. Write into system/controlDict: #include "times"; under functions: #include "forces".',
        "   In system/forces the patches of the hull are called (hull): write yours.",
        "4. Compute to the end time. Forces stand in postProcessing/forces, a row each time step,",
        "   along axes that stay and about (0 0 0), such as",
        f"   runs/{first}/postProcessing/forces/0/force.dat and moment.dat.",
        "5. pmmkit reduce . in this folder. Runs that are not computed yet are left out.",
        NO_DAY,
        *held_in_words(programme),
    ]


_HEAD = """\
FoamFile
{{
    version     2.0;
    format      ascii;
    class       dictionary;
    object      {object};
}}
"""
_DYNAMIC_MESH = (
    _HEAD.format(object="dynamicMeshDict")
    + """\
// OpenCFD, and Foundation up to 9. Foundation 10 and later: put the lines from motionSolver on
// into mover { type motionSolver; libs ("libfvMeshMovers.so" "libfvMotionSolvers.so"); ... }
dynamicFvMesh           dynamicMotionSolverFvMesh;
motionSolverLibs        ("libfvMotionSolvers.so");
motionSolver            solidBody;
solidBodyMotionFunction tabulated6DoFMotion;
tabulated6DoFMotionCoeffs
{
    CofG                (0 0 0);
    timeDataFileName    "$FOAM_CASE/constant/6DoF.dat";
}
"""
)
_FORCES = """\
forces
{{
    type            forces;
    libs            ("libforces.so");
    patches         (hull);         // yours
    rho             rhoInf;         // two phases with a field rho: write  rho rho;
    rhoInf          {rho};
    CofR            (0 0 0);        // stays where it is; the campaign file knows
    writeControl    timeStep;
    writeInterval   1;
    writePrecision  10;
}}
"""
_TIMES = """\
startTime       0;
endTime         {end};
// run-up to {run_up} s; the table of the motion ends just beyond endTime
"""

OPENFOAM: Final = TowingSolver(
    format="openfoam",
    forces="postProcessing/forces",
    motion=MOTION,
    write_run=write_run,
    how_to=how_to,
)
