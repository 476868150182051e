"""HDF5 and NetCDF files of any origin."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from pmmkit.readers.base import Request
from pmmkit.readers.vectors import Vector, VectorReader


class Hdf5(VectorReader):
    """HDF5 and NetCDF files of any origin."""

    name = "hdf5"
    words = "HDF5"
    reads = "HDF5, NetCDF 4 and classic NetCDF files of any origin."
    suffixes = (".h5", ".hdf5", ".nc", ".nc4")
    container = True
    general = True
    binary = True
    keys = ("group", "missing")

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file is HDF5 or NetCDF, by its first bytes."""
        from pmmkit.readers.hdf5.datasets import is_hdf5
        from pmmkit.readers.hdf5.netcdf3 import is_netcdf3

        return is_hdf5(head) or is_netcdf3(head)

    def contents(self, request: Request) -> AbstractContextManager[tuple[list[Vector], list[str]]]:
        """What a file offers as columns, and what else it holds; open as long as it is used."""
        from pmmkit.readers.hdf5.reader import contents

        return contents(request)

    def remarks(self, request: Request) -> tuple[str, ...]:
        """The attributes of the file or of the group."""
        from pmmkit.readers.hdf5.reader import remarks

        return remarks(request)
