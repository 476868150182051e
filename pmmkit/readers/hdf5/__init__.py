"""HDF5 and NetCDF files of any origin."""

from __future__ import annotations

from pathlib import Path

from pmmkit.readers.base import Cells, Choose, Columns, Request
from pmmkit.readers.reader import Reader


class Hdf5(Reader):
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

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the columns."""
        from pmmkit.readers.hdf5 import reader

        return reader.names(request)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some datasets as numbers."""
        from pmmkit.readers.hdf5 import reader

        return reader.columns(request, choose)

    def cells(self, request: Request) -> Cells:
        """Datasets of the main length as a table, those of texts among them."""
        from pmmkit.readers.hdf5 import reader

        return reader.cells(request)
