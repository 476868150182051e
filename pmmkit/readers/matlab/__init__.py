"""Files of MATLAB."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from pmmkit.readers.base import Request
from pmmkit.readers.vectors import Vector, VectorReader


class Matlab(VectorReader):
    """MATLAB files of versions 4, 5, 7 and 7.3."""

    name = "matlab"
    words = "MATLAB file"
    reads = "MATLAB files of versions 4, 5, 7 and 7.3."
    suffixes = (".mat",)
    binary = True
    keys = ("group", "missing")
    stroke = "."

    def recognises(self, path: Path, head: bytes) -> bool:  # noqa: ARG002
        """Whether a file is one of MATLAB, by its first bytes."""
        from pmmkit.readers.hdf5.datasets import is_hdf5
        from pmmkit.readers.matlab.mat5 import is_v4, is_v5

        return is_v5(head) or (head.startswith(b"MATLAB 7.3") and is_hdf5(head)) or is_v4(head)

    def contents(self, request: Request) -> AbstractContextManager[tuple[list[Vector], list[str]]]:
        """What a file offers as columns, and what else it holds; open as long as it is used."""
        from pmmkit.readers.matlab.reader import contents

        return contents(request)

    def remarks(self, request: Request) -> tuple[str, ...]:
        """The single numbers."""
        from pmmkit.readers.matlab.reader import remarks

        return remarks(request)
