"""Results of OpenFOAM."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pmmkit.numerics import Array
from pmmkit.readers.base import Choose, Columns, Reader, Request


class OpenFoam(Reader):
    """Forces, coefficients and rigid body motions that OpenFOAM wrote."""

    name = "openfoam"
    words = "OpenFOAM"
    reads = (
        "`forces`, `forceCoeffs` and `sixDoFRigidBodyState` of OpenFOAM: a file or a case; the "
        "table of `tabulated6DoFMotion`."
    )
    fallback = "folder"
    computed = True
    keys = ("missing",)

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether a file is one of OpenFOAM's, or a folder holds its results."""
        from pmmkit.readers.openfoam import places
        from pmmkit.readers.openfoam.mesh_motion import is_motion_table

        return places.recognises(path, head) or (bool(head) and is_motion_table(head))

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers that the files offer: the time, sums over the parts of a force, and the parts."""
        from pmmkit.readers.openfoam import reader

        return reader.names(request)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some columns of the history, from the first start of the computation to the last."""
        from pmmkit.readers.openfoam import reader

        return reader.columns(request, choose)

    def usual(self, headers: Sequence[str]) -> Mapping[str, str]:  # noqa: ARG002
        """Where our channels stand."""
        from pmmkit.readers.openfoam.reader import USUAL

        return USUAL

    @property
    def of_moving_mesh(self) -> Mapping[str, Any]:
        """Forces along axes that stay, moments about a CofR that does so too.

        The function object ``forces`` sums over the patches in the axes of the mesh's space and
        takes moments about a CofR that is read once (its source, both branches of OpenFOAM).
        """
        return {"forces_in": "earth", "moment_centre_moves": False}

    def computation(self, request: Request) -> Mapping[str, Any]:
        """What the case says: density in controlDict, whether the mesh moves in dynamicMeshDict."""
        from pmmkit.readers.openfoam.mesh_motion import case_of, density_in, entries_of, mesh_motion
        from pmmkit.readers.openfoam.places import series_of
        from pmmkit.readers.openfoam.reader import holds_motion_table

        if holds_motion_table(request):
            return {}
        file = series_of(request).parts[0].request.path
        density, case = density_in(entries_of(file)), case_of(file)
        motion = None if case is None else mesh_motion(case)
        still = {"forces_in": "body", "moment_centre_moves": True}
        return {
            **({} if density is None else {"rho_inf": density}),
            **({} if motion is None else self.of_moving_mesh if motion.moves else still),
        }

    def prescribed(self, request: Request) -> tuple[Mapping[str, Array], tuple[str, ...]]:
        """The path of the mesh after dynamicMeshDict, and what of that was not followed."""
        from pmmkit.readers.openfoam.mesh_motion import case_of, mesh_motion
        from pmmkit.readers.openfoam.places import series_of
        from pmmkit.readers.openfoam.reader import holds_motion_table

        if holds_motion_table(request):
            return {}, ()
        case = case_of(series_of(request).parts[0].request.path)
        motion = None if case is None else mesh_motion(case)
        return ({}, ()) if motion is None else (motion.path, motion.notes)

    def files(self, request: Request) -> Sequence[Path]:
        """The files that a request reads."""
        from pmmkit.readers.openfoam.places import series_of
        from pmmkit.readers.openfoam.reader import holds_motion_table

        if holds_motion_table(request):
            return (request.path,)
        return tuple(part.request.path for part in series_of(request).parts)
