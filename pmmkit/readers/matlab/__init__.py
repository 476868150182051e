"""Files of MATLAB."""

from __future__ import annotations

from pathlib import Path

from pmmkit.readers.base import Cells, Choose, Columns, Request
from pmmkit.readers.reader import Reader


class Matlab(Reader):
    """MATLAB files of versions 4, 5, 7 and 7.3."""

    name = "matlab"
    words = "MATLAB file"
    reads = "MATLAB files of versions 4, 5, 7 and 7.3."
    suffixes = (".mat",)
    binary = True
    keys = ("group", "missing")

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file is one of MATLAB, by its first bytes."""
        from pmmkit.readers.hdf5.datasets import is_hdf5
        from pmmkit.readers.matlab.mat5 import is_v4, is_v5

        return is_v5(head) or (head.startswith(b"MATLAB 7.3") and is_hdf5(head)) or is_v4(head)

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the columns."""
        from pmmkit.readers.matlab import reader

        return reader.names(request)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some vectors, or columns of matrices, as numbers."""
        from pmmkit.readers.matlab import reader

        return reader.columns(request, choose)

    def cells(self, request: Request) -> Cells:
        """Vectors of the main length as a table, cell arrays of texts among them."""
        from pmmkit.readers.matlab import reader

        return reader.cells(request)
